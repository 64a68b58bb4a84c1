/* The parts of a static balance. Private to analysis/. */
#ifndef KM_STATICS_STATICS_H
#define KM_STATICS_STATICS_H

#include "forces/forces.h"
#include "kmech/statics.h"
#include "linalg/dense/simd_pair.h"

#include <gsl/gsl_matrix.h>
#include <gsl/gsl_permutation.h>
#include <string.h>

/* Solving for the actuators of one block: a substructure, or several and joints in no loop that pushed points move
 * together. A motion x of its freedoms moves the actuators by Z_A x. */
typedef struct km_actuator_workspace {
  int part_count, alone_count;
  int *part, *alone; /* its substructures; its joints in no loop, by their coordinates */
  int columns;
  const int *coordinate;         /* [columns] */
  const double *Z;               /* [freedom × columns] D · range(N) at the present pose */
  bool gathers;                  /* Z has to be put together; else the basis of the only substructure serves */
  double *gathered;              /* [capacity × columns] Z, where it has */
  int capacity;                  /* freedoms that there is room for */
  int count;                     /* actuators in this block */
  int *actuator;                 /* [count] into the statics' actuators */
  gsl_matrix *U, *V;             /* of Z_A = U S Vᵀ, padded with rows of 0 to at least as many as columns */
  gsl_vector *S, *load, *answer; /* load: Vᵀ g */
  double *basis;                 /* of the motions out of reach */
  int freedom, rank;             /* at the last pose */
  double noise;                  /* of the loads g */
  /* Along a sweep: */
  int most_rank;     /* freedoms that the actuators reach but at single poses */
  gsl_matrix *fixed; /* [actuator × rank] U at the last sample: what is seen from there keeps its signs */
  double *moving;    /* [rank × column] Z V there */
  gsl_matrix *turn;  /* [rank × rank] */
  gsl_permutation *pivots;
} km_actuator_workspace;

/* A motion whose largest actuator moves less than this share of it is out of the actuators' reach. */
static const double km_out_of_reach = 1e-9;
/* A component of a self-stress below this share of its largest is rounding. */
static const double km_no_part = 1e-9;

/* A loop that goes through a joint, and the sign with which its chord's wrench acts there. */
typedef struct km_passing {
  int loop; /* among the substructure's */
  double sense;
} km_passing;

/* Of two loops: Σ over the joints that they share of the product of their senses, alone, times the joint's arm d, and
 * times d dᵀ: xx yy zz, yz zx xy. */
typedef struct km_arm_moments {
  double count;
  km_vec3 first, squares, products;
} km_arm_moments;

typedef struct km_stress_entry {
  int row;
  double value;
} km_stress_entry;

/* Reactions of one substructure. */
typedef struct km_reaction_workspace {
  struct km_body_equilibrium *large; /* NULL: it is small, and J is solved as a dense matrix */
  int rows, columns;                 /* of J: 6 · loops + couplings */
  int loops, joints;
  const int *joint; /* [joints] */
  double size;      /* of the substructure: the chords' forces are counted times it */
  bool *mixed;      /* [6 · joints] of a large one: components that statics alone doesn't determine */
  double *reported; /* [6 · joints] of a large one: what they carry as it is reported */
  /* Of a small one: */
  int *first;          /* [joints + 1] into `passing` */
  km_passing *passing; /* the loops that go through each joint */
  km_vec3 *arm;        /* [joints] from the point that moments of chords are about to where its reaction is */
  double *T;           /* [columns × felt_count] Jᵀ of all six rows of every loop, but for what no motion feels */
  int *felt;           /* [rows] the rows of J that T has; then the others */
  int felt_count;
  double *rhs, *mu;        /* [columns]; [rows] the chords' wrenches, f · size and τ */
  km_arm_moments *moments; /* [loops × loops] with b ≤ a, a · loops + b */
  int *stress_start;       /* [rows + 1] into `stress` */
  km_stress_entry *stress; /* self-stresses N by their entries */
  double *metric;          /* [rows × rows] M: μᵀ M μ is the Σ of km_reactions_minimise_norm */
  double *image;           /* [rows × rows] M N */
  km_pair *looks;          /* [2 · rows + 6 · joints] workspace of km_indeterminate_components_mark */
  double *gram;            /* [rows × rows] Nᵀ M N; its Cholesky factor, the diagonal as reciprocals */
  double *gradient;        /* [rows] half the slope of Σ where μ is 0, */
  double *slope;           /* [rows] the same along each self-stress, */
  double *share;           /* [rows] and how much of each is added */
  int degree;              /* self-stresses at the last pose */
  km_partition partition;  /* of T */
} km_reaction_workspace;

