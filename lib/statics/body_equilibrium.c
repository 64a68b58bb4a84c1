/* Reactions of a large substructure: the equilibrium of every body, and what its free motions leave a joint. A wrench r
 * of each joint is unknown. A r = A r₀ for the bodies, r₀ what the tree carries; h_k · (r − r₀) = f_k + τ_k along the
 * free motions. Coupled motions share a force of unknown size: of their equations only those combinations count that it
 * has no part in. The answer of least Σ |force|² + |torque / L|² is Gᵀ's by Q R. */
#include "base/random.h"
#include "statics/statics.h"

#include "kinematics/loop_equations.h"
#include "linalg/sparse/sparse_qr.h"

#include <string.h>

enum { LOOKS = 3 }; /* random self-stresses that are looked at */

typedef struct km_body_equilibrium {
  const km_mechanism *m;
  const km_substructure *sub;
  int index, joints, bodies;
  const int *joint, *body; /* those of the substructure; bodies whose arc lies in it */
  km_arena arena;
  int *place;       /* [body of the mechanism] among `bodies`; -1 */
  int *head, *tail; /* [joint] its bodies' places; -1: what the substructure hangs on */
  bool *coupled;    /* [column] */
  int coupled_count;
  int *coupled_column;    /* [coupled_count] */
  double *K, *free;       /* [coupled × couplings] and its left null vectors [coupled × coupled] */
  double *one;            /* [coupled] */
  km_partition couplings; /* of Kᵀ */
  int free_count;         /* combinations that no coupling has a part in, at the last pose */
  km_sparse_qr *q;
  double *b, *x, *row; /* [equations], [6 · joints], [6 · joints] of one equation */
  int equations;       /* so many at the last pose */
} equilibrium;

static int body_of(const km_mechanism *m, int joint, int side) {
  return m->model->frames[m->model->joints[joint].frame[side]].body;
}

static void list_bodies(equilibrium *e) {
  for (int b = 0; b < e->m->topology.body_count; ++b)
    e->place[b] = -1;
  for (int i = 0; i < e->bodies; ++i)
    e->place[e->body[i]] = i;
  for (int j = 0; j < e->joints; ++j) {
    e->tail[j] = e->place[body_of(e->m, e->joint[j], 0)];
    e->head[j] = e->place[body_of(e->m, e->joint[j], 1)];
  }
}

/* Calls for every term of the couplings that has a column. */
static void find_coupled(equilibrium *e) {
  for (int i = 0; i < e->sub->coupling_count; ++i) {
    const km_coupling *coupling = &e->m->couplings[e->sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      int column = e->m->terms[coupling->term_start + k].column;
      if (column >= 0)
        e->coupled[column] = true;
    }
  }
  for (int k = 0; k < e->sub->columns; ++k)
    if (e->coupled[k])
      e->coupled_column[e->coupled_count++] = k;
}

static bool reserve(equilibrium *e) {
  const km_substructure *sub = e->sub;
  km_arena *arena = &e->arena;
  size_t columns = (size_t)sub->columns, unknown = 6 * (size_t)e->joints;
  e->place = KM_ARENA_NEW(arena, int, (size_t)e->m->topology.body_count);
  e->head = KM_ARENA_NEW(arena, int, (size_t)e->joints);
  e->tail = KM_ARENA_NEW(arena, int, (size_t)e->joints);
  e->coupled = KM_ARENA_NEW(arena, bool, columns);
  e->coupled_column = KM_ARENA_NEW(arena, int, columns);
  e->b = KM_ARENA_NEW(arena, double, 6 * (size_t)e->bodies + columns);
  e->x = KM_ARENA_NEW(arena, double, unknown);
  e->row = KM_ARENA_NEW(arena, double, unknown);
  if (arena->failed)
    return false;
  list_bodies(e);
  find_coupled(e);
  size_t coupled = (size_t)e->coupled_count;
  e->K = KM_ARENA_NEW(arena, double, coupled *(size_t)sub->coupling_count);
  e->free = KM_ARENA_NEW(arena, double, coupled *coupled);
  e->one = KM_ARENA_NEW(arena, double, coupled);
  for (size_t k = 0; k < coupled && e->one; ++k)
    e->one[k] = 1.0;
  return km_partition_reserve(&e->couplings, sub->coupling_count, e->coupled_count, arena) && !arena->failed;
}

/* A body's equations have 27 entries for each of its joints at most, a motion's 6 for each of its joints. */
static int most_entries(const equilibrium *e) {
  return 54 * e->joints + 6 * e->sub->columns + 6 * e->coupled_count * e->coupled_count;
}

