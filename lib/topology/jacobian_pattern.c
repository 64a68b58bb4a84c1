/* How a substructure's Jacobian is stored: whole, or where it is large and has few entries, those that can differ from
 * 0.
 */
#include "topology/compile.h"

/* From there on the sparse engine is faster than the dense one on chains of four-bars (scripts/bench scale). */
enum { LEAST_ROWS = 24, LEAST_SHARE = 5 /* rows · columns over entries */ };

/* Calls `visit` for each run of rows that a column has entries in: of a loop's entry, or of a coupling's term. */
typedef void (*visitor)(void *context, int column, int first, int count, km_entry *entry, km_term *term);

static int entry_columns(const km_mechanism *m, const km_program *program, const km_entry *entry) {
  return program->planar ? 1 : km_primitive_freedom(m->steps[program->step_start + entry->step].primitive);
}

static void visit_loops(km_mechanism *m, const km_program *program, visitor visit, void *context) {
  for (int l = 0; l < program->loop_count; ++l) {
    const km_loop *loop = &m->loops[m->loop_order[program->loop_start + l]];
    for (int e = 0; e < loop->entry_count; ++e) {
      km_entry *entry = &m->entries[loop->entry_start + e];
      for (int k = 0; k < entry_columns(m, program, entry); ++k)
        visit(context, entry->column + k, loop->row_start, loop->lambda, k == 0 ? entry : NULL, NULL);
    }
  }
}

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

static void count_rows(void *context, int column, int first, int count, km_entry *entry, km_term *term) {
  int *start = context;
  (void)first;
  (void)entry;
  (void)term;
  start[column + 1] += count;
}

/* The next free place of each column. */
typedef struct filling {
  int *next, *row;
} filling;

static void place_rows(void *context, int column, int first, int count, km_entry *entry, km_term *term) {
  const filling *f = context;
  if (entry) { /* the columns of a ball hold the same rows, one column behind the other */
    entry->value_index = (size_t)f->next[column];
    entry->column_stride = (size_t)(f->next[column + 1] - f->next[column]);
  }
  if (term)
    term->value_index = (size_t)f->next[column];
  for (int r = 0; r < count; ++r)
    f->row[f->next[column]++] = first + r;
}

static void place_dense(void *context, int column, int first, int count, km_entry *entry, km_term *term) {
  const km_substructure *sub = context;
  size_t rows = (size_t)sub->rows, at = (size_t)column * rows + (size_t)first;
  for (int i = 0; i < count; ++i)
    sub->pattern.used[at + (size_t)i] = true;
  if (entry) {
    entry->value_index = at;
    entry->column_stride = rows;
  }
  if (term)
    term->value_index = at;
}

static bool store_all(km_mechanism *m, km_substructure *sub) {
  size_t size = (size_t)sub->rows * (size_t)sub->columns;
  sub->pattern = (km_pattern){.size = size, .used = KM_ARENA_NEW(&m->arena, bool, size)};
  if (sub->pattern.used)
    visit_all(m, sub, place_dense, sub);
  return sub->pattern.used != NULL;
}

static bool store_entries(km_mechanism *m, km_substructure *sub, int *start) {
  size_t columns = (size_t)sub->columns;
  km_arena scratch = {0};
  filling f = {KM_ARENA_NEW(&scratch, int, columns + 1), KM_ARENA_NEW(&m->arena, int, (size_t)start[columns])};
  bool done = f.next && f.row;
  for (size_t c = 0; done && c <= columns; ++c)
    f.next[c] = start[c];
  if (done)
    visit_all(m, sub, place_rows, &f);
  sub->pattern = (km_pattern){.start = start, .row = f.row, .size = (size_t)start[columns]};
  km_arena_free(&scratch);
  return done;
}

bool km_compile_pattern(km_mechanism *m, km_substructure *sub) {
  if (sub->rows < LEAST_ROWS)
    return store_all(m, sub);
  int *start = KM_ARENA_NEW(&m->arena, int, (size_t)sub->columns + 1);
  if (!start)
    return false;
  visit_all(m, sub, count_rows, start);
  for (int c = 0; c < sub->columns; ++c)
    start[c + 1] += start[c];
  if ((double)start[sub->columns] * LEAST_SHARE <= (double)sub->rows * sub->columns)
    return store_entries(m, sub, start);
  return store_all(m, sub);
}
