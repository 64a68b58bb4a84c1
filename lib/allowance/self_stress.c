/* Self-stresses as wrenches in the joints (docs/theory.md 14.9): the wrench of joint j is the sum over its loops of
 * ± w_loop, since a displacement of its child against its parent opens these loops by ± that displacement. */
#include "allowance/self_stress.h"

#include "kinematics/body_poses.h"
#include "mobility/left_null_space.h"
#include "spatial/wrench.h"

#include <math.h>

/* A pivot of N_piv, forces per size, below this part of the largest one: the misfit's component is 50 times as large as
 * elsewhere, and the first order doesn't hold. */
static const double vanishing = 0.02;

/* Basis N[rows × count], column-major, with the loops' rows turned into the axes of their closing joints. */
typedef struct basis {
  km_left_space space;
  int rows, count;
  double *N;
} basis;

int km_self_stress_count(const km_state *s, int substructure) {
  const km_substructure *sub = &s->mechanism->substructures[substructure];
  return 6 * sub->loop_count + sub->coupling_count - km_factor_rank(s->factor[substructure]);
}

static km_pose closing_pose(const km_left_space *a, int loop) {
  const km_topology *t = &a->m->topology;
  return km_joint_pose(a->m, a->s, t->chord[t->loop[t->loop_start[a->index] + loop]]);
}

/* Wrench of a loop's rows in a column, about `about` of the loop, inertial axes; lengths in the model's unit. */
static km_wrench loop_wrench(const basis *b, int loop, int column) {
  const double *w = b->N + (size_t)column * (size_t)b->rows + km_left_row(&b->space, loop);
  double scale = 1.0 / b->space.sub->size;
  return (km_wrench){km_vec3_scale(scale, km_vec3_from_array(w)), km_vec3_from_array(w + 3)};
}

static bool find_basis(const km_mechanism *m, km_state *s, int index, km_arena *arena, basis *out) {
  km_left_null null;
  if (!km_left_space_create(m, s, index, arena, &out->space) || !km_left_null_find(&out->space, arena, &null))
    return false;
  const km_left_space *a = &out->space;
  out->rows = a->rows;
  out->count = km_left_null_count(&null);
  out->N = KM_ARENA_NEW(arena, double, (size_t)out->rows *(size_t)out->count + 1);
  if (arena->failed)
    return false;
  for (int k = 0; k < out->count; ++k)
    km_left_null_expand(a, &null, k, out->N + (size_t)k * (size_t)out->rows);
  return true;
}

/* Component of a self-stress that works against a misfit component, per length or radian. */
static double component_of(const basis *b, const km_misfit_component *c, int column) {
  const km_left_space *a = &b->space;
  if (c->loop >= a->sub->loop_count)
    return b->N[(size_t)column * (size_t)b->rows + (size_t)km_left_row(a, c->loop)];
  km_pose pose = closing_pose(a, c->loop);
  km_wrench w = km_wrench_rotate_back(&pose.R, loop_wrench(b, c->loop, column));
  const double entry[6] = {w.f.x, w.f.y, w.f.z, w.t.x, w.t.y, w.t.z};
  return entry[c->component];
}

static km_misfit_component component_at(const basis *b, int row) {
  int loops = b->space.sub->loop_count;
  return row < 6 * loops ? (km_misfit_component){row / 6, row % 6} : (km_misfit_component){row - 6 * loops + loops, 0};
}

/* Picks the largest entry of T[rows × count] outside of used columns; eliminates it from the other columns. Forces
 * count per size of the substructure, and couplings last. */
