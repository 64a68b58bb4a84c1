/* Interpolation of a motion through four closed configurations with their tangents, around a singular configuration
 * (Hermite interpolation, degree 7; theory 4.9, 4.11). Private to continuation/. */
#ifndef KM_CONTINUATION_NODE_CURVE_H
#define KM_CONTINUATION_NODE_CURVE_H

#include "continuation/predictor_corrector.h"

enum { KM_CURVE_NODES = 4 };
/* u = (s - c) / h at the nodes; the singular configuration lies between the inner ones. */
static const double km_node_place[KM_CURVE_NODES] = {-2.0, -1.0, 1.0, 2.0};
/* Distance between the outer nodes of the shortest curve: a singular configuration is bracketed to it. */
#define KM_SINGULAR_BRACKET (4.0 * km_singular_step)

typedef struct km_node_curve {
  double c, h;                            /* s = c + u h */
  double *configuration[KM_CURVE_NODES];  /* as km_state_save */
  double *tangent[KM_CURVE_NODES], *base; /* [columns] dq/ds; [3 · columns] workspace */
} km_node_curve;

/* False without memory. */
bool km_node_curve_reserve(km_node_curve *curve, int columns, km_arena *arena);
/* Records the state's configuration and the tangent t as node i. */
void km_node_curve_record(km_node_curve *curve, const km_continuation *continuation, int i, const double *t);
/* Moves the state to s on the curve, where the loops close to the interpolation error. */
void km_node_curve_place(const km_node_curve *curve, km_continuation *continuation, double s);
/* Computes the tangent t at s, with rotation vectors from the present configuration, which is on the curve. */
void km_node_curve_tangent(const km_node_curve *curve, km_continuation *continuation, double s, double *t);
/* Largest coefficient of u^7. */
double km_node_curve_highest_coefficient(const km_node_curve *curve, km_continuation *continuation);
/* Root u of the cubic through `value` at the nodes, by Newton's method from u. */
double km_node_curve_root(const double value[KM_CURVE_NODES], double u);

#endif
