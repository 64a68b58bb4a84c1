/* Reactions of a large substructure (theory 9.4): minimum-norm solution of the equilibrium of all bodies by sparse QR.
 *
 *   unknown r : one wrench per joint;   A r = A r₀ for every body, r₀ the reactions of the tree alone
 *   h_k · (r - r₀) = f_k + τ_k along every free motion;   min Σ |force|² + |torque/L|²
 *
 * Coupled motions share an unknown coupling force: only their combinations without one are equations. */
#include "base/number/vectors.h"
#include "base/random.h"
#include "statics/statics.h"

#include "kinematics/loop_equations.h"
#include "linalg/sparse/sparse_qr.h"

#include <string.h>

enum { SAMPLES = 3 }; /* random self-stresses that are examined */

typedef struct km_body_equilibrium {
  const km_mechanism *m;
  const km_substructure *sub;
  int index, joints, bodies;
  const int *joint, *body; /* joints and bodies of the substructure */
  km_arena arena;
  int *body_index;  /* [body of the mechanism] index in `body`; -1: other */
  int *head, *tail; /* [joint] body_index of its bodies; -1: base of the substructure */
  bool *coupled;    /* [column] */
  int coupled_count;
  int *coupled_column; /* [coupled_count] columns of coupled motions */
  /* [coupled × couplings] coupling coefficients, and their left null vectors [coupled × coupled] */
  double *K, *free;
  km_factor *couplings; /* factor of Kᵀ */
  int free_count;       /* combinations without a coupling force, at the last configuration */
  km_sparse_qr *q;
  double *b, *x, *row; /* [equations]; [6 · joints]; [6 · joints] of one equation */
  int equations;       /* number of equations at the last configuration */
} equilibrium;

static void list_bodies(equilibrium *e) {
  for (int b = 0; b < e->m->topology.body_count; ++b)
    e->body_index[b] = -1;
  for (int i = 0; i < e->bodies; ++i)
    e->body_index[e->body[i]] = i;
  for (int j = 0; j < e->joints; ++j) {
    e->tail[j] = e->body_index[km_joint_body(e->m->model, e->joint[j], 0)];
    e->head[j] = e->body_index[km_joint_body(e->m->model, e->joint[j], 1)];
  }
}

/* Marks the columns with a coupling term. */
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
  e->body_index = KM_ARENA_NEW(arena, int, (size_t)e->m->topology.body_count);
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
  e->couplings = km_factor_create(sub->coupling_count, e->coupled_count, NULL, arena);
  return !arena->failed;
}

/* Upper bound of the entries: a body has at most 27 per joint, a motion 6 per joint. */
static int max_entries(const equilibrium *e) {
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
  return km_sparse_qr_create(6 * e->joints, 6 * e->bodies + e->sub->columns, max_entries(e), &e->q, error);
}

void km_body_equilibrium_free(equilibrium *e) {
  if (!e)
    return;
  km_sparse_qr_free(e->q);
  km_arena_free(&e->arena);
  km_free(e);
}

/* Assembly of the equations: entries by unknown, ascending, and right side Σ entry · r₀ + given force. */
typedef struct equation_builder {
  equilibrium *e;
  km_columns c;
  const double *r0; /* [6 · joints] scaled reactions of the tree alone: they satisfy the bodies' balance */
  long next;
} equation_builder;

/* Appends an entry to the present equation, and entry · r₀ to its right side; zeros are omitted. */
static void add_entry(equation_builder *s, int unknown, double value) {
  if (value == 0.0)
    return;
  s->c.row[s->next] = unknown;
  s->c.value[s->next++] = value;
  s->e->b[s->e->equations] += value * s->r0[unknown];
}

static void close_equation(equation_builder *s) {
  s->c.start[++s->e->equations] = s->next;
}

static double component(km_vec3 v, int axis) {
  const double values[3] = {v.x, v.y, v.z};
  return values[axis];
}

