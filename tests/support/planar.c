/* Random planar linkages and their balance of forces, without loops or null spaces of the engine. */
#include "support/planar.h"

#include "base/text.h"
#include "kinematics/body_poses.h"

#include <lapacke.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int add(planar *p, randomness *r, int parent, int child, double x, double y, bool slides, bool friction) {
  double turn = uniform(r, 0.0, 2.0 * M_PI);
  planar_joint *j = &p->joint[p->joints];
  *j = (planar_joint){parent, child, slides, {x, y}, {cos(turn), sin(turn)}, 0.0, 0.0};
  if (friction && below(r, 4) > 0) {
    j->coefficient = slides ? uniform(r, 0.02, 0.4) : uniform(r, 0.05, 0.3);
    j->radius = uniform(r, 0.01, 0.15);
  }
  return p->joints++;
}

static void add_hinge(planar *p, randomness *r, int parent, int child, bool friction) {
  double x = uniform(r, -1.0, 1.0), y = uniform(r, -1.0, 1.0);
  add(p, r, parent, child, x, y, false, friction);
}

planar planar_random(randomness *r, int freedoms, int pairs, bool friction) {
  planar p = {.freedoms = freedoms};
  km_vec3 turn = {uniform(r, -2.0, 2.0), uniform(r, -2.0, 2.0), uniform(r, -2.0, 2.0)};
  p.plane = below(r, 3) ? km_quaternion_rotation(km_quaternion_exp(turn)) : km_rotation_identity();
  for (int i = 0; i < freedoms; ++i)
    add_hinge(&p, r, 0, ++p.bodies, friction);
  for (int i = 0; i < pairs; ++i) {
    int first = i == 0 ? 1 : below(r, p.bodies + 1), second = first;
    if (i == 0)
      second = freedoms == 2 ? 2 : 0;
    while (second == first)
      second = below(r, p.bodies + 1);
    int a = ++p.bodies, b = ++p.bodies;
    add_hinge(&p, r, first, a, friction);
    add_hinge(&p, r, a, b, friction);
    double x = uniform(r, -1.0, 1.0), y = uniform(r, -1.0, 1.0);
    add(&p, r, second, b, x, y, below(r, 3) == 0, friction);
  }
  for (int b = 0; b < p.bodies; ++b) {
    p.mass[b] = uniform(r, 0.0, 2.0);
    for (int k = 0; k < 2; ++k)
      p.centre[b][k] = uniform(r, -1.0, 1.0);
  }
  return p;
}

km_vec3 planar_in_space(const planar *p, const double v[2]) {
  return km_rotate(&p->plane, (km_vec3){v[0], v[1], 0.0});
}

/* A frame at a place, its x axis along `along`, its z axis normal to the plane. */
static void write_frame(const planar *p, int joint, km_text *out) {
  const planar_joint *j = &p->joint[joint];
  const double none[2] = {1.0, 0.0}, *along = j->slides ? j->along : none, across[2] = {-along[1], along[0]};
  km_vec3 a = planar_in_space(p, along), b = planar_in_space(p, across), c = p->plane.axis[2];
  km_vec3 at = planar_in_space(p, j->place);
  km_text_format(out,
                 "{\"name\": \"j%d\", \"T\": [%.17g, %.17g, %.17g], \"R\": [[%.17g, %.17g, %.17g], [%.17g, %.17g, "
                 "%.17g], [%.17g, %.17g, %.17g]]}",
                 joint, at.x, at.y, at.z, a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z);
}

static void write_frames(const planar *p, int body, km_text *out) {
  int count = 0;
  km_text_add(out, "\"frames\": [");
  for (int j = 0; j < p->joints; ++j)
    if (p->joint[j].parent == body || p->joint[j].child == body) {
      km_text_add(out, count++ ? ", " : "");
      write_frame(p, j, out);
    }
  km_text_add(out, "]");
}

char *planar_text(const planar *p) {
  km_text out = {0};
  km_text_add(&out, "{\"fixed\": {");
  write_frames(p, 0, &out);
  km_text_add(&out, "}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int b = 1; b <= p->bodies; ++b) {
    km_vec3 c = planar_in_space(p, p->centre[b - 1]);
    km_text_format(&out, "%s{\"name\": \"b%d\", \"mass\": %.17g, \"center_of_mass\": [%.17g, %.17g, %.17g], ",
                   b > 1 ? ", " : "", b, p->mass[b - 1], c.x, c.y, c.z);
    write_frames(p, b, &out);
    km_text_add(&out, "}");
  }
  km_text_add(&out, "], \"joints\": [");
  for (int i = 0; i < p->joints; ++i) {
    const planar_joint *j = &p->joint[i];
    char names[2][16];
    for (int k = 0; k < 2; ++k) {
      int body = k ? j->child : j->parent;
      snprintf(names[k], sizeof names[k], body ? "b%d" : "fixed", body);
    }
    km_text_format(
        &out, "%s{\"name\": \"J%d\", \"type\": \"%s\", \"body_frame_pairs\": [[\"%s\", \"j%d\"], [\"%s\", \"j%d\"]]",
        i ? ", " : "", i, j->slides ? "Tx" : "Rz", names[0], i, names[1], i);
    if (j->coefficient > 0.0 && j->slides)
      km_text_format(&out, ", \"friction\": {\"coefficient\": %.17g}", j->coefficient);
    if (j->coefficient > 0.0 && !j->slides)
      km_text_format(&out, ", \"friction\": {\"coefficient\": %.17g, \"radius\": %.17g}", j->coefficient, j->radius);
    km_text_add(&out, "}");
  }
  km_text_add(&out, "]}]}");
  return out.data;
}

