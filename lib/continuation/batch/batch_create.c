/* Memory of a batch, and the assignment of motions to lanes. */
#include "continuation/batch/batch_arrays.h"

static km_batch_number *allocate_numbers(km_arena *arena, int count) {
  return KM_ARENA_NEW(arena, km_batch_number, (size_t)count + 1);
}

/* Allocates the block of the lanes' positions and its saved copy. */
static void allocate_position(km_batch *l) {
  int columns = l->sub->columns, coordinates = l->m->coordinate_count;
  km_batch_number **by_column[] = {&l->t, &l->last_t, &l->last_move, &l->remaining_step};
  const int count = sizeof by_column / sizeof *by_column, per_ball = sizeof *l->ball / sizeof *l->q;
  l->position_count = (size_t)(coordinates + per_ball * l->m->ball_count + (count + KM_CURVE_MOVES) * columns);
  l->saved = KM_ARENA_NEW(&l->arena, km_batch_number, l->position_count);
  l->q = KM_ARENA_NEW(&l->arena, km_batch_number, l->position_count);
  if (!l->q)
    return;
  l->ball = (km_lane_quaternion *)(l->q + coordinates);
  km_batch_number *next = l->q + coordinates + per_ball * l->m->ball_count;
  for (int i = 0; i < count; ++i, next += columns)
    *by_column[i] = next;
  for (int i = 0; i < KM_CURVE_MOVES; ++i, next += columns)
    l->past[i] = next;
}

/* Allocates the rows. Directions of motion are read in a row and the two before it only: rows share three vectors in
 * turn. Probes have their own. */
static void allocate_rows(km_batch *l) {
  size_t columns = (size_t)l->sub->columns;
  l->row_size = 2 * columns + 1;
  km_batch_number *row = KM_ARENA_NEW(&l->arena, km_batch_number, (KM_BATCH_ROWS + 1) * l->row_size);
  km_batch_number *z = KM_ARENA_NEW(&l->arena, km_batch_number, 4 * columns);
  for (size_t r = 0; row && z && r <= KM_BATCH_ROWS; ++r, row += l->row_size)
    l->rows[r] = (km_lane_row){row, z + (r < KM_BATCH_ROWS ? r % 3 : 3) * columns, row + columns, row + 2 * columns};
}

/* Allocates loops, steps and slots of planar and spatial programs. */
static void allocate_loops(km_batch *l) {
  const km_mechanism *m = l->m;
  km_arena *arena = &l->arena;
  size_t loops = (size_t)m->topology.loop_count, slots = (size_t)m->largest_slots;
  bool planar = false, spatial = false;
  for (int p = l->sub->program_start; p < l->sub->program_start + l->sub->program_count; ++p) {
    planar = planar || m->programs[p].planar;
    spatial = spatial || !m->programs[p].planar;
  }
  l->loops = KM_ARENA_NEW(arena, km_lane_loop, loops);
  if (planar) {
    l->steps = KM_ARENA_NEW(arena, km_lane_step, (size_t)m->planar_step_count);
    l->planar_loops = KM_ARENA_NEW(arena, km_lane_planar_loop, loops);
    l->slots = KM_ARENA_NEW(arena, km_lane_slot, slots);
    l->h = KM_ARENA_NEW(arena, km_lane_column, (size_t)m->twist_count);
  }
  if (spatial) {
    l->spatial_steps = KM_ARENA_NEW(arena, km_lane_spatial_step, (size_t)m->step_count);
    l->spatial_loops = KM_ARENA_NEW(arena, km_lane_spatial_loop, loops);
    l->poses = KM_ARENA_NEW(arena, km_lane_pose, slots);
    l->twists = KM_ARENA_NEW(arena, km_lane_twist, 3 * (size_t)m->step_count);
  }
}

static bool allocate_batch(km_batch *l) {
  const km_mechanism *m = l->m;
  km_arena *arena = &l->arena;
  int columns = l->sub->columns, rows = l->sub->rows;
  l->is_length = KM_ARENA_NEW(arena, bool, (size_t)columns);
  l->is_ball = KM_ARENA_NEW(arena, bool, (size_t)columns);
  l->is_limited = KM_ARENA_NEW(arena, bool, (size_t)columns);
  /* including those outside the loops */
  l->from_ball = KM_ARENA_NEW(arena, km_lane_quaternion, (size_t)m->ball_count);
  allocate_loops(l);
  l->entries = KM_ARENA_NEW(arena, km_lane_entry, (size_t)m->entry_count + 1);
  l->couplings = KM_ARENA_NEW(arena, km_lane_coupling, (size_t)m->coupling_count + 1);
  l->coefficients = allocate_numbers(arena, m->term_count);
  l->term_unit = allocate_numbers(arena, m->term_count);
  l->J = allocate_numbers(arena, rows * (columns + 2));
  allocate_position(l);
  km_batch_number **by_column[] = {&l->unit, &l->weight, &l->low, &l->high,      &l->from,
                                   &l->move, &l->next_t, &l->x,   &l->last_z[0], &l->last_z[1]};
  for (size_t i = 0; i < sizeof by_column / sizeof *by_column; ++i)
    *by_column[i] = allocate_numbers(arena, columns);
  for (int i = 0; i < 2; ++i)
    l->previous_z[i] = l->last_z[i];
  int freedoms = columns < KM_BATCH_FREEDOMS ? columns : KM_BATCH_FREEDOMS;
  l->B = allocate_numbers(arena, rows * freedoms);
  l->Z = allocate_numbers(arena, columns * freedoms);
  km_batch_number **by_row[] = {&l->error, &l->y, &l->inverse};
  for (size_t i = 0; i < sizeof by_row / sizeof *by_row; ++i)
    *by_row[i] = allocate_numbers(arena, rows);
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    l->stage[i] = allocate_numbers(arena, columns);
  allocate_rows(l);
  return km_recorded_elimination_reserve(&l->elimination, rows, columns, KM_BATCH_LANES, arena);
}

km_status km_batch_create(km_arena *memory, km_driver_motion *const *drives, int count, km_batch **out,
                          km_error *error) {
  *out = NULL;
  for (int i = 0; i < count; ++i)
    if (i == 0 ? !km_batch_fits(drives[0]) : !km_batch_has_same_structure(drives[0], drives[i]))
      return KM_OK;
  km_arena arena = km_arena_reuse(memory);
  km_batch *l = KM_ARENA_NEW(&arena, km_batch, 1); /* aligned for the widest registers */
  if (l) {
    const km_driver_motion *first = drives[0];
    *l = (km_batch){
        .arena = arena, .count = count, .m = first->c.mechanism, .sub = km_driver_motion_substructure(first)};
    l->coordinate = first->c.coordinate;
    l->column = first->c.column;
  } else {
    km_arena_free(&arena);
  }
  if (!l || !allocate_batch(l)) {
    km_batch_free(memory, l);
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  km_batch_copy_structure(l);
  for (int i = 0; i < count; ++i) {
    l->drives[i] = drives[i];
    drives[i]->lanes = l;
    drives[i]->lane = i;
    km_batch_copy_numbers(l, i);
  }
  *out = l;
  return KM_OK;
}

void km_batch_free(km_arena *memory, km_batch *l) {
  if (!l)
    return;
  for (int i = 0; i < l->count; ++i) {
    if (!l->drives[i])
      continue;
    km_driver_motion_write_back(l->drives[i]);
    l->drives[i]->lanes = NULL;
  }
  km_arena arena = l->arena; /* the batch itself lies in its arena */
  km_arena_recycle(&arena, memory);
}
