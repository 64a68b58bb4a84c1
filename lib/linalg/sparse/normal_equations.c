/* Normal equations A Aᵀ z = b, x = Aᵀ z by sparse Cholesky (CHOLMOD), with iterative refinement (docs/theory.md 3.5).
 *
 *   [A E] [A E]ᵀ = A Aᵀ + E      E = 1 in the diagonal of unused rows, so that the pattern is that of all rows */
#include "linalg/sparse/normal_equations.h"

#include "base/dynamic_library.h"
#include "base/memory.h"
#include "linalg/dense/simd_pair.h"

#include <cholmod.h>
#include <float.h>
#include <math.h>
#include <string.h>

#define CHOLMOD_FUNCTIONS(X)                                                                                           \
  X(cholmod_l_start)                                                                                                   \
  X(cholmod_l_finish)                                                                                                  \
  X(cholmod_l_analyze)                                                                                                 \
  X(cholmod_l_factorize)                                                                                               \
  X(cholmod_l_solve2)                                                                                                  \
  X(cholmod_l_free_dense)                                                                                              \
  X(cholmod_l_free_factor)

typedef struct library {
#define X(name) __typeof__(name) *name; /* the function's own type */
  CHOLMOD_FUNCTIONS(X)
#undef X
} library;

struct km_normal_equations {
  const library *cholmod;
  cholmod_common common;
  cholmod_factor *L;
  cholmod_dense *X, *Y, *F;   /* workspace of solutions */
  long rows, columns;         /* size of A */
  long *start, *row;          /* pattern of [A E] by columns */
  double *value, *next_value; /* entries of [A E] of the factor, and of the next one */
  bool *used;                 /* [rows] rows of the present factor */
  double *b, *step;           /* [rows], [columns] */
  bool is_factored;
};

/* Loads CHOLMOD's functions. */
static const library *load_cholmod(void) {
#define X(name) #name,
  static const char *const files[] = {KM_CHOLMOD, NULL}, *const names[] = {CHOLMOD_FUNCTIONS(X) NULL};
#undef X
  static library functions;
  static km_library cholmod = {files, names, &functions, false};
  return km_library_load(&cholmod) ? NULL : &functions;
}

/* [A E] as CHOLMOD's matrix. */
static cholmod_sparse matrix_view(const km_normal_equations *n) {
  const size_t columns = (size_t)(n->columns + n->rows);
  return (cholmod_sparse){.nrow = (size_t)n->rows,
                          .ncol = columns,
                          .nzmax = (size_t)n->start[columns],
                          .p = n->start,
                          .i = n->row,
                          .x = n->value,
                          .itype = CHOLMOD_LONG,
                          .xtype = CHOLMOD_REAL,
                          .dtype = CHOLMOD_DOUBLE,
                          .packed = 1};
}

/* Reserves the arrays and sets the pattern of [A E]. */
static bool reserve_arrays(km_normal_equations *n, int rows, int columns, const int *start, const int *row) {
  const size_t entries = (size_t)start[columns] + (size_t)rows;
  n->rows = rows;
  n->columns = columns;
  n->start = KM_NEW(long, (size_t)columns + (size_t)rows + 1);
  n->row = KM_NEW(long, entries + 1);
  n->used = KM_NEW(bool, (size_t)rows + 1);
  n->value = KM_NEW(double, entries + 1);
  n->next_value = KM_NEW(double, entries + 1);
  n->b = KM_NEW(double, (size_t)rows + 1);
  n->step = KM_NEW(double, (size_t)columns + 1);
  if (!n->start || !n->row || !n->used || !n->value || !n->next_value || !n->b || !n->step)
    return false;
  for (int c = 0; c <= columns; ++c)
    n->start[c] = start[c];
  for (int i = 0; i < start[columns]; ++i)
    n->row[i] = row[i];
  for (int r = 0; r < rows; ++r) {
    n->row[start[columns] + r] = r;
    n->start[columns + r + 1] = start[columns] + r + 1;
  }
  return true;
}

/* Analyses the pattern: elimination order by COLAMD, then the symbolic factor. */
static bool analyse_pattern(km_normal_equations *n) {
  cholmod_common *c = &n->common;
  n->cholmod->cholmod_l_start(c);
  c->print = 0;
  c->nmethods = 1;
  c->method[0].ordering = CHOLMOD_COLAMD;
  c->supernodal = CHOLMOD_SIMPLICIAL; /* supernodal factors need threads to pay */
  cholmod_sparse A = matrix_view(n);
  n->L = n->cholmod->cholmod_l_analyze(&A, c);
  return n->L != NULL;
}

km_normal_equations *km_normal_equations_create(int rows, int columns, const int *start, const int *row) {
  const library *cholmod = load_cholmod();
  km_normal_equations *n = cholmod ? KM_NEW(km_normal_equations, 1) : NULL;
  if (!n)
    return NULL;
  n->cholmod = cholmod;
  if (reserve_arrays(n, rows, columns, start, row) && analyse_pattern(n))
    return n;
  km_normal_equations_free(n);
  return NULL;
}

