/* Families with friction. */
#include "support/forces.h"
#include "support/planar.h"

#include "kmech/transfer.h"

#include <lapacke.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* All equations of balance: unknown are the reactions x[0 … n−2] and the load x[n−1] that a force of ±1 at the input
 * moves, with the share t of the friction. */
typedef struct system {
  const planar *p;
  const planar_balance *b;
  const double *rates;
  int input, output;
  double force;
} system_of;

/* The force that presses in joint j, and its gradient in the two columns of its reaction. */
static double pressing(const system_of *s, int j, const double *x, double gradient[2]) {
  const double *r = x + 2 * j;
  double size = s->p->joint[j].slides ? fabs(r[0]) : hypot(r[0], r[1]);
  gradient[0] = size > 0.0 ? r[0] / size : 0.0;
  gradient[1] = size > 0.0 && !s->p->joint[j].slides ? r[1] / size : 0.0;
  return size;
}

/* One Newton step at t; returns the largest residual before it. */
static double newton_step(const system_of *s, double t, double *x) {
  int n = s->b->rows, reactions = 2 * s->p->joints;
  double J[PLANAR_MOST_SIZE * PLANAR_MOST_SIZE], rhs[PLANAR_MOST_SIZE], worst = 0.0;
  const double *act = s->b->A + reactions * n;
  memcpy(J, s->b->A, sizeof *J * (size_t)(reactions * n));
  for (int k = 0; k < n; ++k) {
    J[reactions * n + k] = -act[s->output * n + k];
    rhs[k] = -s->force * act[s->input * n + k];
  }
  for (int i = 0; i <= reactions; ++i)
    for (int k = 0; k < n; ++k)
      rhs[k] -= J[i * n + k] * x[i];
  for (int j = 0; j < s->p->joints; ++j) {
    const planar_joint *joint = &s->p->joint[j];
    double gradient[2], size = pressing(s, j, x, gradient);
    double factor = -t * joint->coefficient * (joint->slides ? 1.0 : joint->radius) * (s->rates[j] < 0.0 ? -1.0 : 1.0);
    for (int k = 0; k < n; ++k) {
      rhs[k] -= factor * size * act[j * n + k];
      for (int i = 0; i < 2; ++i)
        J[(2 * j + i) * n + k] += factor * gradient[i] * act[j * n + k];
    }
  }
  for (int k = 0; k < n; ++k)
    worst = fmax(worst, fabs(rhs[k]));
  lapack_int pivots[PLANAR_MOST_SIZE];
  if (LAPACKE_dgesv(LAPACK_COL_MAJOR, n, 1, J, n, pivots, rhs, n))
    return (double)NAN;
  for (int k = 0; k < n; ++k)
    x[k] += rhs[k];
  return worst;
}

static double size_of(const double *x, int n) {
  double size = 0.0;
  for (int k = 0; k < n; ++k)
    size = fmax(size, fabs(x[k]));
  return size;
}

/* Continuation from no friction by many small steps. Returns the share reached; the load passes through 0 at *lock
 * (NaN: it doesn't). */
static double continue_to_all(const system_of *s, double *x, double *lock) {
  int n = s->b->rows;
  double t = 0.0, h = 1.0 / 32.0;
  *lock = (double)NAN;
  while (t < 1.0 && h > 1e-9 && size_of(x, n) < 1e9) {
    double y[PLANAR_MOST_SIZE], residual = HUGE_VAL, change = 0.0;
    h = fmin(h, 1.0 - t);
    memcpy(y, x, sizeof y);
    for (int i = 0; i < 12 && residual > 1e-12 * size_of(y, n); ++i)
      residual = newton_step(s, t + h, y);
    for (int k = 0; k < n; ++k)
      change = fmax(change, fabs(y[k] - x[k]));
    bool crosses = x[n - 1] > 0.0 && y[n - 1] <= 0.0;
    if (!(residual <= 1e-12 * size_of(y, n)) || change > 0.1 * size_of(x, n) || (crosses && h > 1e-8)) {
      h *= 0.5;
      continue;
    }
    if (crosses)
      *lock = t + h * x[n - 1] / (x[n - 1] - y[n - 1]);
    memcpy(x, y, sizeof y);
    t += h;
    h = fmin(2.0 * h, 1.0 / 32.0);
  }
  return t;
}

static bool near(double a, double b, double tolerance) {
  return fabs(a - b) <= tolerance;
}

static bool compare(const system_of *s, const km_losses *told, family_count *count) {
  int n = s->b->rows;
  double x[PLANAR_MOST_SIZE] = {0}, lock, ideal;
  newton_step(s, 0.0, x);
  ideal = x[n - 1];
  double all = continue_to_all(s, x, &lock), efficiency = x[n - 1] / ideal;
  bool moves = !told->locks && !told->why;
  count->moves += moves;
  count->locks += told->locks;
  count->open += told->why != NULL;
  if (all >= 1.0 && efficiency > 1e-9) /* by 1e-12 of the equations, whose condition may be 1e4 */
    return moves && near(told->efficiency, efficiency, 1e-7);
  bool lost = efficiency < -1e-9 || (all < 1.0 && efficiency <= 0.0);
  if (lost) /* zero of the load by linear interpolation over 1e-8; the load has a kink where forces pass through 0 */
    return told->locks && near(told->locks_from, lock, 1e-7);
  return all >= 1.0 || !told->locks; /* the limit; or the continuation fails: a lock isn't proved */
}

