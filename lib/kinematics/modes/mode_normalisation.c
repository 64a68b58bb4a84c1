/* Random starts and normal forms of assembly modes (mode_normalisation.h). */
#include "kinematics/modes/mode_normalisation.h"
#include "base/number/tolerances.h"
#include "base/random.h"

#include "kinematics/assembly.h"

#include <string.h>

static const km_substructure *substructure_of(const km_mode_workspace *f) {
  return &f->m->substructures[f->substructure];
}

static int coordinate_of_column(const km_mode_workspace *f, int column) {
  return f->m->column_coordinate[substructure_of(f)->column_start + column];
}

bool km_mode_workspace_reserve(km_mode_workspace *f, km_arena *arena) {
  size_t columns = (size_t)substructure_of(f)->columns;
  f->saved = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *columns);
  f->before = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *columns);
  f->step = KM_ARENA_NEW(arena, double, columns);
  f->locked = KM_ARENA_NEW(arena, bool, (size_t)f->m->coordinate_count);
  if (!arena->failed)
    memcpy(f->locked, f->s->locked, (size_t)f->m->coordinate_count * sizeof *f->locked);
  return !arena->failed;
}

void km_mode_randomise(km_mode_workspace *f) {
  const km_substructure *sub = substructure_of(f);
  for (int k = 0; k < sub->columns; ++k) {
    int c = coordinate_of_column(f, k);
    f->step[k] = f->s->locked[c] ? 0.0
                                 : km_splitmix(&f->random, -1.0, 1.0) *
                                       (km_model_coordinate_is_length(f->m->model, c) ? 1.0 : M_PI);
  }
  km_state_move(f->m, f->s, sub, f->step);
}

bool km_mode_close(km_mode_workspace *f) {
  bool closed;
  f->failed = km_assemble_one(f->m, f->s, f->substructure, f->saved, &closed) || f->failed;
  return closed;
}

/* True if the coordinate belongs to the strut's slide or to the joint at either end. */
static bool belongs_to_strut(const km_mechanism *m, int strut, int coordinate) {
  const km_model *model = m->model;
  int slide = model->coordinates[strut].joint, joint = model->coordinates[coordinate].joint;
  return joint == slide || km_joint_body(model, joint, 1) == km_joint_body(model, slide, 0) ||
         km_joint_body(model, joint, 0) == km_joint_body(model, slide, 1);
}

/* Restores the locks. */
static void lock_again(km_mode_workspace *f) {
  km_state_unlock(f->s);
  for (int c = 0; c < f->m->coordinate_count; ++c)
    if (f->locked[c])
      km_state_lock(f->s, c);
}

/* Reverses a strut of negative length: its length becomes |q|, its own joints are closed again from random starts, all
 * others stay. False, with the state unchanged, if no start closes. */
static bool reverse_strut(km_mode_workspace *f, int strut) {
  enum { STARTS = 40 };
  const km_substructure *sub = substructure_of(f);
  bool is_reversed = false;
  km_state_save(f->s, sub, f->before);
  km_state_lock(f->s, strut);
  for (int k = 0; k < sub->columns; ++k)
    if (!belongs_to_strut(f->m, strut, coordinate_of_column(f, k)))
      km_state_lock(f->s, coordinate_of_column(f, k));
  for (int i = 0; i < STARTS && !is_reversed; ++i) {
    km_state_restore(f->s, sub, f->before);
    f->s->q[strut] = fabs(f->s->q[strut]);
    km_mode_randomise(f);
    is_reversed = km_mode_close(f);
  }
  lock_again(f);
  if (!is_reversed)
    km_state_restore(f->s, sub, f->before);
  return is_reversed;
}

/* Moves hinge angles by full turns to within half a turn of the original values, or into their limits. */
static void choose_full_turns(km_mode_workspace *f) {
  const km_substructure *sub = substructure_of(f);
  for (int k = 0; k < sub->columns && sub->coupling_count == 0; ++k) {
    int c = coordinate_of_column(f, k);
    double *q = &f->s->q[c];
    if (!km_coordinate_turns(f->m, c))
      continue;
    double turn = remainder(*q - f->original->q[c], 2.0 * M_PI);
    *q = f->original->q[c] + (turn < km_root_rounding - M_PI ? turn + 2.0 * M_PI : turn);
    if (*q > f->m->high[c])
      *q -= 2.0 * M_PI * ceil((*q - f->m->high[c]) / (2.0 * M_PI));
    else if (*q < f->m->low[c])
      *q += 2.0 * M_PI * ceil((f->m->low[c] - *q) / (2.0 * M_PI));
  }
}

/* Normalises a configuration: strut lengths of at least 0, hinge angles nearest to the original ones or within limits.
 * False if a strut could not be reversed. */
bool km_mode_normalise(km_mode_workspace *f) {
  bool is_reversed = true;
  for (int k = 0; k < substructure_of(f)->columns; ++k) {
    int c = coordinate_of_column(f, k);
    if (f->m->model->coordinates[c].is_strut && f->s->q[c] < 0.0 && !f->locked[c])
      is_reversed = reverse_strut(f, c) && is_reversed;
  }
  choose_full_turns(f);
  return is_reversed;
}
