/* Walking along a path, sample by sample: what every method is made of. */
#ifndef KM_ARM_TRACKING_TRACKER_H
#define KM_ARM_TRACKING_TRACKER_H

#include "arm/path/path.h"
#include "arm/path_control.h"
#include "arm/tracking/objective.h"

/* A pose on the path, with the directions that lead on. Its arrays stand in one block, which belongs to a km_arena. */
enum { KM_NODE_BENDS = 2 };
typedef struct km_node {
  double *q;    /* [n] */
  double *path; /* [n + 1] path-control column */
  double *self; /* [freedom × n] pose-control columns, following those of the node before */
  double *bend; /* [KM_NODE_BENDS × n] what Newton added to the predictors of the last steps, the latest first */
  double *tilt; /* [freedom] of these steps */
  double along; /* Δσ of each of them */
  int bends;    /* how many of them are known */
  double z;     /* path entry */
  double value; /* of the objective */
} km_node;

bool km_node_create(const km_arm *arm, km_arena *arena, km_node *node);
void km_node_copy(const km_arm *arm, km_node *to, const km_node *from);

typedef struct km_tracker {
  const km_arm *arm;
  const km_path *path;
  const km_objective *objective;
} km_tracker;

/* One thread's workspace of a walk. */
typedef struct km_tracker_space {
  km_arm_space arm;
  km_node here; /* between samples */
} km_tracker_space;

bool km_tracker_space_create(const km_arm *arm, km_tracker_space *space);
void km_tracker_space_free(km_tracker_space *space);

/* How to leave a node. Zeros are greedy's way. */
typedef struct km_step_choice {
  const double *tilt; /* [freedom] tan φ towards each pose-control column; NULL: 0 */
  const bool *held;   /* [n] columns that don't move; NULL: none */
  double damping;     /* dls: λ at singular poses, 0: none */
  double below;       /* dls: smallest singular value from which on it is damped */
  int tries;          /* most parts that a step may be cut into, refused ones counted; 0: very many */
} km_step_choice;

/* Joint rates [n] of a track that passes a pose with these columns, at the mean rates [n] of a step that begins or ends
 * there: the least that follow the path, and the self-motion of the step. Held joints' columns give theirs. */
void km_node_rates(const km_arm *arm, const double *path, const double *self, double speed, const double *mean,
                   double *rates);

/* A step by Δσ from a node: the predictor (c₁/z + tan φ·c₂/z)Δσ[n], and the corrector moved[n] to expect after it, 0 where
 * the steps before were others. Returns how long the corrector may be: half the predictor. */
double km_node_predict(const km_arm *arm, const km_node *here, const km_step_choice *way, double ds, double *step,
                       double *moved);

/* How many of the node's bends a step by Δσ goes on from: those of steps that had the same Δσ and tilt. */
int km_node_known_bends(const km_arm *arm, const km_node *here, const km_step_choice *way, double ds);

/* √(Σ xᵢ²) of joint values. */
double km_joint_length(const double *x, int n);

/* Tells the node at a step's end what its corrector moved[n] was. */
void km_node_remember(const km_arm *arm, const km_node *from, const km_step_choice *way, double ds, const double *moved,
                      km_node *to);

/* Why a step doesn't lead to its end, and how far it leads. */
typedef struct km_step_end {
  km_track_stop stop;
  int column;
  double fraction;           /* of the interval that was covered, limits and rates not counted */
  unsigned long evaluations; /* Jacobians that it took; set by km_tracker_steps */
} km_step_end;

/* The node at q on a sample, q being there already. */
void km_tracker_begin(const km_tracker *walk, km_tracker_space *space, int sample, const double *q,
                      const km_step_choice *way, km_node *out);

/* From a node at `sample` to a fraction of the interval after it: predictor (c₁/z + tan φ·c₂/z)Δσ, then Newton steps
 * to 1e-12 towards the pose that is nearest to the predictor. A corrector (from the predictor to the pose) longer than
 * half the predictor is refused and the step halved. Where the steps before had the same Δσ and tilt, Newton begins at
 * the corrector 2d₁ − d₂ that their correctors lead to expect; as the pose is the nearest one all the same, this only
 * saves a Jacobian. Limits and rates are checked at the end only. */
km_step_end km_tracker_step(const km_tracker *walk, km_tracker_space *space, int sample, double fraction,
                            const km_node *from, const km_step_choice *way, km_node *to);

/* Up to eight whole steps from nodes at their samples, side by side where the arm is one of seven joints; ways with a tilt
 * only. The same bits as km_tracker_step one by one. */
enum { KM_WALK_ABREAST = 8 };
void km_tracker_steps(const km_tracker *walk, km_tracker_space *space, const int *samples, int count,
                      const km_node *const *from, const km_step_choice *ways, km_node *const *to, km_step_end *ends);

/* A whole step fails with `end`; if that is a rate, again with the nearest tilt that keeps the rates at the node, and a
 * little more and more below them. How it ends at last. */
km_step_end km_tracker_ease(const km_tracker *walk, km_tracker_space *space, int sample, const km_node *from,
                            const km_step_choice *way, km_step_end end, km_node *to);
/* Has the arm a joint with a rate? */
bool km_tracker_rated(const km_arm *arm);

/* A step to the fraction `outside` fails with `end`: the largest fraction that keeps everything (end.fraction), the
 * node there, and what stops it just past it. */
km_step_end km_tracker_find_end(const km_tracker *walk, km_tracker_space *space, int sample, const km_node *from,
                                const km_step_choice *way, km_step_end end, double outside, km_node *to);

#endif
