/* Products of a matrix's rows. */
#include "linalg/sparse/row_products.h"

#include "linalg/sparse/row_storage.h"

#include <limits.h>
#include <stdlib.h>

static int ascending(const void *a, const void *b) {
  long x = *(const long *)a, y = *(const long *)b;
  return (x > y) - (x < y);
}

static bool is_kept(long row, long column, bool upper) {
  return upper ? row <= column : row >= column;
}

/* What is needed to list a column of products. */
typedef struct listing {
  const int *start, *row; /* of A */
  const int *row_start;   /* of A by row: see km_create_row_storage */
  const km_row_entry *by_row;
  const long *place;
  long *at;        /* [rows] by place: the entry of this column, -1: none */
  km_factors *met; /* the column's pairs as they are met */
  long *entry;     /* of each of these: the other row's place, then the entry that sums its product */
  bool upper;
} listing;

static bool reserve(km_row_products *out, int rows, int columns, const int *start, km_arena *arena, listing *l) {
  double pairs = 0.0;
  for (int c = 0; c < columns; ++c)
    pairs += 0.5 * (start[c + 1] - start[c]) * (start[c + 1] - start[c] + 1.0);
  if (pairs + rows >= INT_MAX)
    return false;
  size_t most = (size_t)pairs + (size_t)rows;
  out->rows = rows;
  out->start = KM_NEW(long, (size_t)rows + 1);
  out->row = KM_NEW(long, most + 1);
  out->diagonal = KM_NEW(long, (size_t)rows + 1);
  out->pair_start = KM_NEW(long, most + 2);
  out->pair = KM_NEW(km_factors, most + 1);
  l->met = KM_ARENA_NEW(arena, km_factors, most + 1);
  l->entry = KM_ARENA_NEW(arena, long, most + 1);
  return out->start && out->row && out->diagonal && out->pair_start && out->pair && !arena->failed;
}

/* The pairs of entries that row r makes with the rows whose products are kept. Returns how many. */
static long meet(const listing *l, int r) {
  const long k = l->place[r];
  long count = 0;
  for (int n = l->row_start[r]; n < l->row_start[r + 1]; ++n)
    for (int i = l->start[l->by_row[n].column]; i < l->start[l->by_row[n].column + 1]; ++i) {
      long other = l->place[l->row[i]];
      if (!is_kept(other, k, l->upper))
        continue;
      l->met[count] = (km_factors){l->by_row[n].entry, i};
      l->entry[count++] = other;
    }
  return count;
}

/* The rows that have a product with row r, and which entries make it, in the order in which they are met. */
static void list_column(const listing *l, int r, km_row_products *out) {
  const long k = l->place[r], first = out->start[k], count = meet(l, r);
  long end = first;
  out->row[end++] = k;
  l->at[k] = 0;
  for (long i = 0; i < count; ++i) {
    if (l->at[l->entry[i]] >= 0)
      continue;
    l->at[l->entry[i]] = 0;
    out->row[end++] = l->entry[i];
  }
  qsort(out->row + first, (size_t)(end - first), sizeof *out->row, ascending);
  for (long i = first; i < end; ++i)
    l->at[out->row[i]] = i;
  out->diagonal[r] = l->at[k];
  /* Of each entry where its next pair goes: in the end that is where those of the one behind it begin. */
  long *const next = out->pair_start + 1;
  for (long i = 0; i < count; ++i) {
    l->entry[i] = l->at[l->entry[i]];
    if (l->entry[i] + 1 < end)
      next[l->entry[i] + 1]++;
  }
  for (long i = first + 1; i < end; ++i)
    next[i] += next[i - 1];
  for (long i = 0; i < count; ++i)
    out->pair[next[l->entry[i]]++] = l->met[i];
  next[end] = next[end - 1];
  for (long i = first; i < end; ++i)
    l->at[out->row[i]] = -1;
  out->start[k + 1] = end;
}

bool km_row_products_create(int rows, int columns, const int *start, const int *row, const long *place, bool upper,
                            km_row_products *out) {
  km_arena arena = {0};
  *out = (km_row_products){0};
  int *order = KM_ARENA_NEW(&arena, int, (size_t)rows), *row_start = KM_ARENA_NEW(&arena, int, (size_t)rows + 2);
  km_row_entry *by_row = KM_ARENA_NEW(&arena, km_row_entry, (size_t)start[columns]);
  listing l = {.start = start, .row = row, .row_start = row_start, .by_row = by_row, .place = place, .upper = upper};
  l.at = KM_ARENA_NEW(&arena, long, (size_t)rows);
  bool made = reserve(out, rows, columns, start, &arena, &l);
  if (made)
    km_create_row_storage(rows, columns, start, row, row_start, by_row);
  for (int r = 0; r < rows && made; ++r) {
    l.at[r] = -1;
    order[place[r]] = r;
  }
  for (int k = 0; k < rows && made; ++k)
    list_column(&l, order[k], out);
  km_arena_free(&arena);
  out->value = made ? KM_NEW(double, (size_t)out->start[rows] + 1) : NULL;
  return out->value != NULL;
}

void km_row_products_free(km_row_products *p) {
  void *const all[] = {p->start, p->row, p->value, p->diagonal, p->pair_start, p->pair};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    km_free(all[i]);
  *p = (km_row_products){0};
}

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
