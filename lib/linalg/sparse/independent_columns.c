/* Choice of independent columns by complete pivoting of the null vectors (docs/theory.md 3.6).
 *
 *   pivot: the largest entry of all remaining null vectors;  its column becomes independent and is eliminated from the
 *   other vectors. So |B| <= 2 about, as with complete pivoting of the matrix.
 *
 * Null vectors are stored by their entries; they are local, so a step changes few of them. */
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

/* A null vector by its entries. */
typedef struct null_vector {
  int *column;
  double *value;
  int count;
  size_t capacity, value_capacity;
  int largest; /* candidate column with the largest entry */
  double size; /* magnitude of that entry */
} null_vector;

/* List of the vectors with an entry in a column: a vector, and the next list element; -1: none. */
typedef struct column_entry {
  int vector, next;
} column_entry;

typedef struct null_pivoting {
  km_factor *p;
  const bool *forced;
  km_arena arena;
  null_vector *vectors;
  int count;
  int *first; /* [columns] first list element of each column; -1: none */
  column_entry *holders;
  int holder_count;
  size_t holder_capacity;
  int *entry_index; /* [columns] index + 1 of the column's entry in the present vector; 0: none */
  double visits;    /* number of visited entries */
  bool is_full;     /* the vectors exceed the bounds of fill-in or visits */
} null_pivoting;

/* Bounds relative to the entries of the matrix: entries of all null vectors, and visited entries with many vectors.
 * Longer times exceed the value of a smaller B. With few vectors visits are not bounded, since a basis is formed from
 * them. */
enum { MAX_FILL = 50, MAX_VISITS = 2500 };

/* `times` the number of entries of the matrix. */
static double entry_multiple(const null_pivoting *h, int times) {
  return (double)times * h->p->sparse->start[h->p->columns];
}

/* True if the sum over the first `done_count` of all vectors extrapolates to more than `most`. */
static bool will_exceed(const null_pivoting *h, double sum, int done_count, double most) {
  enum { MIN_SAMPLE = 20 };
  return done_count >= MIN_SAMPLE && km_factor_freedom(h->p) > KM_MANY_VECTORS &&
         sum * km_factor_freedom(h->p) > most * done_count;
}

/* Counts a visit of all entries of a vector. */
static void count_visits(null_pivoting *h, const null_vector *v) {
  h->visits += v->count;
  h->is_full = h->is_full || (h->visits > entry_multiple(h, MAX_VISITS) && km_factor_freedom(h->p) > KM_MANY_VECTORS);
}

/* True if the column may become independent by this choice. */
static bool is_candidate(const null_pivoting *h, int c) {
  return !h->p->sparse->is_postponed[c] && !km_sparse_is_preset(h->p, h->forced, c);
}

/* Finds the candidate column with the largest entry of a vector; of equal entries the first column, of zero entries the
 * first candidate. */
static void find_largest(null_pivoting *h, null_vector *v) {
  count_visits(h, v);
  v->largest = -1;
  v->size = 0.0;
  for (int i = 0; i < v->count; ++i) {
    int c = v->column[i];
    double size = fabs(v->value[i]);
    if (size > 0.0 && size >= v->size && (size > v->size || c < v->largest) && is_candidate(h, c)) {
      v->largest = c;
      v->size = size;
    }
  }
  for (int c = 0; c < h->p->columns && v->largest < 0; ++c)
    if (is_candidate(h, c))
      v->largest = c;
}

/* Appends an entry to a vector and to the list of its column. */
static bool append_entry(null_pivoting *h, int vector, int column, double value) {
  null_vector *v = &h->vectors[vector];
  h->is_full = h->is_full || h->holder_count >= entry_multiple(h, MAX_FILL);
  if (h->is_full || !km_arena_grow(&h->arena, (void **)&v->column, &v->capacity, (size_t)v->count + 1, sizeof(int)) ||
      !km_arena_grow(&h->arena, (void **)&v->value, &v->value_capacity, (size_t)v->count + 1, sizeof(double)) ||
      !km_arena_grow(&h->arena, (void **)&h->holders, &h->holder_capacity, (size_t)h->holder_count + 1,
                     sizeof(column_entry)))
    return false;
  v->column[v->count] = column;
  v->value[v->count++] = value;
  h->holders[h->holder_count] = (column_entry){vector, h->first[column]};
  h->first[column] = h->holder_count++;
  return true;
}

