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

/* Interpolates by the cubic between two configurations: `move` leads from the first to the second over h, t0 and t1
 * are their tangents. Out: the move from the first to parameter `at`, and the tangent there. */
static inline void km_curve_interpolate(int n, double h, const double *move, const double *t0, const double *t1,
                                        double at, double *out, double *tangent) {
  double u = at / h, h01 = u * u * (3 - 2 * u), h10 = u * (1 - u) * (1 - u), h11 = u * u * (u - 1);
  double d01 = 6 * u * (1 - u), d10 = (1 - u) * (1 - 3 * u), d11 = u * (3 * u - 2);
  for (int k = 0; k < n; ++k) {
    double m = move[k], a = t0[k], b = t1[k];
    out[k] = h01 * m + h * (h10 * a + h11 * b);
    tangent[k] = d01 * m / h + d10 * a + d11 * b;
  }
}

#endif
