/* Linearised equations of motion by differences, and their eigenvalues. */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "dynamics/force_breakpoints.h"
#include "dynamics/linearisation.h"
#include "linalg/dense/eigenvalues.h"

#include <string.h>

static const double usual_step = 1e-5, least_step = 1e-8;
static const double difference_error = 1e-9; /* of the accelerations, in their differences */
static const double alike = 1e-6;            /* sizes of eigenvalues that only rounding tells apart */
static const double sure = 4.0;              /* times the error that an eigenvalue may have tell it from 0 */
static const double rest = 1e-6;             /* the largest acceleration of a pose at rest, scaled, over s² */

/* How far differences reach: not beyond a corner of a force, where its slope is another one. */
static double choose_step(const km_dynamics *d, const km_state *s, km_arena *arena) {
  static const double share =
      0.2; /* of the way to the corner: other coordinates go further than the one that is moved */
  km_corners corners;
  double step = usual_step;
  if (!km_corners_list(d, arena, &corners))
    return step;
  for (int i = 0; i < corners.count; ++i) {
    int c = corners.corners[i].coordinate;
    double way = share * d->mechanism->scale[c] * fabs(s->q[c] - corners.corners[i].value);
    if (way > 0.0)
      step = fmin(step, way);
  }
  return fmax(step, least_step);
}

