/* Cause of a dead point of the driver (theory 10.5): loops and joints.
 *
 *   J = [j_d  J'] : the six rows of every loop (full_jacobian.h), j_d the driver's column, J' the others
 *   dead point    : J' loses a row rank that j_d needs: a left null vector w of J' with w · j_d ≠ 0
 *   w ~ (J' J'ᵀ + ε² I)⁻¹ j_d, ε above the smallest singular value that remains at a located end: other directions have
 *       1/σ² of it, and persistent redundancies are orthogonal to j_d
 *   net wrench of a joint : Σ ± w_l over the loops l through it, reciprocal to its motions
 *
 * w is the self-stress that the driver's force would cause without bound: links that transmit it by a force along the
 * line through their hinges are in line. */
#include "sweep/stop_cause.h"

#include "base/number/vectors.h"
#include "base/text.h"
#include "kinematics/body_poses.h"
#include "mobility/full_jacobian.h"

#include <gsl/gsl_linalg.h>
#include <stdio.h>
#include <string.h>

enum { MAX_ROWS = 240, MAX_NAMES = 8 };
/* ε over the largest entry: an end is located to 1e-9, whose root is 3e-5. Smaller parts of the largest net wrench come
 * from it. */
static const double damping = 1e-3;
static const double alignment = 1e-2; /* relative to the substructure's size; sine of a force's direction */

typedef struct joint_wrench {
  km_vec3 force, moment, position; /* moment about `place`, over the size */
} joint_wrench;

typedef struct dead_point {
  const km_mechanism *m;
  const km_state *s;
  const km_substructure *sub;
  int index, driver, rows;
  km_vec3 about;
  km_arena arena;
  double *w;           /* [rows] */
  joint_wrench *joint; /* [joint count of the model] */
} dead_point;

/* Computes w, of length 1; false if the equations are singular. */
static bool find_self_stress(dead_point *c) {
  const km_mechanism *m = c->m;
  size_t rows = (size_t)c->rows, columns = (size_t)c->sub->columns;
  km_twist *twist = KM_ARENA_NEW(&c->arena, km_twist, (size_t)m->coordinate_count);
  double *J = KM_ARENA_NEW(&c->arena, double, rows *columns), *A = KM_ARENA_NEW(&c->arena, double, rows *rows);
  double largest = 0.0;
  c->w = KM_ARENA_NEW(&c->arena, double, rows);
  if (c->arena.failed)
    return false;
  for (size_t k = 0; k < columns; ++k) {
    int q = m->column_coordinate[c->sub->column_start + (int)k];
    twist[q] = km_coordinate_twist(m, c->s, q);
  }
  km_full_jacobian(m, c->s, c->index, twist, c->about, 1, rows, J);
  for (size_t k = 0; k < columns; ++k) {
    const double *column = J + k * rows;
    if (m->column_coordinate[c->sub->column_start + (int)k] == c->driver) {
      memcpy(c->w, column, rows * sizeof *column);
      continue;
    }
    for (size_t r = 0; r < rows; ++r)
      for (size_t l = 0; l < rows; ++l)
        A[r * rows + l] += column[r] * column[l];
  }
  for (size_t r = 0; r < rows; ++r)
    largest = fmax(largest, A[r * rows + r]);
  for (size_t r = 0; r < rows; ++r)
    A[r * rows + r] += damping * damping * largest;
  gsl_matrix_view view = gsl_matrix_view_array(A, rows, rows);
  gsl_vector_view w = gsl_vector_view_array(c->w, rows);
  if (!(largest > 0.0) || gsl_linalg_cholesky_decomp1(&view.matrix) || gsl_linalg_cholesky_svx(&view.matrix, &w.vector))
    return false;
  double length = km_norm(c->w, c->rows);
  for (size_t r = 0; r < rows; ++r)
    c->w[r] /= length;
  return length > 0.0 && isfinite(length);
}

/* Computes the net wrench in every joint of the loops, moments about the joint. */
static bool find_joint_wrenches(dead_point *c) {
  const km_topology *t = &c->m->topology;
  c->joint = KM_ARENA_NEW(&c->arena, joint_wrench, (size_t)c->m->model->joint_count);
  for (int k = t->joint_start[c->index]; c->joint && k < t->joint_start[c->index + 1]; ++k) {
    joint_wrench *n = &c->joint[t->joint[k]];
    n->position = km_joint_pose(c->m, c->s, t->joint[k]).p;
    km_vec3 arm = km_vec3_scale(1.0 / c->sub->size, km_vec3_axpy(-1.0, n->position, c->about));
    for (int i = t->joint_loop_start[t->joint[k]]; i < t->joint_loop_start[t->joint[k] + 1]; ++i) {
      const double *w = c->w + 6 * t->joint_loop[i].loop, sign = t->joint_loop[i].sign;
      km_vec3 force = km_vec3_from_array(w), moment = km_vec3_from_array(w + 3);
      n->force = km_vec3_axpy(sign, force, n->force);
      n->moment = km_vec3_axpy(sign, km_vec3_add(moment, km_vec3_cross(arm, force)), n->moment);
    }
  }
  return c->joint != NULL;
}

static double size_of(const joint_wrench *n) {
  return km_vec3_norm(n->force) + km_vec3_norm(n->moment);
}

/* Lists the joints with a significant net wrench, except the driver's, in the substructure's order; returns their
 * number. */
