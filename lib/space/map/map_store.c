/* The store of a map (space/map/map_store.h).
 *
 * A map is found by the same steps each time. A store has the results of the parts that take long: the modes, and what
 * a part of the search adds to the queue of grid points, to the curves and to the choices of primary rows. Starts,
 * aspects and the workspace are computed again. */
#include "space/map/map_store.h"

#include "base/arguments.h"
#include "base/file.h"
#include "base/store/store_file.h"
#include "base/table.h"
#include "exchange/mesh/model_meshes.h"
#include "kmech/version.h"
#include "model/model_numbers.h"

#include <string.h>

enum { FORMAT = 1 /* version of the pieces */ };

struct km_map_store {
  km_piece_store *pieces;
  int drivers[2];
  unsigned long seed;
  km_all_modes modes; /* evidence and mobility numbers aren't kept */
  bool has_modes;     /* they were taken from the file, or kept in it */
  bool is_used;       /* a map has been computed with it */
};

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the store of a map");
}

/* ---- Identity. */

/* Adds all numbers of the model, also those that were set after the file was read. */
static void add_model(km_text *out, const km_model *model) {
  km_model_numbers numbers;
  km_model_numbers_list((km_model *)model, &numbers); /* the list is only read */
  km_identity_add_name(out, model->sha256);
  for (size_t i = 0; i < numbers.count; ++i)
    km_identity_add_numbers(out, numbers.items[i].at, 1);
  out->failed = out->failed || numbers.failed;
  km_model_numbers_free(&numbers);
}

static void add_pose(km_text *out, const km_mechanism *m, const km_state *s) {
  for (int c = 0; c < m->coordinate_count; ++c)
    km_identity_add_name(out, m->held[c] ? "held" : "");
  km_identity_add_numbers(out, s->q, m->coordinate_count);
  const double lengths[2] = {m->length, m->closure_tolerance};
  km_identity_add_numbers(out, lengths, 2);
}

/* Adds the definition as a person reads it, so that two of them can be compared. */
static void describe(km_text *out, const km_mechanism *m, const km_space_map_def *def, unsigned long seed) {
  km_text_format(out, "the model %.12s over ", m->model->sha256);
  for (int d = 0; d < 2; ++d) {
    const km_space_axis *a = &def->axis[d];
    km_text_format(out, "%s%s %s", d ? ", " : "", m->model->coordinates[a->coordinate].label, KM_SHOWN(a->from));
    km_text_format(out, " to %s in %d steps", KM_SHOWN(a->to), a->steps);
  }
  if (def->has_point)
    km_text_format(out, ", point %s", def->point_name);
  km_text_add(out, def->own_sheet ? ", own sheet" : "");
  km_text_add(out, def->within_limits ? ", within limits" : "");
  if (def->clearance)
    km_text_format(out, ", clearance %s", KM_SHOWN(def->least_clearance));
  for (int i = 0; def->figures && i < def->figures->count; ++i)
    km_text_format(out, ", %s", def->figures->names[i]);
  km_text_format(out, ", seed %lu, kmech %s", seed, km_version());
}

/* Adds the numbers of the definition that its description rounds. */
static void add_definition(km_text *out, const km_space_map_def *def) {
  for (int d = 0; d < 2; ++d)
    km_identity_add_numbers(out, (const double[2]){def->axis[d].from, def->axis[d].to}, 2);
  km_identity_add_numbers(out, &def->least_clearance, def->clearance ? 1 : 0);
  for (int i = 0; def->clearance && i < km_clearance_pair_count(def->clearance); ++i)
    km_identity_add_name(out, km_clearance_pair_name(def->clearance, i));
  for (int i = 0; def->figures && i < def->figures->count; ++i)
    km_identity_add_name(out, def->figures->units[i]);
}

/* Finds the identity of a map, and its description with the beginning of the hash of all else. */
static km_status identify(const km_mechanism *m, const km_state *s, const km_space_map_def *def, unsigned long seed,
                          char hash[KM_SHA256_TEXT], km_text *what, km_error *error) {
  km_text text = {0};
  const double format = FORMAT;
  describe(what, m, def, seed);
  km_identity_add_numbers(&text, &format, 1);
  km_identity_add_name(&text, what->data);
  add_model(&text, m->model);
  add_pose(&text, m, s);
  add_definition(&text, def);
  km_status status = def->clearance || def->figures ? km_model_identify_meshes(m->model, &text, error) : KM_OK;
  if (!status && !text.failed) {
    km_sha256(text.data, text.size, hash);
    km_text_format(what, " (%.8s)", hash);
  }
  bool failed = text.failed || what->failed;
  km_text_free(&text);
  return status || !failed ? status : no_memory(error);
}

