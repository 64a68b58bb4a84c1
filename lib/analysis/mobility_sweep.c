/* Mobility numbers over a sweep, and where a joint loses its grip: roots of its entry in the direction of motion. */
#include "kmech/mobility_sweep.h"
#include "analysis/singular.h"
#include "base/check.h"

/* |z| below this is 0: z = Z_j of the one free direction, known to about 1e-12. */
static const double zero = 1e-9;

/* What a mobility sweep remembers from row to row. */
typedef struct watch {
  km_mobility_sweep *out;
  double *z, *last_z; /* [coordinate] unit direction of motion at the row and at the row before */
  double last_s;
  bool have_last;
  km_singular_watch singular;
} watch;

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  (void)self;
  const km_model *model = r->m->model;
  bool added = true;
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    int freedom = km_model_freedom(model, j);
    if (freedom == 0)
      added = km_sweeper_column(table, "m.", joint->label, "", NULL) && added;
    for (int k = 0; k < freedom; ++k)
      added = km_sweeper_column(table, "m.", model->coordinates[joint->first_coordinate + k].label, "", NULL) && added;
  }
  return (!r->plan->singularities || km_sweeper_column(table, "", "singular_value", "", NULL)) && added;
}

static double *write_numbers(void *self, km_sweeper *r, double *cell) {
  watch *w = self;
  const km_model *model = r->m->model;
  for (int j = 0; j < model->joint_count; ++j) {
    int first = model->joints[j].first_coordinate, freedom = km_model_freedom(model, j);
    if (freedom == 0)
      *cell++ = 0.0;
    for (int k = 0; k < freedom; ++k)
      *cell++ = r->s->numbers[first + k];
  }
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
  for (int c = 0; c < m->coordinate_count; ++c)
    z[c] /= sqrt(sum);
}

static bool is_idle(const km_sweep *sweep, int coordinate) {
  return sweep->idle_coordinates && sweep->idle_coordinates[coordinate];
}

/* The unit direction of the one free motion, in the order of the coordinates, beside which idle freedoms move least;
 * false where there is more than one, or the driver stands at its own toggle. */
static bool direction(const km_sweeper *r, double *z) {
  if (r->substructure < 0 || km_partition_freedom(&r->s->partition[r->substructure]) - r->out->idle != 1 ||
      !r->mover.rates(r->mover.self, r->rates))
    return false;
  normalise(r->m, r->rates, z);
  return true;
}

/* Between last_s and s the sign of z_c changes: where exactly, by regula falsi (Illinois) on the closed pose. */
static double locate(const watch *w, const km_sweeper *r, int c, double s) {
  double a = w->last_s, b = s, fa = w->last_z[c], fb = w->z[c], root = b;
  for (int i = 0; i < 60 && fabs(b - a) > 1e-13 * (fabs(a) + fabs(b)); ++i) {
    root = (a * fb - b * fa) / (fb - fa);
    if (!r->mover.probe(r->mover.self, root, r->rates))
      break;
    normalise(r->m, r->rates, r->scratch);
    double f = r->scratch[c];
    if (fabs(f) < 1e-14)
      break;
    if (f * fb < 0.0) {
      a = b;
      fa = fb;
    } else {
      fa *= 0.5;
    }
    b = root;
    fb = f;
  }
  return root;
}

static void note_extremes(const watch *w, const km_sweeper *r, double s) {
  for (int c = 0; c < r->m->coordinate_count; ++c)
    if (r->s->numbers[c] < w->out->extremes[c].number)
      w->out->extremes[c] = (km_extreme){r->s->numbers[c], s};
}

/* Looks for toggles since the last row, and comes back to this one. */
static km_status see(void *self, km_sweeper *r, double s, km_error *error) {
  watch *w = self;
  km_status status = km_singular_see(&w->singular, r, s, w->out, error);
  if (status)
    return status;
  note_extremes(w, r, s);
  if (!direction(r, w->z)) {
    w->have_last = false;
    return KM_OK;
  }
  bool moved = false, failed = false;
  for (int c = 0; c < r->m->coordinate_count; ++c) {
    if (r->m->substructure_of[c] != r->substructure || r->m->held[c] || is_idle(r->out, c))
      continue;
    bool here = fabs(w->z[c]) < zero, before = w->have_last && fabs(w->last_z[c]) < zero;
    bool between = w->have_last && !here && !before && w->z[c] * w->last_z[c] < 0.0;
    if (here && !before)
      failed = !add_toggle(w->out, c, s) || failed;
    if (between)
      failed = !add_toggle(w->out, c, locate(w, r, c, s)) || failed;
    moved = moved || between;
  }
  if (moved)
    r->mover.settle(r->mover.self);
  double *swap = w->last_z;
  w->last_z = w->z;
  w->z = swap;
  w->last_s = s;
  w->have_last = true;
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the dead points") : KM_OK;
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

km_status km_mobility_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan, km_mobility_sweep *out,
                                km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_mobility_sweep){.motion = {.substructure = -1}};
  km_status fits = km_check_sweep(m, s, plan, error);
  if (fits)
    return fits;
  size_t count = (size_t)m->coordinate_count;
  *out = (km_mobility_sweep){
      .motion = {.substructure = -1}, .extremes = KM_NEW(km_extreme, count), .smallest = {nan(""), nan("")}};
  double *z = KM_NEW(double, 2 * count);
  watch w = {.out = out, .z = z, .last_z = z + count};
  bool ready = z && out->extremes && (!plan->singularities || km_singular_watch_make(&w.singular, m));
  km_status status = ready ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for a sweep");
  if (!status) {
    km_observer observer = {&w, add_columns, write_numbers, see, plan->singularities ? pass : NULL, forget, end_at};
    for (size_t c = 0; c < count; ++c)
      out->extremes[c] = (km_extreme){HUGE_VAL, nan("")};
    status = km_sweep_run(m, s, plan, &observer, &out->motion, error);
  }
  km_singular_watch_free(&w.singular);
  km_free(z);
  return status;
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
