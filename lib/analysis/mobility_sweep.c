#include "kmech/mobility_sweep.h"

#include "analysis/mobility.h"
#include "base/text.h"
#include "kinematics/loops.h"
#include "kinematics/poses.h"

#include <stdio.h>
#include <string.h>

/* |z| below this is 0: z = Z_j of the one free direction, known to about 1e-12. */
static const double zero = 1e-9;

/* Everything that one sweep needs at hand. */
typedef struct runner {
  const km_mechanism *m;
  km_state *s;
  const km_sweep_plan *plan;
  km_mobility_sweep *out;
  km_drive *drive;
  int substructure;     /* the driven one, -1 */
  double *rates;        /* [coordinate] */
  double *z, *last_z;   /* [coordinate] direction of motion of the row and of the row before */
  double last_s;
  bool have_last;
  double other_residual; /* of the substructures that stand still */
  int other_mobility;
} runner;

km_sweep_plan km_sweep_plan_default(const km_model *model) {
  const km_sweep_def *sweep = &model->sweep;
  return (km_sweep_plan){.coordinate = sweep->coordinate,
                         .from = sweep->range[0],
                         .to = sweep->range[1],
                         .steps = sweep->steps};
}

static void add_named(km_table *table, const char *prefix, const char *name, const char *suffix, const char *unit,
                      bool *failed) {
  km_text text = {0};
  km_text_format(&text, "%s%s%s", prefix, name, suffix);
  if (text.failed || km_table_add_column(table, text.data, unit) < 0)
    *failed = true;
  km_text_free(&text);
}

static void add_point_columns(const runner *r, const km_sweep_point *point, bool *failed) {
  static const char *const places[3] = {".x", ".y", ".z"}, *const slopes[3] = {".dx", ".dy", ".dz"};
  const char *length = r->m->model->units.length->suffix;
  km_table *table = r->out->table;
  for (int k = 0; k < 3; ++k)
    add_named(table, "point.", point->name, places[k], length, failed);
  if (!r->plan->derivatives)
    return;
  km_text unit = {0};
  km_text_format(&unit, "%s/%s", length, km_model_coordinate_unit(r->m->model, r->plan->coordinate));
  for (int k = 0; k < 3 && !unit.failed; ++k)
    add_named(table, "point.", point->name, slopes[k], unit.data, failed);
  km_text_free(&unit);
}

static km_status add_columns(const runner *r, km_error *error) {
  const km_model *model = r->m->model;
  km_table *table = r->out->table;
  bool failed = false;
  add_named(table, "", "step", "", NULL, &failed);
  failed = km_table_add_plain_column(table, "s", km_model_coordinate_unit(model, r->plan->coordinate)) < 0 || failed;
  for (int c = 0; c < model->coordinate_count; ++c)
    add_named(table, "q.", model->coordinates[c].label, "", km_model_coordinate_unit(model, c), &failed);
  for (int j = 0; j < model->joint_count; ++j) {
    const km_joint_def *joint = &model->joints[j];
    int freedom = km_model_freedom(model, j);
    if (freedom == 0)
      add_named(table, "m.", joint->label, "", NULL, &failed);
    for (int k = 0; k < freedom; ++k)
      add_named(table, "m.", model->coordinates[joint->first_coordinate + k].label, "", NULL, &failed);
  }
  add_named(table, "", "dof", "", NULL, &failed);
  for (int i = 0; i < r->m->topology.substructure_count; ++i) {
    char name[32];
    snprintf(name, sizeof name, "dof.%d", i + 1);
    add_named(table, name, "", "", NULL, &failed);
  }
  add_named(table, "", "residual", "", NULL, &failed);
  for (int i = 0; i < r->plan->point_count; ++i)
    add_point_columns(r, &r->plan->points[i], &failed);
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the table") : KM_OK;
}

/* Velocity of a frame's origin per unit rate of the driver: the twists of the chain to it, added up. */
static void point_rates(const runner *r, int frame, double out[3]) {
  const km_mechanism *m = r->m;
  const km_frame_def *def = &m->model->frames[frame];
  km_twist t = {{0, 0, 0}, {0, 0, 0}};
  for (int body = def->body; body > 0; body = m->topology.parent[body])
    t = km_twist_axpy(1.0, km_body_twist(m, r->s, body, r->rates), t);
  km_vec3 p = km_pose_point(&r->s->pose[def->body], def->pose.p);
  km_vec3 v = km_vec3_add(t.v, km_vec3_cross(t.w, p));
  out[0] = v.x;
  out[1] = v.y;
  out[2] = v.z;
}

