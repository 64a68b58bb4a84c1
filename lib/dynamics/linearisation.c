/* Linearised equations of motion by central differences, their eigenvalues, modes and error bounds (docs/theory.md
 * 11.12).
 *
 *   x = (δu, δu̇),  ẋ = A x + B f;   A, B by central differences of the accelerations, with steps h and 2h
 *   error of an eigenvalue = Σ |y_i| E_ij |x_j| / |yᴴ x|,  y, x left and right eigenvectors  (Stewart, Sun 1990) */
#include "kmech/dynamics.h"

#include "base/arguments.h"
#include "dynamics/force_breakpoints.h"
#include "dynamics/linearisation.h"
#include "linalg/dense/eigenvalues.h"

#include <math.h>
#include <string.h>

static const double default_step = 1e-5, least_step = 1e-8;
static const double difference_error = 1e-9;  /* relative error of accelerations in their differences */
static const double equal_magnitude = 1e-6;   /* relative difference of magnitudes below which eigenvalues count as
                                              * equal */
static const double error_factor = 4.0;       /* an eigenvalue counts as non-zero above this multiple of its error */
static const double rest_acceleration = 1e-6; /* largest scaled acceleration per s² of a configuration at rest */

/* Step of the differences: not beyond a corner of a force law, where the slope changes. */
static double choose_step(const km_dynamics *d, const km_state *s, km_arena *arena) {
  static const double error_share =
      0.2; /* part of the distance to the corner; other coordinates can move farther than the shifted one */
  km_corners corners;
  double step = default_step;
  if (!km_corners_list(d, arena, &corners))
    return step;
  for (int i = 0; i < corners.count; ++i) {
    int c = corners.corners[i].coordinate;
    if (c == KM_CORNER_TIME)
      continue;
    double above = km_corners_above(&corners, c, s->q[c]) - s->q[c];
    double below = s->q[c] - km_corners_up_to(&corners, c, nextafter(s->q[c], -HUGE_VAL));
    step = fmin(step, error_share * d->mechanism->scale[c] * fmin(above, below));
  }
  return fmax(step, least_step);
}