static int list_joints(const dead_point *c, int *out) {
  const km_topology *t = &c->m->topology;
  double largest = 0.0;
  int count = 0, driver_joint = c->m->model->coordinates[c->driver].joint;
  for (int k = t->joint_start[c->index]; k < t->joint_start[c->index + 1]; ++k)
    largest = fmax(largest, size_of(&c->joint[t->joint[k]]));
  for (int k = t->joint_start[c->index]; k < t->joint_start[c->index + 1]; ++k) {
    int j = t->joint[k];
    bool moves = km_model_freedom(c->m->model, j) > 0 && !c->m->held[c->m->model->joints[j].first_coordinate];
    if (j != driver_joint && moves && size_of(&c->joint[j]) > damping * largest)
      out[count++] = j;
  }
  return count;
}

static bool is_rotational(const km_model *model, int joint) {
  km_joint_type type = model->joints[joint].type;
  return type == KM_RX || type == KM_RY || type == KM_RZ || type == KM_SPHERICAL || type == KM_UNIVERSAL;
}

/* True if all these joints lie on the line of one force. Hinges count where the plane is pierced by their axis. */
static bool are_in_line(const dead_point *c, const int *joint, int count) {
  const km_model *model = c->m->model;
  const joint_wrench *first = &c->joint[joint[0]];
  double size = km_vec3_norm(first->force);
  km_vec3 along = km_vec3_scale(1.0 / size, first->force);
  if (count < 3 || !(size > 0.0))
    return false;
  for (int i = 0; i < count; ++i) {
    const joint_wrench *n = &c->joint[joint[i]];
    int q = model->joints[joint[i]].first_coordinate;
    bool is_hinge = is_rotational(model, joint[i]) && km_model_freedom(model, joint[i]) == 1;
    km_vec3 distance = km_vec3_axpy(-1.0, first->position, n->position), axis = km_coordinate_twist(c->m, c->s, q).w;
    if (!is_rotational(model, joint[i]))
      return false;
    if (is_hinge)
      distance = km_vec3_axpy(-km_vec3_dot(distance, axis), axis, distance);
    km_vec3 offset = km_vec3_axpy(-km_vec3_dot(distance, along), along, distance);
    if (km_vec3_norm(km_vec3_cross(n->force, along)) > alignment * size ||
        km_vec3_norm(offset) > alignment * c->sub->size)
      return false;
  }
  return true;
}

/* Lists the bodies that carry two of the joints; returns their number. */
static int list_links(const dead_point *c, const int *joint, int count, int *out) {
  const km_model *model = c->m->model;
  int found = 0;
  for (int b = 1; b < model->body_count; ++b) {
    int is_last = 0;
    for (int i = 0; i < count; ++i)
      for (int e = 0; e < 2; ++e)
        is_last += km_joint_body(model, joint[i], e) == b;
    if (is_last >= 2)
      out[found++] = b;
  }
  return found;
}

static void add_name(km_text *out, int position, int count, const char *name) {
  if (position < MAX_NAMES)
    km_text_format(out, "%s%.80s", position == 0 ? "" : position == count - 1 ? " and " : ", ", name);
  else if (position == MAX_NAMES)
    km_text_format(out, " and %d more", count - MAX_NAMES);
}

static void write_description(const dead_point *c, const int *joint, int count, int *link, km_text *out) {
  const km_model *model = c->m->model;
  bool in_line = are_in_line(c, joint, count);
  int links = in_line ? list_links(c, joint, count, link) : 0, loops = 0, position = 0;
  double largest = km_max_norm(c->w, 6 * c->sub->loop_count);
  km_text joints = {0}, where = {0};
  for (int i = 0; i < count; ++i)
    add_name(&joints, i, count, model->joints[joint[i]].label);
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < c->sub->loop_count; ++i) {
      char number[16];
      if (!(km_max_norm(c->w + 6 * i, 6) > damping * largest))
        continue;
      loops += pass == 0;
      snprintf(number, sizeof number, "%d", c->m->topology.loop[c->m->topology.loop_start[c->index] + i] + 1);
      if (pass == 1)
        add_name(&where, position++, loops, number);
    }
  km_text_add(out, links > 1 ? "links " : "");
  for (int i = 0; i < links && links > 1; ++i)
    add_name(out, i, links, model->bodies[link[i]].name);
  if (links > 1)
    km_text_format(out, " of loop%s %s are in line (joints %s)", loops == 1 ? "" : "s", where.data ? where.data : "",
                   joints.data ? joints.data : "");
  else
    km_text_format(out, "%sjoints %s of loop%s %s %s", in_line ? "" : "the axes of ", joints.data ? joints.data : "",
                   loops == 1 ? "" : "s", where.data ? where.data : "",
                   in_line ? "are in line" : "have become dependent");
  out->failed = out->failed || joints.failed || where.failed;
  km_text_free(&joints);
  km_text_free(&where);
}

char *km_stop_cause(const km_mechanism *m, km_state *s, int substructure, int driver) {
  const km_substructure *sub = &m->substructures[substructure];
  dead_point c = {.m = m, .s = s, .sub = sub, .index = substructure, .driver = driver};
  km_text out = {0};
  c.rows = 6 * sub->loop_count + sub->coupling_count;
  if (c.rows > MAX_ROWS || sub->loop_count == 0)
    return NULL;
  km_poses_compute(m, s);
  c.about = km_joint_pose(m, s, m->model->coordinates[driver].joint).p;
  int *joint = KM_ARENA_NEW(&c.arena, int, (size_t)m->model->joint_count);
  int *link = KM_ARENA_NEW(&c.arena, int, (size_t)m->model->body_count);
  if (!c.arena.failed && find_self_stress(&c) && find_joint_wrenches(&c)) {
    int count = list_joints(&c, joint);
    if (count > 0)
      write_description(&c, joint, count, link, &out);
  }
  km_arena_free(&c.arena);
  if (out.failed)
    km_text_free(&out);
  return out.data;
}
