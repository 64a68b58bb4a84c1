/* Solves two equations that are linear in the cosines and sines of two angles x, y.
 *
 *   e0 cos x + e1 sin x + e2 cos y + e3 sin y + e4 = 0    (two rows)
 *
 * Solving both rows for (cos x, sin x) and cos²x + sin²x = 1 gives a trigonometric quadratic in y. As a
 * polynomial of degree 4 in z = exp(iy), its roots on the unit circle are the real angles. */
#include "arm/ik/trigonometric_equations.h"

#include <complex.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

static const double negligible = 1e-12;

/* a cos x + b sin x + c = 0 as hypot(a, b) cos(x − atan2(b, a)) = −c. */
int km_solve_cos_sin(const double line[3], double x[2]) {
  double size = hypot(line[0], line[1]), middle = atan2(line[1], line[0]);
  if (!(size > negligible) || fabs(line[2]) > 1.5 * size)
    return 0;
  double cosine = -line[2] / size, half = acos(fmin(fmax(cosine, -1.0), 1.0));
  x[0] = middle + half;
  x[1] = middle - half;
  return half == 0.0 || fabs(cosine) >= 1.0 ? 1 : 2;
}

/* Complex number; CMPLX isn't in older headers of clang. */
static double complex make_complex(double real, double imaginary) {
  const double parts[2] = {real, imaginary};
  double complex z;
  memcpy(&z, parts, sizeof z);
  return z;
}

/* All roots of c[0] + … + c[degree] z^degree, by the Durand-Kerner iteration. */
static void find_roots(const double complex *c, int degree, double complex *z) {
  enum { MAX_STEPS = 500 };
  for (int i = 0; i < degree; ++i)
    z[i] = cexp(make_complex(0.0, 0.4 + 2.0 * M_PI * i / degree));
  for (int step = 0; step < MAX_STEPS; ++step) {
    double moved = 0.0;
    for (int i = 0; i < degree; ++i) {
      double complex value = c[degree], apart = c[degree];
      for (int k = degree - 1; k >= 0; --k)
        value = value * z[i] + c[k];
      for (int k = 0; k < degree; ++k)
        apart *= k == i ? 1.0 : z[i] - z[k];
      double complex move = cabs(apart) > 0.0 ? value / apart : make_complex(1e-8, 0.0);
      z[i] -= move;
      moved = fmax(moved, cabs(move) / (1.0 + cabs(z[i])));
    }
    if (moved < 1e-15)
      return;
  }
}

/* Solves f[0] + f[1] cos y + f[2] sin y + f[3] cos² y + f[4] cos y sin y + f[5] sin² y = 0 as a polynomial in z =
 * exp(iy). Real angles are roots on the unit circle; nearly double roots lie close to it and are kept. −1: every
 * angle is a solution. */
static int solve_quadratic(const double search[6], double y[4]) {
  double complex c[5], z[4];
  c[4] = make_complex(0.25 * (search[3] - search[5]), -0.25 * search[4]);
  c[3] = make_complex(0.5 * search[1], -0.5 * search[2]);
  c[2] = search[0] + 0.5 * (search[3] + search[5]);
  c[1] = conj(c[3]);
  c[0] = conj(c[4]);
  double size = cabs(c[4]) + cabs(c[3]) + fabs(creal(c[2])), terms = 0.0;
  int first = 0, degree = 4, count = 0;
  for (int k = 0; k < 6; ++k)
    terms += fabs(search[k]);
  if (!(size > 1e-10 * terms))
    return -1;
  if (!(cabs(c[4]) + cabs(c[3]) > negligible * size))
    return 0;
  if (!(cabs(c[4]) > negligible * size)) {
    first = 1;
    degree = 2;
  }
  find_roots(c + first, degree, z);
  for (int i = 0; i < degree; ++i)
    if (fabs(cabs(z[i]) - 1.0) < 0.2)
      y[count++] = carg(z[i]);
  return count;
}

/* Eliminates one angle x: cos x and sin x are linear in cos y and sin y, and cos² x + sin² x = 1 is quadratic in
 * them. `second` selects the angle to eliminate. */
