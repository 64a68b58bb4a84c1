/* Mobility numbers along a sweep and the dead points of coordinates (theory 10.3, 10.4).
 *
 *   z = D q̇/|D q̇| at rows and steps; a coordinate has a dead point where its entry z_j is 0:
 *   sign change between rows, several sign changes between steps, or a minimum of |z_j| near 0 */
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "base/table.h"
#include "sweep/clearance/clearance_search.h"
#include "sweep/events/event_search.h"
#include "sweep/singular_value_minima.h"
#include "sweep/sweep_observer.h"
#include "sweep/transmission_columns.h"

#include <string.h>

/* State of the search between rows. */
typedef struct sweep_events {
  km_mobility_sweep *out;
  km_observer observer;
  km_event_search search; /* zeros of the entries z of the candidates */
  km_events events;
  km_arena arena;
  size_t rows;     /* rows of the table at the last call */
  bool *moved;     /* [coordinate] it moved at some row: coordinates at rest have no dead points */
  int *candidates; /* coordinates that can have dead points */
  int candidate_count;
  int *cell_coordinate; /* coordinate of each column of mobility numbers, -1: joint without freedom */
  int column_count;
  size_t *cell;                    /* [coordinate] cell of its mobility number in a row; 0: none */
  bool *unread;                    /* [coordinate] see km_observer */
  const char *const *read_columns; /* see km_sweep_job */
  km_singular_value_minima singular;
  const km_port *ports; /* [input, output] of the transmission; NULL: not requested */
  km_transmission_columns transmission;
  km_clearance_search clearances;
  bool failed; /* no memory for the last row */
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
  if (r->plan->singularities)
    added = km_table_add_joined_column(table, "", "singular_value", "", NULL) && added;
  return added && (!w->ports || km_transmission_columns_add(&w->transmission, &w->ports[1], table)) &&
         km_clearance_search_columns(&w->clearances, r, table);
}

/* The motion at the row; 0 where it has no direction. */
static const double *rates_at_row(km_sweeper *r) {
  if (r->is_batched)
    return km_sweeper_batched_rates(r);
  if (km_sweeper_update_rates(r))
    return r->rates;
  memset(r->scratch, 0, (size_t)r->m->coordinate_count * sizeof *r->scratch);
  return r->scratch;
}

static double *write_numbers(void *self, km_sweeper *r, double *cell) {
  sweep_events *w = self;
  const int *cell_coordinate = w->cell_coordinate;
  const double *numbers = r->s->mobility_number;
  for (int i = 0, count = w->column_count; i < count; ++i)
    *cell++ = cell_coordinate[i] < 0 ? 0.0 : numbers[cell_coordinate[i]];
  if (r->plan->singularities)
    *cell++ = km_singular_value_kept(&w->singular, r);
  if (w->ports) {
    cell = km_transmission_columns_write(&w->transmission, r->s, rates_at_row(r), cell);
    w->failed = w->failed || w->transmission.failed;
  }
  return km_clearance_search_cells(&w->clearances, r, cell);
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

/* Computes the unit direction D q̇/|D q̇| of the rates. */
static void compute_unit_direction(const km_mechanism *m, const double *rates, double *z) {
  double sum = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    z[c] = m->scale[c] * rates[c];
    sum += z[c] * z[c];
  }
  double inverse = 1.0 / sqrt(sum);
  for (int c = 0; c < m->coordinate_count; ++c)
    z[c] *= inverse;
}

/* Computes the unit direction of the single freedom besides passive ones; false with more freedoms or at the driver's
 * dead point. */
static bool compute_direction(const km_sweeper *r, double *z) {
  int freedom = r->substructure < 0 ? 0 : km_factor_freedom(r->s->factor[r->substructure]);
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
    compute_unit_direction(r->m, r->rates, z);
  return true;
}

/* Copies the candidates' entries of a unit direction, rounding as 0 but at a probe, and marks those that move. */
static void copy_entries(sweep_events *w, const double *z, double *entries) {
  for (int i = 0; i < w->candidate_count; ++i) {
    const int c = w->candidates[i];
    bool moves = fabs(z[c]) >= km_relative_zero;
    entries[i] = moves || w->search.is_probing ? z[c] : 0.0;
    w->moved[c] = w->moved[c] || moves;
  }
}

