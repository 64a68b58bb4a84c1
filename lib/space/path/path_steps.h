/* Steps of closed configurations from one to another on a path without a singularity (docs/theory.md 4.21).
 *
 *   J = (A B),  e(q) = 0;   du drivers:  dq = N du,  N = (−A⁻¹ B; I)
 *   step towards q':  du = (Nᵀ N)⁻¹ Nᵀ (q' − q), |N du| <= KM_LONGEST_PATH_STEP, then Newton's method with the drivers
 *                     fixed
 *   kept if          sign det A stays, σ_min(A) >= margin, within limits, the caller's condition holds */
#ifndef KM_SPACE_PATH_STEPS_H
#define KM_SPACE_PATH_STEPS_H

#include "space/driver_surface.h"

#define KM_LONGEST_PATH_STEP         0.04 /* radians, sizes */
#define KM_EQUAL_PATH_CONFIGURATIONS 1e-6 /* distance of equal configurations */

typedef struct km_path_steps {
  km_driver_surface f; /* controls: the drivers */
  const km_space_path_def *def;
  double *N;       /* [drivers × columns] */
  double *towards; /* [columns] step to a configuration */
  double square[KM_MAX_PATH_DRIVERS * KM_MAX_PATH_DRIVERS], du[KM_MAX_PATH_DRIVERS], right[KM_MAX_PATH_DRIVERS];
  int small_row[KM_MAX_PATH_DRIVERS];
  double *before; /* saved configuration */
  double margin;
  int sign; /* sign of det A, which steps keep; 0: any */
} km_path_steps;

/* Allocates the arrays; f.m, f.s, def and margin are given. Errors as km_driver_surface_create and
 * km_driver_surface_begin. */
km_status km_path_steps_create(km_path_steps *steps, km_arena *arena, km_error *error);
/* Moves the state to a saved configuration of the path or a tree; A's factors and `sign` are then those there. */
void km_path_steps_move_to(km_path_steps *steps, const double *saved);
/* Smallest singular value of A at the last update: infinite without conditions, where no driver is ever singular. */
double km_path_steps_input_value(km_path_steps *steps);
/* True if the closed configuration, with this sign of det A, may be on a path. */
bool km_path_steps_is_allowed(km_path_steps *steps, int sign);
/* towards <- step from the present to a saved configuration; hinges without limits take the shorter path. Returns its
 * length. */
double km_path_steps_difference(km_path_steps *steps, const double *saved);
/* f.step <- N du with N of the last km_driver_surface_rates. Returns its length. */
double km_path_steps_tangent(km_path_steps *steps, const double *du);
/* Moves by the part of f.step, whose length is given, that is as long as a step may be. *is_whole: by all of it. False:
 * it isn't allowed; the state's configuration is then undefined. */
bool km_path_steps_move(km_path_steps *steps, double length, bool *is_whole);
/* One step towards a saved configuration, `distance` away by `towards`. False: it isn't allowed; the state returns. */
bool km_path_steps_towards(km_path_steps *steps, double distance);

#endif
