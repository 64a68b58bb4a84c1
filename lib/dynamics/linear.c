/* Linearised equations of motion by differences, and their eigenvalues. */
#include "kmech/linear.h"

#include "base/check.h"
#include "dynamics/linear.h"
#include "partition/eigen.h"

#include <string.h>

static const double step = 1e-5;
static const double difference_error = 1e-9; /* of the accelerations, in their differences */
static const double alike = 1e-6;            /* sizes of eigenvalues that only rounding tells apart */
static const double rounding = 1e-5; /* of the largest eigenvalue: what the differences leave of an eigenvalue 0 */
static const double rest = 1e-6;     /* the largest acceleration of a pose at rest, scaled, over s² */

bool km_poise_take(const km_dynamics *d, const km_state *s, km_poise *out) {
  const km_mechanism *m = d->mechanism;
  size_t n = (size_t)m->coordinate_count;
  int count = 0;
  *out = (km_poise){0};
  out->q = KM_ARENA_NEW(&out->arena, double, n);
  out->rate = KM_ARENA_NEW(&out->arena, double, n);
  out->ball = KM_ARENA_NEW(&out->arena, km_quaternion, (size_t)m->ball_count);
  out->independent = KM_ARENA_NEW(&out->arena, int, n);
  out->acceleration = KM_ARENA_NEW(&out->arena, double, n);
  if (out->arena.failed)
    return false;
  memcpy(out->q, s->q, n * sizeof *s->q);
  memcpy(out->rate, s->rate, n * sizeof *s->rate);
  memcpy(out->ball, s->ball, (size_t)m->ball_count * sizeof *s->ball);
  for (int i = 0; i < d->tree.cluster_count; ++i)
    for (int k = 0; k < d->cluster[i].freedom; ++k)
      out->independent[count++] =
          d->tree.coordinate_order[d->tree.clusters[i].coordinate_start + d->cluster[i].independent[k]];
  out->freedom = count;
  return true;
}

void km_poise_free(km_poise *poise) {
  km_arena_free(&poise->arena);
}

void km_poise_restore(const km_poise *poise, const km_mechanism *m, km_state *s) {
  memcpy(s->q, poise->q, (size_t)m->coordinate_count * sizeof *s->q);
  memcpy(s->rate, poise->rate, (size_t)m->coordinate_count * sizeof *s->rate);
  memcpy(s->ball, poise->ball, (size_t)m->ball_count * sizeof *s->ball);
}

void km_nudge(const km_mechanism *m, km_state *s, int c, double by) {
  int ball = m->ball_of[c];
  if (ball < 0) {
    s->q[c] += by;
    return;
  }
  double turn[3] = {0.0, 0.0, 0.0};
  turn[c - m->ball_coordinate[ball]] = by;
  km_state_turn_ball(m, s, ball, km_vec3_make(turn));
}

/* Accelerations of the independent coordinates at the state; false where an evaluation fails. */
static bool accelerations(km_dynamics *d, km_state *s, const km_poise *p, double *out) {
  if (km_dynamics_evaluate(d, s, false) != KM_DYNAMICS_DONE)
    return false;
  for (int i = 0; i < p->freedom; ++i)
    out[i] = s->acceleration[p->independent[i]];
  return true;
}

typedef enum change { OF_POSE, OF_RATE, OF_FORCE } change;

/* Adds to a coordinate's value, rate or force. */
static void shift(km_dynamics *d, km_state *s, const km_poise *p, change what, int c, double by) {
  km_poise_restore(p, d->mechanism, s);
  if (what == OF_POSE)
    km_nudge(d->mechanism, s, c, by);
  else if (what == OF_RATE)
    s->rate[c] += by;
  else
    d->forces->extra[c] += by;
}

/* Central differences of the accelerations. work[2 freedom]. */
static bool derivative(km_dynamics *d, km_state *s, const km_poise *p, change what, int c, double by, double *work,
                       double *out) {
  bool good = true;
  for (int side = 0; side < 2 && good; ++side) {
    shift(d, s, p, what, c, side ? -by : by);
    good = accelerations(d, s, p, work + side * p->freedom);
    if (what == OF_FORCE)
      d->forces->extra[c] -= side ? -by : by;
  }
  for (int i = 0; i < p->freedom && good; ++i)
    out[i] = (work[i] - work[p->freedom + i]) / (2.0 * by);
  km_poise_restore(p, d->mechanism, s);
  return good;
}

bool km_stiffness_of_accelerations(km_dynamics *d, km_state *s, const km_poise *p, double *work, double *K) {
  for (int k = 0; k < p->freedom; ++k)
    if (!derivative(d, s, p, OF_POSE, p->independent[k], step / d->mechanism->scale[p->independent[k]], work,
                    K + (size_t)k * (size_t)p->freedom))
      return false;
  return true;
}