/* ---- Modes. */

/* Passes modes to a piece or from it. False when out of memory. */
static bool pass_modes(km_piece *piece, const km_mechanism *m, km_all_modes *modes) {
  km_piece_pass(piece, &modes->count, sizeof modes->count);
  size_t numbers = (size_t)modes->count * (size_t)m->coordinate_count;
  if (piece->is_read)
    modes->coordinates = KM_NEW(double, numbers + 1);
  if (!modes->coordinates && numbers > 0)
    return false;
  km_piece_pass(piece, modes->coordinates, numbers * sizeof *modes->coordinates);
  km_piece_pass(piece, &modes->is_complete, sizeof modes->is_complete);
  km_piece_pass(piece, &modes->gap, sizeof modes->gap);
  return true;
}

/* Copies modes by way of a piece. */
static bool copy_modes(const km_mechanism *m, const km_all_modes *from, km_all_modes *to) {
  km_all_modes source = *from;
  km_piece piece = {0};
  bool is_ok = pass_modes(&piece, m, &source) && !piece.failed;
  piece.is_read = true;
  *to = (km_all_modes){0};
  is_ok = is_ok && pass_modes(&piece, m, to);
  km_piece_free(&piece);
  return is_ok;
}

/* Takes the file's modes, if it has some and they weren't taken or kept yet. */
static km_status take_modes(km_map_store *store, const km_mechanism *m, km_error *error) {
  km_piece piece;
  if (store->has_modes)
    return KM_OK;
  km_status status = km_piece_store_take(store->pieces, &piece, &store->has_modes, error);
  if (!status && store->has_modes && !pass_modes(&piece, m, &store->modes))
    status = no_memory(error);
  km_piece_free(&piece);
  return status;
}

static km_status keep_modes(km_map_store *store, const km_mechanism *m, const km_all_modes *modes, km_error *error) {
  km_piece piece = {0};
  if (!copy_modes(m, modes, &store->modes) || !pass_modes(&piece, m, &store->modes))
    return no_memory(error);
  store->has_modes = true;
  km_status status = km_piece_store_add(store->pieces, &piece, error);
  km_piece_free(&piece);
  return status;
}

km_status km_map_store_modes(km_map_store *store, const km_mechanism *m, const km_state *s, km_progress progress,
                             void *context, km_all_modes *out, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = take_modes(store, m, error);
  if (status)
    return status;
  if (store->has_modes)
    return copy_modes(m, &store->modes, out) ? KM_OK : no_memory(error);
  status = km_map_modes_find(m, s, store->drivers[0], store->drivers[1], store->seed, progress, context, out, error);
  return status ? status : keep_modes(store, m, out, error);
}

km_status km_map_check_modes(km_map_search *g, const km_all_modes *modes, km_error *error) {
  km_map_store *store = g->def->store;
  const km_mechanism *m = g->f.m;
  if (!store)
    return KM_OK;
  if (store->is_used)
    return km_fail(error, KM_USAGE, "the store has been used; expected one that is opened for each map");
  km_status status = take_modes(store, m, error);
  if (!status && !store->has_modes)
    status = keep_modes(store, m, modes, error);
  if (status)
    return status;
  store->is_used = true;
  size_t numbers = (size_t)modes->count * (size_t)m->coordinate_count;
  bool is_same =
      modes->count <= store->modes.count &&
      (numbers == 0 || memcmp(modes->coordinates, store->modes.coordinates, numbers * sizeof *modes->coordinates) == 0);
  return is_same ? KM_OK : km_fail(error, KM_USAGE, "the store holds a map from other assembly modes");
}

/* ---- Parts of the search. */

/* The search when a part began. */
typedef struct search_mark {
  int tail, choices;
  size_t points;
} search_mark;

/* Tangents at the state's configuration; those of a cell were found there by the same steps. */
static bool restore_tangents(km_map_search *g, double *N) {
  int sign;
  km_driver_surface_update(&g->f);
  bool is_regular = km_driver_surface_factor(&g->f, &sign);
  if (is_regular)
    km_driver_surface_rates(&g->f, N);
  return is_regular;
}

