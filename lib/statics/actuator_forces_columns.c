/* Actuators against loads where a substructure has many freedoms: what the motions have of the actuators' rows and of the loads
 * is found by sparse Q R, and of the basis Z only the vectors that are told.
 *
 * Everything stands in the substructure's columns, scaled: with P = Z Zᵀ and the actuators' rows A, P Aᵀ = Z Z_Aᵀ has the
 * singular values of Z_A. Householder's vectors of Z_Aᵀ = Q R are here Z times those of km_decompose_wide, and so are Q's
 * columns: the directions are the same. */
#include "linalg/partition.h"
#include "local/tangent_cone.h"
#include "statics/statics.h"

#include <gsl/gsl_linalg.h>

/* More actuators than that are many too: then the whole basis is made. */
enum { MOST_ACTUATORS = KM_MANY_VECTORS };
/* Of a row's length: less is rounding. */
static const double rounding = 1e-13;

typedef struct block {
  const km_mechanism *m;
  km_statics *st;
  km_actuator_workspace *h;
  int n, count; /* columns; actuators */
  double *load; /* [n] P τ, scaled */
  double *v;    /* [count × n] P Aᵀ, then Householder's vectors */
  double *tau;  /* [count] their factors */
  double *z;    /* [known × n] the first vectors of Z */
  int known;
  gsl_matrix *U, *W; /* [count × count] of Rᵀ = U S Wᵀ */
  gsl_vector *S;
  double *kept; /* [KM_MAX_DIRECTIONS × n] directions that are told */
} block;

static double dot(const double *a, const double *b, int n) {
  double sum = 0.0;
  for (int j = 0; j < n; ++j)
    sum += a[j] * b[j];
  return sum;
}

static void add(double factor, const double *a, double *b, int n) {
  for (int j = 0; j < n; ++j)
    b[j] += factor * a[j];
}

/* The row of an actuator in the columns, scaled. */
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
  b->known = b->count + KM_MAX_DIRECTIONS + 1; /* the direction in which loads fall is spanned by the others */
  b->known = b->known < freedom ? b->known : freedom;
  b->load = KM_ARENA_NEW(arena, double, n);
  b->v = KM_ARENA_NEW(arena, double, count *n);
  b->tau = KM_ARENA_NEW(arena, double, count);
  b->z = KM_ARENA_NEW(arena, double, (size_t)b->known *n);
  b->U = square(arena, b->count);
  b->W = square(arena, b->count);
  b->S = KM_ARENA_NEW(arena, gsl_vector, 1);
  double *values = KM_ARENA_NEW(arena, double, count);
  b->kept = KM_ARENA_NEW(arena, double, KM_MAX_DIRECTIONS *n);
  if (!arena->failed)
    *b->S = (gsl_vector){.size = count, .stride = 1, .data = values};
  return !arena->failed;
}

/* x − τ v (vᵀ x). */
static void reflect(const block *b, int k, double *x) {
  const double *v = b->v + (size_t)k * (size_t)b->n;
  add(-b->tau[k] * dot(v, x, b->n), v, x, b->n);
}

/* What is left of actuator k's row behind the first k vectors of Z becomes the vector that turns it onto the next one; returns
 * the diagonal entry of R. */
static double make_reflector(block *b, int k, double *x) {
  const double *z = b->z + (size_t)k * (size_t)b->n;
  double alpha = dot(z, x, b->n);
  alpha = fabs(alpha) > rounding ? alpha : 0.0; /* its sign decides how the others turn */
  add(-alpha, z, x, b->n);
  double rest = sqrt(dot(x, x, b->n));
  b->tau[k] = 0.0;
  if (rest <= rounding)
    return alpha;
  double beta = alpha >= 0.0 ? -hypot(alpha, rest) : hypot(alpha, rest);
  b->tau[k] = (beta - alpha) / beta;
  for (int j = 0; j < b->n; ++j)
    x[j] = z[j] + x[j] / (alpha - beta);
  return beta;
}

/* Rᵀ into U, and its singular values. */
static void decompose(block *b) {
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
      add(-gsl_matrix_get(b->U, (size_t)k, (size_t)i), b->z + (size_t)i * (size_t)b->n, x, b->n);
    gsl_matrix_set(b->U, (size_t)k, (size_t)k, make_reflector(b, k, x));
  }
  if (b->count > 0)
    gsl_linalg_SV_decomp_jacobi(b->U, b->W, b->S);
}

/* The first columns of Z Q in the place of those of Z. */
static void turn(const block *b) {
  for (int i = 0; i < b->known; ++i)
    for (int k = b->count - 1; k >= 0; --k)
      reflect(b, k, b->z + (size_t)i * (size_t)b->n);
}

/* Z times column i of V, where U S Vᵀ is Z_A. */
static void singular_motion(const block *b, int i, double *x) {
  memset(x, 0, (size_t)b->n * sizeof *x);
  if (i >= b->count)
    add(1.0, b->z + (size_t)i * (size_t)b->n, x, b->n);
  for (int k = 0; k < b->count && i < b->count; ++k)
    add(gsl_matrix_get(b->W, (size_t)k, (size_t)i), b->z + (size_t)k * (size_t)b->n, x, b->n);
}

