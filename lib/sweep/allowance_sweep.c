/* Play that redundant constraints need, along a sweep (docs/theory.md 14.9): misfits and the ratio of needed play at
 * each row; after the last one, from all rows, the joints whose play counts and the forces without play. */
#include "allowance/strain_forces.h"
#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "base/table.h"
#include "base/text.h"
#include "kinematics/body_poses.h"
#include "local/generic_neighbour.h"
#include "mobility/mobility_numbers.h"
#include "sweep/sweep_observer.h"

#include <math.h>
#include <string.h>

/* A substructure with redundant constraints. */
typedef struct part {
  int index, count;
  km_misfit_component *component; /* [count] */
  int first_constraint;           /* index of its first one in the result */
  km_ratio_search search[2];      /* worst case, statistical */
} part;

/* A substructure at a row. */
typedef struct station {
  const part *of;
  double s, ratio[2]; /* worst case, statistical */
  double *a[2];       /* [count] their self-stresses */
  km_self_stress stress;
  km_support_terms terms;
} station;

typedef struct allowance {
  km_allowance_sweep *out;
  km_observer observer;
  const km_mechanism *m;
  km_arena arena;
  part *parts;
  int part_count;
  station *stations;
  size_t station_count, station_capacity;
  bool failed;
} allowance;

enum { WORST, STATISTICAL };
/* Followed maxima of the ratio: all joints have play; few have. */
enum { FOLLOWED = 4, FEW_FOLLOWED = 1 };

/* ---- Rows */

/* Ratio of a station, where only some joints have play (NULL: all); `search` has followed it up to there. */
static double ratio_of(const station *at, int kind, const bool *counts, km_ratio_search *search) {
  if (!at->stress.measures) /* this row has another basis than the last one, */
    search->count = 0;
  double ratio = km_ratio_search_next(search, &at->terms, kind == STATISTICAL, counts);
  if (!at->stress.measures) /* and than the next one */
    search->count = 0;
  return kind == STATISTICAL ? km_statistical_factor(at->of->count) * ratio : ratio;
}

static void take(km_peak *peak, double value, double s) {
  /* the first of equal values */
  if (!isnan(value) && !(peak->value * (1.0 + km_root_rounding) >= value))
    *peak = (km_peak){value, s};
}

static bool is_angle(const km_allowance_constraint *c) {
  return c->joint >= 0 && c->component >= 3;
}

static double misfit_of(const station *at, const double *a, bool squared) {
  return km_support(&at->terms, at->terms.error, at->terms.error_count, a, squared, -1);
}

/* A gap above this part of the size, or angle in radians, is beyond the first order. */
static const double largest_gap = 0.1;

/* Misfits of a station's constraints into cells (NaN where they aren't measured) and peaks. */
static void write_misfits(allowance *w, const station *at, double *cells) {
  const part *p = at->of;
  double unit[KM_MAX_ALLOWANCE] = {0}, radian = w->m->model->units.angle->si;
  for (int i = 0; i < p->count; ++i) {
    km_allowance_constraint *c = &w->out->constraints[p->first_constraint + i];
    unit[i] = 1.0;
    double worst = misfit_of(at, unit, false), statistical = km_statistical_factor(1) * misfit_of(at, unit, true);
    unit[i] = 0.0;
    const double bound = largest_gap * (is_angle(c) ? 1.0 : w->m->substructures[p->index].size);
    const bool is_small = at->stress.measures && worst <= bound;
    cells[2 * i] = !is_small ? nan("") : worst / (is_angle(c) ? radian : 1.0);
    cells[2 * i + 1] = !is_small ? nan("") : statistical / (is_angle(c) ? radian : 1.0);
    take(&c->worst, is_small ? worst : nan(""), at->s);
    take(&c->statistical, is_small ? statistical : nan(""), at->s);
  }
}

