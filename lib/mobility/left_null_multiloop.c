/* Left null vectors w, wᵀ J = 0, that span several loops (theory 7.1).
 *
 *   C_i    orthonormal complement of loop i's own left null vectors in its six rows
 *   R = [C_iᵀ J_i; couplings]: reduced rows; the null space of Rᵀ gives the vectors that span several loops
 *
 * Up to 240 rows: dense elimination, orthonormal vectors. Larger: one vector of the sparse factor per superfluous
 * row, each in few loops. A block is the rows of a loop or the row of a coupling. */
#include "base/number/tolerances.h"
#include "base/number/vectors.h"
#include "kinematics/loop_equations.h"
#include "local/local.h"
#include "mobility/left_null_space.h"

#include <string.h>

/* Most rows for the dense elimination. */
enum { MOST_DENSE_ROWS = 240 };

/* Computes the orthonormal complement C[6 × returned] of a loop's own null vectors W[6 × count] in its six rows, by
 * Gram-Schmidt on the axes with the largest remainder first. */
static int orthogonal_complement(const double *W, int count, double *C) {
  int found = 0;
  for (; count + found < 6; ++found) {
    double *best = C + 6 * found, largest = 0.0;
    for (int axis = 0; axis < 6; ++axis) {
      double v[6] = {0};
      v[axis] = 1.0;
      for (int pass = 0; pass < 2; ++pass) {
        for (int k = 0; k < count; ++k)
          km_remove_projection(W + 6 * k, v, 6);
        for (int k = 0; k < found; ++k)
          km_remove_projection(C + 6 * k, v, 6);
      }
      double size = km_dot(v, v, 6);
      for (int r = 0; r < 6 && size > 1.0001 * largest; ++r)
        best[r] = v[r] / sqrt(size);
      largest = fmax(largest, size);
    }
  }
  return found;
}

/* Reduced matrix R: the loops' rows projected on their complements, then the couplings' rows. */
typedef struct reduced_matrix {
  const km_left_space *a;
  int rows;
  double *C;           /* [36 · loop] complements */
  int *first;          /* [block + 1] first row of each block */
  double *entries;     /* row after row of R, compressed: */
  int *start, *column; /* columns of row r: column[start[r] … start[r + 1]-1] */
  int block, next;     /* block being filled, and the next entry of its first row */
} reduced_matrix;

static bool find_complements(reduced_matrix *R, const km_left_null *null, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  int loops = sub->loop_count;
  R->C = KM_ARENA_NEW(scratch, double, 36 * (size_t)loops);
  R->first = KM_ARENA_NEW(scratch, int, (size_t)(loops + sub->coupling_count) + 1);
  if (scratch->failed)
    return false;
  for (int i = 0; i < loops; ++i)
    R->first[i + 1] = R->first[i] + orthogonal_complement(null->local + 6 * null->first[i],
                                                          null->first[i + 1] - null->first[i], R->C + 36 * i);
  for (int i = loops; i < loops + sub->coupling_count; ++i)
    R->first[i + 1] = R->first[i] + 1;
  R->rows = R->first[loops + sub->coupling_count];
  return true;
}

static void write_column(void *out, int column, const double entry[6]) {
  reduced_matrix *R = out;
  int first = R->first[R->block];
  for (int k = 0; first + k < R->first[R->block + 1]; ++k) {
    int at = R->start[first + k] + R->next;
    R->entries[at] = km_dot(R->C + 36 * R->block + 6 * k, entry, 6);
    R->column[at] = column;
  }
  R->next++;
}

/* Writes a coupling's terms into its compressed row; NULL arrays: counts them only. Returns how many have a column. */
static int write_coupling_row(const reduced_matrix *R, int index, double *entries, int *column) {
  const km_left_space *a = R->a;
  const km_coupling *coupling = &a->m->couplings[a->sub->coupling_start + index];
  int count = 0;
  for (int k = 0; k < coupling->term_count; ++k) {
    const km_term *term = &a->m->terms[coupling->term_start + k];
    if (term->column < 0)
      continue;
    if (entries) {
      km_term_value(a->m, a->s, term, &entries[count]);
      column[count] = term->column;
    }
    ++count;
  }
  return count;
}

