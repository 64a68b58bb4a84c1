/* Mobility numbers along a sweep and the dead points of coordinates (theory 10.3, 10.4).
 *
 *   z = D q̇/|D q̇| at rows and steps; a coordinate has a dead point where its entry z_j is 0:
 *   sign change between rows, several sign changes between steps, or a minimum of |z_j| near 0 */
#include "base/arguments.h"
#include "base/table.h"
#include "sweep/dead_points.h"
#include "sweep/singular_value_minima.h"
#include "sweep/sweep_observer.h"

#include <string.h>

/* Relative distance at which dead points count as one position. */
static const double same_position = 1e-9;

/* State of the search between rows. */
typedef struct sweep_events {
  km_mobility_sweep *out;
  km_observer observer;
  km_directions directions;
  size_t rows; /* rows of the table at the last call */
  km_root_search root_search;
  bool searching; /* root_search runs for the coordinate candidates[next] */
  int next;
  bool *listed;    /* [coordinate] its dead points since the last row are in the list */
  bool *moved;     /* [coordinate] it moved at some row: coordinates at rest have no dead points */
  int *candidates; /* coordinates that can have dead points */
  int candidate_count;
  int *cell_coordinate; /* coordinate of each column of mobility numbers, -1: joint without freedom */
  int column_count;
  size_t *cell;                    /* [coordinate] cell of its mobility number in a row; 0: none */
  bool *unread;                    /* [coordinate] see km_observer */
  const char *const *read_columns; /* see km_sweep_job */
  km_singular_value_minima singular;
} sweep_events;

/* True if the column of a mobility number (m) or a coordinate (q) is read. */
static bool is_read(const sweep_events *w, char kind, const char *label) {
  bool found = !w->read_columns;
  for (const char *const *name = w->read_columns; !found && *name; ++name)
    found = (*name)[0] == kind && (*name)[1] == '.' && strcmp(*name + 2, label) == 0;
  return found;
}

/* Adds the column of coordinate c, -1: of a joint without freedom, if it is read. */
static bool add_column(sweep_events *w, const char *label, int c, km_table *table) {
  if (!is_read(w, 'm', label))
    return true;
  if (c >= 0)
    w->cell[c] = km_table_columns(table);
  w->cell_coordinate[w->column_count++] = c;
  return km_table_add_joined_column(table, "m.", label, "", NULL);
}

/* Adds the columns of mobility numbers that are read: one for each coordinate, and one for each joint without freedom.
 * Marks the coordinates whose own columns are not read. */
static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  sweep_events *w = self;
  const km_model *model = r->m->model;
  bool added = true;
  w->column_count = 0;
  for (int c = 0; c < model->coordinate_count; ++c)
    w->unread[c] = !is_read(w, 'q', model->coordinates[c].label);
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    int freedom = km_model_freedom(model, j);
    if (freedom == 0)
      added = add_column(w, joint->label, -1, table) && added;
    for (int c = joint->first_coordinate; c < joint->first_coordinate + freedom; ++c)
      added = add_column(w, model->coordinates[c].label, c, table) && added;
  }
  return (!r->plan->singularities || km_table_add_joined_column(table, "", "singular_value", "", NULL)) && added;
}

static double *write_numbers(void *self, km_sweeper *r, double *cell) {
  sweep_events *w = self;
  const int *cell_coordinate = w->cell_coordinate;
  const double *numbers = r->s->mobility_number;
  for (int i = 0, count = w->column_count; i < count; ++i)
    *cell++ = cell_coordinate[i] < 0 ? 0.0 : numbers[cell_coordinate[i]];
  if (r->plan->singularities)
    *cell++ = km_singular_value_kept(&w->singular, r);
  return cell;
}

/* Returns the sign of s along the sweep. */
static double sweep_sign(const km_sweep_plan *plan) {
  return km_plan_is_driven(plan) && plan->to < plan->from ? -1.0 : 1.0;
}

