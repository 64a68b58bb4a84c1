/* The table of a sweep: columns, rows, and rows passed in a batch. */
#include "base/extrema.h"
#include "base/table.h"
#include "base/text.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_equations.h"
#include "kmech/mobility.h"
#include "local/constant_rank.h"
#include "mobility/mobility_numbers.h"
#include "sweep/sweep.h"

#include <stdio.h>
#include <string.h>

static void add_named(km_table *table, const char *prefix, const char *name, const char *suffix, const char *unit,
                      bool *failed) {
  *failed = !km_table_add_joined_column(table, prefix, name, suffix, unit) || *failed;
}

/* Unit of s: the driver's; none for arc length, which mixes radians and lengths over the characteristic length. */
static const char *s_unit(const km_sweeper *r) {
  return !km_plan_is_driven(r->plan) ? "" : km_model_coordinate_unit(r->m->model, r->plan->coordinate);
}

static void add_point_columns(const km_sweeper *r, const km_sweep_point *point, km_table *table, bool *failed) {
  static const char *const places[3] = {".x", ".y", ".z"}, *const slopes[3] = {".dx", ".dy", ".dz"};
  const char *length = r->m->model->units.length->suffix;
  for (int k = 0; k < 3; ++k)
    add_named(table, "point.", point->name, places[k], length, failed);
  if (!r->plan->derivatives)
    return;
  km_text unit = {0};
  km_text_format(&unit, km_plan_is_driven(r->plan) ? "%s/%s" : "%s", length, s_unit(r));
  *failed = *failed || unit.failed;
  for (int k = 0; k < 3 && !*failed; ++k)
    add_named(table, "point.", point->name, slopes[k], unit.data, failed);
  km_text_free(&unit);
}

static bool add_columns(const km_sweeper *r, km_table *table) {
  const km_model *model = r->m->model;
  bool failed = false;
  add_named(table, "", "step", "", NULL, &failed);
  failed = km_table_add_plain_column(table, "s", s_unit(r)) < 0 || failed;
  for (int c = 0; c < model->coordinate_count; ++c)
    add_named(table, "q.", model->coordinates[c].label, "", km_model_coordinate_unit(model, c), &failed);
  failed = !r->observer->columns(r->observer->self, r, table) || failed;
  add_named(table, "", "dof", "", NULL, &failed);
  for (int i = 0; i < r->m->topology.substructure_count; ++i) {
    char name[32];
    snprintf(name, sizeof name, "dof.%d", i + 1);
    add_named(table, name, "", "", NULL, &failed);
  }
  add_named(table, "", "residual", "", NULL, &failed);
  for (int i = 0; i < r->plan->point_count; ++i)
    add_point_columns(r, &r->plan->points[i], table, &failed);
  return !failed;
}

km_status km_sweeper_columns(const km_sweeper *r, km_error *error) {
  enum { FIRST_ROWS = 1000 }; /* long sweeps can end early */
  size_t rows = (size_t)r->plan->steps + 1;
  bool added = add_columns(r, r->out->table) && km_table_reserve(r->out->table, rows < FIRST_ROWS ? rows : FIRST_ROWS);
  return added ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the table");
}

/* Computes the velocity of a frame's origin per unit of s. */
static void point_rates(const km_sweeper *r, int frame, double out[3]) {
  const km_mechanism *m = r->m;
  km_twist t = km_body_twist(m, r->s, m->model->frames[frame].body, r->rates);
  km_vec3 v = km_point_velocity(t, km_frame_origin(m->model, r->s->pose, frame));
  km_vec3_write(v, out);
}

static double *write_points(const km_sweeper *r, double *cell) {
  if (r->plan->point_count == 0)
    return cell;
  km_poses_compute(r->m, r->s);
  double factor = km_plan_is_driven(r->plan) ? km_model_coordinate_factor(r->m->model, r->plan->coordinate) : 1.0;
  for (int i = 0; i < r->plan->point_count; ++i) {
    km_frame_position(r->m, r->s, r->plan->points[i].frame, cell);
    cell += 3;
    if (!r->plan->derivatives)
      continue;
    point_rates(r, r->plan->points[i].frame, cell);
    for (int k = 0; k < 3; ++k)
      *cell++ *= factor;
  }
  return cell;
}

void km_sweeper_update_motions(km_sweeper *r) {
  if (r->substructure >= 0 && !r->is_batched)
    km_motions_update(r->m, r->s, r->substructure);
}

const double *km_sweeper_batched_rates(const km_sweeper *r) {
  memset(r->scratch, 0, (size_t)r->m->coordinate_count * sizeof *r->scratch);
  r->mover.direction(r->mover.self, r->scratch);
  for (int c = 0; c < r->m->coordinate_count; ++c)
    r->scratch[c] /= r->m->scale[c];
  return r->scratch;
}