static bool count_entries(reduced_matrix *R, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  R->start = KM_ARENA_NEW(scratch, int, (size_t)R->rows + 1);
  if (!R->start)
    return false;
  for (int i = 0; i < sub->loop_count + sub->coupling_count; ++i) {
    int columns =
        i < sub->loop_count ? km_left_column_count(R->a, i) : write_coupling_row(R, i - sub->loop_count, NULL, NULL);
    for (int r = R->first[i]; r < R->first[i + 1]; ++r)
      R->start[r + 1] = R->start[r] + columns;
  }
  R->entries = KM_ARENA_NEW(scratch, double, (size_t)R->start[R->rows]);
  R->column = KM_ARENA_NEW(scratch, int, (size_t)R->start[R->rows]);
  return !scratch->failed;
}

static bool write_rows(reduced_matrix *R, km_arena *scratch) {
  const km_substructure *sub = R->a->sub;
  if (!count_entries(R, scratch))
    return false;
  for (R->block = 0; R->block < sub->loop_count; R->block++) {
    R->next = 0;
    km_left_for_each_column(R->a, R->block, write_column, R);
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    int at = R->start[R->first[sub->loop_count + i]];
    write_coupling_row(R, i, R->entries + at, R->column + at);
  }
  return true;
}

/* Extracts the part of a null vector w, of length `size`, in one block: the wrench of a loop, C w_i, or the force of
 * a coupling. */
static km_left_part extract_part(const reduced_matrix *R, const double *w, double size, int vector, int block) {
  km_left_part part = {.vector = vector, .block = block};
  int first = R->first[block], count = R->first[block + 1] - first;
  if (block >= R->a->sub->loop_count) {
    part.w[0] = w[first] / size;
    return part;
  }
  for (int k = 0; k < count; ++k)
    for (int r = 0; r < 6; ++r)
      part.w[r] += w[first + k] / size * R->C[36 * block + 6 * k + r];
  return part;
}

/* Adds a null vector w with entries in the given blocks (ascending), normalised, by its parts; zero parts are
 * omitted. False without memory. */
static bool add_vector(const reduced_matrix *R, const double *w, const int *blocks, int block_count, km_arena *arena,
                       size_t *capacity, km_left_null *out) {
  int count = out->part_start[out->spanning_count];
  double square = 0.0;
  for (int i = 0; i < block_count; ++i)
    for (int r = R->first[blocks[i]]; r < R->first[blocks[i] + 1]; ++r)
      square += w[r] * w[r];
  double size = sqrt(square);
  for (int i = 0; i < block_count; ++i) {
    double largest = 0.0;
    for (int r = R->first[blocks[i]]; r < R->first[blocks[i] + 1]; ++r)
      largest = fabs(w[r]) > largest ? fabs(w[r]) : largest;
    if (largest <= km_solved_rounding * size)
      continue;
    if (!km_arena_grow(arena, (void **)&out->part, capacity, (size_t)count + 1, sizeof *out->part))
      return false;
    out->part[count++] = extract_part(R, w, size, out->spanning_count, blocks[i]);
  }
  out->part_start[++out->spanning_count] = count;
  return true;
}

static bool reserve_vectors(int count, km_arena *arena, km_left_null *out) {
  out->part_start = KM_ARENA_NEW(arena, int, (size_t)count + 1);
  return out->part_start != NULL;
}

/* Computes orthonormal vectors from the reduced matrix, made dense. */
static bool solve_dense(reduced_matrix *R, km_arena *scratch, km_arena *arena, km_left_null *out) {
  size_t rows = (size_t)R->rows, columns = (size_t)R->a->sub->columns, capacity = 0;
  int block_count = R->a->sub->loop_count + R->a->sub->coupling_count;
  double *transposed = KM_ARENA_NEW(scratch, double, rows *columns), *W = NULL;
  int *blocks = KM_ARENA_NEW(scratch, int, (size_t)block_count);
  if (!write_rows(R, scratch))
    return false;
  for (size_t r = 0; r < rows; ++r)
    for (int i = R->start[r]; i < R->start[r + 1]; ++i)
      transposed[r * columns + (size_t)R->column[i]] = R->entries[i];
  int found = km_dense_null_space(transposed, (int)columns, R->rows, R->a->tolerance, scratch, &W);
  bool ok = found >= 0 && reserve_vectors(found, arena, out);
  for (int i = 0; i < block_count; ++i)
    blocks[i] = i;
  for (int n = 0; n < found && ok; ++n)
    ok = add_vector(R, W + (size_t)n * rows, blocks, block_count, arena, &capacity, out);
  out->is_orthonormal = true;
  return ok;
}

/* A sparse null vector by its entries, and the blocks that contain them. */
typedef struct sparse_vector {
  double *w;     /* [rows] 0 between vectors */
  int *row;      /* [rows + 1] */
  double *entry; /* [rows + 1] */
  int *block_of; /* [row] */
  int *blocks;   /* [block] */
  bool *is_met;  /* [block] */
} sparse_vector;

