/* Products of a matrix's rows. */
#include "partition/products.h"

#include "partition/by_row.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static int ascending(const void *a, const void *b) {
  long x = *(const long *)a, y = *(const long *)b;
  return (x > y) - (x < y);
}

static bool is_kept(long row, long column, bool upper) {
  return upper ? row <= column : row >= column;
}

static bool reserve(km_products *out, int rows, int columns, const int *start) {
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
  out->first = KM_NEW(int, most + 1);
  out->second = KM_NEW(int, most + 1);
  out->entry = KM_NEW(int, most + 1);
  return out->start && out->row && out->diagonal && out->first && out->second && out->entry;
}

/* What is needed to list a column of products. */
typedef struct listing {
  const int *start, *row; /* of A */
  const int *row_start;   /* of A by row: see km_sort_by_row */
  const km_row_entry *by_row;
  const long *place;
  long *at; /* [rows] by place: the entry of this column, -1: none */
  bool upper;
} listing;

/* The rows that have a product with row r, and which entries make it. */
static void list_column(const listing *l, int r, km_products *out) {
  long k = l->place[r], first = out->start[k], end = first;
  out->row[end++] = k;
  l->at[k] = 0;
  for (int n = l->row_start[r]; n < l->row_start[r + 1]; ++n)
    for (int i = l->start[l->by_row[n].column]; i < l->start[l->by_row[n].column + 1]; ++i) {
      long other = l->place[l->row[i]];
      if (!is_kept(other, k, l->upper) || l->at[other] >= 0)
        continue;
      l->at[other] = 0;
      out->row[end++] = other;
    }
  qsort(out->row + first, (size_t)(end - first), sizeof *out->row, ascending);
  for (long i = first; i < end; ++i)
    l->at[out->row[i]] = i;
  out->diagonal[r] = l->at[k];
  for (int n = l->row_start[r]; n < l->row_start[r + 1]; ++n)
    for (int i = l->start[l->by_row[n].column]; i < l->start[l->by_row[n].column + 1]; ++i) {
      long other = l->place[l->row[i]];
      if (!is_kept(other, k, l->upper))
        continue;
      out->first[out->pair_count] = l->by_row[n].entry;
      out->second[out->pair_count] = i;
      out->entry[out->pair_count++] = (int)l->at[other];
    }
  for (long i = first; i < end; ++i)
    l->at[out->row[i]] = -1;
  out->start[k + 1] = end;
}

bool km_products_make(int rows, int columns, const int *start, const int *row, const long *place, bool upper,
                      km_products *out) {
  km_arena arena = {0};
  *out = (km_products){0};
  int *order = KM_ARENA_NEW(&arena, int, (size_t)rows), *row_start = KM_ARENA_NEW(&arena, int, (size_t)rows + 2);
  km_row_entry *by_row = KM_ARENA_NEW(&arena, km_row_entry, (size_t)start[columns]);
  listing l = {start, row, row_start, by_row, place, KM_ARENA_NEW(&arena, long, (size_t)rows), upper};
  bool made = !arena.failed && reserve(out, rows, columns, start);
  if (made)
    km_sort_by_row(rows, columns, start, row, row_start, by_row);
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

void km_products_free(km_products *p) {
  void *const all[] = {p->start, p->row, p->value, p->diagonal, p->first, p->second, p->entry};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    km_free(all[i]);
  *p = (km_products){0};
}

void km_products_find(km_products *p, const double *entries, const bool *used_rows) {
  memset(p->value, 0, (size_t)p->start[p->rows] * sizeof *p->value);
  for (long i = 0; i < p->pair_count; ++i)
    p->value[p->entry[i]] += entries[p->first[i]] * entries[p->second[i]];
  for (long r = 0; r < p->rows; ++r)
    if (!used_rows[r])
      p->value[p->diagonal[r]] = 1.0;
}
