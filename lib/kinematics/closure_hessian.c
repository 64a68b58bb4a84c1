/* Hessian of the closure along multipliers λ (docs/theory.md 2.7).
 *
 *   loops    : ∂²(λᵀe)/∂x_i ∂x_j = ½ side λᵀ[h_i, h_j],   joint i before joint j on one side, side = ±1
 *   couplings: λ_r c_r''(q_j) on the diagonal
 *
 * A column h_j is carried by the joints before it on its side, so log(… exp(h_i x_i) … exp(h_j x_j) …) has the term ½
 * [h_i, h_j] x_i x_j. Joints before both sides move the loop as a rigid body and add nothing. Bilinear terms only;
 * exact for closed loops up to terms that vanish along Jᵀ. */
#include "kinematics/loop_equations.h"

#include <string.h>

/* True if joint a lies before joint b on the same side of the loop. */
static bool is_before(const km_entry *a, const km_entry *b) {
  return a->side == b->side && a->step < b->step;
}

/* Lists the column pairs of the Hessian: two joints on one side of a loop. */
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

/* λᵀ[a, b] of planar twists (v_x, v_y, ω); the angular part of the bracket is 0. */
static double planar_bracket_product(const km_twist *a, const km_twist *b, const double wrench[6]) {
  km_vec3 c = km_planar_bracket(a->v, b->v);
  return wrench[0] * c.x + wrench[1] * c.y;
}

/* λᵀ[a, b] of spatial twists, with the bracket taken at the loop's point. */
static double spatial_bracket_product(const km_twist *a, const km_twist *b, km_vec3 point, const double wrench[6]) {
  km_twist c = km_twist_bracket(*a, *b);
  return km_vec3_dot(km_vec3_from_array(wrench), km_vec3_add(c.v, km_vec3_cross(c.w, point))) +
         km_vec3_dot(km_vec3_from_array(wrench + 3), c.w);
}

/* Hessian entries of one loop, in the order of km_loops_hessian_entries. Returns their number. */
static int compute_loop_hessian(const km_mechanism *m, const km_state *s, const km_program *program, int l,
                                const double *multiplier, double *hessian) {
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
      km_vec3 point = first->side < 0.0 ? km_vec3_sub(s->row_point[l], loop->origin_offset) : s->row_point[l];
      double product =
          program->planar ? planar_bracket_product(a, b, wrench) : spatial_bracket_product(a, b, point, wrench);
      hessian[count++] = 0.5 * first->side * product;
    }
  return count;
}

/* Hessian of the closure: bilinear entries of the loops, diagonal entries of the couplings. */
void km_loops_hessian(const km_mechanism *m, const km_state *s, const km_substructure *sub, const double *multiplier,
                      double *hessian, double *diagonal) {
  memset(diagonal, 0, (size_t)sub->columns * sizeof *diagonal);
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    for (int i = 0; i < program->loop_count; ++i)
      hessian += compute_loop_hessian(m, s, program, m->loop_order[program->loop_start + i], multiplier, hessian);
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      if (term->column >= 0)
        diagonal[term->column] += multiplier[coupling->row] * km_term_curvature(m, s, term);
    }
  }
}