static bool allocate(km_linear *out, int freedom, int coordinates) {
  size_t f = (size_t)freedom, n = (size_t)coordinates;
  out->freedom = freedom;
  out->coordinate_count = coordinates;
  out->independent = KM_NEW(int, f + 1);
  out->A = KM_NEW(double, 4 * f * f + 1);
  out->B = KM_NEW(double, 2 * f * n + 1);
  out->N = KM_NEW(double, n *f + 1);
  out->real = KM_NEW(double, 2 * f + 1);
  out->imaginary = KM_NEW(double, 2 * f + 1);
  out->modes = KM_NEW(double, 4 * f * n + 1);
  return out->independent && out->A && out->B && out->N && out->real && out->imaginary && out->modes;
}

/* N of all clusters, into rows of coordinates. */
static void take_N(const km_dynamics *d, const km_poise *p, km_linear *out) {
  int column = 0;
  for (int i = 0; i < d->tree.cluster_count; ++i) {
    const km_cluster *cluster = &d->tree.clusters[i];
    const km_cluster_motion *c = &d->cluster[i];
    for (int k = 0; k < c->freedom; ++k, ++column)
      for (int o = 0; o < cluster->coordinate_count; ++o)
        out->N[(size_t)column * (size_t)out->coordinate_count +
               (size_t)d->tree.coordinate_order[cluster->coordinate_start + o]] =
            c->N[(size_t)k * (size_t)cluster->coordinate_count + (size_t)o];
  }
  memcpy(out->independent, p->independent, (size_t)p->freedom * sizeof *out->independent);
}

/* A by the independent coordinates and their rates, B by the forces: the equations are linear in these. */
static bool fill(km_dynamics *d, km_state *s, const km_poise *p, double *work, km_linear *out) {
  const km_mechanism *m = d->mechanism;
  size_t f = (size_t)p->freedom, rows = 2 * f;
  double second = m->model->units.time->si;
  bool good = true;
  for (size_t k = 0; k < f && good; ++k) {
    int c = p->independent[k];
    double by = step / m->scale[c];
    out->A[(f + k) * rows + k] = 1.0;
    good = derivative(d, s, p, OF_POSE, c, by, work, out->A + k * rows + f) &&
           derivative(d, s, p, OF_RATE, c, by * second, work, out->A + (f + k) * rows + f);
  }
  for (int c = 0; c < m->coordinate_count && good; ++c)
    if (!m->held[c])
      good = derivative(d, s, p, OF_FORCE, c, 1.0, work, out->B + (size_t)c * rows + f);
  return good;
}

/* An eigenvector of A: its imaginary part is `sign` times a column, or 0. */
typedef struct eigenvector {
  const double *real, *imaginary; /* imaginary NULL: 0 */
  double sign;
} eigenvector;

/* Real and imaginary parts of the coordinates in an eigenvector, the largest scaled one of length 1. */
static void keep_mode(const km_mechanism *m, const km_linear *l, eigenvector v, double *out) {
  int n = l->coordinate_count;
  double largest = 0.0;
  for (int c = 0; c < n; ++c) {
    double re = 0.0, im = 0.0;
    for (int k = 0; k < l->freedom; ++k) {
      double N = l->N[(size_t)k * (size_t)n + (size_t)c];
      re += N * v.real[k];
      im += v.imaginary ? N * v.sign * v.imaginary[k] : 0.0;
    }
    out[c] = re;
    out[n + c] = im;
    largest = fmax(largest, m->scale[c] * hypot(re, im));
  }
  for (int c = 0; c < 2 * n && largest > 0.0; ++c)
    out[c] /= largest;
}

/* What LAPACK gives of A. */
typedef struct eigensystem {
  double *A, *real, *imaginary, *vectors;
  int *order; /* by size */
} eigensystem;

static eigenvector vector_of(const eigensystem *e, size_t size, size_t k) {
  if (e->imaginary[k] == 0.0)
    return (eigenvector){e->vectors + k * size, NULL, 0.0};
  size_t first = e->imaginary[k] > 0.0 ? k : k - 1;
  return (eigenvector){e->vectors + first * size, e->vectors + (first + 1) * size, e->imaginary[k] > 0.0 ? 1.0 : -1.0};
}

/* By size; of those that only rounding tells apart, what grows first. */
static bool precedes(const eigensystem *e, int a, int b) {
  double size[] = {hypot(e->real[a], e->imaginary[a]), hypot(e->real[b], e->imaginary[b])};
  double close = alike * fmax(size[0], size[1]);
  return fabs(size[0] - size[1]) > close ? size[0] < size[1] : e->real[a] > e->real[b] + close;
}

