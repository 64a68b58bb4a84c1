/* How the rows of loops bend along their coordinates. */
#include "kinematics/loop_equations.h"

#include <string.h>

/* A column h_j is fixed in what carries its joint: the joints before it on its side of the loop turn it, so that
 * log(… exp(h_i x_i) … exp(h_j x_j) …) has ½ ad(h_i) h_j x_i x_j twice. Joints before both sides move the whole loop and bend nothing. */

static bool is_before(const km_entry *a, const km_entry *b) {
  return a->side == b->side && a->step < b->step;
}

int km_loops_hessian_entries(const km_mechanism *m, const km_substructure *sub, int *columns) {
  int count = 0;
  for (int l = 0; l < sub->loop_count; ++l) {
    const km_loop *loop = &m->loops[m->loop_order[sub->loop_start + l]];
    const km_entry *entries = &m->entries[loop->entry_start];
    for (int i = 0; i < loop->entry_count; ++i)
      for (int j = 0; j < loop->entry_count; ++j) {
        if (!is_before(&entries[i], &entries[j]))
          continue;
        if (columns) {
          columns[2 * count] = entries[i].column;
          columns[2 * count + 1] = entries[j].column;
        }
        ++count;
      }
  }
  return count;
}

/* Of (x, y, turn): the turn stays. */
static double planar_bend(const km_twist *a, const km_twist *b, const double wrench[6]) {
  km_vec3 c = km_planar_bracket(a->v, b->v);
  return wrench[0] * c.x + wrench[1] * c.y;
}

static double spatial_bend(const km_twist *a, const km_twist *b, km_vec3 place, const double wrench[6]) {
  km_twist c = km_twist_bracket(*a, *b);
  return km_vec3_dot(km_vec3_make(wrench), km_vec3_add(c.v, km_vec3_cross(c.w, place))) +
         km_vec3_dot(km_vec3_make(wrench + 3), c.w);
}

/* One loop's pairs, in the order of km_loops_hessian_entries; returns how many. */
static int bend_loop(const km_mechanism *m, const km_state *s, const km_program *program, int l,
                     const double *multiplier, double *pair) {
  const km_loop *loop = &m->loops[l];
  const km_entry *entries = &m->entries[loop->entry_start];
  const km_twist *h = s->twist + program->twist_start;
  double wrench[6] = {0};
  int count = 0, stride = program->planar ? 1 : 3;
  for (int r = 0; r < loop->lambda; ++r)
    wrench[loop->rows[r]] = multiplier[loop->row_start + r];
  for (int i = 0; i < loop->entry_count; ++i)
    for (int j = 0; j < loop->entry_count; ++j) {
      const km_entry *first = &entries[i], *second = &entries[j];
      if (!is_before(first, second))
        continue;
      const km_twist *a = &h[stride * first->step], *b = &h[stride * second->step];
      km_vec3 place = first->side < 0.0 ? km_vec3_sub(s->row_point[l], loop->origin_offset) : s->row_point[l];
      double bend = program->planar ? planar_bend(a, b, wrench) : spatial_bend(a, b, place, wrench);
      pair[count++] = 0.5 * first->side * bend;
    }
  return count;
}

void km_loops_hessian(const km_mechanism *m, const km_state *s, const km_substructure *sub, const double *multiplier,
                      double *pair, double *own) {
  memset(own, 0, (size_t)sub->columns * sizeof *own);
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    for (int i = 0; i < program->loop_count; ++i)
      pair += bend_loop(m, s, program, m->loop_order[program->loop_start + i], multiplier, pair);
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      if (term->column >= 0)
        own[term->column] += multiplier[coupling->row] * km_term_curvature(m, s, term);
    }
  }
}
