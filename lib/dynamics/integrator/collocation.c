/* One step of Gauss collocation with six stages: order 12 (E. Hairer and G. Wanner 1996, IV.5; docs/theory.md
 * 11.5).
 *
 *   y'(t + θ h) = Σ k_i ℓ_i(θ),  k_i = f(y(t + c_i h)),  ℓ_i Lagrange polynomials of the nodes c_i
 *   stages by fixed-point iteration;   y(t + h) = y + h Σ b_i k_i
 *
 * Its evaluations lie before and after a configuration where constraints are weak, so the step passes over it. */
#include "dynamics/simulation.h"

#include <math.h>
#include <string.h>

/* Weights b_i of the Gauss quadrature. Truncation estimate: the Legendre coefficients of f over the step, c_j = (2j
 * + 1) Σ b_i P_j(2 c_i − 1) k_i, decay like r^j if the step resolves the motion; the quadrature error begins with
 * c_12 (L. N. Trefethen, Approximation Theory and Approximation Practice, chapter 8). */
static const double weight_of_node[KM_STAGES] = {0.085662246189585172, 0.18038078652406930, 0.23395696728634552,
                                                 0.23395696728634552,  0.18038078652406930, 0.085662246189585172};

/* Nodes c_i: roots of the Legendre polynomial of degree 6 on [0, 1]. */
static const double node[KM_STAGES] = {0.033765242898423975, 0.16939530676686776, 0.38069040695840156,
                                       0.61930959304159849,  0.83060469323313224, 0.96623475710157603};
enum { MAX_ROUNDS = 30 };
/* The fixed-point iteration ends when the stages change by less than this part of the error allowed, or stagnate. */
static const double settled_acceleration = 1e-2;

/* Integrals of the Lagrange polynomials: ∫ ℓ_i from 0 to θ. */
static void integrals(double theta, double out[KM_STAGES]) {
  for (int i = 0; i < KM_STAGES; ++i) {
    double p[KM_STAGES + 1] = {1.0}; /* coefficients of ℓ_i, lowest power first */
    int degree = 0;
    for (int j = 0; j < KM_STAGES; ++j) {
      if (j == i)
        continue;
      double scale = 1.0 / (node[i] - node[j]);
      ++degree;
      for (int k = degree; k >= 0; --k)
        p[k] = scale * ((k > 0 ? p[k - 1] : 0.0) - node[j] * p[k]);
    }
    out[i] = 0.0;
    for (int k = degree; k >= 0; --k)
      out[i] = theta * (out[i] + p[k] / (k + 1));
  }
}

/* out = y + h Σ weight_i k_i. */
static void combine(const double *stage, size_t n, const double *y, double h, const double weight[KM_STAGES],
                    double *out) {
  for (size_t c = 0; c < n; ++c) {
    double sum = 0.0;
    for (int i = 0; i < KM_STAGES; ++i)
      sum += weight[i] * stage[(size_t)i * n + c];
    out[c] = y[c] + h * sum;
  }
}

/* Stores an evaluated stage; returns its largest change over the error allowed. */
static double store_stage(const km_simulation *run, double *stage, const double *evaluated, double h) {
  double largest = 0.0;
  for (int c = 0; c < run->size; ++c) {
    largest = fmax(largest, fabs(h * (evaluated[c] - stage[c])) / run->tolerance[c]);
    stage[c] = evaluated[c];
  }
  return largest;
}

/* Truncation error of a step over the error allowed: c_0 r^10 with r the larger of (c_4/c_0)^(1/4) and
 * (c_5/c_0)^(1/5). Both are needed, because a motion symmetric about the middle of the step has no odd coefficients. */
static double truncation(const km_simulation *run, double h) {
  size_t n = (size_t)run->size;
  double p4[KM_STAGES], p5[KM_STAGES], first = 0.0, fourth = 0.0, fifth = 0.0;
  for (int i = 0; i < KM_STAGES; ++i) {
    double x = 2.0 * node[i] - 1.0, x2 = x * x;
    p4[i] = 9.0 * weight_of_node[i] * (3.0 + x2 * (35.0 * x2 - 30.0)) / 8.0;
    p5[i] = 11.0 * weight_of_node[i] * x * (15.0 + x2 * (63.0 * x2 - 70.0)) / 8.0;
  }
  for (size_t c = 0; c < n; ++c) {
    double c0 = 0.0, c4 = 0.0, c5 = 0.0, allowed = run->tolerance[c] / h;
    for (int i = 0; i < KM_STAGES; ++i) {
      double k = run->stage[(size_t)i * n + c];
      c0 += weight_of_node[i] * fabs(k);
      c4 += p4[i] * k;
      c5 += p5[i] * k;
    }
    first = fmax(first, c0 / allowed);
    fourth = fmax(fourth, fabs(c4) / allowed);
    fifth = fmax(fifth, fabs(c5) / allowed);
  }
  return first > 0.0 ? first * fmax(pow(fourth / first, 2.5), pow(fifth / first, 2.0)) : 0.0;
}

/* Fixed-point iteration of the stages; returns the noise of the stages and the truncation error. */
bool km_collocation_try(km_simulation *run, double h, double *noise, double *after) {
  size_t n = (size_t)run->size;
  double weight[KM_STAGES][KM_STAGES], *at = run->stage + KM_STAGES * n, *slope = at + n;
  for (int i = 0; i < KM_STAGES; ++i)
    integrals(node[i], weight[i]);
  if (!km_simulation_derivative(run, run->time, run->y, slope))
    return false;
  for (int i = 0; i < KM_STAGES; ++i)
    memcpy(run->stage + (size_t)i * n, slope, n * sizeof *slope);
  double change = HUGE_VAL, last = HUGE_VAL;
  *noise = *after = 0.0;
  for (int round = 0; change > settled_acceleration && !(round > 6 && change > 0.3 * last); ++round) {
    last = change;
    change = 0.0;
    if (round == MAX_ROUNDS)
      return false;
    *noise = 0.0;
    for (int i = 0; i < KM_STAGES; ++i) {
      combine(run->stage, n, run->y, h, weight[i], at);
      if (!km_simulation_derivative(run, run->time + node[i] * h, at, slope))
        return false;
      *after = km_simulation_noise(run, run->typical_step);
      *noise = fmax(*noise, *after);
      change = fmax(change, store_stage(run, run->stage + (size_t)i * n, slope, h));
    }
  }
  *noise = fmax(fmax(*noise, truncation(run, h)), change - settled_acceleration);
  return true;
}

void km_collocation_keep(km_simulation *run) {
  memcpy(run->kept_stages, run->stage, KM_STAGES * (size_t)run->size * sizeof *run->kept_stages);
}

/* Advances by the stored stages and closes the loops at the end. */
bool km_collocation_step(km_simulation *run, double h) {
  size_t n = (size_t)run->size;
  double weight[KM_STAGES];
  integrals(1.0, weight);
  memcpy(run->before, run->y, n * sizeof *run->y);
  combine(run->kept_stages, n, run->before, h, weight, run->y);
  if (!km_simulation_accept(run, run->y, run->time + h, true)) {
    memcpy(run->y, run->before, n * sizeof *run->y);
    return false;
  }
  run->time += h;
  run->steps++;
  run->step_method = KM_STEP_COLLOCATION;
  run->order = 2 * KM_STAGES;
  return true;
}

void km_collocation_interpolate(const km_simulation *run, double time, double *y) {
  double weight[KM_STAGES], h = run->time - run->last_time;
  integrals((time - run->last_time) / h, weight);
  combine(run->kept_stages, (size_t)run->size, run->before, h, weight, y);
}
