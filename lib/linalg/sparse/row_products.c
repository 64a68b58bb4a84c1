/* Symbolic and numeric product A Aᵀ of a sparse matrix in a given order of rows. */
#include "linalg/sparse/row_products.h"

#include "linalg/sparse/row_storage.h"

#include <limits.h>
#include <stdlib.h>

static int compare_longs(const void *a, const void *b) {
  long x = *(const long *)a, y = *(const long *)b;
  return (x > y) - (x < y);
}

static bool is_in_triangle(long row, long column, bool upper) {
  return upper ? row <= column : row >= column;
}

/* Data for the symbolic product. */
typedef struct product_list {
  const int *start, *row; /* pattern of A */
  const int *row_start;   /* entries of A by row: see km_create_row_storage */
  const km_row_entry *by_row;
  const long *position;
  long *entry_of_row; /* [rows] by position: entry in the present column; -1: none */
  km_factors *pairs;  /* pairs of the present column */
  long *entry;        /* other row's position of each pair, later the entry that sums the product */
  bool upper;
} product_list;

static bool reserve_arrays(km_row_products *out, int rows, int columns, const int *start, km_arena *arena,
                           product_list *l) {
  double pairs = 0.0;
  for (int c = 0; c < columns; ++c)
    pairs += 0.5 * (start[c + 1] - start[c]) * (start[c + 1] - start[c] + 1.0);
  if (pairs + rows >= INT_MAX)
    return false;
  size_t max_pairs = (size_t)pairs + (size_t)rows;
  out->rows = rows;
  out->start = KM_NEW(long, (size_t)rows + 1);
  out->row = KM_NEW(long, max_pairs + 1);
  out->diagonal = KM_NEW(long, (size_t)rows + 1);
  out->pair_start = KM_NEW(long, max_pairs + 2);
  out->pair = KM_NEW(km_factors, max_pairs + 1);
  l->pairs = KM_ARENA_NEW(arena, km_factors, max_pairs + 1);
  l->entry = KM_ARENA_NEW(arena, long, max_pairs + 1);
  return out->start && out->row && out->diagonal && out->pair_start && out->pair && !arena->failed;
}

/* Lists the pairs of entries of row r with the rows of its triangle. Returns their number. */
static long list_pairs(const product_list *l, int r) {
  const long k = l->position[r];
  long count = 0;
  for (int n = l->row_start[r]; n < l->row_start[r + 1]; ++n)
    for (int i = l->start[l->by_row[n].column]; i < l->start[l->by_row[n].column + 1]; ++i) {
      long other_row = l->position[l->row[i]];
      if (!is_in_triangle(other_row, k, l->upper))
        continue;
      l->pairs[count] = (km_factors){l->by_row[n].entry, i};
      l->entry[count++] = other_row;
    }
  return count;
}

/* Creates the column of row r: rows with a product, and the pairs of entries that each product sums. */
static void create_column(const product_list *l, int r, km_row_products *out) {
  const long k = l->position[r], first = out->start[k], count = list_pairs(l, r);
  long end = first;
  out->row[end++] = k;
  l->entry_of_row[k] = 0;
  for (long i = 0; i < count; ++i) {
    if (l->entry_of_row[l->entry[i]] >= 0)
      continue;
    l->entry_of_row[l->entry[i]] = 0;
    out->row[end++] = l->entry[i];
  }
  qsort(out->row + first, (size_t)(end - first), sizeof *out->row, compare_longs);
  for (long i = first; i < end; ++i)
    l->entry_of_row[out->row[i]] = i;
  out->diagonal[r] = l->entry_of_row[k];
  /* next[i]: index of the next pair of entry i; in the end the first pair of entry i + 1. */
  long *const next = out->pair_start + 1;
  for (long i = 0; i < count; ++i) {
    l->entry[i] = l->entry_of_row[l->entry[i]];
    if (l->entry[i] + 1 < end)
      next[l->entry[i] + 1]++;
  }
  for (long i = first + 1; i < end; ++i)
    next[i] += next[i - 1];
  for (long i = 0; i < count; ++i)
    out->pair[next[l->entry[i]]++] = l->pairs[i];
  next[end] = next[end - 1];
  for (long i = first; i < end; ++i)
    l->entry_of_row[out->row[i]] = -1;
  out->start[k + 1] = end;
}

/* Symbolic product A Aᵀ. */
bool km_row_products_create(int rows, int columns, const int *start, const int *row, const long *position, bool upper,
                            km_row_products *out) {
  km_arena arena = {0};
  *out = (km_row_products){0};
  int *order = KM_ARENA_NEW(&arena, int, (size_t)rows), *row_start = KM_ARENA_NEW(&arena, int, (size_t)rows + 2);
  km_row_entry *by_row = KM_ARENA_NEW(&arena, km_row_entry, (size_t)start[columns]);
  product_list l = {
      .start = start, .row = row, .row_start = row_start, .by_row = by_row, .position = position, .upper = upper};
  l.entry_of_row = KM_ARENA_NEW(&arena, long, (size_t)rows);
  bool is_ok = reserve_arrays(out, rows, columns, start, &arena, &l);
  if (is_ok)
    km_create_row_storage(rows, columns, start, row, row_start, by_row);
  for (int r = 0; r < rows && is_ok; ++r) {
    l.entry_of_row[r] = -1;
    order[position[r]] = r;
  }
  for (int k = 0; k < rows && is_ok; ++k)
    create_column(&l, order[k], out);
  km_arena_free(&arena);
  out->value = is_ok ? KM_NEW(double, (size_t)out->start[rows] + 1) : NULL;
  return out->value != NULL;
}

void km_row_products_free(km_row_products *p) {
  void *const all[] = {p->start, p->row, p->value, p->diagonal, p->pair_start, p->pair};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    km_free(all[i]);
  *p = (km_row_products){0};
}

/* Numeric product A Aᵀ by the listed pairs. */
void km_row_products_compute(km_row_products *p, const double *entries, const bool *used_rows) {
  const km_factors *const pair = p->pair;
  for (long i = 0; i < p->start[p->rows]; ++i) {
    double sum = 0.0;
    for (long n = p->pair_start[i]; n < p->pair_start[i + 1]; ++n)
      sum += entries[pair[n].first] * entries[pair[n].second];
    p->value[i] = sum;
  }
  for (long r = 0; r < p->rows; ++r)
    if (!used_rows[r])
      p->value[p->diagonal[r]] = 1.0;
}