/* Forces in the motions that the actuators reach; the load loses what they carry. x[n]: workspace. */
static void push(block *b, double *x) {
  for (int i = 0; i < b->h->rank; ++i) {
    singular_motion(b, i, x);
    double along = dot(x, b->load, b->n), value = gsl_vector_get(b->S, (size_t)i);
    for (int a = 0; a < b->count; ++a)
      b->st->actuator_forces[b->h->actuator[a]] -= gsl_matrix_get(b->U, (size_t)a, (size_t)i) * along / value;
    add(-along, x, b->load, b->n);
  }
  for (int a = 0; a < b->count; ++a)
    b->st->actuator_forces[b->h->actuator[a]] *= km_actuator_scale(b->m, b->st, b->h->actuator[a]);
}

/* What rounding can make of the load along itself. */
static double noise_of(const block *b, double size) {
  double sum = 0.0;
  for (int j = 0; j < b->n; ++j) {
    int c = b->h->coordinate[j];
    sum += fabs(b->load[j]) * b->st->work->least_load[c] / b->m->scale[c];
  }
  return size > 0.0 ? sum / size : 0.0;
}

static void tell(const block *b, const double *x, bool falls) {
  double *rates = km_direction_begin(b->m, falls, b->st);
  for (int j = 0; j < b->n && rates; ++j)
    rates[b->h->coordinate[j]] = x[j] / b->m->scale[b->h->coordinate[j]];
  if (rates)
    km_direction_end(b->m, b->h, rates);
}

/* Tells the motions out of reach: if loads act on them, the one in which they fall, then others at right angles to it. Returns
 * whether nothing falls. */
static bool tell_unreached(const block *b) {
  int unreached = b->h->freedom - b->h->rank, kept = 0;
  double size = sqrt(dot(b->load, b->load, b->n));
  bool falls = unreached > 0 && size > noise_of(b, size);
  for (int i = falls ? b->h->rank - 1 : b->h->rank; i < b->known && kept < unreached; ++i) {
    if (b->st->direction_count >= KM_MAX_DIRECTIONS)
      break;
    double *x = b->kept + (size_t)kept * (size_t)b->n;
    if (i >= b->h->rank)
      singular_motion(b, i, x);
    for (int j = 0; j < b->n && i < b->h->rank; ++j)
      x[j] = b->load[j] / size;
    if (km_orthonormalise(b->kept, kept, b->n, x)) {
      tell(b, x, i < b->h->rank);
      ++kept;
    }
  }
  b->st->direction_count += unreached - kept; /* the others are counted */
  return !falls;
}

/* Where every free coordinate has an actuator they hold everything, by the least forces. */
static bool push_all(const km_statics *st, const km_actuator_workspace *h, const km_partition *p) {
  bool joints = true;
  for (int a = 0; a < h->count; ++a)
    joints = joints && st->actuators[h->actuator[a]].kind == KM_PORT_JOINT;
  return joints && h->count == p->columns - p->locked_count;
}

static void take_least(const km_actuator_workspace *h, km_statics *st) {
  for (int a = 0; a < h->count; ++a)
    st->actuator_forces[h->actuator[a]] = st->least_norm[st->actuators[h->actuator[a]].coordinate];
}

/* By the first vectors of Z, and by Q R. */
static bool find_motions(block *b, const km_state *s, int index) {
  const km_partition *p = &s->partition[index];
  const double *weight = b->m->column_weight + b->m->substructures[index].column_start;
  const double *J = s->jacobian + b->m->substructures[index].matrix_start;
  for (int a = 0; a < b->count; ++a)
    fill_row(b, b->h->actuator[a], b->v + (size_t)a * (size_t)b->n);
  for (int j = 0; j < b->n; ++j)
    b->load[j] = -b->st->least_norm[b->h->coordinate[j]] / b->m->scale[b->h->coordinate[j]];
  if (b->count > 0 && !km_partition_project_null_space(p, J, weight, b->v, b->count))
    return false;
  km_partition_null_space(p, weight, b->known, b->z);
  return true;
}

bool km_actuator_forces_solve_columns(const km_mechanism *m, const km_state *s, int index, km_statics *st) {
  km_actuator_workspace *h = &st->work->holding[index];
  km_arena arena = {0};
  block b = {.m = m, .st = st, .h = h, .n = h->columns, .count = h->count};
  if (h->gathers || st->work->compares)
    return false;
  const km_partition *p = &s->partition[h->part[0]];
  int freedom = km_partition_freedom(p);
  bool all = push_all(st, h, p);
  if (!p->sparse || freedom <= KM_MANY_VECTORS || (!all && h->count > MOST_ACTUATORS))
    return false;
  bool found = all || (reserve(&b, freedom, &arena) && find_motions(&b, s, h->part[0]));
  if (found) {
    h->freedom = h->rank = freedom;
    if (all) {
      take_least(h, st);
    } else {
      decompose(&b);
      turn(&b);
      for (h->rank = 0; h->rank < h->count && gsl_vector_get(b.S, (size_t)h->rank) > km_out_of_reach;)
        h->rank++;
      push(&b, b.kept);
      bool holds = tell_unreached(&b);
      for (int a = 0; a < h->count && !holds; ++a)
        st->actuator_forces[h->actuator[a]] = nan("");
      st->held = st->held && holds;
    }
    st->redundant = st->redundant || h->count > h->rank;
  }
  km_arena_free(&arena);
  return found;
}