/* Inserts a dead point in the order of the sweep. */
static bool add_toggle(km_mobility_sweep *out, const km_sweep_plan *plan, int coordinate, double s) {
  const double sign = sweep_sign(plan);
  void *toggles = out->toggles;
  if (!km_reserve(&toggles, &out->toggle_capacity, out->toggle_count + 1, sizeof *out->toggles))
    return false;
  out->toggles = toggles;
  size_t index = out->toggle_count++;
  for (; index > 0 && sign * (out->toggles[index - 1].s - s) > same_position * (1.0 + fabs(s)); --index)
    out->toggles[index] = out->toggles[index - 1];
  out->toggles[index] = (km_toggle){coordinate, s};
  return true;
}

static bool is_passive(const km_sweep *sweep, int coordinate) {
  return sweep->passive_coordinates && sweep->passive_coordinates[coordinate];
}

/* Writes the single null vector with the orientation of the rates. */
static void write_null_vector(const km_sweeper *r, double *z) {
  const km_mechanism *m = r->m;
  const km_substructure *sub = &m->substructures[r->substructure];
  const int *coordinate = m->column_coordinate + sub->column_start;
  const double *Z = km_state_basis(r->s, r->substructure);
  double along = 0.0;
  for (int k = 0; k < sub->columns; ++k)
    along += Z[k] * m->scale[coordinate[k]] * r->rates[coordinate[k]];
  for (int k = 0; k < sub->columns; ++k)
    z[coordinate[k]] = along < 0.0 ? -Z[k] : Z[k];
}

/* Computes the unit direction of the single freedom besides passive ones; false with more freedoms or at the driver's
 * dead point. */
static bool compute_direction(const km_sweeper *r, double *z) {
  int freedom = r->substructure < 0 ? 0 : km_partition_freedom(&r->s->partition[r->substructure]);
  if (freedom - r->out->passive != 1)
    return false;
  if (r->is_batched && freedom == 1) {
    r->mover.direction(r->mover.self, z);
    return true;
  }
  if (!r->mover.rates(r->mover.self, r->rates))
    return false;
  if (freedom == 1)
    write_null_vector(r, z);
  else
    km_unit_direction(r->m, r->rates, z);
  return true;
}

/* Finds the smallest mobility numbers of the table's rows. */
static void find_extremes(const sweep_events *w, int count) {
  const km_table *table = w->out->motion.table;
  for (int c = 0; c < count; ++c) {
    size_t row = km_table_extreme_row(table, w->cell[c], 1.0);
    if (row < km_table_rows(table))
      w->out->extremes[c] = (km_extreme){km_table_row(table, row)[w->cell[c]], km_table_row(table, row)[1]};
  }
}

static void choose_candidates(sweep_events *w, const km_sweeper *r) {
  for (int c = 0; c < r->m->coordinate_count; ++c)
    if (r->m->substructure_of[c] == r->substructure && !r->m->held[c] && !is_passive(r->out, c))
      w->candidates[w->candidate_count++] = c;
}

/* Entry of a coordinate at the row and at the previous one. */
static double entry_at_row(const sweep_events *w, int c) {
  return km_directions_entry(&w->directions, w->directions.row, c);
}

static double entry_at_last(const sweep_events *w, int c) {
  return km_directions_entry(&w->directions, w->directions.last, c);
}

static bool has_last_row(const sweep_events *w) {
  return w->directions.last >= 0;
}

/* Returns the next candidate, from w->next on, whose entry is 0 at this row or may have been since the last. */
static int next_candidate(const sweep_events *w) {
  int i = w->next;
  while (has_last_row(w) && i < w->candidate_count &&
         entry_at_row(w, w->candidates[i]) * entry_at_last(w, w->candidates[i]) > km_batch_sign_threshold)
    ++i;
  return i;
}

