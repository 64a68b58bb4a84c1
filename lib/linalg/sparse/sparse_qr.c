/* Sparse QR by SPQR: projections Q Qᵀ v, minimum-norm solutions Q R⁻ᵀ b, row norms |R⁻ᵀ b|². */
#include "linalg/sparse/sparse_qr.h"

#include "base/dynamic_library.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>
#include <SuiteSparseQR_C.h>

#define SPQR_FUNCTIONS(X)                                                                                              \
  X(cholmod_l_start)                                                                                                   \
  X(cholmod_l_finish)                                                                                                  \
  X(cholmod_l_free)                                                                                                    \
  X(cholmod_l_free_dense)                                                                                              \
  X(cholmod_l_free_sparse)                                                                                             \
  X(cholmod_l_transpose)                                                                                               \
  X(SuiteSparseQR_C)                                                                                                   \
  X(SuiteSparseQR_C_factorize)                                                                                         \
  X(SuiteSparseQR_C_solve)                                                                                             \
  X(SuiteSparseQR_C_qmult)                                                                                             \
  X(SuiteSparseQR_C_free)

typedef struct library {
#define X(name) __typeof__(name) *name; /* the function's own type */
  SPQR_FUNCTIONS(X)
#undef X
} library;

struct km_sparse_qr {
  const library *spqr;
  cholmod_common common;
  SuiteSparseQR_C_factorization *QR;
  SuiteSparse_long rows, columns, entries, *start, *row;
  double *value;
  int rank;
};

/* Loads SPQR's functions. */
static const library *load_spqr(km_error *error) {
#define X(name) #name,
  static const char *const files[] = {KM_SPQR, NULL}, *const names[] = {SPQR_FUNCTIONS(X) NULL};
#undef X
  static library functions;
  static km_library spqr = {files, names, &functions, false};
  const char *reason = km_library_load(&spqr);
  if (!reason)
    return &functions;
  km_fail(error, KM_IO, "a large mechanism can't be solved: %.300s; expected SuiteSparse's SPQR to be installed",
          reason);
  return NULL;
}

km_status km_sparse_qr_create(int rows, int columns, int entries, km_sparse_qr **out, km_error *error) {
  *out = NULL;
  const library *spqr = load_spqr(error);
  if (!spqr)
    return KM_IO;
  km_sparse_qr *q = KM_NEW(km_sparse_qr, 1);
  if (!q)
    return km_fail(error, KM_MEMORY, "out of memory for a factorisation");
  q->spqr = spqr;
  q->spqr->cholmod_l_start(&q->common);
  q->common.SPQR_nthreads = 1; /* equal sums in equal order on every machine */
  q->common.SPQR_grain = 1;
  q->common.print = 0;
  q->rows = rows;
  q->columns = columns;
  q->entries = entries;
  q->start = KM_NEW(SuiteSparse_long, (size_t)columns + 1);
  q->row = KM_NEW(SuiteSparse_long, (size_t)entries + 1);
  q->value = KM_NEW(double, (size_t)entries + 1);
  *out = q;
  if (q->start && q->row && q->value)
    return KM_OK;
  km_sparse_qr_free(q);
  *out = NULL;
  return km_fail(error, KM_MEMORY, "out of memory for a factorisation");
}

void km_sparse_qr_free(km_sparse_qr *q) {
  if (!q)
    return;
  q->spqr->SuiteSparseQR_C_free(&q->QR, &q->common);
  q->spqr->cholmod_l_finish(&q->common);
  km_free(q->start);
  km_free(q->row);
  km_free(q->value);
  km_free(q);
}

km_columns km_sparse_qr_columns(km_sparse_qr *q) {
  return (km_columns){q->start, q->row, q->value};
}

/* The matrix as CHOLMOD's matrix. */
static cholmod_sparse matrix_view(const km_sparse_qr *q) {
  return (cholmod_sparse){.nrow = (size_t)q->rows,
                          .ncol = (size_t)q->columns,
                          .nzmax = (size_t)q->start[q->columns],
                          .p = q->start,
                          .i = q->row,
                          .x = q->value,
                          .itype = CHOLMOD_LONG,
                          .xtype = CHOLMOD_REAL,
                          .dtype = CHOLMOD_DOUBLE,
                          .sorted = 1,
                          .packed = 1};
}

