/* The loops and joints that stop a driver at its dead point.
 *
 *   J = [j_d  J'] : the six rows of every loop (full_jacobian.h), j_d the driver's column, J' the others
 *   dead point    : J' loses a row rank that j_d needs: a left null vector w of J' with w · j_d ≠ 0
 *   w ~ (J' J'ᵀ + ε² I)⁻¹ j_d, ε above the smallest singular value that is left at a located end: other directions have 1/σ² of it,
 *        and what is redundant for all motions is orthogonal to j_d
 *   net wrench of a joint : Σ ± w_l over the loops l through it, reciprocal to its motions
 *
 * w is the self-stress that the driver's force would cause without bound: links that carry it by a force along the line through
 * their hinges are in line. */
#include "sweep/stop_cause.h"

#include "base/text.h"
#include "kinematics/body_poses.h"
#include "mobility/full_jacobian.h"

#include <gsl/gsl_linalg.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ROWS = 240, MOST_NAMED = 8 };
static const double damping = 1e-3;  /* ε over the largest entry: an end is located to 1e-9, whose root is 3e-5 */
static const double part = 1e-3;     /* of the largest net wrench: less is what the damping leaves */
static const double straight = 1e-2; /* of the substructure's size, and of a force's direction */

typedef struct net {
  km_vec3 force, moment, place; /* moment about the place, over the size */
} net;

typedef struct cause {
  const km_mechanism *m;
  const km_state *s;
  const km_substructure *sub;
  int index, driver, rows;
  km_vec3 about;
  km_arena arena;
  double *w;  /* [rows] */
  net *joint; /* [joint count of the model] */
} cause;

/* w, of length 1; false where the equations can't be solved. */
static bool find_vector(cause *c) {
  const km_mechanism *m = c->m;
  size_t rows = (size_t)c->rows, columns = (size_t)c->sub->columns;
  km_twist *twist = KM_ARENA_NEW(&c->arena, km_twist, (size_t)m->coordinate_count);
  double *J = KM_ARENA_NEW(&c->arena, double, rows *columns), *A = KM_ARENA_NEW(&c->arena, double, rows *rows);
  double largest = 0.0, square = 0.0;
  c->w = KM_ARENA_NEW(&c->arena, double, rows);
  if (c->arena.failed)
    return false;
  for (size_t k = 0; k < columns; ++k) {
    int q = m->column_coordinate[c->sub->column_start + (int)k];
    twist[q] = km_coordinate_twist(m, c->s, q);
  }
  km_full_jacobian(m, c->s, c->index, twist, c->about, J);
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
  for (size_t r = 0; r < rows; ++r)
    square += c->w[r] * c->w[r];
  for (size_t r = 0; r < rows; ++r)
    c->w[r] /= sqrt(square);
  return square > 0.0 && isfinite(square);
}

/* The net wrench in every joint of the loops, the moment about the joint. */
static bool find_nets(cause *c) {
  const km_topology *t = &c->m->topology;
  c->joint = KM_ARENA_NEW(&c->arena, net, (size_t)c->m->model->joint_count);
  for (int i = 0; c->joint && i < c->sub->loop_count; ++i) {
    int loop = t->loop[t->loop_start[c->index] + i];
    km_vec3 force = km_vec3_from_array(c->w + 6 * i), moment = km_vec3_from_array(c->w + 6 * i + 3);
    for (int k = t->member_start[loop]; k < t->member_start[loop + 1]; ++k) {
      net *n = &c->joint[t->member[k].joint];
      double sense = km_member_sign(&t->member[k]);
      n->place = km_joint_pose(c->m, c->s, t->member[k].joint).p;
      km_vec3 arm = km_vec3_scale(1.0 / c->sub->size, km_vec3_axpy(-1.0, n->place, c->about));
      n->force = km_vec3_axpy(sense, force, n->force);
      n->moment = km_vec3_axpy(sense, km_vec3_add(moment, km_vec3_cross(arm, force)), n->moment);
    }
  }
  return c->joint != NULL;
}

static double size_of(const net *n) {
  return km_vec3_norm(n->force) + km_vec3_norm(n->moment);
}

/* Joints that carry a part of it, without the driver's, in the substructure's order. Returns their number. */
static int list_joints(const cause *c, int *out) {
  const km_topology *t = &c->m->topology;
  double largest = 0.0;
  int count = 0, own = c->m->model->coordinates[c->driver].joint;
  for (int k = t->joint_start[c->index]; k < t->joint_start[c->index + 1]; ++k)
    largest = fmax(largest, size_of(&c->joint[t->joint[k]]));
  for (int k = t->joint_start[c->index]; k < t->joint_start[c->index + 1]; ++k) {
    int j = t->joint[k];
    bool moves = km_model_freedom(c->m->model, j) > 0 && !c->m->held[c->m->model->joints[j].first_coordinate];
    if (j != own && moves && size_of(&c->joint[j]) > part * largest)
      out[count++] = j;
  }
  return count;
}