bool km_poise_take(const km_dynamics *d, const km_state *s, km_rest_pose *out) {
  const km_mechanism *m = d->mechanism;
  size_t n = (size_t)m->coordinate_count;
  int count = 0;
  *out = (km_rest_pose){0};
  out->q = KM_ARENA_NEW(&out->arena, double, n);
  out->rate = KM_ARENA_NEW(&out->arena, double, n);
  out->ball = KM_ARENA_NEW(&out->arena, km_quaternion, (size_t)m->ball_count);
  out->independent = KM_ARENA_NEW(&out->arena, int, n);
  out->acceleration = KM_ARENA_NEW(&out->arena, double, n);
  out->step = choose_step(d, s, &out->arena);
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

void km_poise_free(km_rest_pose *poise) {
  km_arena_free(&poise->arena);
}

void km_poise_restore(const km_rest_pose *poise, const km_mechanism *m, km_state *s) {
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
  km_state_rotate_ball(m, s, ball, km_vec3_from_array(turn));
}

/* Accelerations of the independent coordinates at the state; false where an evaluation fails. */
static bool accelerations(km_dynamics *d, km_state *s, const km_rest_pose *p, double *out) {
  if (km_dynamics_evaluate(d, s, false) != KM_DYNAMICS_DONE)
    return false;
  for (int i = 0; i < p->freedom; ++i)
    out[i] = s->acceleration[p->independent[i]];
  return true;
}

typedef enum change { OF_POSE, OF_RATE, OF_FORCE } change;

/* Adds to a coordinate's value, rate or force. */
static void shift(km_dynamics *d, km_state *s, const km_rest_pose *p, change what, int c, double by) {
  km_poise_restore(p, d->mechanism, s);
  if (what == OF_POSE)
    km_nudge(d->mechanism, s, c, by);
  else if (what == OF_RATE)
    s->rate[c] += by;
  else
    d->forces->extra[c] += by;
}

/* Central differences of the accelerations. work[2 freedom]. */
static bool derivative(km_dynamics *d, km_state *s, const km_rest_pose *p, change what, int c, double by, double *work,
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

bool km_stiffness_of_accelerations(km_dynamics *d, km_state *s, const km_rest_pose *p, double *work, double *K) {
  for (int k = 0; k < p->freedom; ++k)
    if (!derivative(d, s, p, OF_POSE, p->independent[k], p->step / d->mechanism->scale[p->independent[k]], work,
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
  out->doubt = KM_NEW(double, 2 * f + 1);
  out->real = KM_NEW(double, 2 * f + 1);
  out->imaginary = KM_NEW(double, 2 * f + 1);
  out->modes = KM_NEW(double, 4 * f * n + 1);
  return out->independent && out->A && out->B && out->N && out->doubt && out->real && out->imaginary && out->modes;
}

/* N of all clusters, into rows of coordinates. */
static void take_N(const km_dynamics *d, const km_rest_pose *p, km_linear *out) {
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

/* A's columns of a coordinate and of its rate, by differences of `size` times the usual step. */
static bool fill_columns(km_dynamics *d, km_state *s, const km_rest_pose *p, size_t k, double size, double *work,
                         double *A) {
  size_t f = (size_t)p->freedom, rows = 2 * f;
  int c = p->independent[k];
  double by = size * p->step / d->mechanism->scale[c], second = d->mechanism->model->units.time->si;
  return derivative(d, s, p, OF_POSE, c, by, work, A + k * rows + f) &&
         derivative(d, s, p, OF_RATE, c, by * second, work, A + (f + k) * rows + f);
}

/* A by the independent coordinates and their rates, with steps of two sizes, of which `other` [4 freedom²] takes the
 * larger ones'; B by the forces: the equations are linear in these. */
static bool fill(km_dynamics *d, km_state *s, const km_rest_pose *p, double *work, km_linear *out, double *other) {
  const km_mechanism *m = d->mechanism;
  size_t f = (size_t)p->freedom, rows = 2 * f;
  bool good = true;
  for (size_t k = 0; k < f && good; ++k) {
    out->A[(f + k) * rows + k] = other[(f + k) * rows + k] = 1.0;
    good = fill_columns(d, s, p, k, 1.0, work, out->A) && fill_columns(d, s, p, k, 2.0, work, other);
  }
  for (int c = 0; c < m->coordinate_count && good; ++c)
    if (!m->held[c])
      good = derivative(d, s, p, OF_FORCE, c, 1.0, work, out->B + (size_t)c * rows + f);
  return good;
}

/* What the entries of A may err by, in the place of those of `other`: what larger steps tell, and 1e-9 of the row's largest. */
static void find_errors(const km_mechanism *m, const km_linear *l, double *other) {
  size_t f = (size_t)l->freedom, rows = 2 * f;
  double second = m->model->units.time->si;
  for (size_t i = 0; i < rows; ++i) {
    double largest = 0.0;
    for (size_t k = 0; k < rows; ++k) {
      double unit = m->scale[l->independent[k % f]] / (k < f ? 1.0 : second);
      largest = fmax(largest, fabs(l->A[k * rows + i]) / unit);
    }
    for (size_t k = 0; k < rows; ++k) {
      double unit = m->scale[l->independent[k % f]] / (k < f ? 1.0 : second);
      double told = fabs(l->A[k * rows + i] - other[k * rows + i]);
      other[k * rows + i] = i < f ? 0.0 : told + difference_error * unit * largest;
    }
  }
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
  double *A, *real, *imaginary, *left, *right;
  int *order; /* by size */
} eigensystem;

static eigenvector vector_of(const eigensystem *e, const double *vectors, size_t size, size_t k) {
  if (e->imaginary[k] == 0.0)
    return (eigenvector){vectors + k * size, NULL, 0.0};
  size_t first = e->imaginary[k] > 0.0 ? k : k - 1;
  return (eigenvector){vectors + first * size, vectors + (first + 1) * size, e->imaginary[k] > 0.0 ? 1.0 : -1.0};
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

static double part(const eigenvector *v, size_t i) {
  return v->imaginary ? hypot(v->real[i], v->imaginary[i]) : fabs(v->real[i]);
}

/* An eigenvalue's error to first order, Σ |y_i| E_ij |x_j| / |yᴴ x| of its left and right vectors (G. Stewart, J. Sun, Matrix
 * Perturbation Theory, 1990, IV.2.3): of a double eigenvalue 0 the size that the errors give it, but for a factor. */
static double error_of(eigenvector y, eigenvector x, const double *E, size_t size) {
  double sum = 0.0, re = 0.0, im = 0.0;
  for (size_t j = 0; j < size; ++j) {
    for (size_t i = 0; i < size; ++i)
      sum += part(&y, i) * E[j * size + i] * part(&x, j);
    re += y.real[j] * x.real[j];
    if (y.imaginary) {
      re += y.imaginary[j] * x.imaginary[j];
      im += y.real[j] * x.imaginary[j] - y.imaginary[j] * x.real[j];
    }
  }
  double along = hypot(re, im);
  return sum > 0.0 ? sum / along : 0.0;
}

/* E: what the entries of A may err by. */
static km_status find_modes(const km_mechanism *m, km_linear *l, const double *E, km_error *error) {
  size_t size = 2 * (size_t)l->freedom;
  if (size == 0)
    return KM_OK;
  km_arena arena = {0};
  eigensystem e = {.A = KM_ARENA_NEW(&arena, double, size *size),
                   .real = KM_ARENA_NEW(&arena, double, size),
                   .imaginary = KM_ARENA_NEW(&arena, double, size),
                   .left = KM_ARENA_NEW(&arena, double, size *size),
                   .right = KM_ARENA_NEW(&arena, double, size *size),
                   .order = KM_ARENA_NEW(&arena, int, size)};
  km_status status = KM_OK;
  if (arena.failed) {
    status = km_fail(error, KM_MEMORY, "out of memory for the linearised equations");
  } else {
    memcpy(e.A, l->A, size * size * sizeof *e.A);
    status = km_eigen((int)size, e.A, e.real, e.imaginary, e.left, e.right, error);
  }
  if (!status)
    sort(&e, (int)size);
  for (size_t k = 0; k < size && !status; ++k) {
    size_t from = (size_t)e.order[k];
    l->real[k] = e.real[from];
    l->imaginary[k] = e.imaginary[from];
    eigenvector left = vector_of(&e, e.left, size, from), right = vector_of(&e, e.right, size, from);
    l->doubt[k] = fmax(l->noise, sure * error_of(left, right, E, size));
    keep_mode(m, l, right, l->modes + k * 2 * (size_t)l->coordinate_count);
  }
  km_arena_free(&arena);
  return status;
}

/* At the state's rates. */
static km_status linearise(km_dynamics *d, km_state *s, km_linear *out, km_error *error) {
  km_status status = km_dynamics_accelerate(d, s, error);
  if (status)
    return status;
  km_rest_pose poise = {0};
  bool memory = km_poise_take(d, s, &poise);
  size_t f = (size_t)poise.freedom;
  double *work = KM_NEW(double, 2 * f + 1), *other = KM_NEW(double, 4 * f * f + 1);
  memory = memory && work && other && allocate(out, poise.freedom, d->mechanism->coordinate_count);
  double second = d->mechanism->model->units.time->si;
  bool good = memory;
  if (good) {
    for (int k = 0; k < poise.freedom; ++k) {
      int c = poise.independent[k];
      out->residual = fmax(out->residual, fabs(s->acceleration[c]) * d->mechanism->scale[c] / (second * second));
    }
    out->noise = second * sqrt(difference_error * out->residual);
    take_N(d, &poise, out);
    good = fill(d, s, &poise, work, out, other);
  }
  if (good) {
    find_errors(d->mechanism, out, other);
    status = find_modes(d->mechanism, out, other, error);
  }
  if (poise.acceleration) {
    km_poise_restore(&poise, d->mechanism, s);
    km_dynamics_evaluate(d, s, true);
  }
  km_free(work);
  km_free(other);
  km_poise_free(&poise);
  if (!memory)
    return km_fail(error, KM_MEMORY, "out of memory for the linearised equations");
  return good ? status : km_fail(error, KM_DIVERGED, "the loops can't be closed beside the pose; is it a dead point?");
}

static bool stands(const km_state *s) {
  bool all = true;
  for (int c = 0; c < s->mechanism->coordinate_count; ++c)
    all = all && s->rate[c] == 0.0;
  return all;
}

km_status km_linearise(km_dynamics *d, km_state *s, km_linear *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_linear){0};
  km_status status = km_dynamics_project_rates(d, s, NULL, error);
  if (status)
    return status;
  d->forces->moving->frictionless = stands(s);
  status = linearise(d, s, out, error);
  d->forces->moving->frictionless = false;
  return status;
}

void km_linear_free(km_linear *l) {
  if (!l)
    return;
  km_free(l->independent);
  km_free(l->A);
  km_free(l->B);
  km_free(l->N);
  km_free(l->doubt);
  km_free(l->real);
  km_free(l->imaginary);
  km_free(l->modes);
  *l = (km_linear){0};
}

const char *km_stability_name(km_stability stability) {
  static const char *const names[] = {"stable", "unstable", "indifferent", "not at rest"};
  return (size_t)stability < sizeof names / sizeof *names ? names[stability] : "";
}

km_stability km_linear_stability(const km_linear *l) {
  bool still = false;
  if (!l)
    return KM_INDIFFERENT;
  if (!(l->residual <= rest))
    return KM_NOT_AT_REST;
  for (int k = 0; k < 2 * l->freedom; ++k) {
    if (l->real[k] > l->doubt[k])
      return KM_UNSTABLE;
    still = still || hypot(l->real[k], l->imaginary[k]) <= l->doubt[k];
  }
  return still ? KM_INDIFFERENT : KM_STABLE;
}
