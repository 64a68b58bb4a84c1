/* Two equations that are linear in the cosines and sines of two angles. */
#include "arm/ik/trigonometric_equations.h"

#include <complex.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

static const double nothing = 1e-12;

int km_solve_line(const double line[3], double x[2]) {
  double size = hypot(line[0], line[1]), middle = atan2(line[1], line[0]);
  if (!(size > nothing) || fabs(line[2]) > 1.5 * size)
    return 0;
  double cosine = -line[2] / size, half = acos(fmin(fmax(cosine, -1.0), 1.0));
  x[0] = middle + half;
  x[1] = middle - half;
  return half == 0.0 || fabs(cosine) >= 1.0 ? 1 : 2;
}

/* CMPLX, which clang has only with newer headers. */
static double complex make(double real, double imaginary) {
  const double parts[2] = {real, imaginary};
  double complex z;
  memcpy(&z, parts, sizeof z);
  return z;
}

/* Roots of the polynomial c[0] + … + c[degree] z^degree, all at once (Durand and Kerner). */
static void find_roots(const double complex *c, int degree, double complex *z) {
  enum { MOST_STEPS = 500 };
  for (int i = 0; i < degree; ++i)
    z[i] = cexp(make(0.0, 0.4 + 2.0 * M_PI * i / degree));
  for (int step = 0; step < MOST_STEPS; ++step) {
    double moved = 0.0;
    for (int i = 0; i < degree; ++i) {
      double complex value = c[degree], apart = c[degree];
      for (int k = degree - 1; k >= 0; --k)
        value = value * z[i] + c[k];
      for (int k = 0; k < degree; ++k)
        apart *= k == i ? 1.0 : z[i] - z[k];
      double complex move = cabs(apart) > 0.0 ? value / apart : make(1e-8, 0.0);
      z[i] -= move;
      moved = fmax(moved, cabs(move) / (1.0 + cabs(z[i])));
    }
    if (moved < 1e-15)
      return;
  }
}

/* f[0] + f[1] cos y + f[2] sin y + f[3] cos² y + f[4] cos y sin y + f[5] sin² y = 0, by z = exp(iy): a real root lies
 * on the unit circle, two that are nearly one lie beside it. −1: every angle does. */
static int solve_quadratic(const double f[6], double y[4]) {
  double complex c[5], z[4];
  c[4] = make(0.25 * (f[3] - f[5]), -0.25 * f[4]);
  c[3] = make(0.5 * f[1], -0.5 * f[2]);
  c[2] = f[0] + 0.5 * (f[3] + f[5]);
  c[1] = conj(c[3]);
  c[0] = conj(c[4]);
  double size = cabs(c[4]) + cabs(c[3]) + fabs(creal(c[2])), terms = 0.0;
  int first = 0, degree = 4, count = 0;
  for (int k = 0; k < 6; ++k)
    terms += fabs(f[k]);
  if (!(size > 1e-10 * terms))
    return -1;
  if (!(cabs(c[4]) + cabs(c[3]) > nothing * size))
    return 0;
  if (!(cabs(c[4]) > nothing * size)) {
    first = 1;
    degree = 2;
  }
  find_roots(c + first, degree, z);
  for (int i = 0; i < degree; ++i)
    if (fabs(cabs(z[i]) - 1.0) < 0.2)
      y[count++] = carg(z[i]);
  return count;
}

