/* Parts of a static balance (theory 9). Private to the library. */
#ifndef KM_STATICS_STATICS_H
#define KM_STATICS_STATICS_H

#include "base/number/tolerances.h"
#include "forces/forces.h"
#include "kmech/statics.h"
#include "linalg/dense/simd_pair.h"

#include <gsl/gsl_matrix.h>
#include <gsl/gsl_permutation.h>
#include <string.h>

/* Forces of the actuators of one block: a substructure, or several with tree joints that pushed points move together.
 * A motion x of its freedoms moves the actuators by Z_A x. */
typedef struct km_actuator_workspace {
  int part_count, tree_joint_count;
  int *part, *tree_joint; /* its substructures; coordinates of its tree joints */
  int columns;
  const int *coordinate; /* [columns] */
  const double *Z;       /* [size × columns] basis of D · range(N) at the present configuration, or its part Z' */
  bool is_composed;      /* Z is composed of several bases; else it is that of the only substructure, or Z' */
  double *own_Z;         /* [capacity × columns] composed Z, or Z' */
  int size, capacity;    /* vectors of Z; most that the arrays hold */
  int count;             /* actuators in this block */
  int *actuator;         /* [count] indices of the actuators */
  gsl_matrix *U, *V;     /* Z_A = U S Vᵀ, padded with zero rows to at least as many as columns */
  gsl_vector *S, *load, *answer; /* load: Vᵀ g */
  double *basis;                 /* basis of the motions out of reach */
  int freedom, rank;             /* values at the last configuration */
  double noise;                  /* rounding of the loads g */
  /* Data of a sweep. */
  int regular_rank;        /* regular rank: freedoms that the actuators hold except at single configurations */
  gsl_matrix *reference_U; /* [actuator × rank] U at the last sample, which determines the signs */
  double *reference_ZV;    /* [rank × column] Z V at the last sample */
  gsl_matrix *rotation;    /* [rank × rank] rotation since the last sample */
  gsl_permutation *pivots;
} km_actuator_workspace;

/* Relative to all applied forces: smaller generalised forces are 0. */
static const double km_load_rounding = 1e-10;

/* Sums over the joints that two loops share, weighted by the product of their signs: of 1, of the joint's arm d, and
 * of d dᵀ (xx yy zz, yz zx xy). */
typedef struct km_arm_moments {
  double count;
  km_vec3 first, squares, products;
} km_arm_moments;

typedef struct km_stress_entry {
  int row;
  double value;
} km_stress_entry;

/* Data of the reactions of one substructure. */
typedef struct km_reaction_workspace {
  struct km_body_equilibrium *body_equilibrium; /* NULL: small, J is solved as a dense matrix */
  int rows, columns;                            /* size of J: 6 · loops + couplings */
  int loops, joints;
  const int *joint;        /* [joints] */
  double size;             /* size of the substructure; chords' forces are scaled by it */
  bool *indeterminate_out; /* [6 · joints] large substructures: indeterminate components */
  double *reported;        /* [6 · joints] large substructures: reactions along the reporting axes */
  /* Small substructures: */
  const int *first;                 /* [joint of the model + 1] into joint_loops */
  const km_joint_loop *joint_loops; /* loops through each joint, and the sign of the chord's wrench there */
  km_vec3 *arm;                     /* [joints] from the chords' reference point to the reaction's point */
  double *T;        /* [columns × nonzero_row_count] Jᵀ of all six rows of every loop, without zero rows of J */
  int *nonzero_row; /* [rows] rows of J in T, then the zero rows */
  int nonzero_row_count;
  double *rhs, *mu;        /* [columns]; [rows] chords' wrenches, f · size and τ */
  km_arm_moments *moments; /* [loops × loops] with b ≤ a, a · loops + b */
  int *stress_start;       /* [rows + 1] into `stress` */
  km_stress_entry *stress; /* nonzero entries of the self-stresses N */
  double *metric;          /* [rows × rows] M: μᵀ M μ is the norm of km_reactions_minimise_norm */
  double *image;           /* [rows × rows] M N */
  km_pair *sample;         /* [2 · rows + 6 · joints] workspace of km_indeterminate_components_mark */
  double *gram;            /* [rows × rows] Nᵀ M N; its Cholesky factor, with reciprocal diagonal */
  double *gradient;        /* [rows] half the gradient of the norm at μ = 0, */
  double *slope;           /* [rows] its component along each self-stress, */
  double *share;           /* [rows] coefficients of the self-stresses */
  int degree;              /* self-stresses at the last configuration */
  km_factor *factor;       /* factor of T */
} km_reaction_workspace;

