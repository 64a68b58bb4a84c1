/* Polynomials through configurations and tangents of a motion (Hermite interpolation, theory 4.5). Moves are scaled
 * steps, [n]; tangents are d(move)/ds. */
#ifndef KM_CONTINUATION_HERMITE_CURVE_H
#define KM_CONTINUATION_HERMITE_CURVE_H

#define T        double
#define FN(name) km_##name
#include "continuation/polynomials_body.h"
#undef T
#undef FN

/* Weights of the degree-10 Hermite polynomial through nine configurations, h apart, and the tangents at the last two,
 * evaluated h after the last: of the eight moves and of the two tangents times h, the latest first. Error 9! 2! h¹¹
 * y⁽¹¹⁾/11!. More tangents would have larger weights and amplify the closing errors in them from step to step. */
enum { KM_CURVE_MOVES = 8 };
static const double km_curve_moves[KM_CURVE_MOVES] = {-6989.0 / 140.0, -1585.0 / 28.0, 767.0 / 28.0, -409.0 / 28.0,
                                                      179.0 / 28.0,    -281.0 / 140.0, 11.0 / 28.0,  -1.0 / 28.0};
static const double km_curve_tangents[2] = {18.0, 72.0};

#endif
