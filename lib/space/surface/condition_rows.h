/* Independent rows of a matrix, followed while it changes (docs/theory.md 4.19).
 *
 *   J_all = W J,   J: the primary rows, as many as the rank of J_all;   |W_ij| ≤ 2
 *   row i takes the place of primary row j:  det (J; ·) gets the factor W_ij
 *
 * The first primary row is multiplied by ±1, so that determinants keep their signs where rows are exchanged. */
#ifndef KM_SPACE_CONDITION_ROWS_H
#define KM_SPACE_CONDITION_ROWS_H

#include "base/memory.h"
#include "base/store/piece_store.h"

#include <stdbool.h>

/* A choice of rows. */
typedef struct km_row_choice {
  int *row; /* [rows] ascending */
  int sense;
} km_row_choice;

typedef struct km_condition_rows {
  int all, rows, columns; /* size of J_all, number of primary rows */
  km_arena *arena;
  km_row_choice *choices; /* [count] met so far, the first one first */
  size_t capacity;
  int count, present;                 /* index of the present choice */
  double *remainder, *gram, *weights; /* [all × columns], [rows × rows], [rows] workspace */
  int *next, *pivot;                  /* [rows] workspace */
  bool *is_primary;                   /* [all] workspace */
} km_condition_rows;

/* Begins with the first rows. False when out of memory. */
bool km_condition_rows_create(km_condition_rows *p, int all, int rows, int columns, km_arena *arena);
/* Chooses independent rows of J_all[all × columns], column-major, by Gram-Schmidt's method; its determinants have no
 * relation to those of other choices. False when out of memory. */
bool km_condition_rows_choose(km_condition_rows *p, const double *J_all);
/* Exchanges rows until |W_ij| ≤ 2. *is_changed: some were. False where the primary rows depend on each other; the
 * choice is then the same, as when out of memory. */
bool km_condition_rows_exchange(km_condition_rows *p, const double *J_all, bool *is_changed);
/* Passes the choices from number `first` on to a piece or from it. False when out of memory. */
bool km_condition_rows_pass(km_condition_rows *p, int first, km_piece *piece);
/* Copies the primary rows of A_all[all × columns] to A[rows × columns]; A may be A_all if all rows are primary. */
void km_condition_rows_take(const km_condition_rows *p, const double *A_all, int columns, double *A);

#endif
