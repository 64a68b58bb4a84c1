/* Arrays of a block of actuators. They grow with the freedoms of a configuration: large mechanisms have many joints
 * and few freedoms. */
#include "statics/statics.h"

#include <string.h>

static gsl_matrix *matrix(km_arena *arena, int rows, int columns) {
  gsl_matrix *a = KM_ARENA_NEW(arena, gsl_matrix, 1);
  double *data = KM_ARENA_NEW(arena, double, (size_t)rows *(size_t)columns);
  if (a && data)
    *a = (gsl_matrix){.size1 = (size_t)rows, .size2 = (size_t)columns, .tda = (size_t)columns, .data = data};
  return a;
}

static gsl_vector *vector(km_arena *arena, int size) {
  gsl_vector *a = KM_ARENA_NEW(arena, gsl_vector, 1);
  double *data = KM_ARENA_NEW(arena, double, (size_t)size);
  if (a && data)
    *a = (gsl_vector){.size = (size_t)size, .stride = 1, .data = data};
  return a;
}

static gsl_permutation *permutation(km_arena *arena, int size) {
  gsl_permutation *p = KM_ARENA_NEW(arena, gsl_permutation, 1);
  size_t *places = KM_ARENA_NEW(arena, size_t, (size_t)size);
  if (p && places)
    *p = (gsl_permutation){(size_t)size, places};
  return p;
}

/* Copies the reference of the signs along a sweep. */
static void copy_reference(km_actuator_workspace *to, const km_actuator_workspace *from) {
  for (int b = 0; b < from->regular_rank; ++b)
    for (int i = 0; i < from->count; ++i)
      gsl_matrix_set(to->reference_U, (size_t)i, (size_t)b, gsl_matrix_get(from->reference_U, (size_t)i, (size_t)b));
  if (from->regular_rank > 0)
    memcpy(to->reference_ZV, from->reference_ZV,
           (size_t)from->regular_rank * (size_t)from->columns * sizeof *to->reference_ZV);
}

bool km_actuator_workspace_fit(km_actuator_workspace *h, int size, km_arena *arena) {
  if (size <= h->capacity)
    return true;
  int rows = h->count > size ? h->count : size; /* pushed points can outnumber the freedoms */
  km_actuator_workspace grown = *h;
  grown.capacity = size;
  grown.U = matrix(arena, rows, size);
  grown.V = matrix(arena, size, size);
  grown.S = vector(arena, size);
  grown.load = vector(arena, size);
  grown.answer = vector(arena, size);
  grown.basis = KM_ARENA_NEW(arena, double, (size_t)size *(size_t)size);
  grown.reference_U = matrix(arena, rows, size);
  grown.rotation = matrix(arena, size, size);
  grown.pivots = permutation(arena, size);
  grown.reference_ZV = KM_ARENA_NEW(arena, double, (size_t)size *(size_t)h->columns);
  grown.own_Z = KM_ARENA_NEW(arena, double, (size_t)size *(size_t)h->columns);
  if (arena->failed)
    return false;
  copy_reference(&grown, h);
  *h = grown;
  return true;
}