bool km_sweeper_update_rates(km_sweeper *r) {
  bool moves = r->mover.rates(r->mover.self, r->rates);
  if (r->substructure >= 0)
    km_motions_update(r->m, r->s, r->substructure);
  return moves;
}

/* Updates the mobility numbers of the moving substructure and returns its residual. */
static double update_moving_substructure(km_sweeper *r) {
  if (r->is_batched)
    return r->residual;
  km_numbers_update(r->m, r->s, r->substructure);
  return km_loops_residual(r->m, r->s, &r->m->substructures[r->substructure]);
}

/* Writes a row at the state's configuration; r->rates is the motion if the plan has derivatives. */
static bool write_row(km_sweeper *r, km_table *table, int step, double s) {
  const km_mechanism *m = r->m;
  double *cell = km_table_add_raw_rows(table, 1);
  if (!cell)
    return false;
  int mobility = r->other_mobility;
  double residual = r->other_residual;
  if (r->substructure >= 0) {
    residual = fmax(residual, update_moving_substructure(r));
    mobility += km_factor_freedom(r->s->factor[r->substructure]);
  }
  *cell++ = step;
  *cell++ = s;
  int coordinates = m->coordinate_count;
  for (int c = 0; c < coordinates; ++c)
    *cell++ = km_state_value(r->s, c);
  cell = r->observer->cells(r->observer->self, r, cell);
  *cell++ = mobility;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    *cell++ = km_factor_freedom(r->s->factor[i]);
  *cell++ = residual;
  write_points(r, cell);
  return true;
}

bool km_sweeper_write_between(km_sweeper *r, double s) {
  km_table *table = r->out->between; /* few sweeps have such rows */
  if (km_table_columns(table) == 0 && !add_columns(r, table))
    return false;
  return write_row(r, r->out->between, 0, s);
}

km_status km_sweeper_row(km_sweeper *r, int step, double s, km_error *error) {
  /* The rates come first: mobility numbers can search other pivots. */
  bool tangent = r->plan->derivatives && r->mover.rates(r->mover.self, r->rates);
  if (r->plan->derivatives && !tangent)
    for (int c = 0; c < r->m->coordinate_count; ++c)
      r->rates[c] = nan("");
  if (!write_row(r, r->out->table, step, s))
    return km_fail(error, KM_MEMORY, "out of memory for the table");
  return r->observer->row_written ? r->observer->row_written(r->observer->self, r, s, error) : KM_OK;
}

/* Copies the row at `first` to the rows behind it, `count` in all (doubling copies). */
static void repeat_row(double *first, size_t width, size_t count) {
  for (size_t done = 1; done < count; done *= 2)
    memcpy(first + done * width, first, (done < count - done ? done : count - done) * width * sizeof *first);
}

/* The cells of a column in several rows. */
typedef struct column_cells {
  double *first;
  size_t width; /* width of a row of the table */
  int count;    /* rows */
} column_cells;

/* Writes the numbers of a lane, `stride` doubles apart, into a column, divided by their unit's factor. */
static void write_column(column_cells to, const double *from, size_t stride, double factor) {
  double *cell = to.first;
  if (factor == 1.0)
    for (int i = 0; i < to.count; ++i, cell += to.width, from += stride)
      *cell = *from;
  else
    for (int i = 0; i < to.count; ++i, cell += to.width, from += stride)
      *cell = km_convert_unit(*from, factor);
}

/* Writes coordinates and mobility numbers of passed rows. */
static void write_passed_numbers(const km_sweeper *r, const km_batched_rows *rows, column_cells row) {
  const km_substructure *sub = &r->m->substructures[r->substructure];
  const int *coordinate = r->m->column_coordinate + sub->column_start;
  const bool *unread = r->observer->unread;
  for (int k = 0; k < sub->columns; ++k) {
    int c = coordinate[k];
    size_t number = r->observer->number_cells[c], lane = (size_t)k * KM_BATCH_LANES;
    if (!unread || !unread[c])
      write_column((column_cells){row.first + 2 + c, row.width, row.count}, rows->q + lane, rows->stride,
                   r->m->factor[c]);
    if (number)
      write_column((column_cells){row.first + number, row.width, row.count}, rows->numbers + lane, rows->stride, 1.0);
  }
}

/* True if a row has more cells than step, s, the numbers of the moving substructure, `count` mobilities and the
 * residual. */