/* Passes a grid point of the queue to a piece or from it. False when out of memory. */
static bool pass_cell(km_map_search *g, int at, km_piece *p) {
  size_t width = km_table_columns(g->out->cells);
  km_piece_pass(p, &g->queue[at], sizeof *g->queue);
  int cell = g->queue[at];
  double *saved = g->saved + (size_t)cell * g->f.saved_size;
  km_piece_pass(p, &g->sign[cell], sizeof *g->sign);
  km_piece_pass(p, &g->output_sign[cell], sizeof *g->output_sign);
  km_piece_pass(p, &g->is_written[cell], sizeof *g->is_written);
  km_piece_pass(p, saved, g->f.saved_size * sizeof *saved);
  km_piece_pass(p, g->rows + (size_t)cell * width, width * sizeof *g->rows);
  if (g->f.frame >= 0)
    km_piece_pass(p, g->output + 3 * (size_t)cell, 3 * sizeof *g->output);
  if (!p->is_read || p->failed)
    return true;
  km_driver_surface_restore(&g->f, saved);
  p->failed = !restore_tangents(g, g->N + (size_t)cell * 2 * (size_t)g->f.columns);
  return km_map_note_configuration(g, cell);
}

/* Passes what was added since `from` to a piece or from it. False when out of memory. */
static bool pass_part(km_map_search *g, const search_mark *from, km_piece *p) {
  bool is_ok =
      km_condition_rows_pass(&g->f.primary, from->choices, p) && km_surface_curves_pass(g->curves, from->points, p);
  km_piece_pass(p, &g->tail, sizeof g->tail);
  for (int i = from->tail; is_ok && !p->failed && i < g->tail; ++i)
    is_ok = pass_cell(g, i, p);
  return is_ok;
}

/* Takes the results of a part from the store. *is_there false: it has none. */
static km_status take_part(km_map_search *g, const search_mark *from, bool *is_there, km_error *error) {
  km_piece_store *pieces = g->def->store->pieces;
  km_piece piece;
  km_status status = km_piece_store_take(pieces, &piece, is_there, error);
  if (!status && *is_there && !pass_part(g, from, &piece))
    status = no_memory(error);
  if (!status && *is_there && (piece.failed || piece.at < piece.size))
    status = km_piece_store_fail(pieces, error);
  km_piece_free(&piece);
  return status;
}

static km_status keep_part(km_map_search *g, const search_mark *from, km_error *error) {
  km_piece piece = {0};
  km_status status =
      pass_part(g, from, &piece) ? km_piece_store_add(g->def->store->pieces, &piece, error) : no_memory(error);
  km_piece_free(&piece);
  return status;
}

km_status km_map_do(km_map_search *g, km_map_work work, size_t first, km_error *error) {
  search_mark from = {.tail = g->tail, .choices = g->f.primary.count};
  bool is_there;
  if (!g->def->store)
    return work(g, first, error);
  km_surface_curves_points(g->curves, &from.points);
  km_status status = take_part(g, &from, &is_there, error);
  if (status || is_there)
    return status;
  status = work(g, first, error);
  return status ? status : keep_part(g, &from, error);
}

/* ---- The store. */

km_status km_map_store_open(const char *path, const km_mechanism *m, const km_state *s, const km_space_map_def *def,
                            unsigned long seed, bool replace, km_map_store **out, km_error *error) {
  char hash[KM_SHA256_TEXT];
  km_text what = {0};
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_given(path && def, "path of the store or definition of the map", error);
  if (!status)
    status = km_check_state(m, s, error);
  if (!status)
    status = km_map_check_definition(m, def, error);
  if (!status)
    status = identify(m, s, def, seed, hash, &what, error);
  km_map_store *store = status ? NULL : KM_NEW(km_map_store, 1);
  if (!status && !store)
    status = no_memory(error);
  if (!status) {
    *store = (km_map_store){.drivers = {def->axis[0].coordinate, def->axis[1].coordinate}, .seed = seed};
    status = km_piece_store_open(path, "map", hash, what.data, replace, &store->pieces, error);
  }
  km_text_free(&what);
  if (status)
    km_free(store);
  else
    *out = store;
  return status;
}

void km_map_store_free(km_map_store *store) {
  if (!store)
    return;
  km_piece_store_free(store->pieces);
  km_all_modes_free(&store->modes);
  km_free(store);
}
