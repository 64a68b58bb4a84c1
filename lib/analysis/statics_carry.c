/* What every joint carries: Jᵀ μ = f + τ for the wrenches μ of the loops' chords, then down the tree. */
#include "analysis/statics.h"
#include "analysis/whole_jacobian.h"
#include "kinematics/closure.h"
#include "kinematics/loops.h"

#include <string.h>

/* Up to so many rows dense matrices are the faster ones. */
enum { MOST_DENSE_ROWS = 120 };

static void reserve_dense(km_carrying *c, km_arena *arena) {
  size_t rows = (size_t)c->rows, columns = (size_t)c->columns, parts = 6 * (size_t)c->joints;
  c->J = KM_ARENA_NEW(arena, double, rows *columns);
  c->T = KM_ARENA_NEW(arena, double, rows *columns);
  c->rhs = KM_ARENA_NEW(arena, double, columns);
  c->mu = KM_ARENA_NEW(arena, double, rows);
  c->null = KM_ARENA_NEW(arena, double, rows *rows);
  c->field = KM_ARENA_NEW(arena, double, rows *parts);
  c->ones = KM_ARENA_NEW(arena, double, rows);
  for (size_t r = 0; r < rows && c->ones; ++r)
    c->ones[r] = 1.0;
  km_partition_reserve(&c->partition, c->columns, c->rows, arena);
}

static km_status reserve_one(const km_mechanism *m, km_statics_work *w, int index, km_error *error) {
  const km_topology *t = &m->topology;
  const km_substructure *sub = &m->substructures[index];
  km_carrying *c = &w->carrying[index];
  c->rows = 6 * sub->loop_count + sub->coupling_count;
  c->columns = sub->columns;
  c->joints = t->joint_start[index + 1] - t->joint_start[index];
  for (int j = 0; j < c->joints; ++j)
    w->place[t->joint[t->joint_start[index] + j]] = j;
  c->carried = KM_ARENA_NEW(&w->arena, double, 6 * (size_t)c->joints);
  if (c->rows > MOST_DENSE_ROWS) {
    c->mixed = KM_ARENA_NEW(&w->arena, bool, 6 * (size_t)c->joints);
    return km_equilibrium_create(m, index, &c->large, error);
  }
  reserve_dense(c, &w->arena);
  return KM_OK;
}

km_status km_carrying_reserve(const km_mechanism *m, km_statics_work *w, km_error *error) {
  const km_topology *t = &m->topology;
  km_arena *arena = &w->arena;
  km_status status = KM_OK;
  w->carrying = KM_ARENA_NEW(arena, km_carrying, (size_t)t->substructure_count);
  w->frame = KM_ARENA_NEW(arena, km_pose, (size_t)t->joint_count);
  w->place = KM_ARENA_NEW(arena, int, (size_t)t->joint_count);
  for (int i = 0; i < t->substructure_count && !arena->failed && !status; ++i)
    status = reserve_one(m, w, i, error);
  return status || !arena->failed ? status : km_fail(error, KM_MEMORY, "out of memory for the reactions");
}

void km_carrying_free(km_statics_work *w) {
  for (int i = 0; w->carrying && i < w->mechanism->topology.substructure_count; ++i)
    km_equilibrium_free(w->carrying[i].large);
}

/* The frame that a reaction is reported in. */
static km_pose report_frame(const km_mechanism *m, const km_forces *f, int joint, km_axes axes) {
  const km_model_frame *frame = &m->model->frames[m->model->joints[joint].frame[1]];
  km_pose X = km_pose_product(&f->pose[frame->body], &frame->pose);
  if (axes == KM_AXES_FIXED)
    X.R = km_rotation_identity();
  return X;
}

static void reported(const km_pose *frame, km_wrench w, double out[6]) {
  w = km_wrench_turned_back(&frame->R, km_wrench_about(w, frame->p));
  const double values[6] = {w.f.x, w.f.y, w.f.z, w.t.x, w.t.y, w.t.z};
  memcpy(out, values, sizeof values);
}

/* What a tree joint carries without any loop: its parent holds all that hangs on the child. */
static km_wrench from_tree(const km_mechanism *m, const km_statics_work *w, int joint) {
  const km_model_joint *def = &m->model->joints[joint];
  bool against = m->topology.against[joint];
  int body = m->model->frames[def->frame[!against]].body;
  if (m->topology.arc[body] != joint)
    return (km_wrench){{0, 0, 0}, {0, 0, 0}}; /* a chord */
  return km_wrench_axpy(against ? 1.0 : -1.0, w->subtree[body], (km_wrench){{0, 0, 0}, {0, 0, 0}});
}