/* Adds the balance of a body about the frame of its arc: forces along the inertial axes, then moments over L. */
static void balance_body(equation_builder *s, const km_statics_workspace *w, int body_index) {
  const equilibrium *e = s->e;
  const km_topology *t = &e->m->topology;
  const int body = e->body[body_index];
  double length = e->m->length;
  km_vec3 about = w->frame[t->arc[body]].p;
  for (int equation = 0; equation < 6; ++equation) {
    int axis = equation % 3;
    for (int n = t->incident_start[body]; n < t->incident_start[body + 1]; ++n) {
      if (t->substructure_of_joint[t->incident[n]] != e->index)
        continue;
      int j = w->joint_index[t->incident[n]];
      double sign = e->head[j] == body_index ? 1.0 : -1.0;
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

/* Computes the power of a joint's unit wrenches along the motion of a column, in units of the coordinate; returns the
 * joint. */
static int motion_entries(const equilibrium *e, const km_statics_workspace *w, int column, double out[6]) {
  int c = e->m->column_coordinate[e->sub->column_start + column], joint = e->m->model->coordinates[c].joint;
  const km_pose *X = &w->frame[joint];
  km_twist h = w->twist[c];
  km_vec3 v = km_rotate_back(&X->R, km_vec3_add(h.v, km_vec3_cross(h.w, X->p)));
  km_vec3 rotation = km_vec3_scale(e->m->length, km_rotate_back(&X->R, h.w));
  const double values[6] = {v.x, v.y, v.z, rotation.x, rotation.y, rotation.z};
  for (int k = 0; k < 6; ++k)
    out[k] = e->m->unit[c] * values[k];
  return w->joint_index[joint];
}

/* Scaled force along a motion: of its actuator, f, and of the loads, τ (right side of h · (r − r₀) = f + τ). */
static double given_force(const equilibrium *e, const km_statics_workspace *w, int column) {
  int c = e->m->column_coordinate[e->sub->column_start + column];
  return e->m->unit[c] * (w->force[c] + w->tau[c]);
}

/* Adds the equation along an uncoupled motion, normalised. */
static void add_motion_equation(equation_builder *s, const km_statics_workspace *w, int column) {
  double entry[6];
  int j = motion_entries(s->e, w, column, entry);
  double length = km_norm(entry, 6);
  s->e->b[s->e->equations] = given_force(s->e, w, column) / length;
  for (int k = 0; k < 6; ++k)
    add_entry(s, 6 * j + k, entry[k] / length);
  close_equation(s);
}

/* Computes the coupling coefficients K and the combinations of motions without a coupling force. */
static void find_uncoupled_combinations(equilibrium *e, const km_state *state) {
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
  km_factor_compute(e->couplings, e->K, e->sub->coupling_count, e->coupled_count,
                    &(km_factor_options){.tolerance = 1e-12 * (1.0 + e->coupled_count)});
  e->free_count = km_factor_freedom(e->couplings);
  e->free = km_factor_null_space(e->couplings, e->free_count);
}

/* Adds the equation along a combination of coupled motions, normalised. */
static void add_combination_equation(equation_builder *s, const km_statics_workspace *w, const double *share) {
  equilibrium *e = s->e;
  double given = 0.0, entry[6];
  memset(e->row, 0, 6 * (size_t)e->joints * sizeof *e->row);
  for (int i = 0; i < e->coupled_count; ++i) {
    int column = e->coupled_column[i], j = motion_entries(e, w, column, entry);
    given += share[i] * given_force(e, w, column);
    for (int k = 0; k < 6; ++k)
      e->row[6 * j + k] += share[i] * entry[k];
  }
  double length = km_norm(e->row, 6 * e->joints);
  e->b[e->equations] = given / length;
  for (int i = 0; i < 6 * e->joints; ++i)
    add_entry(s, i, e->row[i] / length);
  close_equation(s);
}

/* Assembles all equations. */
static void assemble(equilibrium *e, const km_statics_workspace *w, const km_state *state, const double *r0) {
  equation_builder s = {.e = e, .c = km_sparse_qr_columns(e->q), .r0 = r0};
  e->equations = 0;
  memset(e->b, 0, (size_t)(6 * e->bodies + e->sub->columns) * sizeof *e->b);
  for (int i = 0; i < e->bodies; ++i)
    balance_body(&s, w, i);
  for (int k = 0; k < e->sub->columns; ++k)
    if (!e->coupled[k])
      add_motion_equation(&s, w, k);
  find_uncoupled_combinations(e, state);
  for (int i = 0; i < e->free_count; ++i)
    add_combination_equation(&s, w, e->free + (size_t)i * (size_t)e->coupled_count);
  /* fewer equations for coupled motions: empty columns */
  while (e->equations < 6 * e->bodies + e->sub->columns)
    close_equation(&s);
}

/* Marks the indeterminate components: those in which one of three random self-stresses has a part. */
static bool mark_indeterminate(equilibrium *e, bool *indeterminate_out) {
  double to_size = e->m->length / e->sub->size;
  uint64_t random = 1;
  for (int look = 0; look < SAMPLES; ++look) {
    double largest = 0.0;
    for (int i = 0; i < 6 * e->joints; ++i)
      e->row[i] = km_uniform(&random);
    if (!km_sparse_qr_remove(e->q, e->row, 1))
      return false;
    for (int i = 0; i < 6 * e->joints; ++i)
      largest = fmax(largest, fabs(e->row[i]) * (i % 6 < 3 ? 1.0 : to_size));
    for (int i = 0; i < 6 * e->joints; ++i)
      indeterminate_out[i] =
          indeterminate_out[i] || fabs(e->row[i]) * (i % 6 < 3 ? 1.0 : to_size) > km_relative_zero * largest;
  }
  return true;
}

int km_body_equilibrium_solve(equilibrium *e, const km_statics_workspace *w, const km_state *state, double tolerance,
                              double *carried, bool *indeterminate_out) {
  for (int i = 0; i < 6 * e->joints; ++i)
    e->x[i] = carried[i] / (i % 6 < 3 ? 1.0 : e->m->length);
  assemble(e, w, state, e->x);
  if (!km_sparse_qr_factor(e->q, tolerance) || !km_sparse_qr_minimum_norm(e->q, e->b, e->x))
    return -1;
  for (int i = 0; i < 6 * e->joints; ++i)
    carried[i] = e->x[i] * (i % 6 < 3 ? 1.0 : e->m->length);
  int stresses = 6 * e->joints - km_sparse_qr_rank(e->q);
  int coupling_stresses = e->sub->coupling_count - (e->coupled_count - e->free_count);
  if (stresses > 0 && !mark_indeterminate(e, indeterminate_out))
    return -1;
  return stresses + coupling_stresses;
}
