/* Which entries of a substructure's Jacobian can be other than 0: a large one with few of them gets the sparse engine.
 */
#include "kinematics/state.h"

/* From there on it is faster than the dense engine on chains of four-bars (scripts/bench scale). */
enum { LEAST_ROWS = 24, LEAST_SHARE = 5 /* rows · columns over entries */ };

/* Calls `visit` with a run of rows for each place where a column of the substructure has entries. */
static void visit_entries(const km_mechanism *m, const km_substructure *sub, int *start, int *row,
                          void (*visit)(int *start, int *row, int column, int first, int count)) {
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    for (int l = 0; l < program->loop_count; ++l) {
      const km_loop *loop = &m->loops[m->loop_order[program->loop_start + l]];
      for (int e = 0; e < loop->entry_count; ++e) {
        const km_entry *entry = &m->entries[loop->entry_start + e];
        int freedom = program->planar ? 1 : km_primitive_freedom(m->steps[program->step_start + entry->step].primitive);
        for (int k = 0; k < freedom; ++k)
          visit(start, row, entry->column + k, loop->row_start, loop->lambda);
      }
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k)
      if (m->terms[coupling->term_start + k].column >= 0)
        visit(start, row, m->terms[coupling->term_start + k].column, coupling->row, 1);
  }
}

static void count_rows(int *start, int *row, int column, int first, int count) {
  (void)row;
  (void)first;
  start[column + 1] += count;
}

/* start[column] is where the next row of the column goes, and ends up where the column ends. */
static void add_rows(int *start, int *row, int column, int first, int count) {
  for (int r = 0; r < count; ++r)
    row[start[column]++] = first + r;
}

bool km_state_reserve_partition(const km_mechanism *m, km_state *s, int index) {
  const km_substructure *sub = &m->substructures[index];
  km_partition *p = &s->partition[index];
  if (sub->rows < LEAST_ROWS)
    return km_partition_reserve(p, sub->rows, sub->columns, &s->arena);
  int *start = KM_ARENA_NEW(&s->arena, int, (size_t)sub->columns + 2), *row = NULL;
  if (!start)
    return false;
  /* One place to the right of its own: filling moves each start to its column's end, the next one's start. */
  visit_entries(m, sub, start + 1, NULL, count_rows);
  for (int c = 0; c < sub->columns; ++c)
    start[c + 2] += start[c + 1];
  int entries = start[sub->columns + 1];
  if ((double)entries * LEAST_SHARE > (double)sub->rows * sub->columns)
    return km_partition_reserve(p, sub->rows, sub->columns, &s->arena);
  row = KM_ARENA_NEW(&s->arena, int, (size_t)entries);
  if (!row)
    return false;
  visit_entries(m, sub, start + 1, row, add_rows);
  return km_partition_reserve_sparse(p, sub->rows, sub->columns, start, row, &s->arena);
}