struct km_statics_workspace {
  km_arena arena;
  const km_mechanism *mechanism;
  km_port *actuators;
  int *part;          /* [actuator] its block, -1: a single tree joint */
  int *tree_joint;    /* [actuator] coordinate of that tree joint; -1 */
  double *tree_load;  /* [actuator] its generalised force, to which pushes are added later */
  int *column;        /* [actuator] column of a joint in its block */
  double **row;       /* [actuator] points: rate along the direction per unit rate of each coordinate; joints: NULL */
  bool *actuated;     /* [coordinate] */
  km_twist *twist;    /* [coordinate] twist of the child relative to the parent, about the forces' origin */
  km_wrench *subtree; /* [body] applied wrenches on the body and its subtree */
  double *squares;    /* [actuator] workspace of km_statics_find_friction */
  double *tau;        /* [coordinate] generalised forces of the loads, springs in joints included */
  double *force;      /* [coordinate] forces of the actuators, or f̄ */
  bool no_reactions;  /* see km_statics_skip_reactions */
  bool keeps_factors; /* every block keeps its Z, U, S, V for km_statics_ratios */
  double *least_load; /* [coordinate] generalised forces below this are rounding */
  km_pose *frame;     /* [joint] frame in which its reaction is reported, about the forces' origin */
  km_wrench *carried; /* [joint] reaction along the inertial axes */
  int *joint_index;   /* [joint] index among the joints of its substructure */
  km_actuator_workspace *blocks; /* [block_count] */
  int block_count;
  km_reaction_workspace *reactions_of;
};

/* Returns the scale D of an actuator's force: that of its coordinate, or of a length. */
static inline double km_actuator_scale(const km_mechanism *m, const km_statics *st, int actuator) {
  const km_port *h = &st->actuators[actuator];
  return h->kind == KM_PORT_JOINT ? m->scale[h->coordinate] : 1.0 / m->length;
}
/* Visits every free coordinate between a point's body and the inertial frame in the tree. */
typedef void (*km_mover_visitor)(void *context, int coordinate, bool is_reversed);
void km_point_each_mover(const km_mechanism *mechanism, const km_port *point, km_mover_visitor at, void *context);
/* Finds the blocks: substructures and tree joints that the actuators move together, into work->blocks, part,
 * tree_joint, column. KM_USAGE: a point cannot move, or pushes the tree joint of another actuator; KM_MEMORY. */
km_status km_blocks_make(const km_mechanism *mechanism, km_statics *statics, km_error *error);
/* Computes work->row of every pushed point from work->twist; and adds the wrenches of points that hold to the loads. */
void km_pushed_points_update(const km_mechanism *mechanism, const km_forces *forces, km_statics *statics);
void km_pushed_points_apply(const km_mechanism *mechanism, const km_forces *forces, km_statics *statics);
/* True if an actuator's force is a force, not a torque. */
bool km_actuator_has_force(const km_model *model, const km_port *actuator);
/* Allocates the blocks' arrays; false without memory. */
bool km_actuator_workspace_reserve(km_statics *statics);
/* Extends a block's arrays to a number of vectors of Z; false without memory. */
bool km_actuator_workspace_fit(km_actuator_workspace *blocks, int size, km_arena *arena);
/* Number of vectors of Z: the freedom, or with many freedoms those of Z' (actuator_subspace.c), which
 * km_actuator_subspace_compute forms in own_Z and size; false without memory. */
int km_actuator_subspace_size(const km_actuator_workspace *blocks, const km_state *state, int freedom);
bool km_actuator_subspace_compute(const km_mechanism *mechanism, const km_state *state, const km_statics *statics,
                                  km_actuator_workspace *blocks);
/* Scaled rates of an actuator per unit of the block's scaled coordinates: row[columns]. */
void km_actuator_row(const km_mechanism *mechanism, const km_statics *statics, const km_actuator_workspace *blocks,
                     int actuator, double *row);
km_status km_reaction_workspace_reserve(const km_mechanism *mechanism, km_statics_workspace *work, km_error *error);
/* Switches a substructure to the method of large ones. */
km_status km_reaction_workspace_make_large(const km_mechanism *mechanism, km_statics_workspace *work, int substructure,
                                           km_error *error);