/* Computes a substructure at the row; false without memory. */
static bool compute_station(allowance *w, km_sweeper *r, part *p, double s, double *cells) {
  void *stations = w->stations;
  if (!km_arena_grow(&w->arena, &stations, &w->station_capacity, w->station_count + 1, sizeof *w->stations))
    return false;
  w->stations = stations;
  station *at = &w->stations[w->station_count++];
  *at = (station){.of = p, .s = s};
  for (int k = WORST; k <= STATISTICAL; ++k)
    at->a[k] = KM_ARENA_NEW(&w->arena, double, (size_t)p->count);
  if (w->arena.failed || !km_self_stress_compute(r->m, r->s, p->index, p->component, &w->arena, &at->stress) ||
      !km_fit_terms_create(r->m, &at->stress, &w->out->defaults, &w->arena, &at->terms))
    return false;
  for (int k = WORST; k <= STATISTICAL; ++k) {
    at->ratio[k] = ratio_of(at, k, NULL, &p->search[k]);
    memcpy(at->a[k], p->search[k].track, (size_t)p->count * sizeof(double));
  }
  write_misfits(w, at, cells);
  return !isnan(at->ratio[WORST]) && !isnan(at->ratio[STATISTICAL]);
}

static double *write_cells(void *self, km_sweeper *r, double *cell) {
  allowance *w = self;
  const km_table *table = w->out->motion.table;
  double s = km_table_row(table, km_table_rows(table) - 1)[1], *ratio = cell;
  ratio[WORST] = ratio[STATISTICAL] = 0.0;
  cell += 2;
  km_poses_compute(r->m, r->s);
  for (int i = 0; i < w->part_count && !w->failed; ++i) {
    part *p = &w->parts[i];
    bool is_regular = km_self_stress_count(r->s, p->index) == p->count;
    for (int k = 0; k < 2 * p->count; ++k)
      cell[k] = nan("");
    if (is_regular)
      w->failed = !compute_station(w, r, p, s, cell);
    for (int k = WORST; k <= STATISTICAL && !w->failed; ++k)
      ratio[k] = is_regular && !isnan(ratio[k]) ? fmax(ratio[k], w->stations[w->station_count - 1].ratio[k]) : nan("");
    cell += 2 * p->count;
  }
  take(&w->out->worst, ratio[WORST], s);
  take(&w->out->statistical, ratio[STATISTICAL], s);
  return cell;
}

static km_status after_row(void *self, km_sweeper *r, double s, km_error *error) {
  (void)r;
  (void)s;
  return ((allowance *)self)->failed ? km_fail(error, KM_MEMORY, "out of memory for the allowance") : KM_OK;
}

/* ---- Columns */

static const char *const components[6] = {"x", "y", "z", "rx", "ry", "rz"};

static bool add_constraint(const km_model *model, const km_allowance_constraint *c, km_table *table) {
  km_text name = {0};
  if (c->joint >= 0)
    km_text_format(&name, "%s.%s", model->joints[c->joint].label, components[c->component]);
  else
    km_text_format(&name, "coupling %d", c->component + 1);
  const char *unit = c->joint < 0 ? NULL : is_angle(c) ? model->units.angle->suffix : model->units.length->suffix;
  bool added = !name.failed && km_table_add_joined_column(table, "gap.", name.data, ".worst", unit) &&
               km_table_add_joined_column(table, "gap.", name.data, ".statistical", unit);
  km_text_free(&name);
  return added;
}

static bool add_columns(void *self, const km_sweeper *r, km_table *table) {
  const allowance *w = self;
  bool added = km_table_add_joined_column(table, "play.", "worst", "", NULL) &&
               km_table_add_joined_column(table, "play.", "statistical", "", NULL);
  for (int i = 0; i < w->out->constraint_count && added; ++i)
    added = add_constraint(r->m->model, &w->out->constraints[i], table);
  return added;
}

/* ---- Conclusions from all rows */

/* Largest ratio over the stations of a substructure if some joints have play. */
static double largest_ratio(allowance *w, const part *p, int kind, const bool *counts) {
  km_arena scratch = {0};
  km_ratio_search search;
  double largest = 0.0;
  w->failed = !km_ratio_search_create(p->count, FEW_FOLLOWED, &scratch, &search) || w->failed;
  for (size_t i = 0; i < w->station_count && largest < HUGE_VAL && !w->failed; ++i)
    if (w->stations[i].of == p) {
      double ratio = ratio_of(&w->stations[i], kind, counts, &search);
      w->failed = isnan(ratio);
      largest = fmax(largest, ratio);
    }
  km_arena_free(&scratch);
  return largest;
}

