/* Left null vectors that several loops have only together. Those of a small substructure are orthonormal. Those of a
 * large one come from the sparse factor, one for each constraint that the others make superfluous, so that each lies in
 * few loops. */
#include "kinematics/loop_equations.h"
#include "mobility/full_jacobian.h"
#include "mobility/left_null_space.h"

#include <stdlib.h>
#include <string.h>

/* Up to so many rows a dense matrix is solved, and the vectors are orthonormal. */
enum { MOST_DENSE_ROWS = 240 };
/* Entries of a unit vector below this are rounding. */
static const double least_part = 1e-12;

/* Subtracts from v what the unit vector has of it. */
static void subtract(double *v, const double *unit, int count) {
  double dot = 0.0;
  for (int r = 0; r < count; ++r)
    dot += unit[r] * v[r];
  for (int r = 0; r < count; ++r)
    v[r] -= dot * unit[r];
}

/* What is left of the six directions of a loop at right angles to its own null vectors W: orthonormal, C[6 × returned].
 */
static int complement(const double *W, int count, double *C) {
  int found = 0;
  for (; count + found < 6; ++found) {
    double *best = C + 6 * found, largest = 0.0;
    for (int axis = 0; axis < 6; ++axis) {
      double v[6] = {0}, size = 0.0;
      v[axis] = 1.0;
      for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < count; ++k)
          subtract(v, W + 6 * k, 6);
        for (int k = 0; k < found; ++k)
          subtract(v, C + 6 * k, 6);
      }
      for (int r = 0; r < 6; ++r)
        size += v[r] * v[r];
      for (int r = 0; r < 6 && size > 1.0001 * largest; ++r)
        best[r] = v[r] / sqrt(size);
      largest = fmax(largest, size);
    }
  }
  return found;
}

/* The loops' rows along their complements, then the couplings' rows. Its left null vectors are those of several loops
 * together. */
typedef struct reduced {
  const km_left_space *a;
  int rows;
  double *C;  /* [36 · loop] the complement of each loop */
  int *first; /* [loops + couplings + 1] the first row of each */
  /* J transposed, where the rows are filled: a row of entries after the other, or those that aren't 0 by `start`. */
  double *entries;
  int *start, *column; /* NULL: every row has all columns */
  int place, next;     /* the loop that is being filled, and the next entry of its first row */
} reduced;

static bool find_complements(reduced *R, const km_left_null *null, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  int loops = sub->loop_count;
  R->C = KM_ARENA_NEW(scratch, double, 36 * (size_t)loops);
  R->first = KM_ARENA_NEW(scratch, int, (size_t)(loops + sub->coupling_count) + 1);
  if (scratch->failed)
    return false;
  for (int i = 0; i < loops; ++i)
    R->first[i + 1] =
        R->first[i] + complement(null->local + 6 * null->first[i], null->first[i + 1] - null->first[i], R->C + 36 * i);
  for (int i = loops; i < loops + sub->coupling_count; ++i)
    R->first[i + 1] = R->first[i] + 1;
  R->rows = R->first[loops + sub->coupling_count];
  return true;
}

static double along(const reduced *R, int k, const double entry[6]) {
  const double *C = R->C + 36 * R->place + 6 * k;
  double sum = 0.0;
  for (int r = 0; r < 6; ++r)
    sum += C[r] * entry[r];
  return sum;
}

static void take_dense(void *out, int column, const double entry[6]) {
  reduced *R = out;
  int first = R->first[R->place];
  for (int k = 0; first + k < R->first[R->place + 1]; ++k)
    R->entries[(size_t)(first + k) * (size_t)R->a->sub->columns + (size_t)column] = along(R, k, entry);
}

static void take_sparse(void *out, int column, const double entry[6]) {
  reduced *R = out;
  int first = R->first[R->place];
  for (int k = 0; first + k < R->first[R->place + 1]; ++k) {
    int at = R->start[first + k] + R->next;
    R->entries[at] = along(R, k, entry);
    R->column[at] = column;
  }
  R->next++;
}

static void count_one(void *out, int column, const double entry[6]) {
  (void)column;
  (void)entry;
  ++*(int *)out;
}

/* The terms of a coupling that have a column, into its row. Returns how many. */
static int fill_coupling(const reduced *R, int index, double *entries, int *column) {
  const km_left_space *a = R->a;
  const km_coupling *coupling = &a->m->couplings[a->sub->coupling_start + index];
  int count = 0;
  for (int k = 0; k < coupling->term_count; ++k) {
    const km_term *term = &a->m->terms[coupling->term_start + k];
    if (term->column < 0)
      continue;
    if (entries)
      km_term_value(a->m, a->s, term, &entries[column ? count : term->column]);
    if (column)
      column[count] = term->column;
    ++count;
  }
  return count;
}

