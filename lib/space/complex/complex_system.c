/* Choice of the equations and unknowns of the complex closure system (complex_closure.h, docs/theory.md 4.15). */
#include "space/complex/complex_closure.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "model/joint_type.h"
#include "space/complex/complex_chain.h"
#include "space/complex/complex_solve.h"

/* Pivots relative to the first one that count as 0 at a generic configuration: rounding of the elimination. */
static const double generic_rank_tolerance = 1e-10;
static const double generic_distance = 0.5; /* distance of the generic configuration: radians, sizes */
/* Relative change of a functional along a null vector that counts as 0. */
static const double passive_tolerance = 1e-7;

/* Number of loops with a column. */
static int count_loops(const km_complex_closure *c, int column) {
  int count = 0;
  for (int i = 0; i < c->sub->loop_count; ++i) {
    const km_loop *loop = &c->m->loops[c->m->loop_order[c->sub->loop_start + i]];
    for (int e = 0; e < loop->entry_count; ++e) {
      int first = c->m->entries[loop->entry_start + e].column;
      count += first == column ||
               (km_complex_is_ball(c, column) && first <= column && column < first + 3 && km_complex_is_ball(c, first));
    }
  }
  return count;
}

/* True if a step is a hinge, or a ball, where the frames of a loop meet: it turns no position there. */
static bool is_hinge_at_end(const km_planar_step *step, const km_loop *loop) {
  const double *point = loop->planar_closing_point[0];
  return !step->is_slide && step->to == loop->slot[0] && point[0] == 0.0 && point[1] == 0.0;
}

static bool is_ball_at_end(const km_step *step, const km_loop *loop) {
  return step->primitive == KM_BALL && step->to == loop->slot[0] && km_vec3_norm(loop->closing_frame[0].p) == 0.0;
}

/* Step of the ball joint, or planar hinge, that closes a loop and belongs to no other one; −1: none. */
static int find_closing_step(const km_complex_closure *c, const km_state *s, const km_program *program,
                             const km_loop *loop) {
  const km_mechanism *m = c->m;
  int chord = m->topology.chord[loop - m->loops];
  if (!loop->has_moving_point || loop->lambda != (program->planar ? 3 : 6))
    return -1;
  for (int i = 0; i < program->step_count; ++i) {
    int k = program->step_start + i;
    bool is_at_end = program->planar ? is_hinge_at_end(&m->planar_steps[k], loop) : is_ball_at_end(&m->steps[k], loop);
    int coordinate = program->planar ? m->planar_steps[k].coordinate : m->steps[k].coordinate;
    if (is_at_end && !s->locked[coordinate] && m->model->coordinates[coordinate].joint == chord &&
        count_loops(c, km_complex_column(c, coordinate)) == 1)
      return i;
  }
  return -1;
}

/* Finds the candidates for unknowns and equations. Returns the number of unknowns. */
static int number_candidates(km_complex_closure *c, const km_state *s, int *rows) {
  const km_mechanism *m = c->m;
  for (int k = 0; k < c->sub->columns; ++k)
    c->unknown_of[k] = s->locked[m->column_coordinate[c->sub->column_start + k]] ? -1 : 0;
  for (int r = 0; r < c->sub->rows; ++r)
    c->equation_of[r] = 0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      int place = program->loop_start + j;
      const km_loop *loop = &m->loops[m->loop_order[place]];
      int step = c->closing_step[place - c->sub->loop_start] = find_closing_step(c, s, program, loop);
      if (step < 0)
        continue;
      int first = program->planar ? m->planar_steps[program->step_start + step].coordinate
                                  : m->steps[program->step_start + step].coordinate;
      for (int k = 0; k < (program->planar ? 1 : 3); ++k) {
        c->unknown_of[km_complex_column(c, first) + k] = -1;
        c->equation_of[loop->row_start + (program->planar ? 2 : 3) + k] = -1;
      }
    }
  }
  int columns = 0;
  *rows = 0;
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->unknown_of[k] == 0)
      c->unknown_of[k] = columns++;
  for (int r = 0; r < c->sub->rows; ++r)
    if (c->equation_of[r] == 0)
      c->equation_of[r] = (*rows)++;
  return columns;
}

/* Work arrays of the choice. */
typedef struct choice {
  km_complex *J, *gradient;
  km_wide *reference, *generic; /* configurations */
  int *row, *column;
  int rows, unlocked; /* candidates for equations and unknowns */
} choice;

static void evaluate_all(const km_complex_closure *c, const choice *w, const km_wide *x) {
  km_complex_values values = {.J = w->J, .stride = w->unlocked, .functional = -1};
  km_complex_evaluate(c, x, &values);
}

/* Freedoms of the bodies: rank of the changes of random functionals along the null vectors of the eliminated J at the
 * generic configuration. S[n × n]: workspace, n null vectors. */
