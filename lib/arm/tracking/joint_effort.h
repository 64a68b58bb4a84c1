/* Forces and power of an arm's drives over a step of a track: the objectives from inverse dynamics (docs/theory.md
 * 12.10). */
#ifndef KM_ARM_TRACKING_JOINT_EFFORT_H
#define KM_ARM_TRACKING_JOINT_EFFORT_H

#include "arm/tracking/tracker.h"

/* Values of a motion at one instant. Units: force · length of the model, and seconds. */
typedef struct km_joint_effort {
  double force[KM_ARM_MAX_JOINTS]; /* joint forces τ, as km_arm_joint_forces */
  double effort;                   /* Σ τ² */
  double relative;                 /* Σ (τ/largest force)²; NaN if a joint has none */
  double power;                    /* Σ |τ q̇| */
  double positive_power;           /* Σ max(τ q̇, 0) */
} km_joint_effort;

/* Effort at q, q̇, q̈ [n]. */
void km_joint_effort_at(const km_arm *arm, const double *q, const double *rates, const double *accelerations,
                        km_joint_effort *out);

/* Configuration and columns at one end of a step. */
typedef struct km_step_side {
  const double *q, *path, *self; /* as in km_path_node */
  double speed;                  /* dσ/dt */
} km_step_side;

/* Effort in the middle of a step that lasts `seconds`. `corner` is true if the path's direction or speed jumps at the
 * end of the step; the columns there then belong to the next segment and are not used. */
void km_joint_effort_of_step(const km_arm *arm, const km_step_side *from, const km_step_side *to, double seconds,
                             bool corner, km_joint_effort *out);
/* Effort of the minimum-norm rates at a configuration, without accelerations. */
void km_joint_effort_at_rest(const km_arm *arm, const double *q, const double *path, double speed,
                             km_joint_effort *out);

/* Sets the values of the objectives from inverse dynamics, which are minus the efforts, since larger is better. */
void km_joint_effort_values(const km_joint_effort *effort, double *values);
/* Their weighted sum. */
double km_joint_effort_sum(const km_objective *objective, const km_joint_effort *effort);

/* KM_USAGE: the objective needs masses that the arm doesn't have, or largest forces of its drives. */
km_status km_check_objective(const km_arm *arm, const km_objective *objective, km_error *error);

/* True if a new segment or another law of time begins at a sample. */
bool km_path_has_corner(const km_path *path, int sample);
/* Weight of a sample in the mean of the objective over the samples: 1, or for objectives from inverse dynamics the
 * time of the step that ends there over the mean time of all samples, so that the mean is that over the time. */
double km_objective_sample_weight(const km_objective *objective, const km_path *path, int sample);

/* As km_path_node_add_effort, for an objective that needs forces. */
void km_path_node_add_step_effort(const km_tracker *tracker, int sample, const km_path_point *point,
                                  const km_path_node *from, km_path_node *to);
/* Adds the objectives from inverse dynamics of a step from a node at `sample` to a point of its interval to the value
 * of the node there, and sets its weight. */
static inline void km_path_node_add_effort(const km_tracker *tracker, int sample, const km_path_point *point,
                                           const km_path_node *from, km_path_node *to) {
  if (km_objective_needs_forces(tracker->objective))
    km_path_node_add_step_effort(tracker, sample, point, from, to);
  else
    to->weight = 1.0;
}
/* As km_path_node_add_effort for a node without a step: minimum-norm rates, no accelerations. */
void km_path_node_add_effort_at_rest(const km_tracker *tracker, int sample, km_path_node *node);

#endif
