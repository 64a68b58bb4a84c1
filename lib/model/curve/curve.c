/* Values of curves with two derivatives.
 *
 *   piece     : f = Σ c_k u^k + step · s(z) + speed · length · S(z),   u = x − start, z = u/length, S = ∫s dz
 *   cycloidal : s = z − sin(2πz)/(2π),                                max s' = 2,     max |s''| = 2π
 *   3-4-5     : s = 10 z³ − 15 z⁴ + 6 z⁵,                             max s' = 1.875, max |s''| = 10/√3 = 5.774
 *   modified trapezoid, z ≤ 1/2, A = 8π/(2 + π) = max |s''| = 4.888, max s' = 2:
 *               s'' = A sin 4πz to 1/8, A to 3/8, A cos 4π(z − 3/8) to 1/2;   s(z) = 1 − s(1 − z) beyond
 *
 * Source: Shigley and Uicker, Theory of Machines and Mechanisms, chapter on cams; Norton, Cam Design and Manufacturing
 * Handbook. */
#include "model/curve/curve.h"

#include <math.h>
#include <string.h>

static const char *const rise_words[KM_RISES] = {"cycloidal", "3-4-5", "modified-trapezoid"};

const char *km_rise_word(km_rise rise) {
  return rise_words[rise];
}

int km_rise_find(const char *word) {
  for (int r = 0; r < KM_RISES; ++r)
    if (strcmp(word, rise_words[r]) == 0)
      return r;
  return -1;
}

static void cycloidal_at(double z, double out[4]) {
  const double w = 2.0 * M_PI;
  out[0] = 0.5 * z * z + (cos(w * z) - 1.0) / (w * w);
  out[1] = z - sin(w * z) / w;
  out[2] = 1.0 - cos(w * z);
  out[3] = w * sin(w * z);
}

static void polynomial_345_at(double z, double out[4]) {
  double z2 = z * z, z3 = z2 * z;
  out[0] = z2 * z2 * (2.5 - 3.0 * z + z2);
  out[1] = z3 * (10.0 - 15.0 * z + 6.0 * z2);
  out[2] = 30.0 * z2 * (1.0 - z) * (1.0 - z);
  out[3] = 60.0 * z * (1.0 - z) * (1.0 - 2.0 * z);
}

/* First half of the modified trapezoid; `to` is the part that is integrated, part by part. */
static void half_trapezoid_at(double z, double out[4]) {
  const double A = 8.0 * M_PI / (2.0 + M_PI), w = 4.0 * M_PI;
  double u = fmin(z, 0.125);
  out[3] = A * sin(w * u);
  out[2] = A / w * (1.0 - cos(w * u));
  out[1] = A / w * (u - sin(w * u) / w);
  out[0] = A / w * (0.5 * u * u + (cos(w * u) - 1.0) / (w * w));
  if (z <= 0.125)
    return;
  u = fmin(z, 0.375) - 0.125;
  double s = out[1], v = out[2];
  out[3] = A;
  out[2] = v + A * u;
  out[1] = s + u * (v + 0.5 * A * u);
  out[0] += u * (s + u * (0.5 * v + A * u / 6.0));
  if (z <= 0.375)
    return;
  u = z - 0.375;
  s = out[1];
  v = out[2];
  out[3] = A * cos(w * u);
  out[2] = v + A / w * sin(w * u);
  out[1] = s + v * u + A / (w * w) * (1.0 - cos(w * u));
  out[0] += u * (s + 0.5 * v * u) + A / (w * w) * (u - sin(w * u) / w);
}

/* s(z) = 1 − s(1 − z), so S(z) = z − 1/2 + S(1 − z) with S(1) = 1/2. */
static void trapezoid_at(double z, double out[4]) {
  half_trapezoid_at(z <= 0.5 ? z : 1.0 - z, out);
  if (z <= 0.5)
    return;
  out[0] += z - 0.5;
  out[1] = 1.0 - out[1];
  out[3] = -out[3];
}

void km_rise_at(km_rise rise, double z, double out[4]) {
  if (rise == KM_RISE_CYCLOIDAL)
    cycloidal_at(z, out);
  else if (rise == KM_RISE_345)
    polynomial_345_at(z, out);
  else
    trapezoid_at(z, out);
}

/* Horner's scheme for Σ c_k u^k and two derivatives. */
static void polynomial_at(const double *c, int count, double u, double out[3]) {
  double half = 0.0;
  out[0] = out[1] = 0.0;
  for (int k = count - 1; k >= 0; --k) {
    half = half * u + out[1];
    out[1] = out[1] * u + out[0];
    out[0] = out[0] * u + c[k];
  }
  out[2] = 2.0 * half;
}

static void piece_at(const km_curve_piece *p, double u, double out[3]) {
  polynomial_at(p->c, 4, u, out);
  if (p->step == 0.0 && p->speed == 0.0)
    return;
  double s[4], L = p->length;
  km_rise_at(p->rise, u / L, s);
  out[0] += p->step * s[1] + p->speed * L * s[0];
  out[1] += p->step / L * s[2] + p->speed * s[1];
  out[2] += p->step / (L * L) * s[3] + p->speed / L * s[2];
}

/* Last piece that starts at or below x, or the first one. */
static int piece_of(const km_law_curve *f, double x) {
  int low = 0, high = f->count;
  while (high - low > 1) {
    int middle = low + (high - low) / 2;
    if (f->pieces[middle].start <= x)
      low = middle;
    else
      high = middle;
  }
  return low;
}

/* Constant outside the pieces. */
static void pieces_at(const km_law_curve *f, double x, double out[3]) {
  double turns = 0.0;
  if (f->period > 0.0) {
    turns = floor((x - f->pieces[0].start) / f->period);
    x -= turns * f->period;
  }
  const km_curve_piece *p = &f->pieces[piece_of(f, x)];
  double u = x - p->start, inside = fmin(fmax(u, 0.0), p->length);
  piece_at(p, inside, out);
  out[0] += turns * f->gain;
  if (u != inside)
    out[1] = out[2] = 0.0;
}

void km_curve_at(const km_law_curve *f, double x, double out[3]) {
  out[0] = out[1] = out[2] = 0.0;
  if (f->form == KM_CURVE_POLYNOMIAL) {
    polynomial_at(f->numbers, f->count, x, out);
  } else if (f->form == KM_CURVE_SINE) {
    const double *c = f->numbers;
    double angle = c[2] * x + c[3];
    out[0] = c[0] + c[1] * sin(angle);
    out[1] = c[1] * c[2] * cos(angle);
    out[2] = -c[1] * c[2] * c[2] * sin(angle);
  } else if (f->form == KM_CURVE_PIECES) {
    pieces_at(f, x, out);
  } else if (f->form == KM_CURVE_EXPRESSION) {
    km_expression_at(f->expression, x, out);
  }
}

double km_curve_value(const km_law_curve *f, double x) {
  double out[3];
  km_curve_at(f, x, out);
  return out[0];
}