/* Adds the dead points at this row and those that a sign change since the last row shows, until a probe is needed. */
static bool add_sign_changes(sweep_events *w, const km_sweeper *r) {
  const km_directions *d = &w->directions;
  for (; (w->next = next_candidate(w)) < w->candidate_count; ++w->next) {
    int c = w->candidates[w->next];
    double z = entry_at_row(w, c), last = has_last_row(w) ? entry_at_last(w, c) : z;
    bool zero_here = fabs(z) < km_zero_entry, zero_before = has_last_row(w) && fabs(last) < km_zero_entry;
    bool changes_sign = !zero_here && !zero_before && z * last < 0.0 && !w->listed[c];
    if (zero_here && !zero_before && !add_toggle(w->out, r->plan, c, d->s[d->row]))
      return false;
    if (changes_sign && !w->searching)
      km_root_search_begin(&w->root_search, d->s[d->last], d->s[d->row], last, z);
    w->searching = changes_sign && w->root_search.open;
    if (w->searching)
      return true;
    if (changes_sign && !add_toggle(w->out, r->plan, c, w->root_search.root))
      return false;
  }
  return true;
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the dead points");
}

static km_status continue_search(sweep_events *w, const km_sweeper *r, km_error *error) {
  return add_sign_changes(w, r) ? KM_OK : no_memory(error);
}

/* True if the entry changes its sign between samples i and i + 1. */
static bool changes_sign_after(const km_directions *d, int i, int c) {
  double z = km_directions_entry(d, i, c), next = km_directions_entry(d, i + 1, c);
  return z * next < 0.0 && fabs(z) >= km_zero_entry && fabs(next) >= km_zero_entry;
}

/* Adds the coordinate's dead points since the last row if the steps show several sign changes. */
static bool add_changes_between_steps(sweep_events *w, km_sweeper *r, int c, bool *moved) {
  const km_directions *d = &w->directions;
  int count = 0;
  bool added = true;
  for (int i = d->last; i < d->row; ++i)
    count += changes_sign_after(d, i, c);
  w->listed[c] = count > 1;
  *moved = *moved || count > 1;
  for (int i = d->last; i < d->row && count > 1 && added; ++i)
    added = !changes_sign_after(d, i, c) || add_toggle(w->out, r->plan, c, km_dead_point_between(r, d, i, c));
  return added;
}

/* True if a dead point of the coordinate in this interval is in the list. */
static bool is_known(const km_mobility_sweep *out, int c, const km_minimum_search *samples) {
  bool known = false;
  for (size_t i = out->toggle_count; i > 0 && !known; --i) {
    const km_toggle *toggle = &out->toggles[i - 1];
    known = toggle->coordinate == c && (toggle->s - samples->s[0]) * (toggle->s - samples->s[2]) <= 0.0;
  }
  return known;
}

/* Adds the coordinate's dead points, since the sample before the last row, that no sign change shows: minima of |z_j|
 * near 0. */
static bool add_minima(sweep_events *w, km_sweeper *r, int c, bool *moved) {
  const km_directions *d = &w->directions;
  bool added = true;
  for (int i = d->last > 0 ? d->last - 1 : 0; i + 2 <= d->row && added; ++i) {
    km_minimum_search samples = {.s = {d->s[i], d->s[i + 1], d->s[i + 2]}};
    double lowest, roots[2];
    for (int k = 0; k < 3; ++k)
      samples.f[k] = km_directions_entry(d, i + k, c);
    if (!km_minimum_search_may_reach_zero(&samples, &lowest) || is_known(w->out, c, &samples))
      continue;
    *moved = true;
    for (int k = km_minimum_search_find(r, c, &samples, lowest, roots); k > 0 && added; --k)
      added = add_toggle(w->out, r->plan, c, roots[k - 1]);
  }
  return added;
}

/* Adds the dead points since the last row that the two rows do not show; none between passed rows. */
static bool add_hidden_dead_points(sweep_events *w, km_sweeper *r) {
  const bool may_probe = has_last_row(w) && !r->is_passed_row;
  bool added = true, moved = false;
  for (int i = 0; i < w->candidate_count && may_probe && added; ++i)
    added = add_changes_between_steps(w, r, w->candidates[i], &moved) && add_minima(w, r, w->candidates[i], &moved);
  if (moved)
    r->mover.restore(r->mover.self);
  return added;
}