void km_reaction_workspace_free(km_statics_workspace *work);

/* Starts a direction out of reach: returns its rates, all 0; NULL: it is counted only. The second function scales the
 * largest rate to 1. */
double *km_direction_begin(const km_mechanism *mechanism, bool falls, km_statics *statics);
void km_direction_end(const km_mechanism *mechanism, const km_actuator_workspace *blocks, double *rates);
/* Computes actuator forces, directions out of their reach, and whether they hold, from work->tau and, without
 * keeps_factors, from st->least_norm. */
void km_actuator_forces_solve(const km_mechanism *mechanism, const km_state *state, km_statics *statics);
/* Does km_statics_compute without the marks of indeterminate components, which km_statics_mark adds. */
km_status km_statics_find(const km_mechanism *mechanism, km_state *state, km_forces *forces, km_statics *statics);
void km_statics_mark(const km_mechanism *mechanism, km_statics *statics);
/* Balances given forces without reactions: minimum-norm forces and those of the actuators. */
void km_statics_forces_balance(const km_mechanism *mechanism, km_state *state, km_forces *forces, km_statics *statics);
/* Computes st->friction: the part that friction of the contacts may take of each actuator's force. The forces belong to
 * the state afterwards; the balance doesn't. */
void km_statics_find_friction(const km_mechanism *mechanism, km_state *state, km_forces *forces, km_statics *statics);
/* Lists the contacts and the stops that act, after km_forces_compute. */
void km_statics_list_contacts(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                              km_statics *statics);
/* Balances given forces, for instance those of a motion (km_dynamics_balance). */
km_status km_statics_balance(const km_mechanism *mechanism, km_state *state, km_forces *forces, km_statics *statics);
/* Skips the reactions, which are NaN from then on. */
void km_statics_skip_reactions(const km_mechanism *mechanism, km_statics *statics);
/* Computes the reactions only, for given forces of a motion with the driving forces `driving` [coordinate]. */
void km_statics_reactions_compute(const km_mechanism *mechanism, km_state *state, const km_forces *forces,
                                  const double *driving, km_statics *statics);
/* Computes the actuators' forces only; f̄ and reactions keep their values. */
void km_statics_actuators_compute(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                                  km_statics *statics);
/* Computes every actuator's force along a sweep as n/d after km_statics_actuators_compute; both are smooth along the
 * motion, d = 0 where the actuators lose a freedom (theory 9.6). `motion`: rates along it (NULL: unknown). 0 where
 * the value is rounding, if `clears`; NaN where they never hold. False if a rank has grown: earlier samples had one
 * freedom less and are not comparable. */
bool km_statics_ratios(const km_mechanism *mechanism, km_statics *statics, const double *motion, bool clears, double *n,
                       double *d);
/* Makes the configuration of the last km_statics_ratios the reference of the signs. */
void km_statics_set_reference(const km_mechanism *mechanism, km_statics *statics);
/* Reactions of a large substructure by sparse matrices: one wrench per joint, six equations per body. KM_IO: SPQR is
 * not installed; KM_MEMORY. */
km_status km_body_equilibrium_create(const km_mechanism *mechanism, int substructure, struct km_body_equilibrium **out,
                                     km_error *error);
void km_body_equilibrium_free(struct km_body_equilibrium *equilibrium);
/* Computes the minimum-norm reactions into carried[6 · joints], which holds those of the tree alone, and marks
 * indeterminate components. Returns the degree of indeterminacy, -1 without memory. */
int km_body_equilibrium_solve(struct km_body_equilibrium *equilibrium, const km_statics_workspace *work,
                              const km_state *state, double tolerance, double *carried, bool *indeterminate_out);

/* Minimises Σ |force|² + |torque / length|² over the joints: from chord wrenches μ that balance the loads and the
 * reactions of the tree alone in work->carried. Writes work->carried and the degree of indeterminacy. */
void km_reactions_minimise_norm(km_reaction_workspace *reactions_of, km_statics_workspace *work, double length);

/* Marks the components along the reactions' axes with a part of a self-stress, after km_reactions_minimise_norm. */
void km_indeterminate_components_mark(km_reaction_workspace *reactions_of, const km_statics_workspace *work,
                                      km_reaction *reactions);

/* Computes all reactions from work->force. */
void km_reactions_compute(const km_mechanism *mechanism, km_state *state, const km_forces *forces, km_statics *statics);

#endif