static int count_freedoms(km_complex_closure *c, const choice *w, int rank, uint64_t *random, km_complex *S) {
  int n = w->unlocked - rank;
  for (int k = 0; k < n; ++k) {
    km_complex_values values = {.functional = KM_TRACE, .gradient = w->gradient};
    km_complex_redraw_trace(c, random);
    km_complex_evaluate(c, w->generic, &values);
    double scale = 0.0;
    for (int j = 0; j < w->unlocked; ++j)
      scale += cabs(w->gradient[j]);
    for (int d = 0; d < n; ++d) {
      km_complex slope = w->gradient[w->column[rank + d]];
      for (int i = 0; i < rank; ++i)
        slope -= w->gradient[w->column[i]] * w->J[w->row[i] * w->unlocked + w->column[rank + d]];
      S[k * n + d] = cabs(slope) <= passive_tolerance * scale ? 0.0 : slope / scale;
    }
  }
  return km_complex_eliminate(S, n, n, passive_tolerance, w->row, w->column);
}

/* Numbers the chosen rows and columns; sparse columns come first. */
static void number_system(km_complex_closure *c, const choice *w, int size, const bool *is_row, const bool *is_column) {
  int n = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    c->equation_of[r] = is_row[r] ? n++ : -1;
  n = 0;
  for (int loops = 1; loops <= c->sub->loop_count; ++loops)
    for (int k = 0; k < c->sub->columns; ++k)
      if (is_column[k] && count_loops(c, k) == loops) {
        c->column_of[n] = k;
        w->column[k] = n++;
      }
  for (int k = 0; k < c->sub->columns; ++k)
    c->unknown_of[k] = is_column[k] ? w->column[k] : -1;
  c->size = size;
}

/* Marks the equations of rotations. */
static void mark_turns(km_complex_closure *c) {
  for (int i = 0; i < c->size; ++i)
    c->turn_of[i] = -1;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + j]];
      bool is_whole = true; /* a rotation of which some components are free has no quaternion */
      for (int r = 0; r < loop->lambda; ++r)
        is_whole = is_whole && (loop->rows[r] < (program->planar ? 2 : 3) || c->equation_of[loop->row_start + r] >= 0);
      for (int r = 0; r < loop->lambda && is_whole; ++r) {
        int equation = c->equation_of[loop->row_start + r];
        int component = loop->rows[r] - (program->planar ? 2 : 3);
        if (component < 0)
          continue;
        int turn = 4 * (program->loop_start + j - c->sub->loop_start);
        c->has_turn[turn] = c->has_turn[turn + 1 + (program->planar ? 2 : component)] = true;
        if (equation >= 0)
          c->turn_of[equation] = turn + 1 + (program->planar ? 2 : component);
      }
    }
  }
}

/* Chooses equations at the reference and unknowns at a generic configuration. Returns the number of freedoms of the
 * bodies that remain; 0 if the system is square. */
static int choose_system(km_complex_closure *c, const choice *w, double tolerance, uint64_t *random, km_arena *arena) {
  int rows = w->rows, unlocked = w->unlocked;
  int *column_of = KM_ARENA_NEW(arena, int, (size_t)c->sub->columns);
  int *row_of = KM_ARENA_NEW(arena, int, (size_t)c->sub->rows);
  bool *is_row = KM_ARENA_NEW(arena, bool, (size_t)c->sub->rows),
       *is_column = KM_ARENA_NEW(arena, bool, (size_t)c->sub->columns);
  if (arena->failed)
    return 0;
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->unknown_of[k] >= 0)
      column_of[c->unknown_of[k]] = k;
  for (int r = 0; r < c->sub->rows; ++r)
    if (c->equation_of[r] >= 0)
      row_of[c->equation_of[r]] = r;
  evaluate_all(c, w, w->generic);
  int rank = km_complex_eliminate(w->J, rows, unlocked, generic_rank_tolerance, w->row, w->column);
  km_complex *S = KM_ARENA_NEW(arena, km_complex, (size_t)((unlocked - rank) * (unlocked - rank)));
  int freedom = arena->failed ? 0 : count_freedoms(c, w, rank, random, S);
  if (freedom > 0 || arena->failed)
    return freedom;
  evaluate_all(c, w, w->reference);
  int closed_rank = km_complex_eliminate(w->J, rows, unlocked, tolerance, w->row, w->column);
  if (closed_rank < rank && rank < rows)
    return rank - closed_rank;
  /* All equations count at a singular configuration of independent loops. */
  for (int i = 0; i < rank; ++i)
    is_row[row_of[closed_rank < rank ? i : w->row[i]]] = true;
  int n = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    c->equation_of[r] = is_row[r] ? n++ : -1;
  evaluate_all(c, w, w->generic);
  km_complex_eliminate(w->J, rank, unlocked, generic_rank_tolerance, w->row, w->column);
  for (int i = 0; i < rank; ++i)
    is_column[column_of[w->column[i]]] = true;
  number_system(c, w, rank, is_row, is_column);
  mark_turns(c);
  c->passive = unlocked - rank;
  return 0;
}

