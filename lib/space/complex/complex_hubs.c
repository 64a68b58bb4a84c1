/* Choice of the hubs of ball joints (complex_chain.c): of the slots behind the ball, but not behind another ball, that
 * at which most steps begin and loops end. */
#include "space/complex/complex_chain.h"

#include <string.h>

/* Number of steps and loop ends at each slot. */
static void count_uses(const km_mechanism *m, const km_program *program, int *uses) {
  memset(uses, 0, (size_t)program->slot_count * sizeof *uses);
  for (int i = 0; i < program->step_count; ++i)
    ++uses[m->steps[program->step_start + i].from];
  for (int i = 0; i < program->loop_count; ++i)
    for (int side = 0; side < 2; ++side)
      ++uses[m->loops[m->loop_order[program->loop_start + i]].slot[side]];
}

/* Chooses the hub of the ball of step i of a program. uses, step_to: [slots] workspace; step_to: the step that ends
 * at a slot behind the ball, −1: none. */
static void choose_hub(const km_complex_closure *c, const km_program *program, int i, const int *uses, int *step_to,
                       km_arena *arena, km_complex_hub *hub) {
  const km_step *steps = c->m->steps + program->step_start;
  int best = steps[i].to, count = 0;
  for (int k = 0; k < program->slot_count; ++k)
    step_to[k] = -1;
  step_to[best] = i;
  for (int k = i + 1; k < program->step_count; ++k)
    if (step_to[steps[k].from] >= 0 && steps[k].primitive != KM_BALL) {
      step_to[steps[k].to] = k;
      best = uses[steps[k].to] > uses[best] ? steps[k].to : best;
    }
  for (int slot = best; slot != steps[i].to; slot = steps[step_to[slot]].from)
    ++count;
  hub->steps = km_arena_alloc(arena, (size_t)count, sizeof *hub->steps);
  hub->count = arena->failed ? 0 : count;
  for (int slot = best; slot != steps[i].to && !arena->failed; slot = steps[step_to[slot]].from)
    hub->steps[--count] = &steps[step_to[slot]];
}

void km_complex_choose_hubs(km_complex_closure *c, const km_state *s, km_arena *arena) {
  const km_mechanism *m = c->m;
  int *uses = KM_ARENA_NEW(arena, int, (size_t)m->largest_slots);
  int *step_to = KM_ARENA_NEW(arena, int, (size_t)m->largest_slots);
  for (int i = 0; i < c->sub->program_count && !arena->failed; ++i) {
    const km_program *program = &m->programs[c->sub->program_start + i];
    if (program->planar)
      continue;
    count_uses(m, program, uses);
    for (int k = 0; k < program->step_count; ++k) {
      const km_step *step = &m->steps[program->step_start + k];
      km_complex_hub *hub = &c->hub[km_complex_column(c, step->coordinate)];
      if (step->primitive != KM_BALL)
        continue;
      if (!hub->ball && !s->locked[step->coordinate])
        choose_hub(c, program, k, uses, step_to, arena, hub);
      else
        hub->count = 0; /* a ball of two programs has another hub in each */
      hub->ball = step;
    }
  }
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->hub[k].count > 0)
      c->is_hub[c->hub[k].steps[c->hub[k].count - 1] - m->steps] = true;
}
