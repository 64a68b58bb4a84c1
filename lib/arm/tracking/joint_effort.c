/* Joint forces over a step and the objectives from them (docs/theory.md 12.10).
 *
 *   q = (q_0 + q_1)/2,   q̇ = (q_1 - q_0)/Δt,   q̈ = (v_1 - v_0)/Δt        middle of a step from q_0 to q_1
 *   v_i = p_i + Σ (c2_i · r) c2_i,   p_i = c1_i/z_i dσ/dt                 rates at its ends, columns of end i
 *   r = q̇ - (p_0 + p_1)/2                                                 mean rates of self-motion
 *   q̈ = 2 (q̇ - v_0)/Δt,  r = q̇ - p_0                                      where the path has a corner at the end
 *
 * First order in Δt, as the self-motion of a track. Jumps of the rates between steps are impulses and have no part in
 * it. */
#include "arm/tracking/joint_effort.h"

#include "arm/arm_dynamics.h"

void km_joint_effort_at(const km_arm *a, const double *q, const double *rates, const double *accelerations,
                        km_joint_effort *out) {
  *out = (km_joint_effort){.effort = 0.0};
  km_arm_joint_forces(a, q, rates, accelerations, out->force);
  for (int k = 0; k < a->n; ++k) {
    const double force = out->force[k], power = force * rates[k], limit = a->mass.force_limit[k];
    out->effort += force * force;
    out->relative += limit < (double)INFINITY ? force * force / (limit * limit) : (double)NAN;
    out->power += fabs(power);
    out->positive_power += fmax(power, 0.0);
  }
}

/* Minimum-norm rates at one end of a step. */
static void path_rates(const km_arm *a, const km_step_side *side, double *rates) {
  const double scale = side->path[a->n] > 0.0 ? side->speed / side->path[a->n] : 0.0;
  for (int k = 0; k < a->n; ++k)
    rates[k] = scale * side->path[k];
}

void km_joint_effort_of_step(const km_arm *a, const km_step_side *from, const km_step_side *to, double seconds,
                             bool corner, km_joint_effort *out) {
  double middle[KM_ARM_MAX_JOINTS], mean[KM_ARM_MAX_JOINTS], first[KM_ARM_MAX_JOINTS], last[KM_ARM_MAX_JOINTS],
      along[KM_ARM_MAX_JOINTS], accelerations[KM_ARM_MAX_JOINTS];
  path_rates(a, from, first);
  path_rates(a, corner ? from : to, last);
  for (int k = 0; k < a->n; ++k) {
    middle[k] = 0.5 * (from->q[k] + to->q[k]);
    mean[k] = (to->q[k] - from->q[k]) / seconds;
    along[k] = mean[k] - 0.5 * (first[k] + last[k]);
  }
  km_path_node_rates(a, from->path, from->self, from->speed, along, first);
  if (!corner)
    km_path_node_rates(a, to->path, to->self, to->speed, along, last);
  for (int k = 0; k < a->n; ++k)
    accelerations[k] = (corner ? 2.0 * (mean[k] - first[k]) : last[k] - first[k]) / seconds;
  km_joint_effort_at(a, middle, mean, accelerations, out);
}

void km_joint_effort_at_rest(const km_arm *a, const double *q, const double *path, double speed, km_joint_effort *out) {
  static const double none[KM_ARM_MAX_JOINTS], far = (double)INFINITY;
  double rates[KM_ARM_MAX_JOINTS];
  *out = (km_joint_effort){.effort = far, .relative = far, .power = far, .positive_power = far};
  if (!(path[a->n] > 0.0))
    return;
  for (int k = 0; k < a->n; ++k)
    rates[k] = path[k] / path[a->n] * speed;
  km_joint_effort_at(a, q, rates, none, out);
}

void km_joint_effort_values(const km_joint_effort *effort, double *values) {
  values[KM_EFFORT] = -effort->effort;
  values[KM_RELATIVE_EFFORT] = -effort->relative;
  values[KM_ENERGY] = -effort->power;
  values[KM_POSITIVE_WORK] = -effort->positive_power;
}

double km_joint_effort_sum(const km_objective *objective, const km_joint_effort *effort) {
  double values[KM_OBJECTIVES] = {0.0};
  km_joint_effort_values(effort, values);
  return km_objective_sum(objective, values);
}

km_status km_check_objective(const km_arm *a, const km_objective *objective, km_error *error) {
  if (objective->weight[KM_BODY_CLEARANCE] != 0.0 && !a->clearance)
    return km_fail(error, KM_USAGE,
                   "the objective clearance of an arm without pairs of bodies; expected "
                   "km_arm_set_clearance before");
  if (!km_objective_needs_forces(objective))
    return KM_OK;
  if (!a->mass.has_mass)
    return km_fail(error, KM_USAGE,
                   "the arm's bodies have no masses, so its joint forces are 0; expected a mass, or another objective "
                   "than effort, relative-effort, energy and positive-work");
  for (int k = 0; k < a->n; ++k)
    if (objective->weight[KM_RELATIVE_EFFORT] != 0.0 && !(a->mass.force_limit[k] < (double)INFINITY))
      return km_fail(error, KM_USAGE,
                     "relative-effort divides by the drives' max_force, and joint %s states none; expected one for "
                     "each joint of the arm, or effort",
                     km_arm_label(a, k));
  return KM_OK;
}

bool km_path_has_corner(const km_path *path, int sample) {
  return sample > 0 && sample < path->samples - 1 &&
         (path->segment_of[sample] != path->segment_of[sample - 1] || path->pace[sample] != path->pace[sample - 1]);
}

double km_objective_sample_weight(const km_objective *objective, const km_path *path, int sample) {
  if (!km_objective_needs_forces(objective))
    return 1.0;
  const km_path_point *points = path->points;
  return sample == 0 ? 0.0 : (points[sample].t - points[sample - 1].t) * path->samples / points[path->samples - 1].t;
}

void km_path_node_add_step_effort(const km_tracker *w, int sample, const km_path_point *point, const km_path_node *from,
                                  km_path_node *to) {
  const km_path_point *here = &w->path->points[sample];
  const bool corner = point->t == here[1].t && km_path_has_corner(w->path, sample + 1);
  km_joint_effort effort;
  const km_step_side start = {from->q, from->path, from->self, here->speed},
                     end = {to->q, to->path, to->self, point->speed};
  km_joint_effort_of_step(w->arm, &start, &end, point->t - here->t, corner, &effort);
  to->weight = km_objective_sample_weight(w->objective, w->path, sample + 1);
  to->value += km_joint_effort_sum(w->objective, &effort);
}

void km_path_node_add_effort_at_rest(const km_tracker *w, int sample, km_path_node *node) {
  node->weight = km_objective_sample_weight(w->objective, w->path, sample);
  if (!km_objective_needs_forces(w->objective))
    return;
  km_joint_effort effort;
  km_joint_effort_at_rest(w->arm, node->q, node->path, w->path->points[sample].speed, &effort);
  node->value += km_joint_effort_sum(w->objective, &effort);
}