static bool turns(const km_model *model, int joint) {
  km_joint_type type = model->joints[joint].type;
  return type == KM_RX || type == KM_RY || type == KM_RZ || type == KM_SPHERICAL || type == KM_UNIVERSAL;
}

/* True if all these joints lie on the line of one force. In a plane hinges count where they pierce it. */
static bool are_in_line(const cause *c, const int *joint, int count) {
  const km_model *model = c->m->model;
  const net *first = &c->joint[joint[0]];
  double size = km_vec3_norm(first->force);
  km_vec3 along = km_vec3_scale(1.0 / size, first->force);
  if (count < 3 || !(size > 0.0))
    return false;
  for (int i = 0; i < count; ++i) {
    const net *n = &c->joint[joint[i]];
    int q = model->joints[joint[i]].first_coordinate;
    bool is_hinge = turns(model, joint[i]) && km_model_freedom(model, joint[i]) == 1;
    km_vec3 away = km_vec3_axpy(-1.0, first->place, n->place), axis = km_coordinate_twist(c->m, c->s, q).w;
    if (!turns(model, joint[i]))
      return false;
    if (is_hinge)
      away = km_vec3_axpy(-km_vec3_dot(away, axis), axis, away);
    km_vec3 beside = km_vec3_axpy(-km_vec3_dot(away, along), along, away);
    if (km_vec3_norm(km_vec3_cross(n->force, along)) > straight * size ||
        km_vec3_norm(beside) > straight * c->sub->size)
      return false;
  }
  return true;
}

/* Bodies that two of the joints are on. Returns their number. */
static int list_links(const cause *c, const int *joint, int count, int *out) {
  const km_model *model = c->m->model;
  int found = 0;
  for (int b = 1; b < model->body_count; ++b) {
    int ends = 0;
    for (int i = 0; i < count; ++i)
      for (int e = 0; e < 2; ++e)
        ends += model->frames[model->joints[joint[i]].frame[e]].body == b;
    if (ends >= 2)
      out[found++] = b;
  }
  return found;
}

static void add_name(km_text *out, int place, int count, const char *name) {
  if (place < MOST_NAMED)
    km_text_format(out, "%s%.80s", place == 0 ? "" : place == count - 1 ? " and " : ", ", name);
  else if (place == MOST_NAMED)
    km_text_format(out, " and %d more", count - MOST_NAMED);
}

static void describe(const cause *c, const int *joint, int count, int *link, km_text *out) {
  const km_model *model = c->m->model;
  bool in_line = are_in_line(c, joint, count);
  int links = in_line ? list_links(c, joint, count, link) : 0, loops = 0, place = 0;
  double largest = 0.0;
  for (int r = 0; r < 6 * c->sub->loop_count; ++r)
    largest = fmax(largest, fabs(c->w[r]));
  km_text joints = {0}, where = {0};
  for (int i = 0; i < count; ++i)
    add_name(&joints, i, count, model->joints[joint[i]].label);
  for (int pass = 0; pass < 2; ++pass)
    for (int i = 0; i < c->sub->loop_count; ++i) {
      double most = 0.0;
      char number[16];
      for (int r = 0; r < 6; ++r)
        most = fmax(most, fabs(c->w[6 * i + r]));
      if (!(most > part * largest))
        continue;
      loops += pass == 0;
      snprintf(number, sizeof number, "%d", c->m->topology.loop[c->m->topology.loop_start[c->index] + i] + 1);
      if (pass == 1)
        add_name(&where, place++, loops, number);
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
  cause c = {.m = m, .s = s, .sub = sub, .index = substructure, .driver = driver};
  km_text out = {0};
  c.rows = 6 * sub->loop_count + sub->coupling_count;
  if (c.rows > MOST_ROWS || sub->loop_count == 0)
    return NULL;
  km_poses_compute(m, s);
  c.about = km_joint_pose(m, s, m->model->coordinates[driver].joint).p;
  int *joint = KM_ARENA_NEW(&c.arena, int, (size_t)m->model->joint_count);
  int *link = KM_ARENA_NEW(&c.arena, int, (size_t)m->model->body_count);
  if (!c.arena.failed && find_vector(&c) && find_nets(&c)) {
    int count = list_joints(&c, joint);
    if (count > 0)
      describe(&c, joint, count, link, &out);
  }
  km_arena_free(&c.arena);
  if (out.failed)
    km_text_free(&out);
  return out.data;
}