static double *write_points(const runner *r, double *cell) {
  if (r->plan->point_count == 0)
    return cell;
  km_poses_update(r->m, r->s);
  double factor = km_model_coordinate_factor(r->m->model, r->plan->coordinate);
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

static double *write_numbers(const runner *r, double *cell) {
  const km_model *model = r->m->model;
  for (int j = 0; j < model->joint_count; ++j) {
    int first = model->joints[j].first_coordinate, freedom = km_model_freedom(model, j);
    if (freedom == 0)
      *cell++ = 0.0;
    for (int k = 0; k < freedom; ++k)
      *cell++ = r->s->numbers[first + k];
  }
  return cell;
}

static void note_extremes(const runner *r, double s) {
  for (int c = 0; c < r->m->coordinate_count; ++c)
    if (r->s->numbers[c] < r->out->extremes[c].number)
      r->out->extremes[c] = (km_extreme){r->s->numbers[c], s};
}

static bool add_toggle(km_mobility_sweep *out, int coordinate, double s) {
  void *toggles = out->toggles;
  if (!km_reserve(&toggles, &out->toggle_capacity, out->toggle_count + 1, sizeof *out->toggles))
    return false;
  out->toggles = toggles;
  out->toggles[out->toggle_count++] = (km_toggle){coordinate, s};
  return true;
}

/* The unit direction of the one free motion, in the order of the coordinates; false where there is more than
 * one, or the driver stands at its own toggle. */
static bool direction(const runner *r, double *z) {
  if (r->substructure < 0 || km_partition_freedom(&r->s->partition[r->substructure]) != 1 ||
      !km_drive_tangent(r->drive, r->rates))
    return false;
  double sum = 0.0;
  for (int c = 0; c < r->m->coordinate_count; ++c) {
    z[c] = r->m->scale[c] * r->rates[c];
    sum += z[c] * z[c];
  }
  for (int c = 0; c < r->m->coordinate_count; ++c)
    z[c] /= sqrt(sum);
  return true;
}

/* Between last_s and s the sign of z_c changes: where exactly, by regula falsi (Illinois) on the closed pose. */
static double locate(const runner *r, int c, double s, double *scratch) {
  double a = r->last_s, b = s, fa = r->last_z[c], fb = r->z[c], root = b;
  for (int i = 0; i < 60 && fabs(b - a) > 1e-13 * (fabs(a) + fabs(b)); ++i) {
    root = (a * fb - b * fa) / (fb - fa);
    if (km_drive_to(r->drive, root).stop || !direction(r, scratch))
      break;
    double f = scratch[c];
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

/* Looks for toggles since the last row, and comes back to this one. */
static km_status find_toggles(runner *r, double s, km_error *error) {
  if (!direction(r, r->z)) {
    r->have_last = false;
    return KM_OK;
  }
  double *scratch = r->rates + 3 * r->m->coordinate_count;
  bool moved = false, failed = false;
  for (int c = 0; c < r->m->coordinate_count; ++c) {
    if (r->m->substructure_of[c] != r->substructure || r->m->held[c])
      continue;
    bool here = fabs(r->z[c]) < zero, before = r->have_last && fabs(r->last_z[c]) < zero;
    bool between = r->have_last && !here && !before && r->z[c] * r->last_z[c] < 0.0;
    if (here && !before)
      failed = !add_toggle(r->out, c, s) || failed;
    if (between)
      failed = !add_toggle(r->out, c, locate(r, c, s, scratch)) || failed;
    moved = moved || between;
  }
  if (moved)
    km_drive_to(r->drive, s);
  double *swap = r->last_z;
  r->last_z = r->z;
  r->z = swap;
  r->last_s = s;
  r->have_last = true;
  return failed ? km_fail(error, KM_MEMORY, "out of memory for the toggles") : KM_OK;
}

static km_status write_row(runner *r, int step, double s, km_error *error) {
  const km_mechanism *m = r->m;
  double *cell = km_table_add_row(r->out->table);
  if (!cell)
    return km_fail(error, KM_MEMORY, "out of memory for the table");
  int mobility = r->other_mobility, worst;
  double residual = r->other_residual;
  /* The direction of motion first: the numbers may search other pivots. */
  bool tangent = r->plan->derivatives && km_drive_tangent(r->drive, r->rates);
  if (r->plan->derivatives && !tangent)
    for (int c = 0; c < m->coordinate_count; ++c)
      r->rates[c] = NAN;
  if (r->substructure >= 0) {
    const km_substructure *sub = &m->substructures[r->substructure];
    km_numbers_update(m, r->s, r->substructure);
    residual = fmax(residual, km_loops_residual(m, r->s, sub, &worst));
    mobility += km_partition_freedom(&r->s->partition[r->substructure]);
  }
  *cell++ = step;
  *cell++ = s;
  for (int c = 0; c < m->coordinate_count; ++c)
    *cell++ = km_state_coordinate(r->s, c);
  cell = write_numbers(r, cell);
  *cell++ = mobility;
  for (int i = 0; i < m->topology.substructure_count; ++i)
    *cell++ = km_partition_freedom(&r->s->partition[i]);
  *cell++ = residual;
  write_points(r, cell);
  note_extremes(r, s);
  return find_toggles(r, s, error);
}

/* The numbers of what the driver doesn't move, once. */
static void prepare(runner *r) {
  km_mobility_update(r->m, r->s, &r->out->first);
  r->other_mobility = r->out->first.mobility;
  if (r->substructure >= 0)
    r->out->freedom = km_partition_freedom(&r->s->partition[r->substructure]);
  r->other_mobility -= r->out->freedom;
  for (int i = 0; i < r->m->topology.substructure_count; ++i) {
    int worst;
    if (i != r->substructure)
      r->other_residual =
          fmax(r->other_residual, km_loops_residual(r->m, r->s, &r->m->substructures[i], &worst));
  }
  for (int c = 0; c < r->m->coordinate_count; ++c)
    r->out->extremes[c] = (km_extreme){INFINITY, NAN};
}

/* FROM is out of reach and the motion towards it ended at a bound: does s lie in what is left of the range? */
static bool reachable(const runner *r, double s) {
  const km_sweep_plan *plan = r->plan;
  double bound = r->out->start.position;
  return plan->to >= plan->from ? bound > plan->from && s > bound : bound < plan->from && s < bound;
}

static bool carries_on(const runner *r, int step) {
  return !r->plan->progress || r->plan->progress(r->plan->context, (double)step / r->plan->steps);
}

static km_status rows(runner *r, km_error *error) {
  const km_sweep_plan *plan = r->plan;
  km_reach *start = &r->out->start, *end = &r->out->end;
  *start = *end = km_drive_to(r->drive, plan->from);
  km_status status = write_row(r, 0, start->position, error);
  int row = 1;
  double last = start->position;
  for (int i = 1; i <= plan->steps && !status; ++i) {
    double s = i == plan->steps ? plan->to : plan->from + (plan->to - plan->from) * i / plan->steps;
    if (start->stop && !reachable(r, s))
      continue;
    if (!carries_on(r, i))
      return km_fail(error, KM_CANCELLED, "stopped at %g", s);
    *end = km_drive_to(r->drive, s);
    bool again = end->stop && fabs(end->position - last) <= 1e-9 * (1.0 + fabs(last));
    if (!again) /* the end may be where the last row stands already */
      status = write_row(r, row++, end->position, error);
    last = end->position;
    if (end->stop)
      break;
  }
  for (int i = 0; i < 2 && !status; ++i) { /* where the driver itself gives out */
    const km_reach *reach = i ? end : start;
    bool again = i && end->position == start->position;
    if (reach->stop == KM_STOP_TOGGLE && !again && !add_toggle(r->out, plan->coordinate, reach->position))
      status = km_fail(error, KM_MEMORY, "out of memory for the toggles");
  }
  if (status)
    return status;
  return start->stop || end->stop ? KM_PARTIAL : KM_OK;
}

static km_status run(runner *r, km_error *error) {
  const km_mechanism *m = r->m;
  size_t count = (size_t)m->coordinate_count;
  r->out->table = km_table_create();
  r->out->extremes = KM_NEW(km_extreme, count);
  r->rates = KM_NEW(double, 4 * count);
  if (!r->out->table || !r->out->extremes || !r->rates)
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  r->z = r->rates + count;
  r->last_z = r->z + count;
  km_status status = km_drive_create(m, r->s, r->plan->coordinate, r->plan->ignore_limits, &r->drive, error);
  if (!status)
    status = add_columns(r, error);
  if (status)
    return status;
  prepare(r);
  return rows(r, error);
}

km_status km_mobility_sweep_run(const km_mechanism *m, km_state *s, const km_sweep_plan *plan,
                                km_mobility_sweep *out, km_error *error) {
  runner r = {.m = m, .s = s, .plan = plan, .out = out, .substructure = m->substructure_of[plan->coordinate]};
  *out = (km_mobility_sweep){0};
  km_status status = run(&r, error);
  km_drive_free(r.drive);
  km_free(r.rates);
  return status;
}

void km_mobility_sweep_free(km_mobility_sweep *sweep) {
  km_table_free(sweep->table);
  km_free(sweep->toggles);
  km_free(sweep->extremes);
  *sweep = (km_mobility_sweep){0};
}