/* The station of a substructure with the largest ratio. */
static const station *critical_station(const allowance *w, const part *p) {
  const station *critical = NULL;
  for (size_t i = 0; i < w->station_count; ++i)
    if (w->stations[i].of == p && (!critical || w->stations[i].ratio[WORST] > critical->ratio[WORST]))
      critical = &w->stations[i];
  return critical;
}

static double support_of(const km_support_term *terms, int count, const station *at, int joint) {
  return km_support(&at->terms, terms, count, at->a[WORST], false, joint);
}

/* Removes joints whose play is needed least, one after another, as long as the others can take up all misfits. False
 * without memory. */
static bool find_set(const station *critical, bool *counts) {
  const km_self_stress *stress = &critical->stress;
  km_arena scratch = {0};
  km_ratio_search search;
  bool found = km_ratio_search_create(critical->of->count, FEW_FOLLOWED, &scratch, &search);
  for (int removed = 0; removed >= 0 && found;) {
    double least = HUGE_VAL;
    removed = -1;
    for (int i = 0; i < stress->joint_count && found; ++i) {
      if (!counts[stress->joint[i]])
        continue;
      counts[stress->joint[i]] = false;
      memcpy(search.track, critical->a[WORST], (size_t)critical->of->count * sizeof(double));
      search.count = 1;
      double ratio = ratio_of(critical, WORST, counts, &search);
      counts[stress->joint[i]] = true;
      found = !isnan(ratio);
      if (ratio < least * (1.0 - 1e-6)) {
        least = ratio;
        removed = stress->joint[i];
      }
    }
    if (removed >= 0)
      counts[removed] = false;
  }
  km_arena_free(&scratch);
  return found;
}

static void conclude_forces(allowance *w, const part *p, km_allowance_joint *joints) {
  km_strain_forces *forces = KM_ARENA_NEW(&w->arena, km_strain_forces, (size_t)w->m->model->joint_count + 1);
  for (size_t i = 0; i < w->station_count && !w->arena.failed; ++i) {
    const station *at = &w->stations[i];
    if (at->of != p)
      continue;
    if (!km_strain_forces_compute(w->m, &at->stress, &at->terms, forces)) {
      w->failed = true;
      return;
    }
    for (int k = 0; k < at->stress.joint_count; ++k) {
      km_allowance_joint *j = &joints[k];
      j->force_worst = fmax(j->force_worst, forces[k].force_worst);
      j->force_statistical = fmax(j->force_statistical, forces[k].force_statistical);
      j->moment_worst = fmax(j->moment_worst, forces[k].moment_worst);
      j->moment_statistical = fmax(j->moment_statistical, forces[k].moment_statistical);
    }
  }
}

/* Joints of a substructure: shares at its critical station, ratios alone, forces. */
static void conclude_joints(allowance *w, const part *p, const station *critical, bool *counts,
                            km_allowance_joint *joints) {
  const km_self_stress *stress = &critical->stress;
  const km_support_terms *t = &critical->terms;
  double plays = support_of(t->play, t->play_count, critical, -1),
         errors = support_of(t->error, t->error_count, critical, -1);
  for (int i = 0; i < stress->joint_count; ++i) {
    int joint = stress->joint[i];
    km_allowance_joint *j = &joints[i];
    *j = (km_allowance_joint){.joint = joint,
                              .play_share = support_of(t->play, t->play_count, critical, joint) / plays,
                              .error_share = support_of(t->error, t->error_count, critical, joint) / errors,
                              .force_worst = nan(""),
                              .force_statistical = nan(""),
                              .moment_worst = nan(""),
                              .moment_statistical = nan("")};
    memset(counts, false, (size_t)w->m->model->joint_count * sizeof *counts);
    counts[joint] = true;
    j->alone_worst = largest_ratio(w, p, WORST, counts);
    j->alone_statistical = isfinite(j->alone_worst) ? largest_ratio(w, p, STATISTICAL, counts) : HUGE_VAL;
  }
  if (km_model_states_stiffness(w->m->model))
    conclude_forces(w, p, joints);
}