/* Refuses joints that are not algebraic. */
static km_status check_joints(const km_mechanism *m, const km_substructure *sub, km_error *error) {
  if (sub->coupling_count > 0)
    return km_fail(error, KM_USAGE,
                   "couplings between joints have no finite number of assembly modes over the complex numbers; random "
                   "starts find some: kmob info --modes");
  for (int i = 0; i < sub->program_count; ++i) {
    const km_program *program = &m->programs[sub->program_start + i];
    for (int j = 0; j < program->step_count && !program->planar; ++j) {
      const km_step *step = &m->steps[program->step_start + j];
      if (step->primitive == KM_HELICAL)
        return km_fail(
            error, KM_USAGE,
            "joint \"%s\" is a screw, which has no finite number of assembly modes over the complex numbers; "
            "hold it, or let random starts find some: kmob info --modes",
            m->model->coordinates[step->coordinate].label);
    }
  }
  return KM_OK;
}

static void allocate(km_complex_closure *c, choice *w, km_arena *arena) {
  size_t rows = (size_t)c->sub->rows, columns = (size_t)c->sub->columns, most = rows > columns ? rows : columns;
  int steps = 0;
  c->start_of = KM_ARENA_NEW(arena, int, columns);
  c->unknown_of = KM_ARENA_NEW(arena, int, columns);
  c->equation_of = KM_ARENA_NEW(arena, int, rows);
  c->column_of = KM_ARENA_NEW(arena, int, most);
  c->closing_step = KM_ARENA_NEW(arena, int, (size_t)c->sub->loop_count);
  c->turn_of = KM_ARENA_NEW(arena, int, rows);
  c->has_turn = KM_ARENA_NEW(arena, bool, (size_t)(4 * c->sub->loop_count));
  for (int i = 0; i < c->sub->program_count; ++i)
    if (c->m->programs[c->sub->program_start + i].step_count > steps)
      steps = c->m->programs[c->sub->program_start + i].step_count;
  c->slot = KM_ARENA_NEW(arena, km_complex_pose, (size_t)c->m->largest_slots);
  c->wide_slot = KM_ARENA_NEW(arena, km_wide_pose, (size_t)c->m->largest_slots);
  c->displacement = KM_ARENA_NEW(arena, km_loop_displacement, (size_t)c->sub->loop_count);
  c->isotropic = KM_ARENA_NEW(arena, km_isotropic_pose, (size_t)c->m->largest_slots);
  c->wrench = km_arena_alloc(arena, (size_t)c->m->largest_slots, sizeof *c->wrench);
  c->twist = km_arena_alloc(arena, (size_t)(3 * steps), sizeof *c->twist);
  c->hub = KM_ARENA_NEW(arena, km_complex_hub, columns);
  c->is_hub = KM_ARENA_NEW(arena, bool, (size_t)c->m->step_count);
  c->rate = KM_ARENA_NEW(arena, km_complex, 4 * columns);
  c->step = KM_ARENA_NEW(arena, km_complex, columns);
  w->J = KM_ARENA_NEW(arena, km_complex, rows * columns);
  w->gradient = KM_ARENA_NEW(arena, km_complex, columns);
  w->reference = KM_ARENA_NEW(arena, km_wide, 4 * columns);
  w->generic = KM_ARENA_NEW(arena, km_wide, 4 * columns);
  w->row = KM_ARENA_NEW(arena, int, most);
  w->column = KM_ARENA_NEW(arena, int, most);
}

km_status km_complex_closure_create(const km_mechanism *m, km_state *s, int substructure, uint64_t *random,
                                    km_arena *arena, km_complex_closure *out, int *freedom, km_error *error) {
  const km_substructure *sub = &m->substructures[substructure];
  choice w = {0};
  *out = (km_complex_closure){.m = m, .sub = sub};
  *freedom = 0;
  km_status status = check_joints(m, sub, error);
  if (status)
    return status;
  allocate(out, &w, arena);
  if (!arena->failed) {
    km_complex_draw_weights(out, random, arena);
    km_complex_choose_hubs(out, s, arena);
  }
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  for (int k = 0; k < sub->columns; ++k) {
    out->start_of[k] = out->length;
    out->length += km_complex_begins_ball(out, k) ? 4 : !km_complex_is_ball(out, k);
  }
  w.unlocked = number_candidates(out, s, &w.rows);
  km_complex_from_state(out, s, w.reference);
  km_complex_randomise(out, w.reference, generic_distance, random, w.generic);
  double tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub));
  *freedom = choose_system(out, &w, tolerance, random, arena);
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  return *freedom == 0 ? KM_OK
                       : km_fail(error, KM_USAGE, "bodies can move in %d way%s", *freedom, *freedom == 1 ? "" : "s");
}

bool km_complex_has_all_rows(const km_complex_closure *c) {
  int count = 0, closing = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    count += c->equation_of[r] >= 0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j)
      if (c->closing_step[program->loop_start + j - c->sub->loop_start] >= 0)
        closing += program->planar ? 1 : 3;
  }
  return count + closing == c->sub->rows;
}
