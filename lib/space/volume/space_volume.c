/* Size of a point's workspace by samples, with an interval (docs/theory.md 4.23).
 *
 *   cells h of volume v, two samples in each, y = 1 where reached:
 *     V  = v Σ (y₁ + y₂)/2,   s² = v² Σ (y₁ − y₂)²/4 = v² D/4,   D: cells of which one sample is reached
 *   interval: V − z v √(D + 2)/2  to  V + u v/2 + z v √(D + 2)/2,   z = 1.96,  u undecided samples
 *   Both samples of a cell are independent, so that s² has no bias (W. G. Cochran, Sampling Techniques, 1977, 5A.1).
 *   √D has an error of about 1/2: D + 2 for D keeps intervals of few such cells from being too short. */
#include "space/volume/volume_search.h"

#include "base/arguments.h"
#include "base/table.h"
#include "model/coordinate_column.h"

#include <string.h>

enum { MOST_BOXES = 5 /* the examples of models/ take one or two */, MOST_JOBS = 64 };
static const double later_boxes = 0.05; /* share of the remaining progress that a box leaves to those after it */
static const double quantile = 1.959963984540054; /* 0.975 of the normal distribution */

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the workspace");
}

/* ---- Preparation. */

static km_status check(const km_mechanism *m, const km_state *s, const km_space_volume_def *def, km_error *error) {
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_given(def && def->point_name, "definition, or name of the point", error);
  if (!status)
    status = km_check_index(def->frame, m->model->frame_count, "frame", error);
  if (!status && def->samples != 0 && (def->samples < KM_MIN_VOLUME_SAMPLES || def->samples > KM_MAX_VOLUME_SAMPLES))
    return km_fail(error, KM_USAGE, "%d samples; expected %d to %d", def->samples, KM_MIN_VOLUME_SAMPLES,
                   KM_MAX_VOLUME_SAMPLES);
  if (!status && def->clearance && !isfinite(def->least_clearance))
    return km_fail(error, KM_USAGE, "a least clearance that isn't finite");
  return status;
}