/* Stores the state and its independent coordinates. */
bool km_stored_configuration_create(const km_dynamics *d, const km_state *s, km_stored_configuration *out) {
  const km_mechanism *m = d->mechanism;
  size_t n = (size_t)m->coordinate_count;
  int count = 0;
  *out = (km_stored_configuration){0};
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

void km_stored_configuration_free(km_stored_configuration *stored) {
  km_arena_free(&stored->arena);
}

void km_stored_configuration_restore(const km_stored_configuration *stored, const km_mechanism *m, km_state *s) {
  memcpy(s->q, stored->q, (size_t)m->coordinate_count * sizeof *s->q);
  memcpy(s->rate, stored->rate, (size_t)m->coordinate_count * sizeof *s->rate);
  memcpy(s->ball, stored->ball, (size_t)m->ball_count * sizeof *s->ball);
}

void km_coordinate_shift(const km_mechanism *m, km_state *s, int c, double by) {
  int ball = m->ball_of[c];
  if (ball < 0) {
    s->q[c] += by;
    return;
  }
  double turn[3] = {0.0, 0.0, 0.0};
  turn[c - m->ball_coordinate[ball]] = by;
  km_state_rotate_ball(m, s, ball, km_vec3_from_array(turn));
}

/* Accelerations of the independent coordinates; false if an evaluation fails. */
static bool accelerations(km_dynamics *d, km_state *s, const km_stored_configuration *p, double *out) {
  if (km_dynamics_evaluate(d, s, false) != KM_DYNAMICS_DONE)
    return false;
  for (int i = 0; i < p->freedom; ++i)
    out[i] = s->acceleration[p->independent[i]];
  return true;
}

typedef enum change { OF_POSE, OF_RATE, OF_FORCE } change;

/* Adds an increment to a coordinate's value, rate or force. */
static void shift_variable(km_dynamics *d, km_state *s, const km_stored_configuration *p, change what, int c,
                           double by) {
  km_stored_configuration_restore(p, d->mechanism, s);
  if (what == OF_POSE)
    km_coordinate_shift(d->mechanism, s, c, by);
  else if (what == OF_RATE)
    s->rate[c] += by;
  else
    d->forces->extra[c] += by;
}

/* Central difference of the accelerations by one variable. work[2 freedom]. */
static bool central_difference(km_dynamics *d, km_state *s, const km_stored_configuration *p, change what, int c,
                               double by, double *work, double *out) {
  bool is_ok = true;
  for (int side = 0; side < 2 && is_ok; ++side) {
    shift_variable(d, s, p, what, c, side ? -by : by);
    is_ok = accelerations(d, s, p, work + side * p->freedom);
    if (what == OF_FORCE)
      d->forces->extra[c] -= side ? -by : by;
  }
  for (int i = 0; i < p->freedom && is_ok; ++i)
    out[i] = (work[i] - work[p->freedom + i]) / (2.0 * by);
  km_stored_configuration_restore(p, d->mechanism, s);
  return is_ok;
}

bool km_stiffness_of_accelerations(km_dynamics *d, km_state *s, const km_stored_configuration *p, double *work,
                                   double *K) {
  for (int k = 0; k < p->freedom; ++k)
    if (!central_difference(d, s, p, OF_POSE, p->independent[k], p->step / d->mechanism->scale[p->independent[k]], work,
                            K + (size_t)k * (size_t)p->freedom))
      return false;
  return true;
}

/* Allocates the matrices and eigenvalues. */
static bool allocate(km_linear *out, int freedom, int coordinates) {
  size_t f = (size_t)freedom, n = (size_t)coordinates;
  out->freedom = freedom;
  out->coordinate_count = coordinates;
  out->independent = KM_NEW(int, f + 1);
  out->A = KM_NEW(double, 4 * f * f + 1);
  out->B = KM_NEW(double, 2 * f * n + 1);
  out->N = KM_NEW(double, n *f + 1);
  out->error_bound = KM_NEW(double, 2 * f + 1);
  out->real = KM_NEW(double, 2 * f + 1);
  out->imaginary = KM_NEW(double, 2 * f + 1);
  out->modes = KM_NEW(double, 4 * f * n + 1);
  return out->independent && out->A && out->B && out->N && out->error_bound && out->real && out->imaginary &&
         out->modes;
}

/* Copies N of all clusters to rows of coordinates. */
static void copy_N(const km_dynamics *d, const km_stored_configuration *p, km_linear *out) {
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

/* Columns of A for a coordinate and its rate, by differences of `size` times the step. */
static bool difference_columns(km_dynamics *d, km_state *s, const km_stored_configuration *p, size_t k, double size,
                               double *work, double *A) {
  size_t f = (size_t)p->freedom, rows = 2 * f;
  int c = p->independent[k];
  double by = size * p->step / d->mechanism->scale[c], second = d->mechanism->model->units.time->si;
  return central_difference(d, s, p, OF_POSE, c, by, work, A + k * rows + f) &&
         central_difference(d, s, p, OF_RATE, c, by * second, work, A + (f + k) * rows + f);
}

/* Computes A by differences of two step sizes (the larger ones in other[4 freedom²]) and B by the forces, in which
 * the equations are linear. */
static bool fill_matrices(km_dynamics *d, km_state *s, const km_stored_configuration *p, double *work, km_linear *out,
                          double *other) {
  const km_mechanism *m = d->mechanism;
  size_t f = (size_t)p->freedom, rows = 2 * f;
  bool is_ok = true;
  for (size_t k = 0; k < f && is_ok; ++k) {
    out->A[(f + k) * rows + k] = other[(f + k) * rows + k] = 1.0;
    is_ok = difference_columns(d, s, p, k, 1.0, work, out->A) && difference_columns(d, s, p, k, 2.0, work, other);
  }
  for (int c = 0; c < m->coordinate_count && is_ok; ++c)
    if (!m->held[c])
      is_ok = central_difference(d, s, p, OF_FORCE, c, 1.0, work, out->B + (size_t)c * rows + f);
  return is_ok;
}

/* Error bounds E of the entries of A, written to `other`: difference of both step sizes plus 1e-9 of the row's
 * largest entry. */
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
      double difference = fabs(l->A[k * rows + i] - other[k * rows + i]);
      other[k * rows + i] = i < f ? 0.0 : difference + difference_error * unit * largest;
    }
  }
}

/* Eigenvector of A; its imaginary part is `sign` times a column, or 0. */
typedef struct eigenvector {
  const double *real, *imaginary;
  double sign; /* 0: the vector is real */
} eigenvector;

/* Mode shape: real and imaginary parts of all coordinates, normalised so that the largest scaled one is 1. */
static void write_mode(const km_mechanism *m, const km_linear *l, eigenvector v, double *out) {
  int n = l->coordinate_count;
  double largest = 0.0;
  for (int c = 0; c < n; ++c) {
    double re = 0.0, im = 0.0;
    for (int k = 0; k < l->freedom; ++k) {
      double N = l->N[(size_t)k * (size_t)n + (size_t)c];
      re += N * v.real[k];
      im += N * v.sign * v.imaginary[k];
    }
    out[c] = re;
    out[n + c] = im;
    largest = fmax(largest, m->scale[c] * hypot(re, im));
  }
  for (int c = 0; c < 2 * n && largest > 0.0; ++c)
    out[c] /= largest;
}

/* Eigenvalues and eigenvectors of A from LAPACK. */
typedef struct eigensystem {
  double *A, *real, *imaginary, *left, *right;
  int *order; /* order by magnitude */
} eigensystem;

static eigenvector eigenvector_at(const eigensystem *e, const double *vectors, size_t size, size_t k) {
  if (e->imaginary[k] == 0.0)
    return (eigenvector){vectors + k * size, vectors + k * size, 0.0};
  size_t first = e->imaginary[k] > 0.0 ? k : k - 1;
  return (eigenvector){vectors + first * size, vectors + (first + 1) * size, e->imaginary[k] > 0.0 ? 1.0 : -1.0};
}

