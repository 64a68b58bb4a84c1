/* Closed configurations with as many controls as freedoms (docs/theory.md 4.19 to 4.21).
 *
 *   e(q) = 0 [r],   J = (A B),   A: the r columns of the other coordinates, B: those of the controls u
 *   dq = N du,  N = (−A⁻¹ B; I)
 *   rows of all conditions: J_all = W J,  |W_ij| ≤ 2   J: the primary rows, r = rank J_all, the first times ±1
 *   input  : K = (J; rows of the drivers in the unit matrix)   singular where A is
 *   output : K = (J; G_1; G_2),  G_i = t_i · ∂(place of a point)/∂q,  t_1, t_2: tangents of its plane or sphere
 *
 * A control is a driver; the last one may be a number of the design instead. Coordinates are scaled: angles in
 * radians, lengths over the substructure's size, the number over its range. */
#ifndef KM_SPACE_DRIVER_SURFACE_H
#define KM_SPACE_DRIVER_SURFACE_H

#include "kinematics/state.h"
#include "kmech/space.h"
#include "space/design_number.h"
#include "space/surface/condition_rows.h"
#include "space/surface/kept_clearance.h"
#include "space/surface/point_surface.h"
#include "space/surface/rod_spin.h"

/* A part of the mechanism that a driver moves: a substructure, or a joint of no loop. */
typedef struct km_surface_part {
  int substructure;            /* −1: a joint of no loop */
  int coordinate;              /* that joint's */
  int columns, rows;           /* coordinates and conditions */
  int column_start, row_start; /* first of each among those of all parts */
} km_surface_part;

typedef struct km_driver_surface {
  const km_mechanism *m;
  km_state *s;
  km_surface_part part[KM_MAX_PATH_DRIVERS]; /* parts of the drivers; several may be in one */
  int part_count;
  double size;       /* length of the output's rows: that of the largest part */
  int columns, rows; /* unknowns, with the number behind the coordinates; primary rows = columns − controls */
  int conditions;    /* primary rows, and those that depend on them, of parts and rods */
  int rod_count;     /* rods that are held from spinning: their conditions come last */
  km_rod_spin *rods;
  int control_count, control[KM_MAX_PATH_DRIVERS]; /* columns of the controls */
  double low[2], high[2];                          /* ranges of two controls: the model's units */
  bool is_full_turn[2];                            /* a hinge whose range is a full turn, and so without ends */
  bool keeps_limits;                               /* joint limits bound curves too */
  km_kept_clearance kept;                          /* and a least clearance */
  km_design_number *number;                        /* the last control; NULL: a driver */
  int *other;                                      /* [rows] the other columns */
  double *J;      /* [rows × columns], column-major; the number's column isn't updated. All conditions: all_J */
  double *e;      /* [rows] closure errors. All conditions: all_e */
  double *all_J;  /* [conditions × columns] of all conditions */
  double *all_e;  /* [conditions] */
  double gap;     /* largest magnitude of all_e */
  double *part_J; /* [conditions × columns] workspace */
  km_condition_rows primary; /* rows of J and e among all conditions */
  double *A;                 /* [rows × rows], by rows: factors after km_driver_surface_factor */
  int *row;
  double *step, *x, *b;   /* [columns], [rows], [rows] */
  int frame;              /* the output's point: its frame; −1: none */
  km_point_surface point_surface; /* its plane or sphere */
  double *G;              /* [2 × joints] rows of the point, over the size, by km_driver_surface_update_output */
  double *frame_jacobian; /* [6 × coordinate] */
  bool *wraps;            /* [joints] km_driver_surface_difference leaves out full turns: hinges by default */
  size_t saved_size;      /* numbers of a saved configuration */
} km_driver_surface;

/* Finds parts and columns; m, s, number, frame and ranges are given, and drivers[count] as coordinates. KM_USAGE: a
 * driver is no free hinge or slide. s may be missing. */
km_status km_driver_surface_create(km_driver_surface *surface, const int *drivers, int count, km_arena *arena,
                                   km_error *error);
/* Finds the conditions at the state's closed configuration, with the first primary rows. KM_USAGE: the freedoms of the
 * parts aren't as many as drivers, there or at a neighbour on the motion, or the point is on no plane and no sphere. */
km_status km_driver_surface_begin(km_driver_surface *surface, km_arena *arena, km_error *error);
/* Returns to the first choice of primary rows, at a closed configuration that no steps have led to, and turns spun rods
 * back. */