km_status km_body_equilibrium_create(const km_mechanism *m, int index, equilibrium **out, km_error *error) {
  const km_topology *t = &m->topology;
  equilibrium *e = KM_NEW(equilibrium, 1);
  *out = e;
  if (!e)
    return km_fail(error, KM_MEMORY, "out of memory for the reactions");
  *e = (equilibrium){.m = m,
                     .sub = &m->substructures[index],
                     .index = index,
                     .joints = t->joint_start[index + 1] - t->joint_start[index],
                     .bodies = t->body_start[index + 1] - t->body_start[index],
                     .joint = t->joint + t->joint_start[index],
                     .body = t->body + t->body_start[index]};
  if (!reserve(e))
    return km_fail(error, KM_MEMORY, "out of memory for the reactions");
  return km_sparse_qr_create(6 * e->joints, 6 * e->bodies + e->sub->columns, most_entries(e), &e->q, error);
}

void km_body_equilibrium_free(equilibrium *e) {
  if (!e)
    return;
  km_sparse_qr_free(e->q);
  km_arena_free(&e->arena);
  km_free(e);
}

/* The equation at hand: entries by unknown, in ascending order, and the right side Σ entry · r₀ + given. */
typedef struct equations {
  equilibrium *e;
  km_columns c;
  const double *r0; /* [6 · joints] scaled */
  long next;
} equations;

static void add_entry(equations *s, int unknown, double value) {
  if (value == 0.0)
    return;
  s->c.row[s->next] = unknown;
  s->c.value[s->next++] = value;
  s->e->b[s->e->equations] += value * s->r0[unknown];
}

static void close_equation(equations *s) {
  s->c.start[++s->e->equations] = s->next;
}

static double component(km_vec3 v, int axis) {
  const double values[3] = {v.x, v.y, v.z};
  return values[axis];
}

/* The balance of a body about the frame of its arc: forces along the inertial axes, then moments over L. */
static void balance_body(equations *s, const km_statics_workspace *w, int place, const int *first,
                         const int *touching) {
  const equilibrium *e = s->e;
  double length = e->m->length;
  km_vec3 about = w->frame[e->m->topology.arc[e->body[place]]].p;
  for (int equation = 0; equation < 6; ++equation) {
    int axis = equation % 3;
    for (int n = first[place]; n < first[place + 1]; ++n) {
      int j = touching[n];
      double sign = e->head[j] == place ? 1.0 : -1.0;
      const km_pose *X = &w->frame[e->joint[j]];
      km_vec3 arm = km_vec3_scale(1.0 / length, km_vec3_sub(X->p, about));
      for (int k = 0; k < 3; ++k) {
        km_vec3 f = equation < 3 ? X->R.axis[k] : km_vec3_cross(arm, X->R.axis[k]);
        add_entry(s, 6 * j + k, sign * component(f, axis));
      }
      for (int k = 0; k < 3 && equation >= 3; ++k)
        add_entry(s, 6 * j + 3 + k, sign * component(X->R.axis[k], axis));
    }
    close_equation(s);
  }
}

/* The joints of each body, ascending. first[bodies + 2], touching[2 · joints]. */
static void list_touching(const equilibrium *e, int *first, int *touching) {
  for (int j = 0; j < e->joints; ++j) {
    first[e->head[j] + 2] += e->head[j] >= 0;
    first[e->tail[j] + 2] += e->tail[j] >= 0;
  }
  for (int b = 0; b < e->bodies; ++b)
    first[b + 2] += first[b + 1];
  for (int j = 0; j < e->joints; ++j) {
    if (e->head[j] >= 0)
      touching[first[e->head[j] + 1]++] = j;
    if (e->tail[j] >= 0)
      touching[first[e->tail[j] + 1]++] = j;
  }
}

/* Six entries of what the wrench of its joint does along the motion of a column, in units of the coordinate. */
static int motion_entries(const equilibrium *e, const km_statics_workspace *w, int column, double out[6]) {
  int c = e->m->column_coordinate[e->sub->column_start + column], joint = e->m->model->coordinates[c].joint;
  const km_pose *X = &w->frame[joint];
  km_twist h = w->twist[c];
  km_vec3 v = km_rotate_back(&X->R, km_vec3_add(h.v, km_vec3_cross(h.w, X->p)));
  km_vec3 turn = km_vec3_scale(e->m->length, km_rotate_back(&X->R, h.w));
  const double values[6] = {v.x, v.y, v.z, turn.x, turn.y, turn.z};
  for (int k = 0; k < 6; ++k)
    out[k] = e->m->unit[c] * values[k];
  return w->place[joint];
}

static double given_force(const equilibrium *e, const km_statics_workspace *w, int column) {
  int c = e->m->column_coordinate[e->sub->column_start + column];
  return e->m->unit[c] * (w->force[c] + w->tau[c]);
}

/* Along a motion of its own, over the size of the entries. */
static void know_column(equations *s, const km_statics_workspace *w, int column) {
  double entry[6], square = 0.0;
  int j = motion_entries(s->e, w, column, entry);
  for (int k = 0; k < 6; ++k)
    square += entry[k] * entry[k];
  s->e->b[s->e->equations] = given_force(s->e, w, column) / sqrt(square);
  for (int k = 0; k < 6; ++k)
    add_entry(s, 6 * j + k, entry[k] / sqrt(square));
  close_equation(s);
}

