/* Singular values of a substructure's Jacobian by LAPACK. */
#include "analysis/singular.h"

#include <gsl/gsl_linalg.h>

struct km_singular {
  km_arena arena;
  double *J, *A, *V, *values, *work; /* A: J or its transpose, whichever is tall, by rows */
};

static int least(int a, int b) {
  return a < b ? a : b;
}

bool km_singular_fits(const km_substructure *sub) {
  return sub->rows <= KM_MOST_SINGULAR && sub->columns <= KM_MOST_SINGULAR;
}

km_singular *km_singular_create(const km_mechanism *m) {
  gsl_set_error_handler_off();
  km_singular *w = KM_NEW(km_singular, 1);
  if (!w)
    return NULL;
  size_t rows = (size_t)least(m->largest_rows, KM_MOST_SINGULAR);
  size_t columns = (size_t)least(m->largest_columns, KM_MOST_SINGULAR), most = rows > columns ? rows : columns;
  w->J = KM_ARENA_NEW(&w->arena, double, rows *columns);
  w->A = KM_ARENA_NEW(&w->arena, double, rows *columns);
  w->V = KM_ARENA_NEW(&w->arena, double, most *most);
  w->values = KM_ARENA_NEW(&w->arena, double, most);
  w->work = KM_ARENA_NEW(&w->arena, double, most);
  if (!w->arena.failed)
    return w;
  km_singular_free(w);
  return NULL;
}

void km_singular_free(km_singular *w) {
  if (w)
    km_arena_free(&w->arena);
  km_free(w);
}

static void load(km_singular *w, const km_mechanism *m, const km_state *s, const km_substructure *sub, size_t wide) {
  const double *weight = m->column_weight + sub->column_start;
  km_state_jacobian_dense(s, sub, w->J);
  bool transposed = sub->columns >= sub->rows;
  for (int c = 0; c < sub->columns; ++c)
    for (int r = 0; r < sub->rows; ++r) {
      size_t at = transposed ? (size_t)c * wide + (size_t)r : (size_t)r * wide + (size_t)c;
      w->A[at] = w->J[(size_t)c * (size_t)sub->rows + (size_t)r] / weight[c];
    }
}

const double *km_singular_values(km_singular *w, const km_mechanism *m, const km_state *s, const km_substructure *sub,
                                 int *count) {
  *count = least(sub->rows, sub->columns);
  size_t wide = (size_t)*count, tall = (size_t)(sub->rows + sub->columns) - wide;
  if (wide == 0)
    return w->values;
  load(w, m, s, sub, wide);
  gsl_matrix_view A = gsl_matrix_view_array(w->A, tall, wide), V = gsl_matrix_view_array(w->V, wide, wide);
  gsl_vector_view values = gsl_vector_view_array(w->values, wide), work = gsl_vector_view_array(w->work, wide);
  gsl_linalg_SV_decomp(&A.matrix, &V.matrix, &values.vector, &work.vector);
  return w->values;
}