struct km_statics_workspace {
  km_arena arena;
  const km_mechanism *mechanism;
  km_port *actuators;
  int *part;          /* [actuator] its block, -1: a joint in no loop that moves by itself */
  int *alone;         /* [actuator] that joint's coordinate; -1 */
  int *column;        /* [actuator] a joint's place among the columns of its block */
  double **row;       /* [actuator] of points: rate along the direction per unit rate of each coordinate; else NULL */
  bool *actuated;     /* [coordinate] */
  km_twist *twist;    /* [coordinate] child against parent, about the forces' origin */
  km_wrench *subtree; /* [body] applied wrenches on it and all that hangs on it in the tree */
  double *tau;        /* [coordinate] generalised forces of what is applied, springs in joints included */
  double *force;      /* [coordinate] of the actuators, or f̄ */
  bool no_reactions;  /* see km_statics_leave_reactions */
  bool compares;      /* km_statics_ratios is asked for: every block keeps its Z, U, S, V */
  double *least_load; /* [coordinate] below this a generalised force is rounding */
  km_pose *frame;     /* [joint] in which its reaction is reported, about the forces' origin */
  km_wrench *carried; /* [joint] its reaction along the inertial axes */
  int *place;         /* [joint] among the joints of its substructure */
  km_actuator_workspace *holding; /* [block_count] */
  int block_count;
  km_reaction_workspace *carrying;
};

/* The scale of an actuator's force, D: that of its coordinate, or of a length. */
static inline double km_actuator_scale(const km_mechanism *m, const km_statics *st, int actuator) {
  const km_port *h = &st->actuators[actuator];
  return h->kind == KM_PORT_JOINT ? m->scale[h->coordinate] : 1.0 / m->length;
}
/* Calls for every free coordinate between a point's body and the inertial frame in the tree. */
typedef void (*km_mover_visit)(void *context, int coordinate, bool against);
void km_point_each_mover(const km_mechanism *mechanism, const km_port *point, km_mover_visit at, void *context);
/* Which substructures and lone joints the actuators move together, into work->holding, part, alone, column. KM_USAGE: a
 * point can't move, or pushes the same lone joint as another actuator. KM_MEMORY. */
km_status km_blocks_make(const km_mechanism *mechanism, km_statics *statics, km_error *error);
/* work->row of every point, from work->twist; and the wrenches of points that hold, added to what is applied. */
void km_pushed_points_update(const km_mechanism *mechanism, const km_forces *forces, km_statics *statics);
void km_pushed_points_apply(const km_mechanism *mechanism, const km_forces *forces, km_statics *statics);
/* Is an actuator's force a force, not a torque? */
bool km_pushes_by_force(const km_model *model, const km_port *actuator);
/* Space for the parts; false when out of memory. */
bool km_actuator_workspace_reserve(km_statics *statics);
/* The same for a block at a pose of so many freedoms. */
bool km_actuator_workspace_fit(km_actuator_workspace *holding, int freedom, km_arena *arena);
km_status km_reaction_workspace_reserve(const km_mechanism *mechanism, km_statics_workspace *work, km_error *error);
/* From now on the substructure is solved as a large one. */
km_status km_reaction_workspace_make_large(const km_mechanism *mechanism, km_statics_workspace *work, int substructure,
                                           km_error *error);
void km_reaction_workspace_free(km_statics_workspace *work);

/* U S Vᵀ of a matrix whose first `rows` rows alone aren't 0, fewer than its columns, in its place; V is whole. False when out of
 * memory. O(columns² · rows), where Jacobi's method takes O(columns³) a sweep. */
bool km_decompose_wide(gsl_matrix *U, gsl_matrix *V, gsl_vector *S, int rows);
/* The same of rows of an orthonormal basis: where all its columns keep their length, the other rows are 0, and U is the matrix
 * itself. False where they don't. */