/* With the columns of x eliminated: cos x and sin x are linear in cos y and sin y, and their squares add up to 1. */
static int eliminate(double e[2][5], bool second, double (*pairs)[2]) {
  const int p = second ? 2 : 0, r = second ? 0 : 2;
  double det = e[0][p] * e[1][p + 1] - e[0][p + 1] * e[1][p], x[2][3], f[6] = {-1.0}, y[4];
  for (int k = 0; k < 3; ++k) { /* of 1, cos y, sin y */
    double g0 = k ? e[0][r + k - 1] : e[0][4], g1 = k ? e[1][r + k - 1] : e[1][4];
    x[0][k] = (-g0 * e[1][p + 1] + g1 * e[0][p + 1]) / det;
    x[1][k] = (-g1 * e[0][p] + g0 * e[1][p]) / det;
  }
  for (int i = 0; i < 2; ++i) {
    f[0] += x[i][0] * x[i][0];
    f[1] += 2.0 * x[i][0] * x[i][1];
    f[2] += 2.0 * x[i][0] * x[i][2];
    f[3] += x[i][1] * x[i][1];
    f[4] += 2.0 * x[i][1] * x[i][2];
    f[5] += x[i][2] * x[i][2];
  }
  int count = solve_quadratic(f, y);
  for (int i = 0; i < count; ++i) {
    double cosine = x[0][0] + x[0][1] * cos(y[i]) + x[0][2] * sin(y[i]);
    double sine = x[1][0] + x[1][1] * cos(y[i]) + x[1][2] * sin(y[i]);
    pairs[i][second] = atan2(sine, cosine);
    pairs[i][!second] = y[i];
  }
  return count;
}

/* The part of the equations in x, or that in y, has (nearly) one row: without it an equation in the other angle alone
 * is left, and then a line for each of its solutions. */
static int one_by_one(double e[2][5], bool second, double (*pairs)[2]) {
  const int p = second ? 2 : 0, r = second ? 0 : 2;
  double a = hypot(e[0][p], e[0][p + 1]), b = hypot(e[1][p], e[1][p + 1]), y[2], x[2];
  double size = hypot(a, b), with[2] = {1.0, 0.0}, without[2] = {0.0, 1.0};
  int count = 0;
  if (size > nothing) { /* the rows' own direction, signed alike */
    double sign = e[0][p] * e[1][p] + e[0][p + 1] * e[1][p + 1] < 0.0 ? -1.0 : 1.0;
    with[0] = a / size;
    with[1] = sign * b / size;
    without[0] = -with[1];
    without[1] = with[0];
  }
  const double alone[3] = {without[0] * e[0][r] + without[1] * e[1][r],
                           without[0] * e[0][r + 1] + without[1] * e[1][r + 1],
                           without[0] * e[0][4] + without[1] * e[1][4]};
  int found = km_solve_line(alone, y);
  for (int i = 0; i < found; ++i) {
    double line[3];
    for (int k = 0; k < 2; ++k)
      line[k] = with[0] * e[0][p + k] + with[1] * e[1][p + k];
    line[2] = 0.0;
    for (int k = 0; k < 2; ++k)
      line[2] += with[k] * (e[k][r] * cos(y[i]) + e[k][r + 1] * sin(y[i]) + e[k][4]);
    for (int k = 0, ways = km_solve_line(line, x); k < ways; ++k, ++count) {
      pairs[count][second] = x[k];
      pairs[count][!second] = y[i];
    }
  }
  return count;
}

/* Size of the determinant of the columns of x (or y), over that of their entries. */
static double independence(double e[2][5], bool second) {
  const int p = second ? 2 : 0;
  double det = e[0][p] * e[1][p + 1] - e[0][p + 1] * e[1][p];
  double size = hypot(e[0][p], e[0][p + 1]) * hypot(e[1][p], e[1][p + 1]);
  return size > nothing * nothing ? fabs(det) / size : 0.0;
}

int km_solve_pair(double e[2][5], double (*pairs)[2]) {
  static const double doubtful = 1e-5;
  for (int row = 0; row < 2; ++row) {
    double size = 0.0;
    for (int k = 0; k < 5; ++k)
      size = fmax(size, fabs(e[row][k]));
    if (!(size > nothing))
      return -1;
    for (int k = 0; k < 5; ++k)
      e[row][k] /= size;
  }
  double x = independence(e, false), y = independence(e, true);
  bool second = y > x;
  double most = fmax(x, y);
  int count = most > nothing ? eliminate(e, second, pairs) : 0;
  if (count < 0)
    return -1;
  if (most < doubtful) {
    count += one_by_one(e, false, pairs + count);
    count += one_by_one(e, true, pairs + count);
  }
  return count;
}
