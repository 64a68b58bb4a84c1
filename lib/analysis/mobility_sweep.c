/* Mobility numbers over a sweep, and where a joint loses its grip: roots of its entry in the direction of motion. */
#include "analysis/observers.h"
#include "analysis/singular.h"
#include "base/check.h"
#include "base/table.h"
#include "kinematics/drive_lanes.h"

#include <string.h>

/* |z| below this is 0: z = Z_j of the one free direction, known to about 1e-12. */
static const double zero = 1e-9;

/* For a root between a and b, with the values fa and fb: the place that is looked at next. */
typedef struct search {
  double a, b, fa, fb, root, width;
  int round;
  bool open; /* the value at `root` is wanted */
} search;

/* What a mobility sweep remembers from row to row. */
typedef struct watch {
  km_mobility_sweep *out;
  km_observer observer;
  double *room;       /* of the next two, which change places from row to row */
  double *z, *last_z; /* [coordinate] unit direction of motion at the row and at the row before */
  double s, last_s;
  bool have_last;
  search at;
  bool searching; /* for a toggle of the coordinate watched[next] */
  int next;
  int *watched; /* coordinates that may lose their grip */
  int watched_count;
  int *shown; /* coordinate of each column of numbers, -1: of a joint that can't move */
  int shown_count;
  size_t *cell;             /* [coordinate] of its number in a row; 0: it has none */
  bool *unread;             /* [coordinate] see km_observer */
  const char *const *reads; /* see km_sweep_job */
  km_singular_watch singular;
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
  const double *numbers = r->s->numbers;
  for (int i = 0, count = w->shown_count; i < count; ++i)
    *cell++ = shown[i] < 0 ? 0.0 : numbers[shown[i]];
  if (r->plan->singularities)
    *cell++ = km_singular_kept(&w->singular, r);
  return cell;
}

static bool add_toggle(km_mobility_sweep *out, int coordinate, double s) {
  void *toggles = out->toggles;
  if (!km_reserve(&toggles, &out->toggle_capacity, out->toggle_count + 1, sizeof *out->toggles))
    return false;
  out->toggles = toggles;
  out->toggles[out->toggle_count++] = (km_toggle){coordinate, s};
  return true;
}

static void normalise(const km_mechanism *m, const double *rates, double *z) {
  double sum = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    z[c] = m->scale[c] * rates[c];
    sum += z[c] * z[c];
  }
  double inverse = 1.0 / sqrt(sum);
  for (int c = 0; c < m->coordinate_count; ++c)
    z[c] *= inverse;
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
    normalise(r->m, r->rates, z);
  return true;
}

/* A root is found where the next place would be nearer than this part of the interval: the places before it were that near
 * already, and the errors of regula falsi multiply. */
static const double found = 1e-9;

/* The next place of the search, or none where the root is found: by regula falsi (Illinois) on the closed pose. */
static void choose_place(search *at) {
  double last = at->root;
  at->open = at->round < 60 && fabs(at->b - at->a) > 1e-13 * (fabs(at->a) + fabs(at->b));
  if (!at->open)
    return;
  at->root = (at->a * at->fb - at->b * at->fa) / (at->fb - at->fa);
  at->open = at->round <= 1 || fabs(at->root - last) >= found * at->width;
}

/* The sign of z_c changes between last_s and s: where exactly? */
static void begin_search(watch *w, int c) {
  double a = w->last_s, b = w->s;
  w->at = (search){.a = a, .b = b, .fa = w->last_z[c], .fb = w->z[c], .root = b, .width = fabs(b - a)};
  choose_place(&w->at);
}

/* f: z_c at the place that was chosen. */
static void narrow(search *at, double f) {
  if (f * at->fb < 0.0) {
    at->a = at->b;
    at->fa = at->fb;
  } else {
    at->fa *= 0.5;
  }
  at->b = at->root;
  at->fb = f;
  at->round++;
  choose_place(at);
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

/* The next of the watched coordinates, from w->next on, whose entry may be 0 at this row or have been since the last. */
static int next_candidate(const watch *w) {
  const int *watched = w->watched;
  const double *z = w->z, *last = w->last_z;
  int i = w->next, count = w->watched_count;
  while (w->have_last && i < count && z[watched[i]] * last[watched[i]] > km_drive_quiet)
    ++i;
  return i;
}

/* Lists the toggles since the last row as far as no more has to be seen for them; then this row is the last one. */
static bool list_toggles(watch *w) {
  for (; (w->next = next_candidate(w)) < w->watched_count; ++w->next) {
    int c = w->watched[w->next];
    bool here = fabs(w->z[c]) < zero, before = w->have_last && fabs(w->last_z[c]) < zero;
    bool between = w->have_last && !here && !before && w->z[c] * w->last_z[c] < 0.0;
    if (here && !before && !add_toggle(w->out, c, w->s))
      return false;
    if (between && !w->searching)
      begin_search(w, c);
    w->searching = between && w->at.open;
    if (w->searching)
      return true;
    if (between && !add_toggle(w->out, c, w->at.root))
      return false;
  }
  double *swap = w->last_z;
  w->last_z = w->z;
  w->z = swap;
  w->last_s = w->s;
  w->have_last = true;
  return true;
}

static km_status go_on(watch *w, km_error *error) {
  return list_toggles(w) ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for the dead points");
}

/* Looks for toggles since the last row. */
static km_status see(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  km_status status = km_singular_see(&w->singular, r, s, w->out, error);
  if (status)
    return status;
  if (!direction(r, w->z)) {
    w->have_last = false;
    return KM_OK;
  }
  if (w->watched_count == 0)
    choose_watched(w, r);
  w->s = s;
  w->next = 0;
  return go_on(w, error);
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
    normalise(r->m, rates, r->scratch);
    double f = r->scratch[w->watched[w->next]];
    if (!(fabs(f) < 1e-14))
      narrow(&w->at, f);
  }
  return go_on(w, error);
}

static km_status pass(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  return km_singular_see(&w->singular, r, s, w->out, error);
}

static void forget(void *self) {
  watch *w = self;
  w->have_last = false;
  w->singular.scan.have = 0;
}

static km_status end_at(void *self, km_sweeper *r, double s, km_error *error) {
  const watch *w = self;
  return add_toggle(w->out, r->plan->coordinate, s) ? KM_OK
                                                    : km_fail(error, KM_MEMORY, "out of memory for the dead points");
}

static km_status tell(void *self, const km_sweep_job *job) {
  if (!job->table_only)
    find_extremes(self, job->m->coordinate_count);
  return job->status;
}

static void close_watch(void *self) {
  watch *w = self;
  km_singular_watch_free(&w->singular);
  km_free(w->room);
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
static bool reserve(watch *w, const km_mechanism *m) {
  size_t count = (size_t)m->coordinate_count;
  w->out->extremes = KM_NEW(km_extreme, count);
  w->room = KM_NEW(double, 2 * count);
  w->watched = KM_NEW(int, count);
  w->cell = KM_NEW(size_t, count);
  w->unread = KM_NEW(bool, count);
  w->shown = KM_NEW(int, count + (size_t)m->model->joint_count);
  if (!w->room || !w->watched || !w->cell || !w->unread || !w->shown || !w->out->extremes)
    return false;
  w->z = w->room;
  w->last_z = w->room + count;
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
    ready = reserve(w, job->m) && (!singularities || km_singular_watch_make(&w->singular, job->m));
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