static bool fill_dense(reduced *R, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  R->entries = KM_ARENA_NEW(scratch, double, (size_t)R->rows *(size_t)sub->columns);
  if (!R->entries)
    return false;
  for (R->place = 0; R->place < sub->loop_count; R->place++)
    km_left_visit(R->a, R->place, take_dense, R);
  for (int i = 0; i < sub->coupling_count; ++i)
    fill_coupling(R, i, R->entries + (size_t)R->first[sub->loop_count + i] * (size_t)sub->columns, NULL);
  return true;
}

static bool count_entries(reduced *R, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  R->start = KM_ARENA_NEW(scratch, int, (size_t)R->rows + 1);
  if (!R->start)
    return false;
  for (int i = 0; i < sub->loop_count + sub->coupling_count; ++i) {
    int columns = 0;
    if (i < sub->loop_count)
      km_left_visit(R->a, i, count_one, &columns);
    else
      columns = fill_coupling(R, i - sub->loop_count, NULL, NULL);
    for (int r = R->first[i]; r < R->first[i + 1]; ++r)
      R->start[r + 1] = R->start[r] + columns;
  }
  R->entries = KM_ARENA_NEW(scratch, double, (size_t)R->start[R->rows]);
  R->column = KM_ARENA_NEW(scratch, int, (size_t)R->start[R->rows]);
  return !scratch->failed;
}

static bool fill_sparse(reduced *R, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  if (!count_entries(R, scratch))
    return false;
  for (R->place = 0; R->place < sub->loop_count; R->place++) {
    R->next = 0;
    km_left_visit(R->a, R->place, take_sparse, R);
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    int at = R->start[R->first[sub->loop_count + i]];
    fill_coupling(R, i, R->entries + at, R->column + at);
  }
  return true;
}

/* The part that a null vector w of the reduced rows, of that size, has in one place. */
static km_left_part part_of(const reduced *R, const double *w, double size, int vector, int place) {
  km_left_part part = {.vector = vector, .place = place};
  int first = R->first[place], count = R->first[place + 1] - first;
  if (place >= R->a->sub->loop_count) {
    part.w[0] = w[first] / size;
    return part;
  }
  for (int k = 0; k < count; ++k)
    for (int r = 0; r < 6; ++r)
      part.w[r] += w[first + k] / size * R->C[36 * place + 6 * k + r];
  return part;
}

/* A null vector w that has entries in the rows of these places, in ascending order, as unit vector in its parts; those that
 * are 0 are left out. False when out of memory. */
static bool add_vector(const reduced *R, const double *w, const int *places, int place_count, km_arena *arena,
                       size_t *room, km_left_null *out) {
  int count = out->part_start[out->whole_count];
  double square = 0.0;
  for (int i = 0; i < place_count; ++i)
    for (int r = R->first[places[i]]; r < R->first[places[i] + 1]; ++r)
      square += w[r] * w[r];
  double size = sqrt(square);
  for (int i = 0; i < place_count; ++i) {
    double largest = 0.0;
    for (int r = R->first[places[i]]; r < R->first[places[i] + 1]; ++r)
      largest = fabs(w[r]) > largest ? fabs(w[r]) : largest;
    if (largest <= least_part * size)
      continue;
    if (!km_arena_grow(arena, (void **)&out->part, room, (size_t)count + 1, sizeof *out->part))
      return false;
    out->part[count++] = part_of(R, w, size, out->whole_count, places[i]);
  }
  out->part_start[++out->whole_count] = count;
  return true;
}

static bool reserve_vectors(int count, km_arena *arena, km_left_null *out) {
  out->part_start = KM_ARENA_NEW(arena, int, (size_t)count + 1);
  return out->part_start != NULL;
}

/* Orthonormal vectors. */
static bool solve_dense(reduced *R, km_arena *scratch, km_arena *arena, km_left_null *out) {
  size_t rows = (size_t)R->rows, room = 0;
  double *W = KM_ARENA_NEW(scratch, double, rows *rows);
  if (!W || !fill_dense(R, scratch))
    return false;
  int found = km_left_solve(R->entries, R->a->sub->columns, R->rows, R->a->tolerance, scratch, W);
  int place_count = R->a->sub->loop_count + R->a->sub->coupling_count;
  int *places = KM_ARENA_NEW(scratch, int, (size_t)place_count);
  bool whole = found >= 0 && places && reserve_vectors(found, arena, out);
  for (int i = 0; i < place_count && whole; ++i)
    places[i] = i;
  for (int n = 0; n < found && whole; ++n)
    whole = add_vector(R, W + (size_t)n * rows, places, place_count, arena, &room, out);
  out->orthonormal = true;
  return whole;
}

/* A null vector by its entries, and the places in whose rows they are. */
typedef struct sparse_vector {
  double *w;     /* [rows] 0 between vectors */
  int *row;      /* [rows + 1] */
  double *entry; /* [rows + 1] */
  int *place_of; /* [row] */
  int *places;   /* [place] */
  bool *is_met;  /* [place] */
} sparse_vector;