static void conclude_set(allowance *w, const part *p, const station *critical, bool *counts) {
  km_allowance_sweep *out = w->out;
  const km_self_stress *stress = &critical->stress;
  memset(counts, true, (size_t)w->m->model->joint_count * sizeof *counts);
  w->failed = !find_set(critical, counts) || w->failed;
  for (int i = 0; i < stress->joint_count; ++i)
    if (counts[stress->joint[i]])
      out->set[out->set_count++] = stress->joint[i];
  out->set_worst = fmax(out->set_worst, largest_ratio(w, p, WORST, counts));
  out->set_statistical = fmax(out->set_statistical, largest_ratio(w, p, STATISTICAL, counts));
}

static km_status finish(void *self, const km_sweep_job *job) {
  allowance *w = self;
  km_allowance_sweep *out = w->out;
  size_t joints = (size_t)job->m->model->joint_count;
  bool *counts = KM_ARENA_NEW(&w->arena, bool, joints + 1);
  out->joints = KM_NEW(km_allowance_joint, joints + 1);
  out->set = KM_NEW(int, joints + 1);
  if (w->arena.failed || !out->joints || !out->set)
    return km_fail(job->error, KM_MEMORY, "out of memory for the allowance");
  for (int i = 0; i < w->part_count && !job->table_only; ++i) {
    const station *critical = critical_station(w, &w->parts[i]);
    if (!critical)
      continue;
    conclude_joints(w, &w->parts[i], critical, counts, out->joints + out->joint_count);
    out->joint_count += critical->stress.joint_count;
    conclude_set(w, &w->parts[i], critical, counts);
  }
  if (w->failed || w->arena.failed)
    return km_fail(job->error, KM_MEMORY, "out of memory for the allowance");
  km_status status = KM_OK;
  if (w->part_count > 0 && !job->table_only)
    status = km_remedy_set_find(job->m, job->s, NULL, NULL, &out->remedies, job->error);
  return status ? status : job->status;
}

/* ---- Beginning */

static void add_constraints(allowance *w, part *p) {
  const km_topology *t = &w->m->topology;
  int loops = w->m->substructures[p->index].loop_count;
  p->first_constraint = w->out->constraint_count;
  for (int k = 0; k < p->count; ++k) {
    const km_misfit_component *c = &p->component[k];
    const km_peak none = {nan(""), nan("")};
    bool is_coupling = c->loop >= loops;
    w->out->constraints[w->out->constraint_count++] =
        (km_allowance_constraint){.joint = is_coupling ? -1 : t->chord[t->loop[t->loop_start[p->index] + c->loop]],
                                  .component = is_coupling ? c->loop - loops : c->component,
                                  .worst = none,
                                  .statistical = none};
  }
}

/* Prepares a substructure at a configuration near the start, so that no incidental self-stress counts. */
static km_status prepare_part(allowance *w, km_state *s, int index, km_error *error) {
  const km_substructure *sub = &w->m->substructures[index];
  double *saved = KM_ARENA_NEW(&w->arena, double, (size_t)(KM_SAVED_PER_COLUMN * sub->columns) + 1);
  double *move = KM_ARENA_NEW(&w->arena, double, (size_t)sub->columns + 1);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the allowance");
  km_generic_neighbour_enter(w->m, s, index, saved, move);
  part *p = &w->parts[w->part_count];
  *p = (part){.index = index, .count = km_self_stress_count(s, index)};
  bool fits = p->count <= KM_MAX_ALLOWANCE, found = true;
  if (fits && p->count > 0) {
    p->component = KM_ARENA_NEW(&w->arena, km_misfit_component, (size_t)p->count);
    for (int k = WORST; k <= STATISTICAL; ++k)
      found = found && km_ratio_search_create(p->count, FOLLOWED, &w->arena, &p->search[k]);
    found = found && !w->arena.failed && km_misfit_components_choose(w->m, s, index, p->component);
  }
  km_generic_neighbour_leave(w->m, s, index, saved);
  if (!fits)
    return km_fail(error, KM_USAGE,
                   "substructure %d has %d redundant constraints; expected at most %d for an allowance (kmob info "
                   "names joint types that end them)",
                   index + 1, p->count, KM_MAX_ALLOWANCE);
  if (!found)
    return km_fail(error, KM_MEMORY, "out of memory for the allowance");
  w->part_count += p->count > 0;
  return KM_OK;
}

