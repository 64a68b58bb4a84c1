/* Surface of closed configurations with two controls (docs/theory.md 4.19, 4.20).
 *
 *   e(q) = 0 [r],   J = (A B),   A: the r columns of the other coordinates, B: those of the two controls
 *   input  : K = (J; rows of the drivers in the unit matrix)   singular where A is
 *   output : K = (J; G_x; G_y),  G = ∂(place of a point in its plane)/∂q
 *
 * A control is a driver; the second one may be a number of the design instead. Coordinates are scaled: angles in
 * radians, lengths over the substructure's size, the number over its range. */
#ifndef KM_SPACE_DRIVER_SURFACE_H
#define KM_SPACE_DRIVER_SURFACE_H

#include "kinematics/state.h"
#include "kmech/space.h"
#include "space/design_number.h"

typedef struct km_driver_surface {
  const km_mechanism *m;
  km_state *s;
  int substructure;
  int columns, rows;        /* unknowns, with the number behind the coordinates; rows = columns − 2 */
  int control[2];           /* columns of the controls */
  double low[2], high[2];   /* their ranges: the model's units */
  km_design_number *number; /* the second control; NULL: a driver */
  int *other;               /* [rows] the other columns */
  double *J;                /* [rows × columns], column-major; the number's column isn't updated */
  double *A;                /* [rows × rows], by rows: factors after km_driver_surface_factor */
  int *row;
  double *step, *x, *b;   /* [columns], [rows], [rows] */
  int frame;              /* the output's point: its frame; −1: none */
  km_vec3 axis[2];        /* axes of its plane */
  double *G;              /* [2 × joints] rows of the point, over the size, by km_driver_surface_update_output */
  double *frame_jacobian; /* [6 × coordinate] */
  size_t saved_size;      /* numbers of a saved configuration */
} km_driver_surface;

/* Allocates the arrays; m, s, number, frame and ranges are given, and the drivers as coordinates. KM_USAGE: a
 * driver is no hinge or slide of a loop, the part of the mechanism has ball joints, or not as many conditions as other
 * coordinates. */
km_status km_driver_surface_create(km_driver_surface *surface, const int *drivers, km_arena *arena, km_error *error);
const km_substructure *km_driver_surface_part(const km_driver_surface *f);
/* Updates e and J at the state's configuration. */
void km_driver_surface_update(km_driver_surface *f);
/* Factors A of the last update; *sign is that of det A. False at a singular configuration. */
bool km_driver_surface_factor(km_driver_surface *f, int *sign);
/* Number of coordinates without a number of the design: the order of K. */
int km_driver_surface_joints(const km_driver_surface *f);
/* Updates G at the state's configuration. */
void km_driver_surface_update_output(km_driver_surface *f);
/* K[joints × joints] by rows, of the last update. */
void km_driver_surface_matrix(const km_driver_surface *f, km_singularity_kind kind, double *K);
/* Adds step[columns] to the configuration. False where the number can't have the value; the state is then unchanged. */
bool km_driver_surface_move(km_driver_surface *f, const double *step);
void km_driver_surface_save(const km_driver_surface *f, double *saved);
void km_driver_surface_restore(km_driver_surface *f, const double *saved);
/* Step from the saved to the present configuration, full turns of hinges left out. Returns its length. */
double km_driver_surface_difference(const km_driver_surface *f, const double *saved, double *step);
/* Value of a control in the model's unit, and whether both are within their ranges. */
double km_driver_surface_value(const km_driver_surface *f, int control);
bool km_driver_surface_is_inside(const km_driver_surface *f);

#endif