/* Where a place of a body, or (moves false) a direction in it, has come to. */
static void moved(const planar *p, const fixture *f, int body, const double v[2], bool place, double out[2]) {
  const km_pose *X = &f->state->pose[body];
  km_vec3 in = planar_in_space(p, v), at = place ? km_pose_point(X, in) : km_rotate(&X->R, in);
  at = km_rotate_back(&p->plane, at);
  out[0] = at.x;
  out[1] = at.y;
}

/* Adds a force at a place, and a moment, on a body. */
static void push(double *column, int body, const double at[2], double x, double y, double moment) {
  if (body == 0)
    return;
  double *rows = column + 3 * (body - 1);
  rows[0] += x;
  rows[1] += y;
  rows[2] += at[0] * y - at[1] * x + moment;
}

/* A force on a joint's child, and its opposite on the parent. */
static void pair(double *column, const planar_joint *j, const double at[2], double x, double y, double moment) {
  push(column, j->child, at, x, y, moment);
  push(column, j->parent, at, -x, -y, -moment);
}

void planar_balance_at(const planar *p, const fixture *f, const double gravity[2], const planar_load *loads, int count,
                       planar_balance *out) {
  *out = (planar_balance){.rows = 3 * p->bodies};
  size_t rows = (size_t)out->rows;
  km_poses_compute(f->mechanism, f->state);
  for (int i = 0; i < p->joints; ++i) {
    const planar_joint *j = &p->joint[i];
    double *first = out->A + 2 * (size_t)i * rows, *second = first + rows;
    double *act = out->A + (size_t)(2 * p->joints + i) * rows, at[2], u[2];
    moved(p, f, j->child, j->place, true, at);
    moved(p, f, j->parent, j->along, false, u);
    pair(first, j, at, j->slides ? -u[1] : 1.0, j->slides ? u[0] : 0.0, 0.0);
    pair(second, j, at, 0.0, j->slides ? 0.0 : 1.0, j->slides ? 1.0 : 0.0);
    pair(act, j, at, j->slides ? u[0] : 0.0, j->slides ? u[1] : 0.0, j->slides ? 0.0 : 1.0);
  }
  for (int b = 1; b <= p->bodies && gravity; ++b) {
    double at[2];
    moved(p, f, b, p->centre[b - 1], true, at);
    push(out->load, b, at, p->mass[b - 1] * gravity[0], p->mass[b - 1] * gravity[1], 0.0);
  }
  for (int i = 0; i < count; ++i) {
    double at[2];
    moved(p, f, loads[i].body, loads[i].place, true, at);
    push(out->load, loads[i].body, at, loads[i].force[0], loads[i].force[1], 0.0);
  }
}

void planar_rates(const planar *p, const planar_balance *b, double *rates) {
  enum { MOST = PLANAR_MOST_SIZE };
  int n = b->rows, reactions = 2 * p->joints;
  double T[MOST * MOST], V[MOST * MOST], s[MOST], super[MOST], U[1];
  for (int i = 0; i < reactions; ++i)
    for (int k = 0; k < n; ++k)
      T[k * reactions + i] = b->A[i * n + k];
  LAPACKE_dgesvd(LAPACK_COL_MAJOR, 'N', 'A', reactions, n, T, reactions, s, U, 1, V, n, super);
  double largest = 0.0;
  for (int i = 0; i < p->joints; ++i) {
    rates[i] = 0.0;
    for (int k = 0; k < n; ++k)
      rates[i] += b->A[(reactions + i) * n + k] * V[k * n + n - 1];
    largest = fmax(largest, fabs(rates[i]));
  }
  for (int i = 0; i < p->joints; ++i)
    rates[i] /= largest;
}

double planar_determinant(double *a, int n) {
  lapack_int pivots[PLANAR_MOST_SIZE];
  double det = 1.0;
  LAPACKE_dgetrf(LAPACK_COL_MAJOR, n, n, a, n, pivots);
  for (int i = 0; i < n; ++i)
    det *= (pivots[i] != i + 1 ? -1.0 : 1.0) * a[i * n + i];
  return det;
}