static int eliminate(double e[2][5], bool second, double (*pairs)[2]) {
  const int p = second ? 2 : 0, r = second ? 0 : 2;
  double det = e[0][p] * e[1][p + 1] - e[0][p + 1] * e[1][p], x[2][3], search[6] = {-1.0}, y[4];
  for (int k = 0; k < 3; ++k) { /* coefficients of 1, cos y, sin y */
    double g0 = k ? e[0][r + k - 1] : e[0][4], g1 = k ? e[1][r + k - 1] : e[1][4];
    x[0][k] = (-g0 * e[1][p + 1] + g1 * e[0][p + 1]) / det;
    x[1][k] = (-g1 * e[0][p] + g0 * e[1][p]) / det;
  }
  for (int i = 0; i < 2; ++i) {
    search[0] += x[i][0] * x[i][0];
    search[1] += 2.0 * x[i][0] * x[i][1];
    search[2] += 2.0 * x[i][0] * x[i][2];
    search[3] += x[i][1] * x[i][1];
    search[4] += 2.0 * x[i][1] * x[i][2];
    search[5] += x[i][2] * x[i][2];
  }
  int count = solve_quadratic(search, y);
  for (int i = 0; i < count; ++i) {
    double cosine = x[0][0] + x[0][1] * cos(y[i]) + x[0][2] * sin(y[i]);
    double sine = x[1][0] + x[1][1] * cos(y[i]) + x[1][2] * sin(y[i]);
    pairs[i][second] = atan2(sine, cosine);
    pairs[i][!second] = y[i];
  }
  return count;
}

/* Case of (nearly) proportional coefficients of one angle: a combination of the rows contains the other angle only;
 * each of its solutions leaves one equation for the first angle. */
static int solve_separately(double e[2][5], bool second, double (*pairs)[2]) {
  const int p = second ? 2 : 0, r = second ? 0 : 2;
  double a = hypot(e[0][p], e[0][p + 1]), b = hypot(e[1][p], e[1][p + 1]), y[2], x[2];
  double size = hypot(a, b), with[2] = {1.0, 0.0}, without[2] = {0.0, 1.0};
  int count = 0;
  if (size > negligible) { /* common direction of both rows */
    double sign = e[0][p] * e[1][p] + e[0][p + 1] * e[1][p + 1] < 0.0 ? -1.0 : 1.0;
    with[0] = a / size;
    with[1] = sign * b / size;
    without[0] = -with[1];
    without[1] = with[0];
  }
  const double single[3] = {without[0] * e[0][r] + without[1] * e[1][r],
                            without[0] * e[0][r + 1] + without[1] * e[1][r + 1],
                            without[0] * e[0][4] + without[1] * e[1][4]};
  int found = km_solve_cos_sin(single, y);
  for (int i = 0; i < found; ++i) {
    double line[3];
    for (int k = 0; k < 2; ++k)
      line[k] = with[0] * e[0][p + k] + with[1] * e[1][p + k];
    line[2] = 0.0;
    for (int k = 0; k < 2; ++k)
      line[2] += with[k] * (e[k][r] * cos(y[i]) + e[k][r + 1] * sin(y[i]) + e[k][4]);
    for (int k = 0, group_count = km_solve_cos_sin(line, x); k < group_count; ++k, ++count) {
      pairs[count][second] = x[k];
      pairs[count][!second] = y[i];
    }
  }
  return count;
}

/* |determinant| of the coefficients of one angle over the product of the row norms. */
static double independence(double e[2][5], bool second) {
  const int p = second ? 2 : 0;
  double det = e[0][p] * e[1][p + 1] - e[0][p + 1] * e[1][p];
  double size = hypot(e[0][p], e[0][p + 1]) * hypot(e[1][p], e[1][p + 1]);
  return size > negligible * negligible ? fabs(det) / size : 0.0;
}

/* Normalises both rows and eliminates the angle with the better conditioned coefficients; nearly proportional
 * coefficients are also solved separately. */
int km_solve_cos_sin_pair(double e[2][5], double (*pairs)[2]) {
  static const double min_independence = 1e-5;
  for (int row = 0; row < 2; ++row) {
    double size = 0.0;
    for (int k = 0; k < 5; ++k)
      size = fmax(size, fabs(e[row][k]));
    if (!(size > negligible))
      return -1;
    for (int k = 0; k < 5; ++k)
      e[row][k] /= size;
  }
  double x = independence(e, false), y = independence(e, true);
  bool second = y > x;
  double most = fmax(x, y);
  int count = most > negligible ? eliminate(e, second, pairs) : 0;
  if (count < 0)
    return -1;
  if (most < min_independence) {
    count += solve_separately(e, false, pairs + count);
    count += solve_separately(e, true, pairs + count);
  }
  return count;
}