/* The wrench of six scaled entries (f · size; τ about `about`), about the origin. */
static km_wrench unscaled(const km_substructure *sub, const double *mu, km_vec3 about) {
  km_wrench w = {km_vec3_scale(1.0 / sub->size, km_vec3_make(mu)), km_vec3_make(mu + 3)};
  return (km_wrench){w.f, km_vec3_add(w.t, km_vec3_cross(about, w.f))};
}

/* What the chords' wrenches do in every joint of the substructure, added to out[6 · joints]. */
static void spread(const km_mechanism *m, const km_statics_work *w, int index, km_vec3 about, const double *mu,
                   double *out) {
  const km_topology *t = &m->topology;
  for (int i = t->loop_start[index]; i < t->loop_start[index + 1]; ++i) {
    int loop = t->loop[i];
    km_wrench wrench = unscaled(&m->substructures[index], mu + 6 * (i - t->loop_start[index]), about);
    for (int n = t->member_start[loop]; n < t->member_start[loop + 1]; ++n) {
      int joint = t->member[n].joint;
      double part[6], sense = km_member_sense(&t->member[n]);
      reported(&w->frame[joint], wrench, part);
      for (int k = 0; k < 6; ++k)
        out[6 * w->place[joint] + k] += sense * part[k];
    }
  }
}

/* f·f' + τ·τ'/L² over all joints. */
static double product(const km_carrying *c, double length, const double *a, const double *b) {
  double forces = 0.0, torques = 0.0;
  for (int j = 0; j < c->joints; ++j)
    for (int k = 0; k < 3; ++k) {
      forces += a[6 * j + k] * b[6 * j + k];
      torques += a[6 * j + 3 + k] * b[6 * j + 3 + k];
    }
  return forces + torques / (length * length);
}

static void subtract(const km_carrying *c, double factor, const double *b, double *a) {
  for (int k = 0; k < 6 * c->joints; ++k)
    a[k] -= factor * b[k];
}

/* Takes the self-stresses out of what is carried: what remains is of least norm. One that lies in couplings alone
 * stresses no joint. */
static void make_least(const km_carrying *c, int degree, double length) {
  size_t parts = 6 * (size_t)c->joints;
  double largest = 0.0;
  for (int k = 0; k < degree; ++k)
    largest = fmax(largest, product(c, length, c->field + (size_t)k * parts, c->field + (size_t)k * parts));
  for (int k = 0; k < degree; ++k) {
    double *field = c->field + (size_t)k * parts;
    for (int pass = 0; pass < 2; ++pass)
      for (int o = 0; o < k; ++o)
        subtract(c, product(c, length, c->field + (size_t)o * parts, field), c->field + (size_t)o * parts, field);
    double square = product(c, length, field, field), size = square > 1e-18 * largest ? sqrt(square) : HUGE_VAL;
    for (size_t i = 0; i < parts; ++i)
      field[i] /= size;
  }
  for (int pass = 0; pass < 2; ++pass)
    for (int k = 0; k < degree; ++k) {
      const double *field = c->field + (size_t)k * parts;
      subtract(c, product(c, length, field, c->carried), field, c->carried);
    }
}

/* A component is determined if no self-stress has a part in it. */
static void mark(const km_mechanism *m, const km_carrying *c, int index, int degree, km_statics *st) {
  double size = m->substructures[index].size;
  size_t parts = 6 * (size_t)c->joints;
  for (int k = 0; k < degree; ++k) {
    const double *field = c->field + (size_t)k * parts;
    double largest = 0.0;
    for (size_t i = 0; i < parts; ++i)
      largest = fmax(largest, fabs(field[i]) / (i % 6 < 3 ? 1.0 : size));
    for (size_t i = 0; i < parts; ++i)
      if (fabs(field[i]) / (i % 6 < 3 ? 1.0 : size) > km_no_part * largest)
        st->reactions[m->topology.joint[m->topology.joint_start[index] + (int)(i / 6)]].indeterminate[i % 6] = true;
  }
}

static double tolerance_of(const km_mechanism *m, const km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  int worst;
  return km_rank_tolerance(m, sub, km_loops_residual(m, s, sub, &worst));
}