/* Creates the null vectors of the independent columns that are not preset. */
static bool create_null_vectors(null_pivoting *h) {
  const km_factor *p = h->p;
  const km_sparse *s = p->sparse;
  h->vectors = KM_ARENA_NEW(&h->arena, null_vector, (size_t)(p->columns - p->rank));
  h->first = KM_ARENA_NEW(&h->arena, int, (size_t)p->columns);
  h->entry_index = KM_ARENA_NEW(&h->arena, int, (size_t)p->columns);
  if (h->arena.failed)
    return false;
  for (int c = 0; c < p->columns; ++c)
    h->first[c] = -1;
  for (int k = p->rank; k < p->columns && !h->is_full; ++k) {
    if (km_sparse_is_preset(p, h->forced, p->column[k]))
      continue;
    bool listed = append_entry(h, h->count, p->column[k], 1.0);
    km_entry_range b = km_sparse_b(p, k - p->rank);
    for (int i = b.start; i < b.end && listed; ++i)
      listed = append_entry(h, h->count, p->column[s->b_store.index[i]], -s->b_store.value[i]);
    if (!listed)
      return false;
    ++h->count;
    h->is_full = h->is_full || will_exceed(h, h->holder_count, h->count, entry_multiple(h, MAX_FILL));
  }
  return !h->is_full;
}

/* vector <- vector − share · pivot_vector. */
static bool subtract_vector(null_pivoting *h, const null_vector *pivot_vector, double share, int vector) {
  null_vector *v = &h->vectors[vector];
  bool is_done = true;
  count_visits(h, v);
  for (int i = 0; i < v->count; ++i)
    h->entry_index[v->column[i]] = i + 1;
  for (int i = 0, before = v->count; i < pivot_vector->count && is_done; ++i) {
    int at = h->entry_index[pivot_vector->column[i]];
    if (at > 0 && at <= before)
      v->value[at - 1] -= share * pivot_vector->value[i];
    else if (pivot_vector->value[i] != 0.0)
      is_done = append_entry(h, vector, pivot_vector->column[i], -share * pivot_vector->value[i]);
  }
  for (int i = 0; i < v->count; ++i)
    h->entry_index[v->column[i]] = 0;
  return is_done;
}

/* Entry of a null vector in a column; 0 if there is none. */
static double find_entry(const null_vector *v, int column) {
  for (int i = 0; i < v->count; ++i)
    if (v->column[i] == column)
      return v->value[i];
  return 0.0;
}

/* Eliminates the pivot column from the vectors that are not done. */
static bool eliminate_column(null_pivoting *h, int vector, const bool *is_done) {
  const null_vector *pivot_vector = &h->vectors[vector];
  int pivot = pivot_vector->largest;
  double value = find_entry(pivot_vector, pivot);
  for (int i = h->first[pivot]; i >= 0; i = h->holders[i].next) {
    int other = h->holders[i].vector;
    null_vector *v = &h->vectors[other];
    double share = is_done[other] || value == 0.0 ? 0.0 : find_entry(v, pivot) / value;
    count_visits(h, v);
    if (h->is_full || (share != 0.0 && !subtract_vector(h, pivot_vector, share, other)))
      return false;
    if (share != 0.0 || v->largest == pivot)
      find_largest(h, v);
  }
  return true;
}

/* Index in order[first … count-1] of the vector with the largest entry. */
static int find_next_pivot(const null_pivoting *h, const int *order, int first) {
  int best = first;
  for (int i = first + 1; i < h->count; ++i)
    if (h->vectors[order[i]].size > h->vectors[order[best]].size)
      best = i;
  return best;
}

/* Complete pivoting of the null vectors; chosen columns are postponed. */
static bool choose_columns(null_pivoting *h) {
  int *order = KM_ARENA_NEW(&h->arena, int, (size_t)h->count);
  bool *is_done = KM_ARENA_NEW(&h->arena, bool, (size_t)h->count), is_ok = !h->arena.failed;
  for (int i = 0; i < h->count && is_ok; ++i) {
    order[i] = i;
    find_largest(h, &h->vectors[i]);
  }
  for (int step = 0; step < h->count && is_ok; ++step) {
    /* later steps visit fewer entries */
    h->is_full = h->is_full || will_exceed(h, h->visits, step, 2.0 * entry_multiple(h, MAX_VISITS));
    int at = find_next_pivot(h, order, step), vector = order[at];
    null_vector *v = &h->vectors[vector];
    order[at] = order[step];
    order[step] = vector;
    if (v->largest >= 0 && !is_candidate(h, v->largest))
      find_largest(h, v);
    if (v->largest < 0)
      break;
    h->p->sparse->is_postponed[v->largest] = is_done[vector] = true;
    is_ok = !h->is_full && eliminate_column(h, vector, is_done);
  }
  return is_ok;
}

/* Chooses the independent columns by complete pivoting of the null vectors. */
bool km_sparse_choose_independent(km_factor *p, const bool *forced) {
  null_pivoting h = {.p = p, .forced = forced};
  bool changed = false;
  memset(p->sparse->is_postponed, 0, (size_t)p->columns * sizeof *p->sparse->is_postponed);
  bool chosen = create_null_vectors(&h) && choose_columns(&h);
  p->failed = p->failed || (!chosen && !h.is_full);
  km_arena_free(&h.arena);
  for (int k = 0; k < p->rank; ++k)
    changed = changed || p->sparse->is_postponed[p->column[k]];
  return changed && chosen;
}