static km_status prepare(allowance *w, km_state *s, km_error *error) {
  int most = 0;
  km_mobility mobility;
  w->parts = KM_ARENA_NEW(&w->arena, part, (size_t)w->m->topology.substructure_count + 1);
  if (!w->parts)
    return km_fail(error, KM_MEMORY, "out of memory for the allowance");
  km_poses_compute(w->m, s);
  km_ranks_update(w->m, s, KM_BASIS_SHORT, &mobility);
  km_status status = KM_OK;
  for (int i = 0; i < w->m->topology.substructure_count && !status; ++i)
    if (w->m->substructures[i].loop_count > 0)
      status = prepare_part(w, s, i, error);
  for (int i = 0; i < w->part_count; ++i)
    most += w->parts[i].count;
  w->out->constraints = KM_NEW(km_allowance_constraint, (size_t)most + 1);
  if (!status && !w->out->constraints)
    status = km_fail(error, KM_MEMORY, "out of memory for the allowance");
  for (int i = 0; i < w->part_count && !status; ++i)
    add_constraints(w, &w->parts[i]);
  return status;
}

static void close_observer(void *self) {
  allowance *w = self;
  km_arena_free(&w->arena);
  km_free(w);
}

static km_status check_defaults(const km_fit_defaults *d, km_error *error) {
  km_status status = km_check_given(d != NULL, "tolerances and play", error);
  if (status)
    return status;
  const double number[4] = {d->position, d->direction, d->play, d->angle};
  for (int k = 0; k < 4; ++k)
    if (!isfinite(number[k]) || number[k] < 0.0)
      return km_fail(error, KM_USAGE, "tolerance or play %g; expected a number of at least 0", number[k]);
  return KM_OK;
}

void km_allowance_sweep_open(km_sweep_job *job, const km_fit_defaults *defaults, km_allowance_sweep *out) {
  const km_peak none = {nan(""), nan("")};
  *out = (km_allowance_sweep){.motion = {.substructure = -1}, .worst = none, .statistical = none};
  job->out = &out->motion;
  job->status = km_check_sweep(job->m, job->s, job->plan, job->error);
  if (!job->status)
    job->status = check_defaults(defaults, job->error);
  if (job->status)
    return;
  allowance *w = KM_NEW(allowance, 1);
  if (!w) {
    job->status = km_fail(job->error, KM_MEMORY, "out of memory for the allowance");
    return;
  }
  out->defaults = *defaults;
  out->states_clearance = defaults->states_play || km_model_states_clearance(job->m->model);
  w->out = out;
  w->m = job->m;
  w->observer = (km_observer){.self = w,
                              .columns = add_columns,
                              .cells = write_cells,
                              .row_written = after_row,
                              .finish = finish,
                              .close = close_observer,
                              .reads_jacobian = true};
  job->observer = &w->observer;
  job->status = prepare(w, job->s, job->error);
}

km_status km_allowance_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan,
                                 const km_fit_defaults *defaults, km_allowance_sweep *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  km_sweep_job job = {.m = m, .s = s, .plan = plan, .error = error};
  km_allowance_sweep_open(&job, defaults, out);
  km_sweeps_run(&job, 1);
  return job.status;
}

void km_allowance_sweep_free(km_allowance_sweep *sweep) {
  if (!sweep)
    return;
  km_sweep_free(&sweep->motion);
  km_free(sweep->constraints);
  km_free(sweep->joints);
  km_free(sweep->set);
  km_remedy_set_free(&sweep->remedies);
  *sweep = (km_allowance_sweep){0};
}