void km_driver_surface_restart(km_driver_surface *f);
/* Turns spun rods back. */
void km_driver_surface_stop_spins(km_driver_surface *f);
/* Exchanges primary rows on which others depend with a larger weight than 2, at the last update. True if one was. */
bool km_driver_surface_exchange(km_driver_surface *f);
/* True if all conditions were satisfied at the last update. */
bool km_driver_surface_is_closed(const km_driver_surface *f);
/* Coordinate of a column that isn't the number's. */
int km_driver_surface_coordinate(const km_driver_surface *f, int column);
/* Updates e and J at the state's configuration. */
void km_driver_surface_update(km_driver_surface *f);
/* Factors A of the last update; *sign is that of det A. False at a singular configuration. */
bool km_driver_surface_factor(km_driver_surface *f, int *sign);
/* Closes the loops with the controls fixed, by Newton's method. False if the first correction exceeds `most`, at a
 * singular configuration, without convergence, or where other conditions than the primary ones stay open. On success
 * A's factors, J and *sign belong to the configuration. */
bool km_driver_surface_close(km_driver_surface *f, double most, int *sign);
/* N[controls × joints], by controls, at the factors of A; without a number of the design. */
void km_driver_surface_rates(km_driver_surface *f, double *N);
/* z[joints]: the spin of a rod with the drivers at rest, at the factors of A. */
void km_driver_surface_spin(km_driver_surface *f, int rod, double *z);
/* Smallest singular values of A and of J at the last update, lengths over the sizes, those of motions that dependent
 * conditions or free spins leave at 0 left out; NaN without conditions. */
double km_driver_surface_input_value(km_driver_surface *f);
double km_driver_surface_closure_value(km_driver_surface *f);
/* Number of coordinates without a number of the design: the order of K. */
int km_driver_surface_joints(const km_driver_surface *f);
/* Copies J to the first rows of M, which is by rows and has `width` columns; J's columns beyond them are left out. */
void km_driver_surface_rows(const km_driver_surface *f, double *M, int width);
/* Place of the point at the state's poses. */
km_vec3 km_driver_surface_place(const km_driver_surface *f);
/* Updates the poses and G at the state's configuration. */
void km_driver_surface_update_output(km_driver_surface *f);
/* K[joints × joints] by rows, of the last update. */
void km_driver_surface_matrix(const km_driver_surface *f, km_curve_kind kind, double *K);
/* det K of this kind at the state's configuration; K[joints × joints] and row[joints] are workspace. */
double km_driver_surface_determinant(km_driver_surface *f, km_curve_kind kind, double *K, int *row);
/* Adds step[columns] to the configuration. False where the number can't have the value; the state is then unchanged. */
bool km_driver_surface_move(km_driver_surface *f, const double *step);
void km_driver_surface_save(const km_driver_surface *f, double *saved);
void km_driver_surface_restore(km_driver_surface *f, const double *saved);
/* Step from the saved to the present configuration, full turns left out as `wraps` says. Returns its length. */
double km_driver_surface_difference(const km_driver_surface *f, const double *saved, double *step);
/* Value of a control in the model's unit. */
double km_driver_surface_value(const km_driver_surface *f, int control);
/* Least distance to the ends of the controls' ranges but full turns, to the joints' limits if they are kept, and to the
 * least clearance; negative outside. A column and a pair don't count; −1: all do. */
double km_driver_surface_margin(km_driver_surface *f, int column, int pair);
/* Adds to row[columns] the gradient of a pair's distance over the size, at the last update of the kept clearance. */
void km_driver_surface_add_clearance_row(km_driver_surface *f, int pair, double *row);
/* Value of a column's coordinate to which limits apply, radians or the model's length: of a ball joint's first column
 * its angle, of the others 0. */
double km_driver_surface_limited_value(const km_driver_surface *f, int column);
/* Adds the derivative of that value, scaled, to row[columns]. */
void km_driver_surface_add_limited_row(const km_driver_surface *f, int column, double *row);
/* Lower and upper limit of that value; infinite: none. */
double km_driver_surface_low(const km_driver_surface *f, int column);
double km_driver_surface_high(const km_driver_surface *f, int column);
/* True if a coordinate of the parts exceeds its limits. */
bool km_driver_surface_is_outside_limit(const km_driver_surface *f);

#endif
