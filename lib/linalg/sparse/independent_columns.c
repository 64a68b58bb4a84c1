/* The choice of independent columns by complete pivoting of the null vectors, each by its entries: where these are local, a
 * step changes few of the others. */
#include "linalg/sparse/sparse_lu.h"

#include <math.h>
#include <string.h>

/* A null vector. */
typedef struct null_vector {
  int *column;
  double *value;
  int count;
  size_t capacity, value_capacity;
  int largest; /* the column of the largest entry, of those that may still become independent */
  double size; /* of that entry */
} null_vector;

/* A vector that has an entry in a column, and the next one there; -1: none. */
typedef struct holder {
  int vector, next;
} holder;

typedef struct choice {
  km_partition *p;
  const bool *forced;
  km_arena arena;
  null_vector *vectors;
  int count;
  int *first; /* [columns] the first holder of each */
  holder *holders;
  int holder_count;
  size_t holder_capacity;
  int *place;   /* [columns] of an entry in the vector at hand, over 0; 0: none */
  double looks; /* at entries of vectors, so far */
  bool full;    /* the vectors have become too long */
} choice;

/* Entries of all null vectors over those of the matrix, and of many of them how often entries are looked at, over the same. What
 * goes beyond takes more time than what a smaller B is worth; that of few vectors is worth any, since a basis is made of them. */
enum { MOST_FILL = 50, MOST_LOOKS = 2500 };

/* Entries of the matrix times so many. */
static double times_entries(const choice *h, int times) {
  return (double)times * h->p->sparse->start[h->p->columns];
}

/* Do the first `done` of as many as there are freedoms tell that all of them will come to more than `most`? */
static bool will_pass(const choice *h, double sum, int done, double most) {
  enum { TELLING = 20 };
  return done >= TELLING && km_partition_freedom(h->p) > KM_MANY_VECTORS &&
         sum * km_partition_freedom(h->p) > most * done;
}

/* One more look at all entries of a vector. */
static void count_looks(choice *h, const null_vector *v) {
  h->looks += v->count;
  h->full = h->full || (h->looks > times_entries(h, MOST_LOOKS) && km_partition_freedom(h->p) > KM_MANY_VECTORS);
}

static bool may_be_chosen(const choice *h, int c) {
  return !h->p->sparse->is_postponed[c] && !km_sparse_is_preset(h->p, h->forced, c);
}

/* Of equal entries that of the first column; without any other than 0 the first column of all. */
static void find_largest(choice *h, null_vector *v) {
  count_looks(h, v);
  v->largest = -1;
  v->size = 0.0;
  for (int i = 0; i < v->count; ++i) {
    int c = v->column[i];
    double size = fabs(v->value[i]);
    if (size > 0.0 && size >= v->size && (size > v->size || c < v->largest) && may_be_chosen(h, c)) {
      v->largest = c;
      v->size = size;
    }
  }
  for (int c = 0; c < h->p->columns && v->largest < 0; ++c)
    if (may_be_chosen(h, c))
      v->largest = c;
}

static bool append(choice *h, int vector, int column, double value) {
  null_vector *v = &h->vectors[vector];
  h->full = h->full || h->holder_count >= times_entries(h, MOST_FILL);
  if (h->full || !km_arena_grow(&h->arena, (void **)&v->column, &v->capacity, (size_t)v->count + 1, sizeof(int)) ||
      !km_arena_grow(&h->arena, (void **)&v->value, &v->value_capacity, (size_t)v->count + 1, sizeof(double)) ||
      !km_arena_grow(&h->arena, (void **)&h->holders, &h->holder_capacity, (size_t)h->holder_count + 1, sizeof(holder)))
    return false;
  v->column[v->count] = column;
  v->value[v->count++] = value;
  h->holders[h->holder_count] = (holder){vector, h->first[column]};
  h->first[column] = h->holder_count++;
  return true;
}

