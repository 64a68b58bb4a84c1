/* Mobility numbers over a sweep, and where a joint loses its grip: roots of its entry in the direction of motion. */
#include "base/arguments.h"
#include "base/table.h"
#include "sweep/dead_points.h"
#include "sweep/singular_value_minima.h"
#include "sweep/sweep_observer.h"

#include <string.h>

/* Toggles of joints that stand together lie as near to each other. */
static const double same_place = 1e-9;

/* What a mobility sweep remembers from row to row. */
typedef struct watch {
  km_mobility_sweep *out;
  km_observer observer;
  km_directions directions;
  size_t rows; /* of the table, when a row was seen last */
  km_root_search at;
  bool searching; /* for a toggle of the coordinate watched[next] */
  int next;
  bool *listed; /* [coordinate] its toggles since the last row are */
  bool *moved;  /* [coordinate] somewhere in the sweep: what stands all the way has no toggles */
  int *watched; /* coordinates that may lose their grip */
  int watched_count;
  int *shown; /* coordinate of each column of numbers, -1: of a joint that can't move */
  int shown_count;
  size_t *cell;             /* [coordinate] of its number in a row; 0: it has none */
  bool *unread;             /* [coordinate] see km_observer */
  const char *const *reads; /* see km_sweep_job */
  km_singular_value_watch singular;
} watch;

/* The column of a number (m) or of a coordinate (q). */
static bool is_read(const watch *w, char kind, const char *label) {
  bool found = !w->reads;
  for (const char *const *name = w->reads; !found && *name; ++name)
    found = (*name)[0] == kind && (*name)[1] == '.' && strcmp(*name + 2, label) == 0;
  return found;
}

/* The column of coordinate c, -1: of a joint that can't move. */
static bool add_column(watch *w, const char *label, int c, km_table *table) {
  if (!is_read(w, 'm', label))
    return true;
  if (c >= 0)
    w->cell[c] = km_table_columns(table);
  w->shown[w->shown_count++] = c;
  return km_table_join_column(table, "m.", label, "", NULL);
}

/* A column for each coordinate, and one for each joint that has none. */
static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  watch *w = self;
  const km_model *model = r->m->model;
  bool added = true;
  w->shown_count = 0;
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
  return (!r->plan->singularities || km_table_join_column(table, "", "singular_value", "", NULL)) && added;
}

static double *write_numbers(void *self, km_sweeper *r, double *cell) {
  watch *w = self;
  const int *shown = w->shown;
  const double *numbers = r->s->mobility_number;
  for (int i = 0, count = w->shown_count; i < count; ++i)
    *cell++ = shown[i] < 0 ? 0.0 : numbers[shown[i]];
  if (r->plan->singularities)
    *cell++ = km_singular_value_kept(&w->singular, r);
  return cell;
}

/* In which s goes along the sweep. */
static double sense_of(const km_sweep_plan *plan) {
  return km_plan_is_driven(plan) && plan->to < plan->from ? -1.0 : 1.0;
}

/* Behind those that the sweep has passed before it, or at the same place but for rounding. */
static bool add_toggle(km_mobility_sweep *out, const km_sweep_plan *plan, int coordinate, double s) {
  const double sense = sense_of(plan);
  void *toggles = out->toggles;
  if (!km_reserve(&toggles, &out->toggle_capacity, out->toggle_count + 1, sizeof *out->toggles))
    return false;
  out->toggles = toggles;
  size_t place = out->toggle_count++;
  for (; place > 0 && sense * (out->toggles[place - 1].s - s) > same_place * (1.0 + fabs(s)); --place)
    out->toggles[place] = out->toggles[place - 1];
  out->toggles[place] = (km_toggle){coordinate, s};
  return true;
}

static bool is_idle(const km_sweep *sweep, int coordinate) {
  return sweep->idle_coordinates && sweep->idle_coordinates[coordinate];
}