static bool reserve_vector(const reduced_matrix *R, km_arena *scratch, sparse_vector *v) {
  const km_substructure *sub = R->a->sub;
  size_t rows = (size_t)R->rows, blocks = (size_t)(sub->loop_count + sub->coupling_count);
  *v = (sparse_vector){.w = KM_ARENA_NEW(scratch, double, rows),
                       .row = KM_ARENA_NEW(scratch, int, rows + 1),
                       .entry = KM_ARENA_NEW(scratch, double, rows + 1),
                       .block_of = KM_ARENA_NEW(scratch, int, rows),
                       .blocks = KM_ARENA_NEW(scratch, int, blocks),
                       .is_met = KM_ARENA_NEW(scratch, bool, blocks)};
  for (int i = 0; i < sub->loop_count + sub->coupling_count && !scratch->failed; ++i)
    for (int r = R->first[i]; r < R->first[i + 1]; ++r)
      v->block_of[r] = i;
  return !scratch->failed;
}

/* Lists the blocks of the rows in v, each once and ascending. */
static int list_blocks(const reduced_matrix *R, sparse_vector *v, int rows) {
  int all = R->a->sub->loop_count + R->a->sub->coupling_count, count = 0;
  for (int i = 0; i < rows; ++i)
    v->is_met[v->block_of[v->row[i]]] = true;
  for (int i = 0; i < all; ++i)
    if (v->is_met[i]) {
      v->blocks[count++] = i;
      v->is_met[i] = false;
    }
  return count;
}

static bool add_sparse_vector(const reduced_matrix *R, const km_factor *p, int k, sparse_vector *v, km_arena *arena,
                              size_t *capacity, km_left_null *out) {
  int count = km_factor_null_entries(p, k, v->row, v->entry);
  for (int i = 0; i < count; ++i)
    v->w[v->row[i]] = v->entry[i];
  bool added = add_vector(R, v->w, v->blocks, list_blocks(R, v, count), arena, capacity, out);
  for (int i = 0; i < count; ++i)
    v->w[v->row[i]] = 0.0;
  return added;
}

/* Computes one vector for each superfluous row from the sparse factor of Rᵀ: that row and the rows of the factor that
 * combine to it. */
static bool solve_sparse(reduced_matrix *R, km_arena *scratch, km_arena *arena, km_left_null *out) {
  sparse_vector v;
  size_t capacity = 0;
  if (!reserve_vector(R, scratch, &v) || !write_rows(R, scratch))
    return false;
  const int columns = R->a->sub->columns;
  km_factor *p = km_factor_create_sparse(columns, R->rows, R->start, R->column, NULL, scratch);
  if (!p)
    return false;
  km_factor_compute(p, R->entries, columns, R->rows,
                    &(km_factor_options){.tolerance = R->a->tolerance, .basis = KM_BASIS_ENTRIES});
  int found = km_factor_freedom(p);
  bool ok = !km_factor_has_failed(p) && reserve_vectors(found, arena, out);
  for (int n = 0; n < found && ok; ++n)
    ok = add_sparse_vector(R, p, n, &v, arena, &capacity, out);
  return ok;
}

/* Sorts the parts by block, in the order of their vectors (counting sort). */
static bool sort_by_block(const km_left_space *a, km_arena *arena, km_left_null *out) {
  int blocks = a->sub->loop_count + a->sub->coupling_count, parts = out->part_start[out->spanning_count];
  out->block_start = KM_ARENA_NEW(arena, int, (size_t)blocks + 2);
  out->block_part = KM_ARENA_NEW(arena, int, (size_t)parts);
  if (arena->failed)
    return false;
  for (int i = 0; i < parts; ++i)
    out->block_start[out->part[i].block + 2]++;
  for (int i = 0; i < blocks; ++i)
    out->block_start[i + 2] += out->block_start[i + 1];
  /* block_start[block + 1] is the position of the next part while they are sorted, and the block's end afterwards. */
  for (int i = 0; i < parts; ++i)
    out->block_part[out->block_start[out->part[i].block + 1]++] = i;
  return true;
}

bool km_left_null_find_multiloop(const km_left_space *a, km_arena *arena, km_left_null *out) {
  km_arena scratch = {0};
  reduced_matrix R = {.a = a};
  bool found = find_complements(&R, out, &scratch) &&
               (R.rows <= MOST_DENSE_ROWS ? solve_dense : solve_sparse)(&R, &scratch, arena, out);
  km_arena_free(&scratch);
  return found && sort_by_block(a, arena, out);
}