/* Stores the direction of motion at the row, if it has one. False without memory. */
static bool store_direction(sweep_events *w, const km_sweeper *r, double s, bool *has_one) {
  const size_t rows = km_table_rows(r->out->table);
  if (rows > w->rows + 1) /* the rows between contain no zero */
    km_directions_skip(&w->directions);
  w->rows = rows;
  double *z = km_directions_row(&w->directions, s);
  *has_one = z && compute_direction(r, z);
  if (!*has_one)
    km_directions_clear(&w->directions);
  return z && !w->directions.failed;
}

static void mark_moved(sweep_events *w) {
  const km_directions *d = &w->directions;
  for (int i = 0; i < w->candidate_count; ++i) {
    const int c = w->candidates[i];
    for (int index = has_last_row(w) ? d->last : d->row; index <= d->row && !w->moved[c]; ++index)
      w->moved[c] = fabs(km_directions_entry(d, index, c)) >= km_zero_entry;
  }
}

/* Finds the dead points since the last row. */
static km_status handle_row(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  bool moves;
  km_status status = km_singular_value_minima_sample(&w->singular, r, s, w->out, error);
  if (status)
    return status;
  if (!store_direction(w, r, s, &moves))
    return no_memory(error);
  if (!moves)
    return KM_OK;
  if (w->candidate_count == 0)
    choose_candidates(w, r);
  mark_moved(w);
  w->next = 0;
  return add_hidden_dead_points(w, r) ? continue_search(w, r, error) : no_memory(error);
}

static void handle_step(void *self, const km_sweeper *r, double s, const double *rates) {
  sweep_events *w = self;
  km_directions_step(&w->directions, r->m, s, rates);
}

static bool next_probe(void *self, double *s) {
  const sweep_events *w = self;
  *s = w->root_search.root;
  return w->searching;
}

static km_status cell_coordinate(void *self, km_sweeper *r, const double *rates, km_error *error) {
  sweep_events *w = self;
  w->root_search.open = false;
  if (rates) {
    km_unit_direction(r->m, rates, r->scratch);
    km_root_search_update(&w->root_search, r->scratch[w->candidates[w->next]]);
  }
  return continue_search(w, r, error);
}

static km_status handle_sample(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  return km_singular_value_minima_sample(&w->singular, r, s, w->out, error);
}

static void handle_branch_switch(void *self) {
  sweep_events *w = self;
  km_directions_clear(&w->directions);
  w->singular.search.have = 0;
}

/* True if the coordinate is at rest at the driver's dead point. The driver's mobility number, the square of its rate,
 * is 0 there up to the accuracy of the position. */
static bool rests_with_driver(const km_sweeper *r, int c) {
  static const double ratio = 100.0; /* ratio of rates of coordinates that move there */
  const double *numbers = r->s->mobility_number;
  return numbers[c] <= ratio * ratio * fmax(numbers[r->plan->coordinate], 1e-30);
}

/* Adds the dead points at an end of the sweep: of the driver and of the coordinates at rest there. */
static km_status handle_end(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  const int driver = r->plan->coordinate;
  const bool one = r->substructure >= 0 && km_partition_freedom(&r->s->partition[r->substructure]) == 1;
  bool added = add_toggle(w->out, r->plan, driver, s);
  w->moved[driver] = true;
  for (int i = 0; i < w->candidate_count && one && added; ++i)
    if (w->candidates[i] != driver && rests_with_driver(r, w->candidates[i]))
      added = add_toggle(w->out, r->plan, w->candidates[i], s);
  return added ? KM_OK : no_memory(error);
}

/* Removes the dead points of coordinates that never move. */
static void remove_resting(const sweep_events *w) {
  km_mobility_sweep *out = w->out;
  size_t kept = 0;
  for (size_t i = 0; i < out->toggle_count; ++i)
    if (w->moved[out->toggles[i].coordinate])
      out->toggles[kept++] = out->toggles[i];
  out->toggle_count = kept;
}