/* Order of eigenvalues: by magnitude; equal magnitudes by decreasing real part. */
static bool precedes(const eigensystem *e, int a, int b) {
  double size[] = {hypot(e->real[a], e->imaginary[a]), hypot(e->real[b], e->imaginary[b])};
  double close = equal_magnitude * fmax(size[0], size[1]);
  return fabs(size[0] - size[1]) > close ? size[0] < size[1] : e->real[a] > e->real[b] + close;
}

/* Stable insertion sort, so that conjugate pairs stay together. */
static void sort(const eigensystem *e, int size) {
  for (int k = 0; k < size; ++k) {
    int at = k;
    for (; at > 0 && precedes(e, k, e->order[at - 1]); --at)
      e->order[at] = e->order[at - 1];
    e->order[at] = k;
  }
}

static double magnitude_at(const eigenvector *v, size_t i) {
  return hypot(v->real[i], v->sign * v->imaginary[i]);
}

/* First-order error bound of an eigenvalue, Σ |y_i| E_ij |x_j| / |yᴴ x| with its left and right eigenvectors (G.
 * Stewart and J. Sun 1990, IV.2.3). A double eigenvalue 0 has about this magnitude. */
static double error_of(eigenvector y, eigenvector x, const double *E, size_t size) {
  double sum = 0.0, re = 0.0, im = 0.0;
  for (size_t j = 0; j < size; ++j) {
    for (size_t i = 0; i < size; ++i)
      sum += magnitude_at(&y, i) * E[j * size + i] * magnitude_at(&x, j);
    re += y.real[j] * x.real[j];
    if (y.sign != 0.0) {
      re += y.imaginary[j] * x.imaginary[j];
      im += y.real[j] * x.imaginary[j] - y.imaginary[j] * x.real[j];
    }
  }
  double along = hypot(re, im);
  return sum > 0.0 ? sum / along : 0.0;
}

/* Computes eigenvalues, their error bounds and modes; E are the error bounds of the entries of A. */
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
    eigenvector left = eigenvector_at(&e, e.left, size, from), right = eigenvector_at(&e, e.right, size, from);
    l->error_bound[k] = fmax(l->noise, error_factor * error_of(left, right, E, size));
    write_mode(m, l, right, l->modes + k * 2 * (size_t)l->coordinate_count);
  }
  km_arena_free(&arena);
  return status;
}

/* Linearises at the state's configuration and rates. */
static km_status linearise(km_dynamics *d, km_state *s, km_linear *out, km_error *error) {
  km_status status = km_dynamics_accelerate(d, s, error);
  if (status)
    return status;
  km_stored_configuration stored = {0};
  bool memory = km_stored_configuration_create(d, s, &stored);
  size_t f = (size_t)stored.freedom;
  double *work = KM_NEW(double, 2 * f + 1), *other = KM_NEW(double, 4 * f * f + 1);
  memory = memory && work && other && allocate(out, stored.freedom, d->mechanism->coordinate_count);
  double second = d->mechanism->model->units.time->si;
  bool is_ok = memory;
  if (is_ok) {
    for (int k = 0; k < stored.freedom; ++k) {
      int c = stored.independent[k];
      out->residual = fmax(out->residual, fabs(s->acceleration[c]) * d->mechanism->scale[c] / (second * second));
    }
    out->noise = second * sqrt(difference_error * out->residual);
    copy_N(d, &stored, out);
    is_ok = fill_matrices(d, s, &stored, work, out, other);
  }
  if (is_ok) {
    find_errors(d->mechanism, out, other);
    status = find_modes(d->mechanism, out, other, error);
  }
  if (stored.acceleration) {
    km_stored_configuration_restore(&stored, d->mechanism, s);
    km_dynamics_evaluate(d, s, true);
  }
  km_free(work);
  km_free(other);
  km_stored_configuration_free(&stored);
  if (!memory)
    return km_fail(error, KM_MEMORY, "out of memory for the linearised equations");
  return is_ok ? status
               : km_fail(error, KM_DIVERGED, "the loops can't be closed near the pose, which can be a dead point");
}

static bool is_at_rest(const km_state *s) {
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
  d->forces->moving->frictionless = is_at_rest(s);
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
  km_free(l->error_bound);
  km_free(l->real);
  km_free(l->imaginary);
  km_free(l->modes);
  *l = (km_linear){0};
}

const char *km_stability_name(km_stability stability) {
  static const char *const names[] = {"stable", "unstable", "indifferent", "not at rest"};
  return (size_t)stability < sizeof names / sizeof *names ? names[stability] : "";
}

/* Unstable if an eigenvalue has a positive real part beyond its error, indifferent if one is 0 within its error. */
km_stability km_linear_stability(const km_linear *l) {
  bool still = false;
  if (!l)
    return KM_INDIFFERENT;
  if (!(l->residual <= rest_acceleration))
    return KM_NOT_AT_REST;
  for (int k = 0; k < 2 * l->freedom; ++k) {
    if (l->real[k] > l->error_bound[k])
      return KM_UNSTABLE;
    still = still || hypot(l->real[k], l->imaginary[k]) <= l->error_bound[k];
  }
  return still ? KM_INDIFFERENT : KM_STABLE;
}
