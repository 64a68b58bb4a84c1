/* Storage of a substructure's Jacobian: dense, or for large sparse ones by the pattern of its entries (docs/theory.md
 * 2.3). */
#include "topology/compile.h"

/* Limits from which the sparse factor is faster than the dense one on chains of four-bars (scripts/bench scale). */
enum { MIN_SPARSE_ROWS = 24, MIN_SPARSITY = 5 /* rows · columns over entries */ };

/* Callback for each range of rows with entries of a column: of a loop's entry (first column only), or of a coupling's
 * term. */
typedef void (*visitor)(void *context, int column, int first, int count, km_entry *entry, km_term *term);

static int entry_column_count(const km_mechanism *m, const km_program *program, const km_entry *entry) {
  return program->planar ? 1 : km_primitive_freedom(m->steps[program->step_start + entry->step].primitive);
}

static void visit_loops(km_mechanism *m, const km_program *program, visitor visit, void *context) {
  for (int l = 0; l < program->loop_count; ++l) {
    const km_loop *loop = &m->loops[m->loop_order[program->loop_start + l]];
    for (int e = 0; e < loop->entry_count; ++e) {
      km_entry *entry = &m->entries[loop->entry_start + e];
      for (int k = 0; k < entry_column_count(m, program, entry); ++k)
        visit(context, entry->column + k, loop->row_start, loop->lambda, k == 0 ? entry : NULL, NULL);
    }
  }
}

/* Visits the entries of all loops and couplings of a substructure. */
static void visit_all(km_mechanism *m, const km_substructure *sub, visitor visit, void *context) {
  for (int p = 0; p < sub->program_count; ++p)
    visit_loops(m, &m->programs[sub->program_start + p], visit, context);
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      km_term *term = &m->terms[coupling->term_start + k];
      if (term->column >= 0)
        visit(context, term->column, coupling->row, 1, NULL, term);
    }
  }
}

/* Counts the entries of a column. */
static void count_rows(void *context, int column, int first, int count, km_entry *entry, km_term *term) {
  int *start = context;
  (void)first;
  (void)entry;
  (void)term;
  start[column + 1] += count;
}

/* Next free index of each column, and the pattern's rows. */
typedef struct fill_position {
  int *next, *row;
} fill_position;

/* Stores the rows of a column, and the value index of the entry or term. */
static void store_pattern_rows(void *context, int column, int first, int count, km_entry *entry, km_term *term) {
  const fill_position *f = context;
  if (entry) { /* the columns of a ball motion have equal rows, one column after the other */
    entry->value_index = (size_t)f->next[column];
    entry->column_stride = (size_t)(f->next[column + 1] - f->next[column]);
  }
  if (term)
    term->value_index = (size_t)f->next[column];
  for (int r = 0; r < count; ++r)
    f->row[f->next[column]++] = first + r;
}

/* Marks the used entries of a dense Jacobian, and stores the value index of the entry or term. */
static void store_dense_indices(void *context, int column, int first, int count, km_entry *entry, km_term *term) {
  const km_substructure *sub = context;
  size_t rows = (size_t)sub->rows, index = (size_t)column * rows + (size_t)first;
  for (int i = 0; i < count; ++i)
    sub->pattern.used[index + (size_t)i] = true;
  if (entry) {
    entry->value_index = index;
    entry->column_stride = rows;
  }
  if (term)
    term->value_index = index;
}

/* Dense storage, with flags of entries that can be non-zero. */
static bool create_dense_pattern(km_mechanism *m, km_substructure *sub) {
  size_t size = (size_t)sub->rows * (size_t)sub->columns;
  sub->pattern = (km_pattern){.size = size, .used = KM_ARENA_NEW(&m->arena, bool, size)};
  if (sub->pattern.used)
    visit_all(m, sub, store_dense_indices, sub);
  return sub->pattern.used != NULL;
}

/* Sparse storage by columns. */
static bool create_sparse_pattern(km_mechanism *m, km_substructure *sub, int *start) {
  size_t columns = (size_t)sub->columns;
  km_arena scratch = {0};
  fill_position f = {KM_ARENA_NEW(&scratch, int, columns + 1), KM_ARENA_NEW(&m->arena, int, (size_t)start[columns])};
  bool is_ok = f.next && f.row;
  for (size_t c = 0; is_ok && c <= columns; ++c)
    f.next[c] = start[c];
  if (is_ok)
    visit_all(m, sub, store_pattern_rows, &f);
  sub->pattern = (km_pattern){.start = start, .row = f.row, .size = (size_t)start[columns]};
  km_arena_free(&scratch);
  return is_ok;
}

/* Chooses sparse storage for at least 24 rows with at most a fifth of the entries. */
bool km_compile_pattern(km_mechanism *m, km_substructure *sub) {
  if (sub->rows < MIN_SPARSE_ROWS)
    return create_dense_pattern(m, sub);
  int *start = KM_ARENA_NEW(&m->arena, int, (size_t)sub->columns + 1);
  if (!start)
    return false;
  visit_all(m, sub, count_rows, start);
  for (int c = 0; c < sub->columns; ++c)
    start[c + 1] += start[c];
  if ((double)start[sub->columns] * MIN_SPARSITY <= (double)sub->rows * sub->columns)
    return create_sparse_pattern(m, sub, start);
  return create_dense_pattern(m, sub);
}
