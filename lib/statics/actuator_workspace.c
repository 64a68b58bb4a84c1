/* Room for the balance of a block of actuators. It grows with the freedoms that a pose has: large mechanisms have many
 * joints and few freedoms. */
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

/* What is seen from the last sample keeps its signs. */
static void keep_reference(km_actuator_workspace *to, const km_actuator_workspace *from) {
  for (int b = 0; b < from->most_rank; ++b)
    for (int i = 0; i < from->count; ++i)
      gsl_matrix_set(to->fixed, (size_t)i, (size_t)b, gsl_matrix_get(from->fixed, (size_t)i, (size_t)b));
  if (from->most_rank > 0)
    memcpy(to->moving, from->moving, (size_t)from->most_rank * (size_t)from->columns * sizeof *to->moving);
}

bool km_actuator_workspace_fit(km_actuator_workspace *h, int freedom, km_arena *arena) {
  if (freedom <= h->capacity)
    return true;
  int rows = h->count > freedom ? h->count : freedom; /* points may be more than what they move */
  km_actuator_workspace grown = *h;
  grown.capacity = freedom;
  grown.U = matrix(arena, rows, freedom);
  grown.V = matrix(arena, freedom, freedom);
  grown.S = vector(arena, freedom);
  grown.load = vector(arena, freedom);
  grown.answer = vector(arena, freedom);
  grown.basis = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)freedom);
  grown.fixed = matrix(arena, rows, freedom);
  grown.turn = matrix(arena, freedom, freedom);
  grown.pivots = permutation(arena, freedom);
  grown.moving = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)h->columns);
  if (h->gathers)
    grown.gathered = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)h->columns);
  if (arena->failed)
    return false;
  keep_reference(&grown, h);
  *h = grown;
  return true;
}