/* Rank-revealing QR in COLAMD order. */
bool km_sparse_qr_factor(km_sparse_qr *q, double tolerance) {
  cholmod_sparse A = matrix_view(q);
  q->spqr->SuiteSparseQR_C_free(&q->QR, &q->common);
  q->QR = q->spqr->SuiteSparseQR_C_factorize(SPQR_ORDERING_COLAMD, tolerance, &A, &q->common);
  q->rank = (int)q->common.SPQR_istat[4];
  return q->QR != NULL;
}

int km_sparse_qr_rank(const km_sparse_qr *q) {
  return q->rank;
}

/* Dense vectors as CHOLMOD's matrix. */
static cholmod_dense dense_view(double *x, SuiteSparse_long rows, int columns) {
  size_t size = (size_t)rows * (size_t)columns;
  return (cholmod_dense){.nrow = (size_t)rows,
                         .ncol = (size_t)columns,
                         .nzmax = size,
                         .d = (size_t)rows,
                         .x = x,
                         .xtype = CHOLMOD_REAL,
                         .dtype = CHOLMOD_DOUBLE};
}

/* v <- (I − Q Qᵀ) v. */
bool km_sparse_qr_remove(km_sparse_qr *q, double *v, int count) {
  cholmod_dense V = dense_view(v, q->rows, count);
  cholmod_dense *Y = q->spqr->SuiteSparseQR_C_qmult(SPQR_QTX, q->QR, &V, &q->common);
  for (int k = 0; k < count && Y; ++k)
    memset((double *)Y->x + (size_t)k * Y->d, 0, (size_t)q->rank * sizeof(double));
  cholmod_dense *projection = Y ? q->spqr->SuiteSparseQR_C_qmult(SPQR_QX, q->QR, Y, &q->common) : NULL;
  bool is_ok = projection != NULL;
  if (is_ok)
    memcpy(v, projection->x, V.nzmax * sizeof(double));
  q->spqr->cholmod_l_free_dense(&Y, &q->common);
  q->spqr->cholmod_l_free_dense(&projection, &q->common);
  return is_ok;
}

/* |Qᵀ v|². */
bool km_sparse_qr_projected_squares(km_sparse_qr *q, double *v, int count, double *squares) {
  cholmod_dense V = dense_view(v, q->rows, count);
  cholmod_dense *Y = q->spqr->SuiteSparseQR_C_qmult(SPQR_QTX, q->QR, &V, &q->common);
  bool is_ok = Y != NULL;
  for (int k = 0; k < count && is_ok; ++k) {
    const double *y = (const double *)Y->x + (size_t)k * Y->d;
    squares[k] = 0.0;
    for (int i = 0; i < q->rank; ++i)
      squares[k] += y[i] * y[i];
  }
  q->spqr->cholmod_l_free_dense(&Y, &q->common);
  return is_ok;
}

/* R, upper triangular, by rows: entries of row k from start[k] on, by column, the diagonal entry first. */
typedef struct triangle {
  const long *start, *column;
  const double *value;
  long columns;
} triangle;

/* |R⁻ᵀ b|² by forward substitution from the first entry of b on. b is 0 on return. O(columns + entries of the rows of R
 * that b reaches): in an order of nested dissection log n rows in a chain of n loops. */
static double solution_square(const triangle *R, long first, double *b) {
  double sum = 0.0;
  for (long k = first; k < R->columns; ++k) {
    if (b[k] == 0.0)
      continue;
    double u = b[k] / R->value[R->start[k]];
    sum += u * u;
    for (long i = R->start[k] + 1; i < R->start[k + 1]; ++i)
      b[R->column[i]] -= R->value[i] * u;
    b[k] = 0.0;
  }
  return sum;
}

