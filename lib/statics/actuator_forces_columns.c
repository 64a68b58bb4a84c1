/* Forces of actuators in a substructure with many freedoms (theory 9.3): projections of the actuators' rows and of the
 * loads on the motions by sparse QR; only the required vectors of the basis Z are formed.
 *
 *   P = Z Zᵀ, A the actuators' rows:  P Aᵀ = Z Z_Aᵀ has the singular values of Z_A
 *   Z_Aᵀ = Q R by Householder reflections, here Z times those of km_decompose_wide;   Rᵀ = U S Wᵀ */
#include "linalg/partition.h"
#include "local/local.h"
#include "statics/statics.h"

#include <gsl/gsl_linalg.h>

/* Most actuators; with more the whole basis is formed. */
enum { MAX_ACTUATORS = KM_MANY_VECTORS };
/* Part of a row's length below which it is rounding. */
static const double rounding = 1e-13;

typedef struct block {
  const km_mechanism *m;
  km_statics *st;
  km_actuator_workspace *h;
  int n, count; /* columns; actuators */
  double *load; /* [n] P τ, scaled */
  double *v;    /* [count × n] P Aᵀ, then the Householder vectors */
  double *tau;  /* [count] factors of the reflections */
  double *z;    /* [z_count × n] first vectors of Z */
  int z_count;
  gsl_matrix *U, *W; /* [count × count] Rᵀ = U S Wᵀ */
  gsl_vector *S;
  double *reported; /* [KM_MAX_DIRECTIONS × n] reported directions */
} block;

static double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int j = 0; j < n; ++j)
    sum += a[j] * b[j];
  return sum;
}

static void add_scaled(double factor, const double *a, double *b, int n) {
  for (int j = 0; j < n; ++j)
    b[j] += factor * a[j];
}

/* Fills the scaled row of an actuator in the substructure's columns. */
static void fill_row(const block *b, int actuator, double *row) {
  const km_statics_workspace *w = b->st->work;
  double scale = km_actuator_scale(b->m, b->st, actuator);
  memset(row, 0, (size_t)b->n * sizeof *row);
  if (!w->row[actuator]) {
    row[w->column[actuator]] = 1.0;
    return;
  }
  for (int j = 0; j < b->n; ++j)
    row[j] = scale * w->row[actuator][b->h->coordinate[j]] / b->m->scale[b->h->coordinate[j]];
}

static gsl_matrix *square(km_arena *arena, int size) {
  gsl_matrix *a = KM_ARENA_NEW(arena, gsl_matrix, 1);
  double *data = KM_ARENA_NEW(arena, double, (size_t)size *(size_t)size);
  if (a && data)
    *a = (gsl_matrix){.size1 = (size_t)size, .size2 = (size_t)size, .tda = (size_t)size, .data = data};
  return a;
}

static bool reserve(block *b, int freedom, km_arena *arena) {
  size_t n = (size_t)b->n, count = (size_t)b->count;
  b->z_count = b->count + KM_MAX_DIRECTIONS + 1; /* the direction in which loads act is spanned by the others */
  b->z_count = b->z_count < freedom ? b->z_count : freedom;
  b->load = KM_ARENA_NEW(arena, double, n);
  b->v = KM_ARENA_NEW(arena, double, count *n);
  b->tau = KM_ARENA_NEW(arena, double, count);
  b->z = KM_ARENA_NEW(arena, double, (size_t)b->z_count *n);
  b->U = square(arena, b->count);
  b->W = square(arena, b->count);
  b->S = KM_ARENA_NEW(arena, gsl_vector, 1);
  double *values = KM_ARENA_NEW(arena, double, count);
  b->reported = KM_ARENA_NEW(arena, double, KM_MAX_DIRECTIONS *n);
  if (!arena->failed)
    *b->S = (gsl_vector){.size = count, .stride = 1, .data = values};
  return !arena->failed;
}

/* Reflects x: x − τ v (vᵀ x). */
static void reflect(const block *b, int k, double *x) {
  const double *v = b->v + (size_t)k * (size_t)b->n;
  add_scaled(-b->tau[k] * dot(v, x, b->n), v, x, b->n);
}

/* Computes the Householder vector that maps the remainder of actuator k's row, orthogonal to the first k vectors of
 * Z, onto the next one; returns the diagonal entry of R. */