static km_status create_points(km_volume_search *g, const km_mechanism *m, km_error *error) {
  km_status status = KM_OK;
  g->point = KM_ARENA_NEW(&g->arena, km_moved_point, (size_t)g->jobs);
  for (int j = 0; g->point && !status && j < g->jobs; ++j) {
    km_moved_point *p = &g->point[j];
    *p = (km_moved_point){.m = m,
                          .frame = g->def->frame,
                          .keeps_limits = g->def->within_limits,
                          .kept = {.clearance = g->def->clearance, .least = g->def->least_clearance},
                          .dimension = 3,
                          .axis = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
    status = km_state_create(m, &p->s, error);
    if (!status)
      status = km_moved_point_create(p, &g->arena, error);
  }
  return g->point ? status : no_memory(error);
}

static double extent(const km_space_volume *v, int axis) {
  return v->box_high[axis] - v->box_low[axis];
}

/* The shortest axis without cells. *volume: of the box along all of these. */
static int shortest_axis(const km_space_volume *v, double *volume) {
  int shortest = -1;
  *volume = 1.0;
  for (int k = 0; k < v->dimension; ++k) {
    if (v->cells[k] > 0)
      continue;
    *volume *= extent(v, k);
    if (shortest < 0 || extent(v, k) < extent(v, shortest))
      shortest = k;
  }
  return shortest;
}

/* Divides the box into cells, at most half as many as samples are requested. Each axis in turn, the shortest first, has
 * cells as long as the sides of cubes of the share that is left; the last one takes what is left. */
static void choose_cells(km_volume_search *g) {
  km_space_volume *out = g->out;
  int left = (g->def->samples > 0 ? g->def->samples : KM_DEFAULT_VOLUME_SAMPLES) / 2;
  memcpy(out->box_low, g->low, sizeof out->box_low);
  memcpy(out->box_high, g->high, sizeof out->box_high);
  memset(out->cells, 0, sizeof out->cells);
  out->samples = 2;
  for (int axes = out->dimension; axes > 0; --axes) {
    double volume;
    int k = shortest_axis(out, &volume);
    double width = pow(volume / left, 1.0 / axes);
    out->cells[k] = axes == 1 ? left : (int)fmax(round(extent(out, k) / width), 1.0);
    out->samples *= out->cells[k];
    left /= out->cells[k];
  }
}

static bool allocate_samples(km_volume_search *g) {
  size_t count = (size_t)g->out->samples;
  km_free(g->samples);
  km_free(g->open);
  g->samples = KM_NEW(km_volume_sample, count);
  g->open = KM_NEW(int, count);
  g->saved = KM_ARENA_NEW(&g->arena, double, count * g->point[0].saved_size);
  return g->samples && g->open && g->saved;
}

/* ---- Result. */

static void estimate(const km_volume_search *g) {
  km_space_volume *out = g->out;
  double cell = 1.0, box = 1.0;
  for (int k = 0; k < out->dimension; ++k) {
    box *= extent(out, k);
    cell *= extent(out, k) / out->cells[k];
  }
  for (int i = 0; i < out->samples; ++i) {
    const km_volume_sample *sample = &g->samples[i];
    out->reached += sample->is_reached;
    out->not_reached += !sample->is_reached && sample->blocked >= KM_VOLUME_ATTEMPTS;
    out->split_cells += i % 2 == 1 && sample->is_reached != sample[-1].is_reached;
  }
  out->undecided = out->samples - out->reached - out->not_reached;
  out->volume = 0.5 * cell * out->reached;
  out->standard_error = 0.5 * cell * sqrt(out->split_cells);
  double half = quantile * 0.5 * cell * sqrt(out->split_cells + 2.0);
  out->low = fmax(out->volume - half, 0.0);
  out->high = fmin(out->volume + 0.5 * cell * out->undecided + half, box);
  out->configurations = g->known_count;
}

static bool add_row(km_volume_search *g, int index) {
  km_moved_point *p = &g->point[0];
  const km_volume_sample *sample = &g->samples[index];
  double *row = km_table_add_row(g->out->points);
  km_vec3 x = g->origin;
  if (!row)
    return false;
  for (int k = 0; k < p->dimension; ++k)
    x = km_vec3_axpy(sample->x[k], p->axis[k], x);
  km_vec3_write(x, row);
  row[3] = sample->is_reached ? 1.0 : sample->blocked >= KM_VOLUME_ATTEMPTS ? 0.0 : -1.0;
  if (sample->is_reached)
    km_moved_point_restore(p, g->saved + (size_t)index * p->saved_size);
  for (int c = 0; c < p->m->coordinate_count; ++c)
    row[4 + c] = sample->is_reached ? km_state_coordinate(p->s, c) : nan("");
  return true;
}

static km_status write_points(km_volume_search *g, const km_state *state, km_error *error) {
  static const char *const suffix[] = {".x", ".y", ".z"};
  const km_model *model = g->point[0].m->model;
  km_table *table = g->out->points = km_table_create();
  bool is_ok = table != NULL;
  for (int k = 0; is_ok && k < 3; ++k)
    is_ok = km_table_add_joined_column(table, "point.", g->def->point_name, suffix[k],
                                       km_model_units(model).length->suffix);
  is_ok = is_ok && km_table_add_joined_column(table, "reached", "", "", "");
  for (int c = 0; is_ok && c < model->coordinate_count; ++c)
    is_ok = km_model_add_coordinate_column(model, c, table);
  km_state_copy(g->point[0].m, g->point[0].s, state); /* coordinates that don't move the point */
  for (int i = 0; is_ok && i < g->out->samples; ++i)
    is_ok = add_row(g, i);
  return is_ok ? KM_OK : no_memory(error);
}

/* Decides samples in larger and larger boxes, until the box has all known configurations. KM_CANCELLED: the samples of
 * the last box are decided so far. */
static km_status decide_boxes(km_volume_search *g, km_error *error) {
  bool is_grown = true;
  km_status status = km_volume_find_box(g, &is_grown, error);
  for (int i = 0; !status && is_grown && i < MOST_BOXES; ++i) {
    choose_cells(g);
    km_progress_stage_next(&g->stage, 1.0 - (1.0 - g->stage.to) * later_boxes);
    status = allocate_samples(g) ? km_volume_decide(g, error) : no_memory(error);
    if (!status)
      status = km_volume_find_box(g, &is_grown, error);
  }
  g->out->is_complete = g->out->is_complete && !is_grown;
  return status;
}

static km_status search(km_volume_search *g, const km_state *state, km_error *error) {
  km_space_volume *out = g->out;
  km_status status = km_volume_start(g, state, error);
  out->dimension = g->point[0].dimension;
  for (int k = 0; k < 3; ++k) {
    g->low[k] = HUGE_VAL;
    g->high[k] = -HUGE_VAL;
  }
  if (!status)
    status = decide_boxes(g, error);
  out->is_stopped = status == KM_CANCELLED;
  if (status && (!out->is_stopped || out->samples == 0))
    return status;
  estimate(g);
  for (int k = 0; k < out->dimension; ++k)
    km_vec3_write(g->point[0].axis[k], out->axis[k]);
  km_status written = write_points(g, state, error);
  return written ? written : status;
}

static void free_search(km_volume_search *g) {
  for (int j = 0; g->point && j < g->jobs; ++j)
    km_state_free(g->point[j].s);
  km_free(g->known);
  km_free(g->order);
  km_free(g->samples);
  km_free(g->open);
  km_arena_free(&g->arena);
}

km_status km_space_volume_find(const km_mechanism *m, const km_state *s, const km_space_volume_def *def,
                               km_progress progress, void *context, km_space_volume *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_space_volume){0};
  km_status status = check(m, s, def, error);
  if (status)
    return status;
  km_volume_search g = {.def = def,
                        .out = out,
                        .jobs = def->jobs < 1           ? 1
                                : def->jobs > MOST_JOBS ? MOST_JOBS
                                                        : def->jobs,
                        .stage = {.progress = progress, .context = context}};
  status = create_points(&g, m, error);
  if (!status)
    status = search(&g, s, error);
  free_search(&g);
  return status;
}

void km_space_volume_free(km_space_volume *volume) {
  if (!volume)
    return;
  km_table_free(volume->points);
  *volume = (km_space_volume){0};
}