bool family_friction(uint64_t seed, family_count *count) {
  randomness r = {seed};
  planar p = planar_random(&r, 1, 1 + below(&r, 2), true);
  char *text = planar_text(&p);
  fixture f = fixture_read(text);
  km_free(text);
  planar_balance b;
  double rates[PLANAR_MOST_JOINTS];
  planar_balance_at(&p, &f, NULL, NULL, 0, &b);
  planar_rates(&p, &b, rates);
  system_of s = {&p, &b, rates, below(&r, p.joints), 0, 1.0};
  while ((s.output = below(&r, p.joints)) == s.input) {
  }
  bool right = true;
  /* Close to a dead centre of either port, rounding leaves nothing to compare. */
  if (fabs(rates[s.input]) > 1e-3 && fabs(rates[s.output]) > 1e-3 && km_model_has_friction(f.model)) {
    bool back = rates[s.output] < 0.0;
    for (int j = 0; j < p.joints; ++j)
      rates[j] = back ? -rates[j] : rates[j];
    s.force = rates[s.input] < 0.0 ? -1.0 : 1.0;
    km_port ends[2] = {{.kind = KM_PORT_JOINT, .coordinate = s.input, .name = "in"},
                       {.kind = KM_PORT_JOINT, .coordinate = s.output, .name = "out"}};
    km_losses_workspace *work = NULL;
    km_losses told;
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    right = km_losses_create(f.mechanism, &ends[0], &ends[1], &work, NULL) == KM_OK;
    if (right) {
      km_losses_compute(f.mechanism, f.state, work, &told);
      right = compare(&s, &told, count);
      if (!right)
        print_error("friction, seed %llu: efficiency %g, locks %d from %g, %s\n", (unsigned long long)seed,
                    told.efficiency, told.locks, told.locks_from, told.why ? told.why : "");
    }
    km_losses_free(work);
  }
  fixture_close(&f);
  return right;
}

/* A wedge slides along x and lifts a block along y on a plane of angle a. */
bool family_wedge(uint64_t seed, family_count *count) {
  randomness r = {seed};
  double a = uniform(&r, 0.1, 1.45), tangent = tan(a), edge = 1.0 / tangent, mu[3] = {0.0, 0.0, 0.0};
  mu[2] = edge * (below(&r, 2) ? uniform(&r, 0.9, 1.1) : uniform(&r, 0.0, 2.0));
  for (int k = 0; k < 2 && below(&r, 2); ++k)
    mu[k] = uniform(&r, 0.0, 0.6);
  char text[3000];
  snprintf(
      text, sizeof text,
      "{\"fixed\": {\"frames\": []}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"wedge\", \"frames\": "
      "[{\"name\": \"plane\", \"T\": [0, 0, 0], \"R\": [[%.17g, %.17g, 0], [%.17g, %.17g, 0], [0, 0, 1]]}]}, "
      "{\"name\": \"block\", \"frames\": [{\"name\": \"plane\", \"T\": [0, 0, 0], \"R\": [[%.17g, %.17g, 0], [%.17g, "
      "%.17g, 0], [0, 0, 1]]}]}], \"joints\": ["
      "{\"name\": \"W\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"wedge\"], \"friction\": "
      "{\"coefficient\": %.17g}},"
      "{\"name\": \"B\", \"type\": \"Ty\", \"body_frame_pairs\": [\"fixed\", \"block\"], \"friction\": "
      "{\"coefficient\": %.17g}},"
      "{\"name\": \"P\", \"type\": \"Tx\", \"body_frame_pairs\": [[\"wedge\", \"plane\"], [\"block\", \"plane\"]], "
      "\"friction\": {\"coefficient\": %.17g}}]}]}",
      cos(a), -sin(a), sin(a), cos(a), cos(a), -sin(a), sin(a), cos(a), mu[0], mu[1], mu[2]);
  fixture f = fixture_read(text);
  km_port in = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "W"},
          out = {.kind = KM_PORT_JOINT, .coordinate = 1, .name = "B"};
  km_losses_workspace *work = NULL;
  km_losses told;
  km_mobility mobility;
  km_mobility_compute(f.mechanism, f.state, &mobility);
  bool right = km_losses_create(f.mechanism, &in, &out, &work, NULL) == KM_OK;
  if (right) {
    km_losses_compute(f.mechanism, f.state, work, &told);
    /* Friction for a normal force of 1 on the plane. */
    double up = cos(a) - mu[2] * sin(a), aside = sin(a) + mu[2] * cos(a);
    double efficiency = tangent * (up - mu[1] * aside) / (aside + mu[0] * fabs(up));
    double reach = fabs(efficiency) < 1e-9 ? told.efficiency : efficiency;
    right = !told.why && told.locks == (reach <= 0.0) && near(told.efficiency, fmax(reach, 0.0), 1e-9);
    if (right && told.locks) { /* all coefficients times t: (1 − t² μ₁ μ₂) = t (μ₁ + μ₂) tan a */
      double both = mu[1] * mu[2], sum = (mu[1] + mu[2]) * tangent;
      right = near(1.0 - told.locks_from * told.locks_from * both, told.locks_from * sum, 1e-9);
    }
    count->locks += told.locks;
    count->moves += !told.locks;
    if (!right)
      print_error("wedge, seed %llu: efficiency %g, locks %d from %g; expected %g\n", (unsigned long long)seed,
                  told.efficiency, told.locks, told.locks_from, efficiency);
  }
  km_losses_free(work);
  fixture_close(&f);
  return right;
}