/* square[row] = |R⁻ᵀ b|² of every row b of the matrix. column_of_r: column of R of each column of the matrix. */
static void compute_squares(const km_sparse_qr *q, const triangle *R, const cholmod_sparse *by_row,
                            const long *column_of_r, double *b, double *square) {
  const long *start = by_row->p, *column = by_row->i;
  const double *value = by_row->x;
  for (long row = 0; row < q->rows; ++row) {
    long first = q->columns;
    for (long i = start[row]; i < start[row + 1]; ++i) {
      long k = column_of_r[column[i]];
      b[k] = value[i];
      first = k < first ? k : first;
    }
    square[row] = solution_square(R, first, b);
  }
}

/* Squared row norms of Q = A R⁻¹, in nested-dissection order. */
bool km_sparse_qr_squared_norms(km_sparse_qr *q, double tolerance, double *square) {
  const library *f = q->spqr;
  cholmod_sparse A = matrix_view(q), *R = NULL;
  SuiteSparse_long *order = NULL;
  long rank = f->SuiteSparseQR_C(SPQR_ORDERING_METIS, tolerance, q->columns, 0, &A, NULL, NULL, NULL, NULL, &R, &order,
                                 NULL, NULL, NULL, &q->common);
  cholmod_sparse *rows_of_r = rank == q->columns ? f->cholmod_l_transpose(R, 1, &q->common) : NULL;
  cholmod_sparse *by_row = rows_of_r ? f->cholmod_l_transpose(&A, 1, &q->common) : NULL;
  long *column_of_r = KM_NEW(long, (size_t)q->columns + 1);
  double *b = KM_NEW(double, (size_t)q->columns + 1);
  bool is_ok = by_row && column_of_r && b;
  for (long k = 0; k < q->columns && is_ok; ++k)
    column_of_r[order ? order[k] : k] = k;
  if (is_ok)
    compute_squares(q, &(triangle){rows_of_r->p, rows_of_r->i, rows_of_r->x, q->columns}, by_row, column_of_r, b,
                    square);
  km_free(b);
  km_free(column_of_r);
  f->cholmod_l_free_sparse(&by_row, &q->common);
  f->cholmod_l_free_sparse(&rows_of_r, &q->common);
  f->cholmod_l_free_sparse(&R, &q->common);
  f->cholmod_l_free((size_t)q->columns, sizeof *order, order, &q->common);
  return is_ok;
}

/* Rank-revealing QR: independent columns. */
int km_sparse_qr_independent_columns(km_sparse_qr *q, double tolerance, int *list) {
  const library *f = q->spqr;
  cholmod_sparse A = matrix_view(q), *R = NULL;
  SuiteSparse_long *order = NULL;
  long rank = f->SuiteSparseQR_C(SPQR_ORDERING_COLAMD, tolerance, 0, 0, &A, NULL, NULL, NULL, NULL, &R, &order, NULL,
                                 NULL, NULL, &q->common);
  for (long k = 0; k < rank; ++k)
    list[k] = (int)(order ? order[k] : k);
  f->cholmod_l_free_sparse(&R, &q->common);
  f->cholmod_l_free((size_t)q->columns, sizeof *order, order, &q->common);
  return (int)rank;
}

/* Minimum-norm solution Q R⁻ᵀ b. */
bool km_sparse_qr_minimum_norm(km_sparse_qr *q, const double *b, double *x) {
  double *copy = KM_NEW(double, (size_t)q->columns + 1); /* the library's interface has no const */
  if (!copy)
    return false;
  memcpy(copy, b, (size_t)q->columns * sizeof *b);
  cholmod_dense B = dense_view(copy, q->columns, 1);
  cholmod_dense *Y = q->spqr->SuiteSparseQR_C_solve(SPQR_RTX_EQUALS_ETB, q->QR, &B, &q->common);
  cholmod_dense *X = Y ? q->spqr->SuiteSparseQR_C_qmult(SPQR_QX, q->QR, Y, &q->common) : NULL;
  bool is_ok = X != NULL;
  if (is_ok)
    memcpy(x, X->x, (size_t)q->rows * sizeof *x);
  q->spqr->cholmod_l_free_dense(&Y, &q->common);
  q->spqr->cholmod_l_free_dense(&X, &q->common);
  km_free(copy);
  return is_ok;
}