/* Stable, so that pairs stay together. */
static void sort(const eigensystem *e, int size) {
  for (int k = 0; k < size; ++k) {
    int at = k;
    for (; at > 0 && precedes(e, k, e->order[at - 1]); --at)
      e->order[at] = e->order[at - 1];
    e->order[at] = k;
  }
}

static km_status find_modes(const km_mechanism *m, km_linear *l, km_error *error) {
  size_t size = 2 * (size_t)l->freedom;
  if (size == 0)
    return KM_OK;
  km_arena arena = {0};
  eigensystem e = {.A = KM_ARENA_NEW(&arena, double, size *size),
                   .real = KM_ARENA_NEW(&arena, double, size),
                   .imaginary = KM_ARENA_NEW(&arena, double, size),
                   .vectors = KM_ARENA_NEW(&arena, double, size *size),
                   .order = KM_ARENA_NEW(&arena, int, size)};
  km_status status = KM_OK;
  if (arena.failed) {
    status = km_fail(error, KM_MEMORY, "out of memory for the linearised equations");
  } else {
    memcpy(e.A, l->A, size * size * sizeof *e.A);
    status = km_eigen((int)size, e.A, e.real, e.imaginary, e.vectors, error);
  }
  if (!status)
    sort(&e, (int)size);
  for (size_t k = 0; k < size && !status; ++k) {
    size_t from = (size_t)e.order[k];
    l->real[k] = e.real[from];
    l->imaginary[k] = e.imaginary[from];
    keep_mode(m, l, vector_of(&e, size, from), l->modes + k * 2 * (size_t)l->coordinate_count);
  }
  km_arena_free(&arena);
  return status;
}

km_status km_linearise(km_dynamics *d, km_state *s, km_linear *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_linear){0};
  km_status status = km_dynamics_project_rates(d, s, NULL, error);
  if (!status)
    status = km_dynamics_accelerate(d, s, error);
  if (status)
    return status;
  km_poise poise = {0};
  bool memory = km_poise_take(d, s, &poise);
  double *work = KM_NEW(double, 2 * (size_t)poise.freedom + 1);
  memory = memory && work && allocate(out, poise.freedom, d->mechanism->coordinate_count);
  double second = d->mechanism->model->units.time->si;
  bool good = memory;
  if (good) {
    for (int k = 0; k < poise.freedom; ++k) {
      int c = poise.independent[k];
      out->residual = fmax(out->residual, fabs(s->acceleration[c]) * d->mechanism->scale[c] / (second * second));
    }
    out->noise = second * sqrt(difference_error * out->residual);
    take_N(d, &poise, out);
    good = fill(d, s, &poise, work, out);
  }
  if (good)
    status = find_modes(d->mechanism, out, error);
  if (poise.acceleration) {
    km_poise_restore(&poise, d->mechanism, s);
    km_dynamics_evaluate(d, s, true);
  }
  km_free(work);
  km_poise_free(&poise);
  if (!memory)
    return km_fail(error, KM_MEMORY, "out of memory for the linearised equations");
  return good ? status : km_fail(error, KM_DIVERGED, "the loops can't be closed beside the pose; is it a dead point?");
}

void km_linear_free(km_linear *l) {
  if (!l)
    return;
  km_free(l->independent);
  km_free(l->A);
  km_free(l->B);
  km_free(l->N);
  km_free(l->real);
  km_free(l->imaginary);
  km_free(l->modes);
  *l = (km_linear){0};
}

const char *km_stability_name(km_stability stability) {
  static const char *const names[] = {"stable", "unstable", "indifferent", "not at rest"};
  return (size_t)stability < sizeof names / sizeof *names ? names[stability] : "";
}

static double largest_of(const km_linear *l) {
  double largest = 0.0;
  for (int k = 0; k < 2 * l->freedom; ++k)
    largest = fmax(largest, hypot(l->real[k], l->imaginary[k]));
  return largest;
}

double km_linear_zero(const km_linear *l) {
  return fmax(rounding * largest_of(l), l->noise);
}

km_stability km_linear_stability(const km_linear *l) {
  double real = -HUGE_VAL, least = HUGE_VAL;
  if (!l)
    return KM_INDIFFERENT;
  if (!(l->residual <= rest))
    return KM_NOT_AT_REST;
  for (int k = 0; k < 2 * l->freedom; ++k) {
    least = fmin(least, hypot(l->real[k], l->imaginary[k]));
    real = fmax(real, l->real[k]);
  }
  /* A double eigenvalue 0 comes out of differences as ± the root of their error. */
  double zero = fmax(1e-3 * largest_of(l), l->noise);
  if (real > zero)
    return KM_UNSTABLE;
  return l->freedom == 0 || least > zero ? KM_STABLE : KM_INDIFFERENT;
}