static double make_reflector(block *b, int k, double *x) {
  const double *z = b->z + (size_t)k * (size_t)b->n;
  double alpha = dot(z, x, b->n);
  alpha = fabs(alpha) > rounding ? alpha : 0.0; /* its sign determines the reflection */
  add_scaled(-alpha, z, x, b->n);
  double remainder = sqrt(dot(x, x, b->n));
  b->tau[k] = 0.0;
  if (remainder <= rounding)
    return alpha;
  double beta = alpha >= 0.0 ? -hypot(alpha, remainder) : hypot(alpha, remainder);
  b->tau[k] = (beta - alpha) / beta;
  for (int j = 0; j < b->n; ++j)
    x[j] = z[j] + x[j] / (alpha - beta);
  return beta;
}

/* Householder QR of Z_Aᵀ = Q R, from the columns P Aᵀ = Z Z_Aᵀ in v by their products with the first vectors of Z; Rᵀ,
 * lower triangular, into U; then its SVD Rᵀ = U S Wᵀ. v receives the Householder vectors. */
static void factor_actuator_rows(block *b) {
  gsl_matrix_set_zero(b->U);
  for (int k = 0; k < b->count; ++k) {
    double *x = b->v + (size_t)k * (size_t)b->n;
    for (int i = 0; i < k; ++i) {
      const double *z = b->z + (size_t)i * (size_t)b->n;
      reflect(b, i, x);
      double entry = dot(z, x, b->n);
      gsl_matrix_set(b->U, (size_t)k, (size_t)i, entry);
    }
    for (int i = 0; i < k; ++i)
      add_scaled(-gsl_matrix_get(b->U, (size_t)k, (size_t)i), b->z + (size_t)i * (size_t)b->n, x, b->n);
    gsl_matrix_set(b->U, (size_t)k, (size_t)k, make_reflector(b, k, x));
  }
  if (b->count > 0)
    gsl_linalg_SV_decomp_jacobi(b->U, b->W, b->S);
}

/* Replaces the first columns of Z by those of Z Q. */
static void apply_reflections(const block *b) {
  for (int i = 0; i < b->z_count; ++i)
    for (int k = b->count - 1; k >= 0; --k)
      reflect(b, k, b->z + (size_t)i * (size_t)b->n);
}

/* Computes Z times column i of V, Z_A = U S Vᵀ. */
static void singular_motion(const block *b, int i, double *x) {
  memset(x, 0, (size_t)b->n * sizeof *x);
  if (i >= b->count)
    add_scaled(1.0, b->z + (size_t)i * (size_t)b->n, x, b->n);
  for (int k = 0; k < b->count && i < b->count; ++k)
    add_scaled(gsl_matrix_get(b->W, (size_t)k, (size_t)i), b->z + (size_t)k * (size_t)b->n, x, b->n);
}

/* Computes the forces in the motions that the actuators reach and removes their part from the load. x[n]: workspace. */
static void add_reached_forces(block *b, double *x) {
  for (int i = 0; i < b->h->rank; ++i) {
    singular_motion(b, i, x);
    double component = dot(x, b->load, b->n), value = gsl_vector_get(b->S, (size_t)i);
    for (int a = 0; a < b->count; ++a)
      b->st->actuator_forces[b->h->actuator[a]] -= gsl_matrix_get(b->U, (size_t)a, (size_t)i) * component / value;
    add_scaled(-component, x, b->load, b->n);
  }
  for (int a = 0; a < b->count; ++a)
    b->st->actuator_forces[b->h->actuator[a]] *= km_actuator_scale(b->m, b->st, b->h->actuator[a]);
}

/* Returns the rounding of the load along itself. */
static double load_rounding(const block *b, double size) {
  double sum = 0.0;
  for (int j = 0; j < b->n; ++j) {
    int c = b->h->coordinate[j];
    sum += fabs(b->load[j]) * b->st->work->least_load[c] / b->m->scale[c];
  }
  return size > 0.0 ? sum / size : 0.0;
}

static void report_direction(const block *b, const double *x, bool is_loaded) {
  double *rates = km_direction_begin(b->m, is_loaded, b->st);
  for (int j = 0; j < b->n && rates; ++j)
    rates[b->h->coordinate[j]] = x[j] / b->m->scale[b->h->coordinate[j]];
  if (rates)
    km_direction_end(b->m, b->h, rates);
}