static int eliminate_largest(const basis *b, double *T, bool *used) {
  int row = 0, column = -1, loops = 6 * b->space.sub->loop_count;
  double largest = -1.0;
  for (int k = 0; k < b->count; ++k)
    for (int r = 0; r < b->rows && !used[k]; ++r) {
      double size = fabs(T[(size_t)k * (size_t)b->rows + (size_t)r]);
      if (r < loops && r % 6 < 3)
        size *= b->space.sub->size;
      if (r >= loops)
        size *= 1e-6;
      if (size > largest * (1.0 + 1e-6)) { /* ties are broken by the order, not by rounding */
        largest = size;
        row = r;
        column = k;
      }
    }
  used[column] = true;
  const double *pivot = T + (size_t)column * (size_t)b->rows;
  for (int k = 0; k < b->count; ++k) {
    double *other = T + (size_t)k * (size_t)b->rows, factor = other[row] / pivot[row];
    for (int r = 0; r < b->rows && !used[k]; ++r)
      other[r] -= factor * pivot[r];
  }
  return row;
}

bool km_misfit_components_choose(const km_mechanism *m, km_state *s, int index, km_misfit_component *component) {
  km_arena scratch = {0};
  basis b;
  bool found = find_basis(m, s, index, &scratch, &b);
  double *T = found ? KM_ARENA_NEW(&scratch, double, (size_t)b.rows *(size_t)b.count + 1) : NULL;
  bool *used = found ? KM_ARENA_NEW(&scratch, bool, (size_t)b.count + 1) : NULL;
  found = found && !scratch.failed;
  for (int k = 0; found && k < b.count; ++k)
    for (int r = 0; r < b.rows; ++r) {
      km_misfit_component c = component_at(&b, r);
      T[(size_t)k * (size_t)b.rows + (size_t)r] = component_of(&b, &c, k);
    }
  for (int k = 0; found && k < b.count; ++k)
    component[k] = component_at(&b, eliminate_largest(&b, T, used));
  km_arena_free(&scratch);
  return found;
}

/* Inverts A[n × n], row-major, into X by Gauss-Jordan elimination with partial pivoting. False if A is singular. */
static bool invert(double *A, int n, double *X) {
  double largest = 0.0;
  for (int i = 0; i < n * n; ++i)
    largest = fmax(largest, fabs(A[i]));
  for (int i = 0; i < n * n; ++i)
    X[i] = i % (n + 1) == 0 ? 1.0 : 0.0;
  for (int c = 0; c < n; ++c) {
    int p = c;
    for (int r = c + 1; r < n; ++r)
      p = fabs(A[r * n + c]) > fabs(A[p * n + c]) ? r : p;
    if (!(fabs(A[p * n + c]) > vanishing * largest))
      return false;
    for (int k = 0; k < n; ++k) {
      double a = A[c * n + k], x = X[c * n + k];
      A[c * n + k] = A[p * n + k];
      X[c * n + k] = X[p * n + k];
      A[p * n + k] = a;
      X[p * n + k] = x;
    }
    for (int r = 0; r < n; ++r) {
      double factor = r == c ? 1.0 - 1.0 / A[c * n + c] : A[r * n + c] / A[c * n + c];
      for (int k = 0; k < n; ++k) {
        A[r * n + k] -= factor * A[c * n + k];
        X[r * n + k] -= factor * X[c * n + k];
      }
    }
  }
  return true;
}

/* Forces count per size of the substructure. */
static double scale_of(const basis *b, const km_misfit_component *c) {
  return c->loop < b->space.sub->loop_count && c->component < 3 ? b->space.sub->size : 1.0;
}

/* Replaces N by N (N_piv)⁻¹, and sets *measures, unless N_piv is singular. False without memory. */
static bool measure_components(basis *b, const km_misfit_component *component, km_arena *scratch, bool *measures) {
  const int n = b->count, rows = b->rows;
  double *A = KM_ARENA_NEW(scratch, double, 2 * (size_t)n * (size_t)n + 1);
  double *N = KM_ARENA_NEW(scratch, double, (size_t)rows *(size_t)n + 1);
  if (scratch->failed)
    return false;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k)
      A[i * n + k] = component_of(b, &component[i], k) * scale_of(b, &component[i]);
  double *inverse = A + n * n;
  *measures = invert(A, n, inverse);
  for (int i = 0; *measures && i < n; ++i)
    for (int k = 0; k < n; ++k)
      for (int r = 0; r < rows; ++r)
        N[i * rows + r] += b->N[k * rows + r] * inverse[k * n + i] * scale_of(b, &component[i]);
  if (*measures)
    b->N = N;
  return true;
}

