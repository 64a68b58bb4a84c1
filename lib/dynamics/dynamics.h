/* The equations of motion of one thread: what acts, and everything that an evaluation leaves.
 *
 * Symbols: u the rates of a cluster's independent coordinates, q̇ = N u, q̈ = N u̇ + γ (theory 4: N = [−B; I], γ the
 * velocity products of the dependent ones); V, A twist and acceleration of a node, P_k its partial velocity by u_k, so
 * that A = A_base + ζ + Σ P_k u̇_k; I its inertia with all that hangs on it, p its velocity products less the wrenches
 * on it. A cluster's equations are D u̇ = b − Uᵀ A_base with D = Σ PᵀIP, U = Σ I P and b = Nᵀτ − Σ Pᵀ(p + I ζ). On its
 * base it acts as a body of inertia Σ I − U D⁻¹ Uᵀ: the reverse Schur complement over substructures of (187). */
#ifndef KM_DYNAMICS_DYNAMICS_H
#define KM_DYNAMICS_DYNAMICS_H

#include "dynamics/cluster_tree.h"
#include "dynamics/prescribed_motion.h"
#include "forces/motion_forces.h"
#include "kmech/dynamics.h"

/* What an evaluation comes to. */
typedef enum km_dynamics_outcome {
  KM_DYNAMICS_DONE,
  KM_DYNAMICS_OPEN,     /* a loop can't be closed, or memory is out */
  KM_DYNAMICS_MASSLESS, /* a free motion has no mass */
  KM_DYNAMICS_JAMMED,   /* no friction agrees with what presses under it */
  KM_DYNAMICS_INFINITE  /* rates or accelerations aren't finite numbers */
} km_dynamics_outcome;

/* What an evaluation leaves of a node. Twists and wrenches about km_forces.origin, along the inertial axes. */
typedef struct km_node_motion {
  km_pose pose; /* its frame, from that origin */
  km_twist V, A;
  km_twist zeta;
  km_inertia inertia; /* of what it carries; mc and I about the origin */
  km_wrench p;
} km_node_motion;

/* The numbers of a cluster's partition. */
typedef struct km_cluster_motion {
  int freedom, driven; /* independent coordinates whose acceleration is unknown, and that are prescribed */
  int *independent;    /* [freedom + driven] places in the cluster, the unknown ones first */
  double *N;           /* [(freedom + driven) × coordinates], columns one after the other */
  double *gamma;       /* [coordinates] */
  km_twist *P;         /* [nodes × (freedom + driven)] by node */
  km_wrench *U;        /* [freedom] Σ I P; W after the inward pass */
  double *D, *b, *udot; /* [freedom²] LDLᵀ after the inward pass, by rows; [freedom] then L⁻¹ b; [freedom + driven] */
  size_t room;          /* independent coordinates that there is space for */
} km_cluster_motion;

struct km_dynamics {
  km_arena arena;
  const km_mechanism *mechanism;
  km_tree tree;
  km_forces *forces; /* borrowed */
  km_prescribed *prescribed;
  km_node_motion *node;
  km_articulated *articulated; /* [node] of those that bear clusters: what these leave on it */
  km_twist *column;            /* [coordinate] h of the tree's coordinates, with the motion's sense */
  km_cluster_motion *cluster;
  double *row;      /* [largest_rows] */
  double *step;     /* [largest_columns] */
  double *armature; /* [coordinate] of drives: force · time² / length, or about an axis; NULL: none has one */
  bool *driven;     /* [coordinate] its acceleration is prescribed */
  double *driven_acceleration; /* [coordinate] */
  km_twist *driven_velocity;   /* [node] workspace of km_dynamics_driving_force */
  bool feeds_back;             /* loops aren't closed: their errors are fed back with `omega` (thesis 6.7) */
  double omega;                /* per time */
  double closing;              /* error at which loops count as closed within a step, scaled */
  double residual;             /* largest scaled loop error of the last evaluation, before it closed the loops */
  double weakness;             /* largest reciprocal of a pivot at the last evaluation: what rounding grows by */
  int *renewed;                /* [substructure] how often its partition was renewed since km_dynamics_create */
  bool stale;                  /* a monitor asks for new pivots at the next accepted pose */
  bool repivoted;              /* the last evaluation has changed pivots in a motion */
  /* Forces by the accelerations: called once these are known; goes on by km_dynamics_resolve. NULL: none. */
  km_dynamics_outcome (*press)(void *context, km_state *state);
  void *press_context;
  /* Of evaluations that fail, for the message. */
  int massless;   /* of the last that ended as KM_DYNAMICS_MASSLESS: the coordinate on which nothing with mass moves */
  double open;    /* of the last that ended as KM_DYNAMICS_OPEN: the residual */
  int overdriven; /* of the last one: a prescribed coordinate that other prescribed ones move already; -1: none */
};

/* Accelerations at the state's time, coordinates and rates. `search`: the pose is one that the motion goes through, where
 * partitions may be renewed and the origin moves along; else pivots change only where they have to. */
km_dynamics_outcome km_dynamics_evaluate(km_dynamics *dynamics, km_state *state, bool search);
/* Forces and accelerations once more, after one that is set from outside has changed. */
km_dynamics_outcome km_dynamics_resolve(km_dynamics *dynamics, km_state *state);
km_status km_dynamics_fail(const km_dynamics *dynamics, km_dynamics_outcome outcome, km_error *error);
/* Moves the state along its branch to where the prescribed motions are at its time, if that is further than closing the loops goes:
 * the statuses of km_state_move_to. */
km_status km_dynamics_bring(km_dynamics *dynamics, km_state *state, km_error *error);
/* Puts prescribed coordinates to their rates at the state's time, and to their values. */
void km_dynamics_drive(km_dynamics *dynamics, km_state *state, bool position);

/* Makes the forces those of a static balance: after an evaluation, weights and inertia forces of every body and drive
 * beside what acts. */
void km_dynamics_balance(km_dynamics *dynamics, const km_state *state);

/* The sum of the inertia forces of all bodies at the last evaluation, without weights: about km_forces.origin. */
km_wrench km_dynamics_inertia_forces(const km_dynamics *dynamics);

/* km_dynamics_repartitions counts from here on. */
void km_dynamics_forget_repartitions(km_dynamics *dynamics);

/* The kinetic energy at the last evaluation. */
double km_dynamics_kinetic(const km_dynamics *dynamics, const km_state *state);

/* What prescribed motions give at the last evaluation. */
double km_dynamics_driving_power(const km_dynamics *dynamics, const km_state *state);

/* Closes the loops from the state's independent coordinates, renews partitions where that is needed (`search`: wherever
 * a monitor asks for it, at a pose that is accepted), makes the dependent rates follow, and leaves N and γ. False when
 * out of memory, or where a loop can't close. */
bool km_constraints_update(km_dynamics *dynamics, km_state *state, bool search);

/* Poses, columns, twists, inertias and velocity products of the nodes. */
void km_tree_move(km_dynamics *dynamics, const km_state *state);

/* The force that an acceleration of the node asks for, of what it carries and of what has been eliminated from it. */
km_wrench km_node_force(const km_dynamics *dynamics, int node, km_twist acceleration);

/* Inward and outward over the clusters: from forces and velocity products to accelerations. */
km_dynamics_outcome km_tree_solve(km_dynamics *dynamics, km_state *state);

#endif