/* Reports the motions out of reach: first the one in which the loads act, then others orthogonal to it. Returns true
 * if no load acts on them. */
static bool report_unreached(const block *b) {
  int unreached = b->h->freedom - b->h->rank, reported = 0;
  double size = sqrt(dot(b->load, b->load, b->n));
  bool is_loaded = unreached > 0 && size > load_rounding(b, size);
  for (int i = is_loaded ? b->h->rank - 1 : b->h->rank; i < b->z_count && reported < unreached; ++i) {
    if (b->st->direction_count >= KM_MAX_DIRECTIONS)
      break;
    double *x = b->reported + (size_t)reported * (size_t)b->n;
    if (i >= b->h->rank)
      singular_motion(b, i, x);
    for (int j = 0; j < b->n && i < b->h->rank; ++j)
      x[j] = b->load[j] / size;
    if (km_orthonormalise(b->reported, reported, b->n, x)) {
      report_direction(b, x, i < b->h->rank);
      ++reported;
    }
  }
  b->st->direction_count += unreached - reported; /* the others are counted only */
  return !is_loaded;
}

/* True if every free coordinate has an actuator: they hold everything, with the minimum-norm forces f̄. */
static bool all_coordinates_actuated(const km_statics *st, const km_actuator_workspace *h, const km_partition *p) {
  bool joints = true;
  for (int a = 0; a < h->count; ++a)
    joints = joints && st->actuators[h->actuator[a]].kind == KM_PORT_JOINT;
  return joints && h->count == p->columns - p->locked_count;
}

static void copy_minimum_norm(const km_actuator_workspace *h, km_statics *st) {
  for (int a = 0; a < h->count; ++a)
    st->actuator_forces[h->actuator[a]] = st->least_norm[st->actuators[h->actuator[a]].coordinate];
}

/* Computes P Aᵀ, the actuators' rows projected onto the null space of J, the first `z_count` vectors of its orthonormal
 * basis Z, and the load P τ = −D⁻¹ f̄, which needs no projection because the minimum-norm forces f̄ are projected. */
static bool compute_projections(block *b, const km_state *s, int index) {
  const km_partition *p = &s->partition[index];
  const double *weight = b->m->column_weight + b->m->substructures[index].column_start;
  const double *J = s->jacobian + b->m->substructures[index].matrix_start;
  for (int a = 0; a < b->count; ++a)
    fill_row(b, b->h->actuator[a], b->v + (size_t)a * (size_t)b->n);
  for (int j = 0; j < b->n; ++j)
    b->load[j] = -b->st->least_norm[b->h->coordinate[j]] / b->m->scale[b->h->coordinate[j]];
  if (b->count > 0 && !km_partition_project_null_space(p, J, weight, b->v, b->count))
    return false;
  km_partition_null_space(p, weight, b->z_count, b->z);
  return true;
}

bool km_actuator_forces_solve_columns(const km_mechanism *m, const km_state *s, int index, km_statics *st) {
  km_actuator_workspace *h = &st->work->blocks[index];
  km_arena arena = {0};
  block b = {.m = m, .st = st, .h = h, .n = h->columns, .count = h->count};
  if (h->is_composed || st->work->keeps_factors)
    return false;
  const km_partition *p = &s->partition[h->part[0]];
  int freedom = km_partition_freedom(p);
  bool all_actuated = all_coordinates_actuated(st, h, p);
  if (!p->sparse || freedom <= KM_MANY_VECTORS || (!all_actuated && h->count > MAX_ACTUATORS))
    return false;
  bool found = all_actuated || (reserve(&b, freedom, &arena) && compute_projections(&b, s, h->part[0]));
  if (found) {
    h->freedom = h->rank = freedom;
    if (all_actuated) {
      copy_minimum_norm(h, st);
    } else {
      factor_actuator_rows(&b);
      apply_reflections(&b);
      for (h->rank = 0; h->rank < h->count && gsl_vector_get(b.S, (size_t)h->rank) > km_actuator_rank_tolerance;)
        h->rank++;
      add_reached_forces(&b, b.reported);
      bool holds = report_unreached(&b);
      for (int a = 0; a < h->count && !holds; ++a)
        st->actuator_forces[h->actuator[a]] = nan("");
      st->held = st->held && holds;
    }
    st->redundant = st->redundant || h->count > h->rank;
  }
  km_arena_free(&arena);
  return found;
}