static bool reserve_vector(const reduced *R, km_arena *scratch, sparse_vector *v) {
  const km_substructure *sub = R->a->sub;
  size_t rows = (size_t)R->rows, places = (size_t)(sub->loop_count + sub->coupling_count);
  *v = (sparse_vector){.w = KM_ARENA_NEW(scratch, double, rows),
                       .row = KM_ARENA_NEW(scratch, int, rows + 1),
                       .entry = KM_ARENA_NEW(scratch, double, rows + 1),
                       .place_of = KM_ARENA_NEW(scratch, int, rows),
                       .places = KM_ARENA_NEW(scratch, int, places),
                       .is_met = KM_ARENA_NEW(scratch, bool, places)};
  for (int i = 0; i < sub->loop_count + sub->coupling_count && !scratch->failed; ++i)
    for (int r = R->first[i]; r < R->first[i + 1]; ++r)
      v->place_of[r] = i;
  return !scratch->failed;
}

static int ascending(const void *a, const void *b) {
  int x = *(const int *)a, y = *(const int *)b;
  return (x > y) - (x < y);
}

/* The places of the rows, each once and ascending. Of many rows they are found by looking at all places. */
static int list_places(const reduced *R, sparse_vector *v, int rows) {
  int all = R->a->sub->loop_count + R->a->sub->coupling_count, count = 0;
  bool many = rows > all / 16;
  for (int i = 0; i < rows; ++i) {
    int place = v->place_of[v->row[i]];
    if (!v->is_met[place] && !many)
      v->places[count++] = place;
    v->is_met[place] = true;
  }
  for (int i = 0; i < all && many; ++i)
    if (v->is_met[i])
      v->places[count++] = i;
  if (!many)
    qsort(v->places, (size_t)count, sizeof *v->places, ascending);
  for (int i = 0; i < count; ++i)
    v->is_met[v->places[i]] = false;
  return count;
}

static bool add_sparse_vector(const reduced *R, const km_partition *p, int k, sparse_vector *v, km_arena *arena,
                              size_t *room, km_left_null *out) {
  int count = km_partition_null_entries(p, k, v->row, v->entry);
  for (int i = 0; i < count; ++i)
    v->w[v->row[i]] = v->entry[i];
  bool added = add_vector(R, v->w, v->places, list_places(R, v, count), arena, room, out);
  for (int i = 0; i < count; ++i)
    v->w[v->row[i]] = 0.0;
  return added;
}

/* One vector for each superfluous row: the row itself and those of the factor that make it up. */
static bool solve_sparse(reduced *R, km_arena *scratch, km_arena *arena, km_left_null *out) {
  km_partition p;
  sparse_vector v;
  size_t room = 0;
  if (!reserve_vector(R, scratch, &v) || !fill_sparse(R, scratch) ||
      !km_partition_reserve_sparse(&p, R->a->sub->columns, R->rows, R->start, R->column, scratch))
    return false;
  p.unrestricted_basis = true;
  km_partition_factor(&p, R->entries, R->a->sub->columns, R->rows, NULL, R->a->tolerance);
  int found = km_partition_freedom(&p);
  bool whole = !p.failed && reserve_vectors(found, arena, out);
  for (int n = 0; n < found && whole; ++n)
    whole = add_sparse_vector(R, &p, n, &v, arena, &room, out);
  return whole;
}

/* The parts of each place, in the order of their vectors. */
static bool list_by_place(const km_left_space *a, km_arena *arena, km_left_null *out) {
  int places = a->sub->loop_count + a->sub->coupling_count, parts = out->part_start[out->whole_count];
  out->at_start = KM_ARENA_NEW(arena, int, (size_t)places + 2);
  out->at = KM_ARENA_NEW(arena, int, (size_t)parts);
  if (arena->failed)
    return false;
  for (int i = 0; i < parts; ++i)
    out->at_start[out->part[i].place + 2]++;
  for (int i = 0; i < places; ++i)
    out->at_start[i + 2] += out->at_start[i + 1];
  /* at_start[place + 1] is where its next part goes, and ends up where the place's parts end. */
  for (int i = 0; i < parts; ++i)
    out->at[out->at_start[out->part[i].place + 1]++] = i;
  return true;
}

bool km_left_null_find_multiloop(const km_left_space *a, km_arena *arena, km_left_null *out) {
  km_arena scratch = {0};
  reduced R = {.a = a};
  bool found = find_complements(&R, out, &scratch) &&
               (R.rows <= MOST_DENSE_ROWS ? solve_dense : solve_sparse)(&R, &scratch, arena, out);
  km_arena_free(&scratch);
  return found && list_by_place(a, arena, out);
}