/* K of the couplings at the pose, a coupling after the other, and what no coupling has a part in. */
static void free_combinations(equilibrium *e, const km_state *state) {
  e->free_count = 0;
  if (e->coupled_count == 0)
    return;
  memset(e->K, 0, (size_t)e->coupled_count * (size_t)e->sub->coupling_count * sizeof *e->K);
  for (int i = 0; i < e->sub->coupling_count; ++i) {
    const km_coupling *coupling = &e->m->couplings[e->sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &e->m->terms[coupling->term_start + k];
      for (int c = 0; c < e->coupled_count; ++c)
        if (e->coupled_column[c] == term->column)
          km_term_value(e->m, state, term, &e->K[(size_t)c * (size_t)e->sub->coupling_count + (size_t)i]);
    }
  }
  km_partition_factor(&e->couplings, e->K, e->sub->coupling_count, e->coupled_count, NULL,
                      1e-12 * (1.0 + e->coupled_count));
  e->free_count = km_partition_freedom(&e->couplings);
  km_partition_null_space(&e->couplings, e->one, e->free_count, e->free);
}

/* Along a combination of coupled motions. */
static void know_combination(equations *s, const km_statics_workspace *w, const double *share) {
  equilibrium *e = s->e;
  double given = 0.0, square = 0.0, entry[6];
  memset(e->row, 0, 6 * (size_t)e->joints * sizeof *e->row);
  for (int i = 0; i < e->coupled_count; ++i) {
    int column = e->coupled_column[i], j = motion_entries(e, w, column, entry);
    given += share[i] * given_force(e, w, column);
    for (int k = 0; k < 6; ++k)
      e->row[6 * j + k] += share[i] * entry[k];
  }
  for (int i = 0; i < 6 * e->joints; ++i)
    square += e->row[i] * e->row[i];
  e->b[e->equations] = given / sqrt(square);
  for (int i = 0; i < 6 * e->joints; ++i)
    add_entry(s, i, e->row[i] / sqrt(square));
  close_equation(s);
}

/* All equations. False when out of memory. */
static bool fill(equilibrium *e, const km_statics_workspace *w, const km_state *state, const double *r0) {
  equations s = {.e = e, .c = km_sparse_qr_columns(e->q), .r0 = r0};
  int *first = KM_NEW(int, (size_t)e->bodies + 2), *touching = KM_NEW(int, 2 * (size_t)e->joints);
  e->equations = 0;
  memset(e->b, 0, (size_t)(6 * e->bodies + e->sub->columns) * sizeof *e->b);
  if (first && touching) {
    list_touching(e, first, touching);
    for (int i = 0; i < e->bodies; ++i)
      balance_body(&s, w, i, first, touching);
  }
  bool done = first && touching;
  km_free(first);
  km_free(touching);
  for (int k = 0; k < e->sub->columns && done; ++k)
    if (!e->coupled[k])
      know_column(&s, w, k);
  free_combinations(e, state);
  for (int i = 0; i < e->free_count && done; ++i)
    know_combination(&s, w, e->free + (size_t)i * (size_t)e->coupled_count);
  while (done && e->equations < 6 * e->bodies + e->sub->columns) /* of coupled motions there are fewer */
    close_equation(&s);
  return done;
}

/* A component is determined if no self-stress has a part in it: random ones are looked at. */
static bool mark(equilibrium *e, bool *mixed) {
  double to_size = e->m->length / e->sub->size;
  uint64_t random = 1;
  for (int look = 0; look < LOOKS; ++look) {
    double largest = 0.0;
    for (int i = 0; i < 6 * e->joints; ++i)
      e->row[i] = km_uniform(&random);
    if (!km_sparse_qr_remove(e->q, e->row, 1))
      return false;
    for (int i = 0; i < 6 * e->joints; ++i)
      largest = fmax(largest, fabs(e->row[i]) * (i % 6 < 3 ? 1.0 : to_size));
    for (int i = 0; i < 6 * e->joints; ++i)
      mixed[i] = mixed[i] || fabs(e->row[i]) * (i % 6 < 3 ? 1.0 : to_size) > km_no_part * largest;
  }
  return true;
}

int km_body_equilibrium_solve(equilibrium *e, const km_statics_workspace *w, const km_state *state, double tolerance,
                              double *carried, bool *mixed) {
  for (int i = 0; i < 6 * e->joints; ++i)
    e->x[i] = carried[i] / (i % 6 < 3 ? 1.0 : e->m->length);
  if (!fill(e, w, state, e->x) || !km_sparse_qr_factor(e->q, tolerance) || !km_sparse_qr_minimum_norm(e->q, e->b, e->x))
    return -1;
  for (int i = 0; i < 6 * e->joints; ++i)
    carried[i] = e->x[i] * (i % 6 < 3 ? 1.0 : e->m->length);
  int stresses = 6 * e->joints - km_sparse_qr_rank(e->q);
  int among_couplings = e->sub->coupling_count - (e->coupled_count - e->free_count);
  if (stresses > 0 && !mark(e, mixed))
    return -1;
  return stresses + among_couplings;
}
