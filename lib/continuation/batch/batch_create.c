/* Memory of drives side by side, and the seats that they take in it. */
#include "continuation/batch/batch_arrays.h"

static km_lanes_number *numbers(km_arena *arena, int count) {
  return KM_ARENA_NEW(arena, km_lanes_number, (size_t)count + 1);
}

/* The numbers that make a place, one block of them. */
static void reserve_place(km_drive_lanes *l) {
  int columns = l->sub->columns, coordinates = l->m->coordinate_count;
  km_lanes_number **by_column[] = {&l->t, &l->last_t, &l->last_move, &l->rest};
  const int count = sizeof by_column / sizeof *by_column, per_ball = sizeof *l->ball / sizeof *l->q;
  l->place_count = (size_t)(coordinates + per_ball * l->m->ball_count + (count + KM_CURVE_MOVES) * columns);
  l->kept = KM_ARENA_NEW(&l->arena, km_lanes_number, l->place_count);
  l->q = KM_ARENA_NEW(&l->arena, km_lanes_number, l->place_count);
  if (!l->q)
    return;
  l->ball = (km_lane_quaternion *)(l->q + coordinates);
  km_lanes_number *next = l->q + coordinates + per_ball * l->m->ball_count;
  for (int i = 0; i < count; ++i, next += columns)
    *by_column[i] = next;
  for (int i = 0; i < KM_CURVE_MOVES; ++i, next += columns)
    l->past[i] = next;
}

/* Directions of motion are read of a row and of the two before it alone: rows share three places for them, in turn. Steps that are
 * no row's have their own. */
static void reserve_rows(km_drive_lanes *l) {
  size_t columns = (size_t)l->sub->columns;
  l->row_size = 2 * columns + 1;
  km_lanes_number *row = KM_ARENA_NEW(&l->arena, km_lanes_number, (KM_DRIVE_ROWS + 1) * l->row_size);
  km_lanes_number *z = KM_ARENA_NEW(&l->arena, km_lanes_number, 4 * columns);
  for (size_t r = 0; row && z && r <= KM_DRIVE_ROWS; ++r, row += l->row_size)
    l->rows[r] = (km_lane_row){row, z + (r < KM_DRIVE_ROWS ? r % 3 : 3) * columns, row + columns, row + 2 * columns};
}

/* For the programs of both kinds. */
static void reserve_loops(km_drive_lanes *l) {
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
    l->space_steps = KM_ARENA_NEW(arena, km_lane_space_step, (size_t)m->step_count);
    l->space_loops = KM_ARENA_NEW(arena, km_lane_space_loop, loops);
    l->poses = KM_ARENA_NEW(arena, km_lane_pose, slots);
    l->twists = KM_ARENA_NEW(arena, km_lane_twist, 3 * (size_t)m->step_count);
  }
}

static bool reserve(km_drive_lanes *l) {
  const km_mechanism *m = l->m;
  km_arena *arena = &l->arena;
  int columns = l->sub->columns, rows = l->sub->rows;
  l->is_length = KM_ARENA_NEW(arena, bool, (size_t)columns);
  l->is_ball = KM_ARENA_NEW(arena, bool, (size_t)columns);
  l->is_limited = KM_ARENA_NEW(arena, bool, (size_t)columns);
  l->from_ball = KM_ARENA_NEW(arena, km_lane_quaternion, (size_t)m->ball_count); /* also those outside the loops */
  reserve_loops(l);
  l->entries = KM_ARENA_NEW(arena, km_lane_entry, (size_t)m->entry_count + 1);
  l->couplings = KM_ARENA_NEW(arena, km_lane_coupling, (size_t)m->coupling_count + 1);
  l->coefficients = numbers(arena, m->term_count);
  l->term_unit = numbers(arena, m->term_count);
  l->J = numbers(arena, rows * (columns + 2));
  reserve_place(l);
  km_lanes_number **by_column[] = {&l->unit, &l->weight, &l->low, &l->high,      &l->from,
                                   &l->move, &l->next_t, &l->x,   &l->last_z[0], &l->last_z[1]};
  for (size_t i = 0; i < sizeof by_column / sizeof *by_column; ++i)
    *by_column[i] = numbers(arena, columns);
  for (int i = 0; i < 2; ++i)
    l->before[i] = l->last_z[i];
  int freedoms = columns < KM_LANES_FREEDOMS ? columns : KM_LANES_FREEDOMS;
  l->B = numbers(arena, rows * freedoms);
  l->Z = numbers(arena, columns * freedoms);
  km_lanes_number **by_row[] = {&l->error, &l->y, &l->inverse};
  for (size_t i = 0; i < sizeof by_row / sizeof *by_row; ++i)
    *by_row[i] = numbers(arena, rows);
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    l->stage[i] = numbers(arena, columns);
  reserve_rows(l);
  return km_replay_reserve(&l->replay, rows, columns, KM_DRIVE_LANES, arena);
}

km_status km_drive_lanes_create(km_arena *memory, km_drive *const *drives, int count, km_drive_lanes **out,
                                km_error *error) {
  *out = NULL;
  for (int i = 0; i < count; ++i)
    if (i == 0 ? !km_lanes_fit(drives[0]) : !km_lanes_same_structure(drives[0], drives[i]))
      return KM_OK;
  km_arena arena = km_arena_take(memory);
  km_drive_lanes *l = KM_ARENA_NEW(&arena, km_drive_lanes, 1); /* aligned as registers want it */
  if (l) {
    const km_drive *first = drives[0];
    *l = (km_drive_lanes){.arena = arena, .count = count, .m = first->c.mechanism, .sub = km_drive_driven(first)};
    l->coordinate = first->c.coordinate;
    l->column = first->c.column;
  } else {
    km_arena_free(&arena);
  }
  if (!l || !reserve(l)) {
    km_drive_lanes_free(memory, l);
    return km_fail(error, KM_MEMORY, "out of memory for a sweep");
  }
  km_lanes_take_structure(l);
  for (int i = 0; i < count; ++i) {
    l->drives[i] = drives[i];
    drives[i]->lanes = l;
    drives[i]->lane = i;
    km_lanes_take_numbers(l, i);
  }
  *out = l;
  return KM_OK;
}

void km_drive_lanes_free(km_arena *memory, km_drive_lanes *l) {
  if (!l)
    return;
  for (int i = 0; i < l->count; ++i) {
    if (!l->drives[i])
      continue;
    km_drive_settle(l->drives[i]);
    l->drives[i]->lanes = NULL;
  }
  km_arena arena = l->arena; /* in which `l` lies */
  km_arena_give(&arena, memory);
}