bool km_decompose_straight(const gsl_matrix *U, gsl_matrix *V, gsl_vector *S);
/* A direction to be filled with rates of the coordinates, all 0 yet; NULL: it is counted only. Then its largest scaled rate
 * becomes 1. */
double *km_direction_begin(const km_mechanism *mechanism, bool falls, km_statics *statics);
void km_direction_end(const km_mechanism *mechanism, const km_actuator_workspace *holding, double *rates);
/* Holds a block of many freedoms and few actuators, or all, from st->least_norm; false: its basis has to be made. */
bool km_actuator_forces_solve_columns(const km_mechanism *mechanism, const km_state *state, int block,
                                      km_statics *statics);
/* Actuator forces, directions out of their reach, and whether they hold, from work->tau and where they don't compare from
 * st->least_norm. */
void km_actuator_forces_solve(const km_mechanism *mechanism, const km_state *state, km_statics *statics);
/* km_statics_compute without the marks of components that are indeterminate, which km_statics_mark adds: few ask for them. */
km_status km_statics_find(const km_mechanism *mechanism, km_state *state, km_forces *forces, km_statics *statics);
void km_statics_mark(const km_mechanism *mechanism, km_statics *statics);
/* The same for forces that are at hand, as those of a motion (km_dynamics_balance). */
km_status km_statics_balance(const km_mechanism *mechanism, km_state *state, km_forces *forces, km_statics *statics);
/* From now on these don't find reactions, which are NaN: nobody reads them. */
void km_statics_leave_reactions(const km_mechanism *mechanism, km_statics *statics);
/* Reactions alone, for forces that are at hand as those of a motion, with `driving` [coordinate] of what is prescribed. */
void km_statics_bear(const km_mechanism *mechanism, km_state *state, const km_forces *forces, const double *driving,
                     km_statics *statics);
/* The part of it that finds the actuators' forces; f̄ and reactions stay as they were. */
void km_statics_hold(const km_mechanism *mechanism, const km_state *state, const km_forces *forces,
                     km_statics *statics);
/* After km_statics_hold, along a sweep: every actuator's force as n/d, both smooth along the motion, d = 0 where the
 * actuators lose a freedom. `motion`: rates of the coordinates along it (NULL: unknown). Exactly 0 where rounding is
 * all there is; NaN where they never hold. False if a rank has grown: what came before had a freedom less within reach,
 * and nothing before can be compared. */
bool km_statics_ratios(const km_mechanism *mechanism, km_statics *statics, const double *motion, double *n, double *d);
/* The pose of the last km_statics_ratios is a sample: those to come have its signs. */
void km_statics_refer(const km_mechanism *mechanism, km_statics *statics);
/* Reactions of a large substructure, by sparse matrices: one wrench a joint, six equations a body. KM_IO: SPQR isn't
 * installed. KM_MEMORY. */
km_status km_body_equilibrium_create(const km_mechanism *mechanism, int substructure, struct km_body_equilibrium **out,
                                     km_error *error);
void km_body_equilibrium_free(struct km_body_equilibrium *equilibrium);
/* Of least norm, into carried[6 · joints], which holds what the joints carry by the tree alone; `mixed` is set where
 * statics alone doesn't determine a component. Returns the degree of indeterminacy, -1 when out of memory. */
int km_body_equilibrium_solve(struct km_body_equilibrium *equilibrium, const km_statics_workspace *work,
                              const km_state *state, double tolerance, double *carried, bool *mixed);

/* From a μ that balances the loads, and what the joints carry by the tree alone in work->carried: what they carry of
 * least Σ |force|² + |torque / length|², into the same; and the degree of indeterminacy. */
void km_reactions_minimise_norm(km_reaction_workspace *carrying, km_statics_workspace *work, double length);

/* Marks the components along the reactions' axes in which some self-stress has a part, after km_reactions_minimise_norm. */
void km_indeterminate_components_mark(km_reaction_workspace *carrying, const km_statics_workspace *work,
                                      km_reaction *reactions);

/* Reactions from work->force. */
void km_reactions_compute(const km_mechanism *mechanism, km_state *state, const km_forces *forces, km_statics *statics);

#endif