/* Wrench that joint j carries in one self-stress, about the inertial origin. */
static km_wrench joint_wrench(const basis *b, int joint, int column) {
  const km_left_space *a = &b->space;
  km_wrench sum = {{0, 0, 0}, {0, 0, 0}};
  const km_topology *t = &a->m->topology;
  for (int i = t->joint_loop_start[joint]; i < t->joint_loop_start[joint + 1]; ++i) {
    const km_joint_loop *in = &t->joint_loop[i];
    km_wrench w = loop_wrench(b, in->loop, column);
    sum = km_wrench_axpy(in->sign, km_wrench_at(w.f, w.t, a->about[in->loop]), sum);
  }
  return sum;
}

static void remove_along(km_vec3 direction, km_vec3 *v) {
  double square = km_vec3_dot(direction, direction);
  if (square > 0.0)
    *v = km_vec3_axpy(-km_vec3_dot(direction, *v) / square, direction, *v);
}

/* Removes what works along the joint's own motions: the force of a coupling balances it, no bearing carries it. */
static void remove_free_components(const km_left_space *a, int joint, km_wrench *at_point) {
  const int first = a->m->model->joints[joint].first_coordinate;
  for (int c = first; c < first + km_model_freedom(a->m->model, joint); ++c) {
    km_twist h = km_coordinate_twist(a->m, a->s, c);
    if (km_vec3_dot(h.w, h.w) > 0.0)
      remove_along(h.w, &at_point->t);
    else
      remove_along(h.v, &at_point->f);
  }
}

static void write_column(const basis *b, int joint, int column, double *wrench) {
  const km_left_space *a = &b->space;
  km_pose pose = km_joint_pose(a->m, a->s, joint);
  km_wrench w = joint_wrench(b, joint, column);
  km_vec3 child_origin = km_frame_origin(a->m->model, a->s->pose, a->m->model->joints[joint].frame[1]);
  km_wrench child = km_wrench_about(w, child_origin), parent = km_wrench_about(w, pose.p);
  remove_free_components(a, joint, &child);
  remove_free_components(a, joint, &parent);
  child = km_wrench_rotate_back(&pose.R, child);
  parent = km_wrench_rotate_back(&pose.R, parent);
  const double f[3] = {child.f.x, child.f.y, child.f.z};
  int own_axis = km_joint_axis(a->m->model->joints[joint].type), axis = own_axis < 0 ? 2 : own_axis;
  const double entry[KM_STRESS_ROWS] = {f[(axis + 1) % 3], f[(axis + 2) % 3], f[axis],    child.t.x, child.t.y,
                                        child.t.z,         parent.t.x,        parent.t.y, parent.t.z};
  for (int r = 0; r < KM_STRESS_ROWS; ++r)
    wrench[r * b->count + column] = entry[r];
}

bool km_self_stress_compute(const km_mechanism *m, km_state *s, int index, const km_misfit_component *component,
                            km_arena *arena, km_self_stress *out) {
  km_arena scratch = {0};
  basis b;
  const km_topology *t = &m->topology;
  int first = t->joint_start[index], joints = t->joint_start[index + 1] - first;
  bool found = find_basis(m, s, index, &scratch, &b);
  if (found) {
    size_t n = (size_t)b.count;
    *out = (km_self_stress){.index = index,
                            .count = b.count,
                            .joint_count = joints,
                            .joint = t->joint + first,
                            .wrench = KM_ARENA_NEW(arena, double, (size_t)joints *KM_STRESS_ROWS *n + 1)};
    found = !arena->failed && measure_components(&b, component, &scratch, &out->measures);
  }
  for (int j = 0; found && j < joints; ++j)
    for (int k = 0; k < b.count; ++k)
      write_column(&b, out->joint[j], k, out->wrench + (size_t)j * KM_STRESS_ROWS * (size_t)b.count);
  km_arena_free(&scratch);
  return found;
}