/* Computes the entries at a row or a probe; NaN without a direction of motion. */
static void compute_values(void *self, km_sweeper *r, double *n, double *d) {
  sweep_events *w = self;
  (void)d;
  bool has_direction = true;
  if (w->search.is_probing)
    compute_unit_direction(r->m, r->rates, r->scratch);
  else
    has_direction = compute_direction(r, r->scratch);
  if (has_direction)
    copy_entries(w, r->scratch, n);
  for (int i = 0; i < w->candidate_count && !has_direction; ++i)
    n[i] = nan("");
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

/* Chooses the coordinates that can have dead points: of the moving substructure, without passive ones. */
static void choose_candidates(sweep_events *w, const km_sweeper *r) {
  for (int c = 0; c < r->m->coordinate_count; ++c)
    if (c == r->plan->coordinate ||
        (r->m->substructure_of[c] == r->substructure && !r->m->held[c] && !is_passive(r->out, c)))
      w->candidates[w->candidate_count++] = c;
}

/* Finds the least singular values and the contacts since the last sample. */
static km_status handle_sample(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  km_status status = km_singular_value_minima_sample(&w->singular, r, s, w->out, error);
  return status ? status : km_clearance_search_sample(&w->clearances, r, s, error);
}

/* Finds the dead points and the events of handle_sample since the last row. */
static km_status handle_row(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  const size_t rows = km_table_rows(r->out->table);
  if (w->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the transmission");
  km_status status = handle_sample(self, r, s, error);
  if (status)
    return status;
  if (rows == 1) {
    choose_candidates(w, r);
    km_event_search_set_count(&w->search, w->candidate_count);
  }
  if (rows > w->rows + 1) /* the rows between contain no zero */
    km_event_search_restart(&w->search);
  w->rows = rows;
  return km_event_search_sample(&w->search, r, s, error);
}

static void handle_step(void *self, const km_sweeper *r, double s, const double *rates) {
  sweep_events *w = self;
  double *entries = km_event_search_step(&w->search, s);
  if (!entries)
    return;
  compute_unit_direction(r->m, rates, r->scratch);
  copy_entries(w, r->scratch, entries);
}

static bool next_probe(void *self, double *s) {
  return km_event_search_next_probe(&((sweep_events *)self)->search, s);
}

static km_status handle_probe(void *self, km_sweeper *r, const double *rates, km_error *error) {
  return km_event_search_probed(&((sweep_events *)self)->search, r, rates != NULL, error);
}

static void handle_branch_switch(void *self) {
  sweep_events *w = self;
  km_event_search_restart(&w->search);
  km_event_search_restart(&w->singular.search);
  km_clearance_search_restart(&w->clearances);
}

/* True if the coordinate is at rest at the driver's dead point. The driver's mobility number, the square of its rate,
 * is 0 there up to the accuracy of the position. */
static bool rests_with_driver(const km_sweeper *r, int c) {
  const double *numbers = r->s->mobility_number;
  return numbers[c] <= km_significant_ratio * km_significant_ratio * fmax(numbers[r->plan->coordinate], 1e-30);
}

/* Adds the dead points at an end of the sweep: of the driver and of the coordinates at rest there. */
static km_status handle_end(void *self, km_sweeper *r, double s, km_error *error) {
  sweep_events *w = self;
  const int driver = r->plan->coordinate;
  const bool has_one_freedom = r->substructure >= 0 && km_factor_freedom(r->s->factor[r->substructure]) == 1;
  km_status status = KM_OK;
  for (int pass = 0; pass < 2; ++pass) /* the driver first */
    for (int i = 0; i < w->candidate_count && !status; ++i) {
      const int c = w->candidates[i];
      if (pass ? c != driver && has_one_freedom && rests_with_driver(r, c) : c == driver)
        status = km_events_add(&w->events, (km_event){KM_EVENT_ZERO, i, s, 0.0}, error);
    }
  w->moved[driver] = true;
  return status;
}

/* Collects the dead points of coordinates that move, in the order of the sweep. */
static km_status collect_toggles(const sweep_events *w, const km_sweep_job *job) {
  km_mobility_sweep *out = w->out;
  km_events events = w->events;
  km_events_sort(&events, job->plan);
  out->toggles = KM_NEW(km_toggle, events.count);
  if (!out->toggles)
    return km_fail(job->error, KM_MEMORY, "out of memory for the dead points");
  for (size_t i = 0; i < events.count; ++i) {
    const int c = w->candidates[events.items[i].function];
    if (w->moved[c])
      out->toggles[out->toggle_count++] = (km_toggle){c, events.items[i].s};
  }
  return KM_OK;
}

static km_status finish(void *self, const km_sweep_job *job) {
  sweep_events *w = self;
  km_status status = collect_toggles(w, job);
  if (!status)
    status = km_clearance_search_finish(&w->clearances, job->plan, job->error);
  if (w->ports)
    km_transmission_columns_finish(&w->transmission, &w->out->motion);
  if (!job->table_only)
    find_extremes(w, job->m->coordinate_count);
  return status ? status : job->status;
}

static void close_observer(void *self) {
  sweep_events *w = self;
  km_singular_value_minima_free(&w->singular);
  km_transmission_columns_free(&w->transmission);
  km_clearance_search_free(&w->clearances);
  km_event_search_free(&w->search);
  km_free(w->events.items);
  km_arena_free(&w->arena);
  km_free(w);
}

static km_observer observer_of(sweep_events *w, const km_sweep_plan *plan, bool table_only) {
  const bool samples = plan->singularities || (plan->clearance && !table_only);
  const bool may_probe = plan->singularities || !table_only;
  const bool reads_rows = plan->singularities || plan->clearance || w->ports;
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_numbers,
                       .row_written = may_probe ? handle_row : NULL,
                       .step_taken = may_probe ? handle_step : NULL,
                       .next_probe = may_probe ? next_probe : NULL,
                       .probed = may_probe ? handle_probe : NULL,
                       .sampled_between = samples ? handle_sample : NULL,
                       .corner = handle_branch_switch,
                       .end_reached = may_probe ? handle_end : NULL,
                       .finish = finish,
                       .close = close_observer,
                       .reads_jacobian = reads_rows,
                       .number_cells = reads_rows ? NULL : w->cell,
                       .unread = w->read_columns ? w->unread : NULL};
}

/* Allocates the arrays of the search. */
static bool reserve(sweep_events *w, const km_mechanism *m, const km_sweep_plan *plan) {
  size_t count = (size_t)m->coordinate_count;
  w->out->extremes = KM_NEW(km_extreme, count);
  w->search = (km_event_search){.self = w,
                                .values = compute_values,
                                .ratios = true,
                                .dips = true,
                                .defers = true,
                                .zero = km_relative_zero,
                                .events = &w->events};
  w->moved = KM_ARENA_NEW(&w->arena, bool, count);
  w->candidates = KM_ARENA_NEW(&w->arena, int, count);
  w->cell = KM_ARENA_NEW(&w->arena, size_t, count);
  w->unread = KM_ARENA_NEW(&w->arena, bool, count);
  w->cell_coordinate = KM_ARENA_NEW(&w->arena, int, count + (size_t)m->model->joint_count);
  if (!km_event_search_reserve(&w->search, m->coordinate_count, plan) || w->arena.failed || !w->out->extremes)
    return false;
  for (size_t c = 0; c < count; ++c)
    w->out->extremes[c] = (km_extreme){HUGE_VAL, nan("")};
  return true;
}

static km_status open_observer(km_sweep_job *job, const km_port *ports, km_mobility_sweep *out) {
  km_status fits = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (fits)
    return fits;
  sweep_events *w = KM_NEW(sweep_events, 1);
  bool singularities = job->plan->singularities, ready = w != NULL;
  if (ready) {
    w->out = out;
    w->ports = ports;
    w->read_columns = job->table_only ? job->read_columns : NULL;
    ready = reserve(w, job->m, job->plan) &&
            (!singularities || km_singular_value_minima_create(&w->singular, job->m, job->plan));
    w->observer = observer_of(w, job->plan, job->table_only);
    job->observer = &w->observer;
  }
  if (!ready)
    return km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
  km_status made = km_clearance_search_create(job->plan, &out->clearances, job->table_only, &w->clearances, job->error);
  if (made)
    return made;
  return ports ? km_transmission_columns_create(job->m, &ports[0], &ports[1], &w->transmission, job->error) : KM_OK;
}

void km_mobility_sweep_open(km_sweep_job *job, const km_port *ports, km_mobility_sweep *out) {
  *out = (km_mobility_sweep){.motion = {.substructure = -1}, .smallest = {nan(""), nan("")}};
  job->out = &out->motion;
  job->status = open_observer(job, ports, out);
}

km_status km_mobility_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_mobility_sweep *out,
                                km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  km_sweep_job job = {.m = m, .s = s, .plan = plan, .error = error};
  km_mobility_sweep_open(&job, NULL, out);
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
  km_clearance_course_free(&sweep->clearances);
  *sweep = (km_mobility_sweep){0};
}
