/* Equations of motion of one thread: forces, tree, and the results of an evaluation.
 *
 * Symbols: u rates of a cluster's independent coordinates, q̇ = N u, q̈ = N u̇ + γ (docs/theory.md 3.1: N = [−B;
 * I], γ the velocity products of the dependent ones, 2.6); V, A twist and acceleration of a node, P_k its partial
 * velocity by u_k, so that A = A_base + ζ + Σ P_k u̇_k; I articulated inertia of the node, p its velocity products
 * minus the wrenches on it. A cluster's equations are D u̇ = b − Uᵀ A_base with D = Σ PᵀIP, U = Σ I P and b = Nᵀτ −
 * Σ Pᵀ(p + I ζ). A cluster acts on its base as a body of inertia Σ I − U D⁻¹ Uᵀ: the reverse Schur complement over
 * substructures of (187). */
#ifndef KM_DYNAMICS_DYNAMICS_H
#define KM_DYNAMICS_DYNAMICS_H

#include "dynamics/cluster_tree.h"
#include "dynamics/prescribed_motion.h"
#include "forces/motion_forces.h"
#include "kmech/dynamics.h"

/* Outcome of an evaluation. */
typedef enum km_dynamics_outcome {
  KM_DYNAMICS_DONE,
  KM_DYNAMICS_OPEN,     /* a loop can't be closed, or out of memory */
  KM_DYNAMICS_MASSLESS, /* a free motion has no mass */
  KM_DYNAMICS_JAMMED,   /* no friction is consistent with the reactions */
  KM_DYNAMICS_IMPLICIT, /* no forces of modules that read accelerations are consistent with these */
  KM_DYNAMICS_STOPPED,  /* the program's force function stopped the run */
  KM_DYNAMICS_INFINITE  /* rates or accelerations aren't finite numbers */
} km_dynamics_outcome;

/* Results of an evaluation for a node. Twists and wrenches are about km_forces.origin, along the inertial axes. */
typedef struct km_node_motion {
  km_pose pose; /* pose of its frame, relative to that origin */
  km_twist V, A;
  km_twist zeta;
  km_inertia inertia; /* inertia of its bodies; mc and I about the origin */
  km_wrench p;
} km_node_motion;

/* Partition of a cluster and its matrices. */
typedef struct km_cluster_motion {
  int freedom, driven;  /* numbers of independent coordinates: with unknown acceleration; prescribed */
  int *independent;     /* [freedom + driven] indices in the cluster, unknown ones first */
  double *N;            /* [(freedom + driven) × coordinates] column-major: q̇ = N u */
  double *gamma;        /* [coordinates] velocity products: q̈ = N u̇ + γ */
  km_twist *P;          /* [nodes × (freedom + driven)] partial velocities, by node */
  km_wrench *U;         /* [freedom] Σ I P; W = U L⁻ᵀ after the inward pass */
  double *D, *b, *udot; /* [freedom²] by rows, L Δ Lᵀ after the inward pass; [freedom] L⁻¹ b after it; [freedom +
                         * driven] */
  size_t capacity;      /* allocated number of independent coordinates */
} km_cluster_motion;

struct km_dynamics {
  km_arena arena;
  const km_mechanism *mechanism;
  km_tree tree;
  km_forces *forces; /* borrowed */
  km_prescribed *prescribed;
  km_node_motion *node;
  km_articulated *articulated; /* [node] inertia of the clusters attached to a base node */
  km_twist *column;            /* [coordinate] joint twists h, with the sign of the motion */
  km_cluster_motion *cluster;
  double *row;                 /* [largest_rows] */
  double *step;                /* [largest_columns] */
  double *armature;            /* [coordinate] armature inertia: force · time²/length, or about an axis; NULL: none */
  bool *driven;                /* [coordinate] true if the acceleration is prescribed */
  double *driven_acceleration; /* [coordinate] */
  km_twist *driven_velocity;   /* [node] work array of km_dynamics_driving_force */
  bool uses_baumgarte;         /* Baumgarte's stabilisation: loops aren't closed, their errors are fed back with
                                * `omega` (thesis 6.7) */
  double omega;                /* ω, per time */
  double closing_tolerance;    /* scaled error at which loops count as closed within a step */
  double residual;             /* largest scaled loop error of the last evaluation, before closing */
  double weakness;             /* largest reciprocal of a pivot at the last evaluation: growth of loop errors in the
                                * coordinates */
  int *repartitions;           /* [substructure] number of repartitions since km_dynamics_create */
  bool stale;                  /* the growth monitor requests new pivots at the next accepted configuration */
  bool changed_pivots;         /* the last evaluation changed pivots during a motion */
  /* Callback for forces that depend on the accelerations (friction), called after these are known; it repeats by
   * km_dynamics_resolve. NULL: none. */
  km_dynamics_outcome (*update_friction)(void *context, km_state *state);
  void *friction_context;
  /* Data of failed evaluations, for the message. */
  int massless;       /* KM_DYNAMICS_MASSLESS: coordinate that moves no mass */
  double open;        /* KM_DYNAMICS_OPEN: residual */
  int overprescribed; /* prescribed coordinate that depends on other prescribed ones; −1: none */
};