static bool has_more_cells(const km_sweeper *r, size_t width, size_t count) {
  const km_substructure *sub = &r->m->substructures[r->substructure];
  size_t moving = 0;
  for (int k = 0; k < sub->columns; ++k)
    moving += r->observer->number_cells[r->m->column_coordinate[sub->column_start + k]] ? 2 : 1;
  return width > 2 + moving + count + 1;
}

km_status km_sweeper_passed_rows(km_sweeper *r, const km_driver_motion *drive, int count, int step, const double *s,
                                 km_error *error) {
  const km_batched_rows rows = km_driver_motion_batched_rows(drive);
  const int freedom = km_factor_freedom(r->s->factor[r->substructure]);
  const size_t mobilities = 1 + (size_t)r->m->topology.substructure_count;
  size_t width = km_table_columns(r->out->table), residual = width - 1, dof = residual - mobilities;
  if (count == 0)
    return KM_OK;
  double *first = km_table_add_raw_rows(r->out->table, (size_t)count), *cells = first;
  if (!first)
    return km_fail(error, KM_MEMORY, "out of memory for the table");
  memcpy(first, first - width, width * sizeof *first); /* cells not written below keep their values */
  first[dof] = r->other_mobility + freedom;
  first[dof + 1 + (size_t)r->substructure] = freedom;
  if (has_more_cells(r, width, mobilities))
    repeat_row(first, width, (size_t)count);
  for (int i = 0; i < count; ++i, cells += width) {
    cells[0] = step + i;
    cells[1] = s[i * KM_BATCH_LANES];
    for (size_t k = dof; k < residual; ++k)
      cells[k] = first[k];
    cells[residual] = km_larger(rows.residual[(size_t)i * rows.stride], r->other_residual);
  }
  write_passed_numbers(r, &rows, (column_cells){first, width, count});
  return KM_OK;
}

km_status km_sweeper_near_row(km_sweeper *r, km_error *error) {
  const km_observer *observer = r->observer;
  km_status status = KM_OK;
  bool is_moved = false;
  double s;
  while (!status && observer->next_probe && observer->next_probe(observer->self, &s)) {
    bool moved = r->mover.probe(r->mover.self, s, r->rates);
    status = observer->probed(observer->self, r, moved ? r->rates : NULL, error);
    is_moved = true;
  }
  if (is_moved)
    r->mover.restore(r->mover.self);
  return status;
}

/* Finds the passive freedoms of the moving substructure. */
static km_status find_passive(km_sweeper *r, km_error *error) {
  km_passive_freedoms passive;
  km_status status = km_passive_freedoms_find(r->m, r->s, NULL, NULL, &passive, error);
  for (int i = 0; i < passive.count; ++i)
    r->out->passive += passive.items[i].substructure == r->substructure ? passive.items[i].freedoms : 0;
  if (!status && r->out->passive > 0) {
    r->out->passive_coordinates = KM_NEW(bool, (size_t)r->m->coordinate_count);
    if (r->out->passive_coordinates)
      km_passive_coordinates(r->m, &passive, r->out->passive_coordinates);
    else
      status = km_fail(error, KM_MEMORY, "out of memory for the passive freedoms");
  }
  km_passive_freedoms_free(&passive);
  return status;
}

/* Finds how many freedoms of a permanently shaky mechanism are infinitesimal only. */
static km_status find_infinitesimal_freedoms(const km_sweeper *r, km_error *error) {
  km_arena arena = {0};
  km_constant_rank constant_rank = {0};
  bool done = km_constant_rank_begin(&constant_rank, r->m, r->s, r->substructure, KM_NO_DRIVER, &arena);
  r->out->infinitesimal = constant_rank.is_active ? r->out->freedom - constant_rank.count : 0;
  km_arena_free(&arena);
  return done ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the tangents");
}

km_status km_sweeper_prepare(km_sweeper *r, km_error *error) {
  if (km_mobility_compute(r->m, r->s, &r->out->first))
    return km_fail(error, KM_MEMORY, "out of memory for the mobility");
  r->other_mobility = r->out->first.mobility;
  if (r->substructure >= 0)
    r->out->freedom = km_factor_freedom(r->s->factor[r->substructure]);
  r->other_mobility -= r->out->freedom;
  r->other_residual = 0.0;
  for (int i = 0; i < r->m->topology.substructure_count; ++i) {
    if (i != r->substructure)
      r->other_residual = fmax(r->other_residual, km_loops_residual(r->m, r->s, &r->m->substructures[i]));
  }
  if (r->out->freedom <= 1)
    return KM_OK;
  km_status infinitesimal = find_infinitesimal_freedoms(r, error);
  return infinitesimal ? infinitesimal : find_passive(r, error);
}