/* The only null vector, as the mobility numbers have it; its sense is that of the rates. */
static void take_null_vector(const km_sweeper *r, double *z) {
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

/* The unit direction of the one free motion, in the order of the coordinates, beside which idle freedoms move least;
 * false where there is more than one, or the driver stands at its own toggle. */
static bool direction(const km_sweeper *r, double *z) {
  int freedom = r->substructure < 0 ? 0 : km_partition_freedom(&r->s->partition[r->substructure]);
  if (freedom - r->out->idle != 1)
    return false;
  if (r->rides && freedom == 1) {
    r->mover.direction(r->mover.self, z);
    return true;
  }
  if (!r->mover.rates(r->mover.self, r->rates))
    return false;
  if (freedom == 1)
    take_null_vector(r, z);
  else
    km_unit_direction(r->m, r->rates, z);
  return true;
}

/* The smallest mobility numbers of the table's rows. */
static void find_extremes(const watch *w, int count) {
  const km_table *table = w->out->motion.table;
  for (int c = 0; c < count; ++c) {
    size_t row = km_table_extreme_row(table, w->cell[c], 1.0);
    if (row < km_table_rows(table))
      w->out->extremes[c] = (km_extreme){km_table_row(table, row)[w->cell[c]], km_table_row(table, row)[1]};
  }
}

static void choose_watched(watch *w, const km_sweeper *r) {
  for (int c = 0; c < r->m->coordinate_count; ++c)
    if (r->m->substructure_of[c] == r->substructure && !r->m->held[c] && !is_idle(r->out, c))
      w->watched[w->watched_count++] = c;
}

/* The coordinate's entry at the row, and at the one before. */
static double entry_here(const watch *w, int c) {
  return km_directions_entry(&w->directions, w->directions.row, c);
}

static double entry_before(const watch *w, int c) {
  return km_directions_entry(&w->directions, w->directions.last, c);
}

static bool has_last(const watch *w) {
  return w->directions.last >= 0;
}

/* The next of the watched coordinates, from w->next on, whose entry may be 0 at this row or have been since the last. */
static int next_candidate(const watch *w) {
  int i = w->next;
  while (has_last(w) && i < w->watched_count &&
         entry_here(w, w->watched[i]) * entry_before(w, w->watched[i]) > km_batch_sign_threshold)
    ++i;
  return i;
}

/* Lists the toggles at this row, and those since the last one that both rows show, as far as no more has to be seen for them. */
static bool list_toggles(watch *w, const km_sweeper *r) {
  const km_directions *d = &w->directions;
  for (; (w->next = next_candidate(w)) < w->watched_count; ++w->next) {
    int c = w->watched[w->next];
    double z = entry_here(w, c), last = has_last(w) ? entry_before(w, c) : z;
    bool here = fabs(z) < km_dead, before = has_last(w) && fabs(last) < km_dead;
    bool between = !here && !before && z * last < 0.0 && !w->listed[c];
    if (here && !before && !add_toggle(w->out, r->plan, c, d->s[d->row]))
      return false;
    if (between && !w->searching)
      km_root_search_begin(&w->at, d->s[d->last], d->s[d->row], last, z);
    w->searching = between && w->at.open;
    if (w->searching)
      return true;
    if (between && !add_toggle(w->out, r->plan, c, w->at.root))
      return false;
  }
  return true;
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the dead points");
}

static km_status go_on(watch *w, const km_sweeper *r, km_error *error) {
  return list_toggles(w, r) ? KM_OK : no_memory(error);
}

/* Does the entry change its sign between the places i and i + 1? */
static bool changes(const km_directions *d, int i, int c) {
  double z = km_directions_entry(d, i, c), next = km_directions_entry(d, i + 1, c);
  return z * next < 0.0 && fabs(z) >= km_dead && fabs(next) >= km_dead;
}

/* Lists the coordinate's toggles since the last row where the steps show more of them than both rows. */
static bool list_changes(watch *w, km_sweeper *r, int c, bool *moved) {
  const km_directions *d = &w->directions;
  int count = 0;
  bool added = true;
  for (int i = d->last; i < d->row; ++i)
    count += changes(d, i, c);
  w->listed[c] = count > 1;
  *moved = *moved || count > 1;
  for (int i = d->last; i < d->row && count > 1 && added; ++i)
    added = !changes(d, i, c) || add_toggle(w->out, r->plan, c, km_dead_point_between(r, d, i, c));
  return added;
}

/* Is a toggle of the coordinate known there already? */
static bool is_known(const km_mobility_sweep *out, int c, const km_minimum_search *dip) {
  bool known = false;
  for (size_t i = out->toggle_count; i > 0 && !known; --i) {
    const km_toggle *toggle = &out->toggles[i - 1];
    known = toggle->coordinate == c && (toggle->s - dip->s[0]) * (toggle->s - dip->s[2]) <= 0.0;
  }
  return known;
}

/* Lists the coordinate's toggles since the last row, and since the place before it, that no change of sign shows. */
static bool list_dips(watch *w, km_sweeper *r, int c, bool *moved) {
  const km_directions *d = &w->directions;
  bool added = true;
  for (int i = d->last > 0 ? d->last - 1 : 0; i + 2 <= d->row && added; ++i) {
    km_minimum_search dip = {.s = {d->s[i], d->s[i + 1], d->s[i + 2]}};
    double lowest, roots[2];
    for (int k = 0; k < 3; ++k)
      dip.f[k] = km_directions_entry(d, i + k, c);
    if (!km_minimum_search_is_zero(&dip, &lowest) || is_known(w->out, c, &dip))
      continue;
    *moved = true;
    for (int k = km_minimum_search_find(r, c, &dip, lowest, roots); k > 0 && added; --k)
      added = add_toggle(w->out, r->plan, c, roots[k - 1]);
  }
  return added;
}

/* Lists the toggles since the last row that both rows don't show. Beside rows that are passed there are none. */
static bool list_hidden(watch *w, km_sweeper *r) {
  const bool looks = has_last(w) && !r->passed;
  bool added = true, moved = false;
  for (int i = 0; i < w->watched_count && looks && added; ++i)
    added = list_changes(w, r, w->watched[i], &moved) && list_dips(w, r, w->watched[i], &moved);
  if (moved)
    r->mover.settle(r->mover.self);
  return added;
}

/* The direction of motion at the row, if it has one. False when out of memory. */
static bool take_direction(watch *w, const km_sweeper *r, double s, bool *has_one) {
  const size_t rows = km_table_rows(r->out->table);
  if (rows > w->rows + 1) /* those between were quiet ones */
    km_directions_skip(&w->directions);
  w->rows = rows;
  double *z = km_directions_row(&w->directions, s);
  *has_one = z && direction(r, z);
  if (!*has_one)
    km_directions_forget(&w->directions);
  return z && !w->directions.failed;
}

static void note_motion(watch *w) {
  const km_directions *d = &w->directions;
  for (int i = 0; i < w->watched_count; ++i) {
    const int c = w->watched[i];
    for (int place = has_last(w) ? d->last : d->row; place <= d->row && !w->moved[c]; ++place)
      w->moved[c] = fabs(km_directions_entry(d, place, c)) >= km_dead;
  }
}

/* Looks for toggles since the last row. */
static km_status see(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  bool moves;
  km_status status = km_singular_value_observe(&w->singular, r, s, w->out, error);
  if (status)
    return status;
  if (!take_direction(w, r, s, &moves))
    return no_memory(error);
  if (!moves)
    return KM_OK;
  if (w->watched_count == 0)
    choose_watched(w, r);
  note_motion(w);
  w->next = 0;
  return list_hidden(w, r) ? go_on(w, r, error) : no_memory(error);
}

static void step(void *self, const km_sweeper *r, double s, const double *rates) {
  watch *w = self;
  km_directions_step(&w->directions, r->m, s, rates);
}

static bool wants(void *self, double *s) {
  const watch *w = self;
  *s = w->at.root;
  return w->searching;
}

static km_status shown(void *self, km_sweeper *r, const double *rates, km_error *error) {
  watch *w = self;
  w->at.open = false;
  if (rates) {
    km_unit_direction(r->m, rates, r->scratch);
    km_root_search_narrow(&w->at, r->scratch[w->watched[w->next]]);
  }
  return go_on(w, r, error);
}

static km_status pass(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  return km_singular_value_observe(&w->singular, r, s, w->out, error);
}

static void forget(void *self) {
  watch *w = self;
  km_directions_forget(&w->directions);
  w->singular.scan.have = 0;
}

/* Does the coordinate stop where the driver does? There the driver's number, the square of its rate in the one motion, is 0 but for
 * how well the place is known. */
static bool stops_with(const km_sweeper *r, int c) {
  static const double ratio = 100.0; /* of rates that both keep beside the place */
  const double *numbers = r->s->mobility_number;
  return numbers[c] <= ratio * ratio * fmax(numbers[r->plan->coordinate], 1e-30);
}

/* The sweep ends at a dead point of its driver, and of what stops with it. */
static km_status end_at(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  const int driver = r->plan->coordinate;
  const bool one = r->substructure >= 0 && km_partition_freedom(&r->s->partition[r->substructure]) == 1;
  bool added = add_toggle(w->out, r->plan, driver, s);
  w->moved[driver] = true;
  for (int i = 0; i < w->watched_count && one && added; ++i)
    if (w->watched[i] != driver && stops_with(r, w->watched[i]))
      added = add_toggle(w->out, r->plan, w->watched[i], s);
  return added ? KM_OK : no_memory(error);
}

/* Joints that stand all the way lose no grip that they had. */
static void drop_standing(const watch *w) {
  km_mobility_sweep *out = w->out;
  size_t kept = 0;
  for (size_t i = 0; i < out->toggle_count; ++i)
    if (w->moved[out->toggles[i].coordinate])
      out->toggles[kept++] = out->toggles[i];
  out->toggle_count = kept;
}

static km_status tell(void *self, const km_sweep_job *job) {
  drop_standing(self);
  if (!job->table_only)
    find_extremes(self, job->m->coordinate_count);
  return job->status;
}

static void close_watch(void *self) {
  watch *w = self;
  km_singular_value_watch_free(&w->singular);
  km_directions_free(&w->directions);
  km_free(w->listed);
  km_free(w->moved);
  km_free(w->watched);
  km_free(w->cell);
  km_free(w->unread);
  km_free(w->shown);
  km_free(w);
}

static km_observer observer_of(watch *w, bool singularities, bool table_only) {
  const bool looks = singularities || !table_only;
  return (km_observer){.self = w,
                       .columns = add_columns,
                       .cells = write_numbers,
                       .seen = looks ? see : NULL,
                       .stepped = looks ? step : NULL,
                       .wants = looks ? wants : NULL,
                       .shown = looks ? shown : NULL,
                       .passed = singularities ? pass : NULL,
                       .corner = forget,
                       .ended = looks ? end_at : NULL,
                       .tell = tell,
                       .close = close_watch,
                       .reads_jacobian = singularities,
                       .number_cells = singularities ? NULL : w->cell,
                       .unread = w->reads ? w->unread : NULL};
}

/* Space for a mechanism's numbers. */
static bool reserve(watch *w, const km_mechanism *m, const km_sweep_plan *plan) {
  size_t count = (size_t)m->coordinate_count;
  w->out->extremes = KM_NEW(km_extreme, count);
  w->directions = (km_directions){.coordinates = count, .sense = sense_of(plan), .last = -1, .row = -1};
  w->listed = KM_NEW(bool, count);
  w->moved = KM_NEW(bool, count);
  w->watched = KM_NEW(int, count);
  w->cell = KM_NEW(size_t, count);
  w->unread = KM_NEW(bool, count);
  w->shown = KM_NEW(int, count + (size_t)m->model->joint_count);
  if (!w->listed || !w->moved || !w->watched || !w->cell || !w->unread || !w->shown || !w->out->extremes)
    return false;
  for (size_t c = 0; c < count; ++c)
    w->out->extremes[c] = (km_extreme){HUGE_VAL, nan("")};
  return true;
}

static km_status open_watch(km_sweep_job *job, km_mobility_sweep *out) {
  km_status fits = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (fits)
    return fits;
  watch *w = KM_NEW(watch, 1);
  bool singularities = job->plan->singularities, ready = w != NULL;
  if (ready) {
    w->out = out;
    w->reads = job->table_only ? job->reads : NULL;
    ready = reserve(w, job->m, job->plan) && (!singularities || km_singular_value_watch_make(&w->singular, job->m));
    w->observer = observer_of(w, singularities, job->table_only);
    job->observer = &w->observer;
  }
  return ready ? KM_OK : km_fail(job->error, KM_MEMORY, "out of memory for a sweep");
}

void km_mobility_sweep_open(km_sweep_job *job, km_mobility_sweep *out) {
  *out = (km_mobility_sweep){.motion = {.substructure = -1}, .smallest = {nan(""), nan("")}};
  job->out = &out->motion;
  job->status = open_watch(job, out);
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