/* Evaluates the accelerations at the state's time, coordinates and rates. `search`: the configuration is an accepted
 * one; partitions are renewed where the monitor requests it and the origin follows the mechanism. Otherwise pivots
 * change only if they fail. */
km_dynamics_outcome km_dynamics_evaluate(km_dynamics *dynamics, km_state *state, bool search);
/* Sets poses and twists of the bodies on which forces act, after km_tree_update. */
void km_dynamics_locate_bodies(const km_dynamics *dynamics);
/* Both parts of km_dynamics_evaluate: prescribed coordinates, closed loops and rates; then the accelerations. */
km_dynamics_outcome km_dynamics_close(km_dynamics *dynamics, km_state *state, bool search);
km_dynamics_outcome km_dynamics_accelerate_closed(km_dynamics *dynamics, km_state *state, bool search);
/* The state between steps has coordinates and rates only, where accelerations result from the state alone: without
 * implicit modules, friction by reactions and a program, which start from their last forces. */
void km_simulation_skip_accelerations(km_simulation *simulation, bool skips);
/* Forces and accelerations at the present forces of the implicit modules. */
km_dynamics_outcome km_dynamics_solve_explicit(km_dynamics *dynamics, km_state *state);
/* Finds the forces of the implicit modules with which laws and accelerations agree, after
 * km_dynamics_solve_explicit. */
km_dynamics_outcome km_implicit_forces_solve(km_dynamics *dynamics, km_state *state);
/* Repeats forces and accelerations after an external force has changed. */
km_dynamics_outcome km_dynamics_resolve(km_dynamics *dynamics, km_state *state);
km_status km_dynamics_fail(const km_dynamics *dynamics, km_dynamics_outcome outcome, km_error *error);
/* Moves the state along its branch to the prescribed values at its time, if they are farther than closing the loops
 * reaches. Statuses of km_state_move_to. */
km_status km_dynamics_move_to_prescribed(km_dynamics *dynamics, km_state *state, km_error *error);
/* Sets the prescribed rates at the state's time and, if `position`, the prescribed values. */
void km_dynamics_apply_prescribed(km_dynamics *dynamics, km_state *state, bool position);

/* Converts the forces to those of a static balance: adds weights and inertia forces of all bodies and drives.
 * Requires an evaluation. */
void km_dynamics_balance(km_dynamics *dynamics, const km_state *state);

/* Sum of the inertia forces of all bodies at the last evaluation, without weights, about km_forces.origin. */
km_wrench km_dynamics_inertia_forces(const km_dynamics *dynamics);

/* Resets the count of km_dynamics_repartitions. */
void km_dynamics_reset_repartitions(km_dynamics *dynamics);

/* Kinetic energy at the last evaluation. */
double km_dynamics_kinetic(const km_dynamics *dynamics, const km_state *state);

/* Power of the driving forces of prescribed motions at the last evaluation. */
double km_dynamics_driving_power(const km_dynamics *dynamics, const km_state *state);

/* Closes the loops by the dependent coordinates, renews partitions where needed (`search`: where the growth monitor
 * requests it, at an accepted configuration), computes the dependent rates and N. False: out of memory, or a loop can't
 * be closed. */
bool km_constraints_close(km_dynamics *dynamics, km_state *state, bool search);
/* Computes γ after km_constraints_close. */
void km_constraints_velocity_products(km_dynamics *dynamics, km_state *state);

/* Computes poses, joint twists, twists, inertias and velocity products of all nodes. */
void km_tree_update(km_dynamics *dynamics, const km_state *state);

/* Wrench I a that an acceleration of the node requires, for its bodies and for the clusters eliminated onto it. */
km_wrench km_node_inertia_force(const km_dynamics *dynamics, int node, km_twist acceleration);

/* Computes accelerations from forces and velocity products: inward and outward pass over the clusters. */
km_dynamics_outcome km_tree_solve(km_dynamics *dynamics, km_state *state);

#endif
