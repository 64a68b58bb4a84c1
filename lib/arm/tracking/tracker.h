/* Tracker: advances an arm along its path from sample to sample (docs/theory.md 12.4). All methods use it. */
#ifndef KM_ARM_TRACKING_TRACKER_H
#define KM_ARM_TRACKING_TRACKER_H

#include "arm/path/path.h"
#include "arm/path_control.h"
#include "arm/tracking/objective.h"

/* A configuration on the path with its columns. Its arrays are one block of an arena. */
enum { KM_NODE_CORRECTIONS = 2 };
typedef struct km_path_node {
  double *q;            /* [n] */
  double *path;         /* [n + 1] path-control column */
  double *self;         /* [freedom × n] pose-control columns, oriented as those of the previous node */
  double *corrections;  /* [KM_NODE_CORRECTIONS × n] corrections (configuration minus predictor) of the last steps, the
                 * latest first */
  double *tan_phi;      /* [freedom] tan φ of these steps */
  double along;         /* Δσ of each of these steps */
  int correction_count; /* number of known corrections */
  double z;             /* path entry of c₁ */
  double value;         /* value of the objective; from inverse dynamics, that of the step that ended here */
  double weight;        /* weight of the value in the mean over the samples; km_objective_sample_weight */
} km_path_node;

bool km_path_node_create(const km_arm *arm, km_arena *arena, km_path_node *node);
void km_path_node_copy(const km_arm *arm, km_path_node *to, const km_path_node *from);

typedef struct km_tracker {
  const km_arm *arm;
  const km_path *path;
  const km_objective *objective;
} km_tracker;

/* Workspace of one thread. */
typedef struct km_tracker_space {
  km_arm_space arm;
  km_path_node here; /* intermediate node of a halved step */
} km_tracker_space;

bool km_tracker_space_create(const km_arm *arm, km_tracker_space *space);
void km_tracker_space_free(km_tracker_space *space);

/* Choice of a step from a node. All zeros: the path-control column (greedy). */
typedef struct km_step_choice {
  const double *tan_phi; /* [freedom] tan φ towards each pose-control column; NULL: 0 */
  const bool *fixed;     /* [n] joints that don't move; NULL: none */
  double damping;        /* dls: λ₀ at singular configurations, 0: no damping */
  double below;          /* dls: singular value σ₀ below which the rates are damped */
  int tries;             /* largest number of partial steps, rejected ones included; 0: the default of 5000 */
} km_step_choice;

/* Joint rates [n] of a track at a configuration with these columns: c₁/z · speed (minimum norm along the path) plus
 * the part of mean[n] along the self-motions. mean[n] are the average rates of a step that begins or ends here. With
 * fixed joints, their columns give their rates. */
void km_path_node_rates(const km_arm *arm, const double *path, const double *self, double speed, const double *mean,
                        double *rates);

/* Predictor of a step by Δσ from a node: step[n] = (c₁/z + tan φ · c₂/z) Δσ, and the extrapolated correction
 * moved[n], 0 if the previous steps had another Δσ or φ. Returns the largest correction allowed: half the length of
 * step. */
double km_path_node_predict(const km_arm *arm, const km_path_node *here, const km_step_choice *choice, double ds,
                            double *step, double *moved);

/* Number of stored corrections that are valid for a step by Δσ: those of steps with the same Δσ and tan φ. */
int km_path_node_valid_corrections(const km_arm *arm, const km_path_node *here, const km_step_choice *choice,
                                   double ds);

/* Euclidean norm √(Σ xᵢ²) of joint values. */
double km_joint_length(const double *x, int n);

/* Stores the correction moved[n] of a step in the node at its end. */
void km_path_node_store_correction(const km_arm *arm, const km_path_node *from, const km_step_choice *choice, double ds,
                                   const double *moved, km_path_node *to);

/* Outcome of a step: the reason why it stopped, and the fraction it covered. */
typedef struct km_step_end {
  km_track_stop stop;
  int column;
  double fraction;           /* part of the interval that was covered; limits and rates don't reduce it */
  unsigned long evaluations; /* Jacobians computed; set by km_tracker_steps */
} km_step_end;

/* Computes the node of a configuration q[n] that has the pose of a sample. */
void km_tracker_compute_node(const km_tracker *tracker, km_tracker_space *space, int sample, const double *q,
                             const km_step_choice *choice, km_path_node *out);

/* As km_tracker_compute_node with the path-control column, for the configuration that a step from the node `from` at
 * the previous sample reached; NULL: the start. */
void km_tracker_compute_arrival(const km_tracker *tracker, km_tracker_space *space, int sample, const double *q,
                                const km_path_node *from, km_path_node *out);

/* Advances from a node at `sample` over a fraction of the next interval: predictor (c₁/z + tan φ · c₂/z) Δσ, then
 * Newton's method to 1e-12 for the configuration closest to the predictor. If the correction exceeds half the
 * predictor, the step is halved. If the previous steps had the same Δσ and tan φ, Newton's method starts at the
 * extrapolated correction 2 d₁ − d₂; the result is the same closest configuration, with one Jacobian less. Limits
 * and rates are checked at the end only. */
km_step_end km_tracker_step(const km_tracker *tracker, km_tracker_space *space, int sample, double fraction,
                            const km_path_node *from, const km_step_choice *choice, km_path_node *to);

/* Advances up to KM_STEP_BATCH nodes by one sample each, as a batch if the arm has seven joints. Choices state tan φ
 * only. The results have the bits of km_tracker_step. */
enum { KM_STEP_BATCH = 8 };
void km_tracker_steps(const km_tracker *tracker, km_tracker_space *space, const int *samples, int count,
                      const km_path_node *const *from, const km_step_choice *choices, km_path_node *const *to,
                      km_step_end *ends);

/* Easing of a step that failed with `end`: if a joint rate was exceeded, repeats the step with the closest tan φ
 * that satisfies the rates at the node, with growing margins. Returns the final outcome. */
km_step_end km_tracker_ease(const km_tracker *tracker, km_tracker_space *space, int sample, const km_path_node *from,
                            const km_step_choice *choice, km_step_end end, km_path_node *to);
/* True if a joint of the arm has a rate. */
bool km_tracker_rated(const km_arm *arm);

/* Locates the end of a track by bisection. The step to the fraction `outside` failed with `end`. Finds the largest
 * fraction that satisfies limits and rates (end.fraction), the node there, and the stop just past it. */
km_step_end km_tracker_find_end(const km_tracker *tracker, km_tracker_space *space, int sample,
                                const km_path_node *from, const km_step_choice *choice, km_step_end end, double outside,
                                km_path_node *to);

#endif