static km_status finish(void *self, const km_sweep_job *job) {
  remove_resting(self);
  if (!job->table_only)
    find_extremes(self, job->m->coordinate_count);
  return job->status;
}

static void close_observer(void *self) {
  sweep_events *w = self;
  km_singular_value_minima_free(&w->singular);
  km_directions_free(&w->directions);
  km_free(w->listed);
  km_free(w->moved);
  km_free(w->candidates);
  km_free(w->cell);
  km_free(w->unread);
  km_free(w->cell_coordinate);
  km_free(w);
}

static km_observer observer_of(sweep_events *w, bool singularities, bool table_only) {
  const bool may_probe = singularities || !table_only;
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_numbers,
                       .row_written = may_probe ? handle_row : NULL,
                       .step_taken = may_probe ? handle_step : NULL,
                       .next_probe = may_probe ? next_probe : NULL,
                       .probed = may_probe ? cell_coordinate : NULL,
                       .sampled_between = singularities ? handle_sample : NULL,
                       .corner = handle_branch_switch,
                       .end_reached = may_probe ? handle_end : NULL,
                       .finish = finish,
                       .close = close_observer,
                       .reads_jacobian = singularities,
                       .number_cells = singularities ? NULL : w->cell,
                       .unread = w->read_columns ? w->unread : NULL};
}

/* Allocates the arrays of the search. */
static bool reserve(sweep_events *w, const km_mechanism *m, const km_sweep_plan *plan) {
  size_t count = (size_t)m->coordinate_count;
  w->out->extremes = KM_NEW(km_extreme, count);
  w->directions = (km_directions){.coordinates = count, .sense = sweep_sign(plan), .last = -1, .row = -1};
  w->listed = KM_NEW(bool, count);
  w->moved = KM_NEW(bool, count);
  w->candidates = KM_NEW(int, count);
  w->cell = KM_NEW(size_t, count);
  w->unread = KM_NEW(bool, count);
  w->cell_coordinate = KM_NEW(int, count + (size_t)m->model->joint_count);
  if (!w->listed || !w->moved || !w->candidates || !w->cell || !w->unread || !w->cell_coordinate || !w->out->extremes)
    return false;
  for (size_t c = 0; c < count; ++c)
    w->out->extremes[c] = (km_extreme){HUGE_VAL, nan("")};
  return true;
}

static km_status open_observer(km_sweep_job *job, km_mobility_sweep *out) {
  km_status fits = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (fits)
    return fits;
  sweep_events *w = KM_NEW(sweep_events, 1);
  bool singularities = job->plan->singularities, ready = w != NULL;
  if (ready) {
    w->out = out;
    w->read_columns = job->table_only ? job->read_columns : NULL;
    ready = reserve(w, job->m, job->plan) && (!singularities || km_singular_value_minima_create(&w->singular, job->m));
    w->observer = observer_of(w, singularities, job->table_only);
    job->observer = &w->observer;
  }
  return ready ? KM_OK : km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
}

void km_mobility_sweep_open(km_sweep_job *job, km_mobility_sweep *out) {
  *out = (km_mobility_sweep){.motion = {.substructure = -1}, .smallest = {nan(""), nan("")}};
  job->out = &out->motion;
  job->status = open_observer(job, out);
}

km_status km_mobility_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_mobility_sweep *out,
                                km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  km_sweep_job job = {.m = m, .s = s, .plan = plan, .error = error};
  km_mobility_sweep_open(&job, out);
  km_sweeps_run(&job, 1);
  return job.status;
}

void km_mobility_sweep_free(km_mobility_sweep *sweep) {
  if (!sweep)
    return;
  km_sweep_free(&sweep->motion);
  km_free(sweep->toggles);
  km_free(sweep->extremes);
  km_free(sweep->minima);
  *sweep = (km_mobility_sweep){0};
}