/* The null vectors of the independent columns that aren't given. */
static bool list_vectors(choice *h) {
  const km_partition *p = h->p;
  const km_sparse *s = p->sparse;
  h->vectors = KM_ARENA_NEW(&h->arena, null_vector, (size_t)(p->columns - p->rank));
  h->first = KM_ARENA_NEW(&h->arena, int, (size_t)p->columns);
  h->place = KM_ARENA_NEW(&h->arena, int, (size_t)p->columns);
  if (h->arena.failed)
    return false;
  for (int c = 0; c < p->columns; ++c)
    h->first[c] = -1;
  for (int k = p->rank; k < p->columns && !h->full; ++k) {
    if (km_sparse_is_preset(p, h->forced, p->column[k]))
      continue;
    bool listed = append(h, h->count, p->column[k], 1.0);
    km_entry_range b = km_sparse_b(p, k - p->rank);
    for (int i = b.start; i < b.end && listed; ++i)
      listed = append(h, h->count, p->column[s->b_store.index[i]], -s->b_store.value[i]);
    if (!listed)
      return false;
    ++h->count;
    h->full = h->full || will_pass(h, h->holder_count, h->count, times_entries(h, MOST_FILL));
  }
  return !h->full;
}

/* Takes `share` times a vector out of another one. */
static bool subtract(choice *h, const null_vector *own, double share, int vector) {
  null_vector *v = &h->vectors[vector];
  bool done = true;
  count_looks(h, v);
  for (int i = 0; i < v->count; ++i)
    h->place[v->column[i]] = i + 1;
  for (int i = 0, before = v->count; i < own->count && done; ++i) {
    int at = h->place[own->column[i]];
    if (at > 0 && at <= before)
      v->value[at - 1] -= share * own->value[i];
    else if (own->value[i] != 0.0)
      done = append(h, vector, own->column[i], -share * own->value[i]);
  }
  for (int i = 0; i < v->count; ++i)
    h->place[v->column[i]] = 0;
  return done;
}

static double entry_of(const null_vector *v, int column) {
  for (int i = 0; i < v->count; ++i)
    if (v->column[i] == column)
      return v->value[i];
  return 0.0;
}

/* The pivot is late now: the vectors that aren't `done` lose what they have in its column. */
static bool eliminate(choice *h, int vector, const bool *done) {
  const null_vector *own = &h->vectors[vector];
  int pivot = own->largest;
  double value = entry_of(own, pivot);
  for (int i = h->first[pivot]; i >= 0; i = h->holders[i].next) {
    int other = h->holders[i].vector;
    null_vector *v = &h->vectors[other];
    double share = done[other] || value == 0.0 ? 0.0 : entry_of(v, pivot) / value;
    count_looks(h, v);
    if (h->full || (share != 0.0 && !subtract(h, own, share, other)))
      return false;
    if (share != 0.0 || v->largest == pivot)
      find_largest(h, v);
  }
  return true;
}

/* Of the vectors in order[first … count-1], the place of that with the largest entry. */
static int next_of(const choice *h, const int *order, int first) {
  int best = first;
  for (int i = first + 1; i < h->count; ++i)
    if (h->vectors[order[i]].size > h->vectors[order[best]].size)
      best = i;
  return best;
}

static bool choose(choice *h) {
  int *order = KM_ARENA_NEW(&h->arena, int, (size_t)h->count);
  bool *done = KM_ARENA_NEW(&h->arena, bool, (size_t)h->count), whole = !h->arena.failed;
  for (int i = 0; i < h->count && whole; ++i) {
    order[i] = i;
    find_largest(h, &h->vectors[i]);
  }
  for (int step = 0; step < h->count && whole; ++step) {
    h->full = h->full || will_pass(h, h->looks, step, 2.0 * times_entries(h, MOST_LOOKS)); /* later steps take fewer */
    int at = next_of(h, order, step), vector = order[at];
    null_vector *v = &h->vectors[vector];
    order[at] = order[step];
    order[step] = vector;
    if (v->largest >= 0 && !may_be_chosen(h, v->largest))
      find_largest(h, v);
    if (v->largest < 0)
      break;
    h->p->sparse->is_postponed[v->largest] = done[vector] = true;
    whole = !h->full && eliminate(h, vector, done);
  }
  return whole;
}

bool km_sparse_choose_independent(km_partition *p, const bool *forced) {
  choice h = {.p = p, .forced = forced};
  bool changed = false;
  memset(p->sparse->is_postponed, 0, (size_t)p->columns * sizeof *p->sparse->is_postponed);
  bool chosen = list_vectors(&h) && choose(&h);
  p->failed = p->failed || (!chosen && !h.full);
  km_arena_free(&h.arena);
  for (int k = 0; k < p->rank; ++k)
    changed = changed || p->sparse->is_postponed[p->column[k]];
  return changed && chosen;
}