void km_normal_equations_free(km_normal_equations *n) {
  if (!n)
    return;
  n->cholmod->cholmod_l_free_dense(&n->X, &n->common);
  n->cholmod->cholmod_l_free_dense(&n->Y, &n->common);
  n->cholmod->cholmod_l_free_dense(&n->F, &n->common);
  n->cholmod->cholmod_l_free_factor(&n->L, &n->common);
  n->cholmod->cholmod_l_finish(&n->common);
  void *const all[] = {n->start, n->row, n->used, n->value, n->next_value, n->b, n->step, n};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    km_free(all[i]);
}

/* Cholesky factorisation of A Aᵀ in the used rows and columns. */
bool km_normal_equations_factor(km_normal_equations *n, const double *matrix, const double *weight,
                                const bool *used_rows, const bool *used_columns) {
  const size_t entries = (size_t)n->start[n->columns + n->rows];
  for (long c = 0; c < n->columns; ++c)
    for (long i = n->start[c]; i < n->start[c + 1]; ++i)
      n->next_value[i] = used_columns[c] && used_rows[n->row[i]] ? matrix[i] / weight[c] : 0.0;
  for (long r = 0; r < n->rows; ++r)
    n->next_value[n->start[n->columns] + r] = used_rows[r] ? 0.0 : 1.0;
  if (n->is_factored && memcmp(n->next_value, n->value, entries * sizeof *n->next_value) == 0)
    return true;
  memcpy(n->value, n->next_value, entries * sizeof *n->next_value);
  memcpy(n->used, used_rows, (size_t)n->rows * sizeof *n->used);
  cholmod_sparse A = matrix_view(n);
  n->is_factored = n->cholmod->cholmod_l_factorize(&A, n->L, &n->common) && n->L->minor == n->L->n;
  return n->is_factored;
}

/* b <- b − A x; unused rows keep 0. */
static void subtract_product(const km_normal_equations *n, const double *x, double *b) {
  for (long c = 0; c < n->columns; ++c)
    for (long i = n->start[c]; i < n->start[c + 1]; ++i)
      b[n->row[i]] -= n->value[i] * x[c];
}

/* z = (A Aᵀ)⁻¹ b; NULL without memory. */
static const double *solve_normal_equations(km_normal_equations *n) {
  const size_t rows = (size_t)n->rows;
  cholmod_dense B = {
      .nrow = rows, .ncol = 1, .nzmax = rows, .d = rows, .x = n->b, .xtype = CHOLMOD_REAL, .dtype = CHOLMOD_DOUBLE};
  bool is_ok = n->cholmod->cholmod_l_solve2(CHOLMOD_A, n->L, &B, NULL, &n->X, NULL, &n->Y, &n->F, &n->common);
  return is_ok ? n->X->x : NULL;
}

/* step = Aᵀ (A Aᵀ)⁻¹ b. Returns |step|; NaN without memory. */
static double solve_minimum_norm(km_normal_equations *n) {
  const double *z = solve_normal_equations(n);
  if (!z)
    return nan("");
  for (long c = 0; c < n->columns; ++c) {
    double sum = 0.0;
    for (long i = n->start[c]; i < n->start[c + 1]; ++i)
      sum += n->value[i] * z[n->row[i]];
    n->step[c] = sum;
  }
  return sqrt(km_pair_dot(n->step, n->step, (int)n->columns));
}

/* Minimum-norm solution of A x = n->b (0 in unused rows) with iterative refinement. Corrections shrink by a nearly
 * constant ratio, which bounds the remaining error. */
static bool refine(km_normal_equations *n, double *x) {
  enum { MAX_REFINEMENTS = 4 };
  double last = solve_minimum_norm(n), length = last;
  memcpy(x, n->step, (size_t)n->columns * sizeof *x);
  for (int i = 0; i < MAX_REFINEMENTS && length > 0.0; ++i) {
    subtract_product(n, n->step, n->b);
    double step = solve_minimum_norm(n);
    for (long c = 0; c < n->columns; ++c)
      x[c] += n->step[c];
    if (step * step <= 5.0 * DBL_EPSILON * last * length)
      return true;
    last = step;
  }
  return length == 0.0;
}

/* Minimum-norm solution of A x = b in the used rows. */
bool km_normal_equations_minimum_norm(km_normal_equations *n, const double *b, double *x) {
  for (long r = 0; r < n->rows; ++r)
    n->b[r] = n->used[r] ? b[r] : 0.0;
  return refine(n, x);
}

/* Row-space projection Aᵀ (A Aᵀ)⁻¹ A y. */
bool km_normal_equations_project(km_normal_equations *n, const double *y, double *x) {
  memset(n->b, 0, (size_t)n->rows * sizeof *n->b);
  subtract_product(n, y, n->b);
  for (long r = 0; r < n->rows; ++r)
    n->b[r] = -n->b[r];
  return refine(n, x);
}