/* Chord wrenches of one substructure, and the self-stresses that leave every joint free of force along its motion. */
static int solve_chords(const km_mechanism *m, const km_state *s, int index, km_vec3 about, km_statics_work *w) {
  const km_substructure *sub = &m->substructures[index];
  km_carrying *c = &w->carrying[index];
  km_whole_jacobian(m, s, index, w->twist, about, c->J);
  for (int r = 0; r < c->rows; ++r)
    for (int k = 0; k < c->columns; ++k)
      c->T[(size_t)r * (size_t)c->columns + (size_t)k] = c->J[(size_t)k * (size_t)c->rows + (size_t)r];
  for (int k = 0; k < c->columns; ++k) { /* τ holds the force of a spring in the joint already */
    int coordinate = m->column_coordinate[sub->column_start + k];
    c->rhs[k] = m->unit[coordinate] * (w->force[coordinate] + w->tau[coordinate]);
  }
  km_partition_factor(&c->partition, c->T, c->columns, c->rows, NULL, tolerance_of(m, s, index));
  km_partition_solve(&c->partition, c->rhs, c->mu);
  int degree = km_partition_freedom(&c->partition);
  km_partition_null(&c->partition, c->ones, degree, c->null);
  return degree;
}

static void carry_small(const km_mechanism *m, const km_state *s, const km_forces *f, int index, km_statics *st) {
  const km_topology *t = &m->topology;
  km_statics_work *w = st->work;
  km_carrying *c = &w->carrying[index];
  const km_model_frame *frame = &m->model->frames[m->model->joints[t->joint[t->joint_start[index]]].frame[0]];
  km_vec3 about = km_pose_point(&f->pose[frame->body], frame->pose.p);
  int degree = solve_chords(m, s, index, about, w);
  st->degree += degree;
  spread(m, w, index, about, c->mu, c->carried);
  memset(c->field, 0, (size_t)degree * 6 * (size_t)c->joints * sizeof *c->field);
  for (int k = 0; k < degree; ++k)
    spread(m, w, index, about, c->null + (size_t)k * (size_t)c->rows, c->field + (size_t)k * 6 * (size_t)c->joints);
  make_least(c, degree, m->length);
  mark(m, c, index, degree, st);
}

/* Without memory nothing is known of its joints. */
static void carry_large(const km_mechanism *m, const km_state *s, int index, km_statics *st) {
  km_carrying *c = &st->work->carrying[index];
  const int *joint = m->topology.joint + m->topology.joint_start[index];
  memset(c->mixed, 0, 6 * (size_t)c->joints * sizeof *c->mixed);
  int degree = km_equilibrium_solve(c->large, st->work, s, tolerance_of(m, s, index), c->carried, c->mixed);
  for (int i = 0; i < 6 * c->joints; ++i) {
    st->reactions[joint[i / 6]].indeterminate[i % 6] = c->mixed[i];
    if (degree < 0)
      c->carried[i] = nan("");
  }
  st->degree += degree > 0 ? degree : 0;
}

static void carry_substructure(const km_mechanism *m, const km_state *s, const km_forces *f, int index,
                               km_statics *st) {
  km_statics_work *w = st->work;
  km_carrying *c = &w->carrying[index];
  const int *joint = m->topology.joint + m->topology.joint_start[index];
  for (int j = 0; j < c->joints; ++j)
    reported(&w->frame[joint[j]], from_tree(m, w, joint[j]), c->carried + 6 * j);
  if (c->large)
    carry_large(m, s, index, st);
  else
    carry_small(m, s, f, index, st);
  for (int j = 0; j < c->joints; ++j) {
    km_reaction *r = &st->reactions[joint[j]];
    memcpy(r->force, c->carried + 6 * j, sizeof r->force);
    memcpy(r->torque, c->carried + 6 * j + 3, sizeof r->torque);
  }
}

void km_statics_carry(const km_mechanism *m, km_state *s, const km_forces *f, km_statics *st) {
  st->degree = 0;
  for (int j = 0; j < m->topology.joint_count; ++j) {
    double part[6];
    st->work->frame[j] = report_frame(m, f, j, st->axes);
    st->reactions[j] = (km_reaction){{0}, {0}, {0}};
    reported(&st->work->frame[j], from_tree(m, st->work, j), part);
    memcpy(st->reactions[j].force, part, sizeof st->reactions[j].force);
    memcpy(st->reactions[j].torque, part + 3, sizeof st->reactions[j].torque);
  }
  for (int i = 0; i < m->topology.substructure_count; ++i)
    carry_substructure(m, s, f, i, st);
}

km_vec3 km_normal_force(const km_mechanism *m, const km_statics *st, int c) {
  const km_twist *h = &st->work->twist[c];
  km_vec3 force = km_vec3_make(st->reactions[m->model->coordinates[c].joint].force);
  bool turns = km_vec3_norm(h->w) > 0.5;
  km_vec3 axis = turns ? h->w : h->v;
  bool all = m->ball_of[c] >= 0 || m->model->joints[m->model->coordinates[c].joint].type == KM_SCREW;
  return all ? force : km_vec3_axpy(-km_vec3_dot(force, axis), axis, force);
}
