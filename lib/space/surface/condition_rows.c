/* Independent rows of a matrix (space/surface/condition_rows.h). */
#include "space/surface/condition_rows.h"

#include "base/number/vectors.h"
#include "space/real_solve.h"

#include <string.h>

static const double most_weight = 2.0;            /* growth of B (docs/theory.md 3.3) */
static const double dependence_tolerance = 1e-12; /* pivot of J Jᵀ over the largest: W has no digits below */

bool km_condition_rows_create(km_condition_rows *p, int all, int rows, int columns, km_arena *arena) {
  size_t r = (size_t)rows, a = (size_t)all;
  *p = (km_condition_rows){.all = all, .rows = rows, .columns = columns, .arena = arena};
  p->remainder = KM_ARENA_NEW(arena, double, a *(size_t)columns + 1);
  p->gram = KM_ARENA_NEW(arena, double, r *r + 1);
  p->weights = KM_ARENA_NEW(arena, double, r + 1);
  p->next = KM_ARENA_NEW(arena, int, r + 1);
  p->pivot = KM_ARENA_NEW(arena, int, r + 1);
  p->is_primary = KM_ARENA_NEW(arena, bool, a + 1);
  return !arena->failed;
}

/* Makes p->next with this sense the present choice. */
static bool make_present(km_condition_rows *p, int sense) {
  size_t size = (size_t)p->rows * sizeof *p->next;
  for (int i = 0; i < p->count; ++i)
    if (p->choices[i].sense == sense && memcmp(p->choices[i].row, p->next, size) == 0) {
      p->present = i;
      return true;
    }
  void *choices = p->choices;
  int *row = KM_ARENA_NEW(p->arena, int, (size_t)p->rows + 1);
  if (!row || !km_arena_grow(p->arena, &choices, &p->capacity, (size_t)p->count + 1, sizeof *p->choices))
    return false;
  memcpy(row, p->next, size);
  p->choices = choices;
  p->choices[p->count] = (km_row_choice){row, sense};
  p->present = p->count++;
  return true;
}

/* The longest remainder of a row that isn't chosen. */
static int longest_row(const km_condition_rows *p) {
  int longest = -1;
  double most = 0.0;
  for (int i = 0; i < p->all; ++i) {
    double length = km_norm(p->remainder + i * p->columns, p->columns);
    if (!p->is_primary[i] && (longest < 0 || length > most)) {
      most = length;
      longest = i;
    }
  }
  return longest;
}

bool km_condition_rows_choose(km_condition_rows *p, const double *J_all) {
  int n = p->columns, count = 0;
  for (int i = 0; i < p->all; ++i) {
    p->is_primary[i] = false;
    for (int k = 0; k < n; ++k)
      p->remainder[i * n + k] = J_all[k * p->all + i];
  }
  for (int pass = 0; pass < p->rows; ++pass) {
    int chosen = longest_row(p);
    const double *row = p->remainder + chosen * n;
    double square = km_dot(row, row, n);
    p->is_primary[chosen] = true;
    for (int i = 0; i < p->all && square > 0.0; ++i) {
      double *other = p->remainder + i * n, part = km_dot(other, row, n) / square;
      for (int k = 0; k < n && !p->is_primary[i]; ++k)
        other[k] -= part * row[k];
    }
  }
  for (int i = 0; i < p->all; ++i)
    if (p->is_primary[i])
      p->next[count++] = i;
  return make_present(p, 1);
}

/* Factors J Jᵀ. False where the primary rows depend on each other. */
static bool factor_gram(km_condition_rows *p, const double *J_all) {
  const int *row = p->choices[p->present].row;
  double largest = 0.0, smallest = HUGE_VAL;
  int sign, r = p->rows;
  for (int i = 0; i < r; ++i)
    for (int j = 0; j < r; ++j) {
      double sum = 0.0;
      for (int k = 0; k < p->columns; ++k)
        sum += J_all[k * p->all + row[i]] * J_all[k * p->all + row[j]];
      p->gram[i * r + j] = sum;
    }
  if (!km_real_factor(p->gram, r, p->pivot, &sign))
    return false;
  for (int i = 0; i < r; ++i) {
    largest = fmax(largest, fabs(p->gram[i * r + i]));
    smallest = fmin(smallest, fabs(p->gram[i * r + i]));
  }
  return smallest > dependence_tolerance * largest;
}

/* Finds the largest weight, of row *i on primary row *j. */
static double largest_weight(km_condition_rows *p, const double *J_all, int *i, int *j) {
  const int *row = p->choices[p->present].row;
  double *right = p->remainder, largest = 0.0;
  for (int other = 0, next = 0; other < p->all; ++other) {
    if (next < p->rows && row[next] == other) {
      ++next;
      continue;
    }
    for (int k = 0; k < p->rows; ++k) {
      right[k] = 0.0;
      for (int c = 0; c < p->columns; ++c)
        right[k] += J_all[c * p->all + row[k]] * J_all[c * p->all + other];
    }
    km_real_solve(p->gram, p->rows, p->pivot, right, p->weights);
    for (int k = 0; k < p->rows; ++k)
      if (fabs(p->weights[k]) > fabs(largest)) {
        largest = p->weights[k];
        *i = other;
        *j = k;
      }
  }
  return largest;
}

/* Puts row i in the place of primary row j, and the rows in order: each transposition reverses the sense. */
static bool replace(km_condition_rows *p, int i, int j, double weight) {
  int sense = p->choices[p->present].sense * (weight < 0.0 ? -1 : 1);
  memcpy(p->next, p->choices[p->present].row, (size_t)p->rows * sizeof *p->next);
  p->next[j] = i;
  for (; j > 0 && p->next[j - 1] > i; --j, sense = -sense)
    p->next[j] = p->next[j - 1];
  p->next[j] = i;
  for (; j + 1 < p->rows && p->next[j + 1] < i; ++j, sense = -sense)
    p->next[j] = p->next[j + 1];
  p->next[j] = i;
  return make_present(p, sense);
}

bool km_condition_rows_exchange(km_condition_rows *p, const double *J_all, bool *is_changed) {
  int i = 0, j = 0;
  *is_changed = false;
  while (p->all > p->rows) {
    if (!factor_gram(p, J_all))
      return false;
    double weight = largest_weight(p, J_all, &i, &j);
    if (fabs(weight) <= most_weight)
      return true;
    if (!replace(p, i, j, weight))
      return false;
    *is_changed = true;
  }
  return true;
}

void km_condition_rows_take(const km_condition_rows *p, const double *A_all, int columns, double *A) {
  const km_row_choice *choice = &p->choices[p->present];
  if (A == A_all)
    return;
  for (int k = 0; k < columns; ++k)
    for (int i = 0; i < p->rows; ++i)
      A[k * p->rows + i] = A_all[k * p->all + choice->row[i]];
  for (int k = 0; k < columns && p->rows > 0; ++k)
    A[k * p->rows] *= choice->sense;
}

bool km_condition_rows_pass(km_condition_rows *p, int first, km_piece *piece) {
  int count = p->count, sense = 1;
  km_piece_pass(piece, &count, sizeof count);
  for (int i = first; i < count && !piece->failed; ++i) {
    if (!piece->is_read) {
      memcpy(p->next, p->choices[i].row, (size_t)p->rows * sizeof *p->next);
      sense = p->choices[i].sense;
    }
    km_piece_pass(piece, p->next, (size_t)p->rows * sizeof *p->next);
    km_piece_pass(piece, &sense, sizeof sense);
    if (piece->is_read && !piece->failed && !make_present(p, sense))
      return false;
  }
  return true;
}
