/* Singular values of a matrix and of a substructure's Jacobian, by the singular value decomposition of GSL. */
#include "mobility/jacobian_singular_values.h"

#include <gsl/gsl_linalg.h>

struct km_singular_value_workspace {
  km_arena arena;
  double *J, *values;
  km_svd_workspace workspace;
};

static int min_int(int a, int b) {
  return a < b ? a : b;
}

bool km_svd_reserve(km_svd_workspace *workspace, int rows, int columns, km_arena *arena) {
  size_t wide = (size_t)min_int(rows, columns);
  gsl_set_error_handler_off();
  workspace->A = KM_ARENA_NEW(arena, double, (size_t)rows *(size_t)columns);
  workspace->V = KM_ARENA_NEW(arena, double, wide *wide);
  workspace->work = KM_ARENA_NEW(arena, double, wide);
  return !arena->failed;
}

int km_svd_values(const double *J, int rows, int columns, km_svd_workspace *workspace, double *values) {
  size_t wide = (size_t)min_int(rows, columns), tall = (size_t)(rows + columns) - wide;
  if (wide == 0)
    return 0;
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r)
      workspace->A[columns >= rows ? (size_t)c * wide + (size_t)r : (size_t)r * wide + (size_t)c] =
          J[(size_t)c * (size_t)rows + (size_t)r];
  gsl_matrix_view A = gsl_matrix_view_array(workspace->A, tall, wide),
                  V = gsl_matrix_view_array(workspace->V, wide, wide);
  gsl_vector_view S = gsl_vector_view_array(values, wide), work = gsl_vector_view_array(workspace->work, wide);
  gsl_linalg_SV_decomp(&A.matrix, &V.matrix, &S.vector, &work.vector);
  return (int)wide;
}

bool km_singular_values_fit(const km_substructure *sub) {
  return sub->rows <= KM_MAX_SINGULAR && sub->columns <= KM_MAX_SINGULAR;
}

km_singular_value_workspace *km_singular_value_workspace_create(const km_mechanism *m) {
  km_singular_value_workspace *w = KM_NEW(km_singular_value_workspace, 1);
  if (!w)
    return NULL;
  int rows = min_int(m->largest_rows, KM_MAX_SINGULAR), columns = min_int(m->largest_columns, KM_MAX_SINGULAR);
  w->J = KM_ARENA_NEW(&w->arena, double, (size_t)rows *(size_t)columns);
  w->values = KM_ARENA_NEW(&w->arena, double, (size_t)min_int(rows, columns));
  if (km_svd_reserve(&w->workspace, rows, columns, &w->arena))
    return w;
  km_singular_value_workspace_free(w);
  return NULL;
}

void km_singular_value_workspace_free(km_singular_value_workspace *w) {
  if (w)
    km_arena_free(&w->arena);
  km_free(w);
}

const double *km_singular_values(km_singular_value_workspace *w, const km_mechanism *m, const km_state *s,
                                 const km_substructure *sub, int *count) {
  const double *weight = m->column_weight + sub->column_start;
  km_state_jacobian_dense(s, sub, w->J);
  for (int c = 0; c < sub->columns; ++c)
    for (int r = 0; r < sub->rows; ++r)
      w->J[(size_t)c * (size_t)sub->rows + (size_t)r] /= weight[c];
  *count = km_svd_values(w->J, sub->rows, sub->columns, &w->workspace, w->values);
  return w->values;
}
