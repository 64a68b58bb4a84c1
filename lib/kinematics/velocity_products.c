/* Velocity products of the loops and their derivatives by the rates (docs/theory.md 2.6).
 *
 *   γ = −J̇ q̇,   ḣ = ad(V) h,   ξ = h q̇
 *   c_to = c_from + ad(V_from) ξ                             V, c: twist and acceleration (q̈ = 0) of a slot
 *   ∂c_end/∂q̇_j = ad(V_from) h_j + ad(h_j) (V_end − V_to)
 *   plane: twists (v_x, v_y, ω),  ad(V) ξ = (V_y ξ_ω − V_ω ξ_y, V_ω ξ_x − V_x ξ_ω, 0)
 *
 * Both sides of a closed loop rotate alike, so the point at which rows are taken may move. */
#include "kinematics/loop_equations.h"

/* Twists V and accelerations c of the slots of a planar program. */
static void compute_planar_slot_motions(const km_program *program, const km_planar_step *steps, const km_twist *h,
                                        double size, const double *rate, km_slot_motion *slot) {
  double inverse = 1.0 / size;
  slot[0] = (km_slot_motion){{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}};
  for (int i = 0; i < program->step_count; ++i) {
    const km_planar_step *step = &steps[i];
    km_vec3 V = slot[step->from].twist.v, c = slot[step->from].product.v;
    km_vec3 x = km_vec3_scale(step->is_slide ? rate[step->coordinate] * inverse : rate[step->coordinate], h[i].v);
    slot[step->to].twist.v = km_vec3_add(V, x);
    slot[step->to].product.v = (km_vec3){c.x + V.y * x.z - V.z * x.y, c.y + V.z * x.x - V.x * x.z, 0.0};
  }
}

/* ∂γ/∂q̇_j of a planar loop, by the entries of J. */
static void write_planar_derivatives(const km_mechanism *m, const km_program *program, const km_loop *loop,
                                     const km_twist *h, const km_slot_motion *slot, double *slopes) {
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    const km_planar_step *step = &m->planar_steps[program->step_start + entry->step];
    km_vec3 column = h[entry->step].v, end = slot[loop->slot[entry->side < 0.0]].twist.v;
    km_vec3 c = km_vec3_add(km_planar_bracket(slot[step->from].twist.v, column),
                            km_planar_bracket(column, km_vec3_sub(end, slot[step->to].twist.v)));
    const double values[3] = {c.x, c.y, 0.0};
    for (int r = 0; r < loop->lambda; ++r)
      slopes[entry->value_index + (size_t)r] = -entry->side * values[loop->rows[r]];
  }
}

/* γ of a planar loop: c_b − c_a of its two ends. */
static void write_planar_products(const km_loop *loop, const km_slot_motion *slot, double *gamma) {
  km_vec3 c = km_vec3_sub(slot[loop->slot[1]].product.v, slot[loop->slot[0]].product.v);
  const double values[3] = {c.x, c.y, 0.0};
  for (int r = 0; r < loop->lambda; ++r)
    gamma[loop->row_start + r] = values[loop->rows[r]];
}

/* Twists V and accelerations c of the slots of a spatial program. */
static void compute_spatial_slot_motions(const km_mechanism *m, const km_program *program, const km_twist *h,
                                         double size, const double *rate, km_slot_motion *slot) {
  slot[0] = (km_slot_motion){{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}};
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &m->steps[program->step_start + i];
    const km_slot_motion *from = &slot[step->from];
    const double *v = &rate[step->coordinate];
    km_twist x = {{0, 0, 0}, {0, 0, 0}};
    for (int k = 0; k < km_primitive_freedom(step->primitive); ++k)
      x = km_twist_axpy(step->primitive == KM_PRISMATIC ? v[k] / size : v[k], h[3 * i + k], x);
    slot[step->to] = (km_slot_motion){km_twist_axpy(1.0, x, from->twist),
                                      km_twist_axpy(1.0, km_twist_bracket(from->twist, x), from->product)};
  }
}

/* Shifts an acceleration to the point of the loop's rows, at `o` from the origin of the branch. */
static km_twist shift_to_point(km_twist c, km_vec3 o) {
  return (km_twist){km_vec3_add(c.v, km_vec3_cross(c.w, o)), c.w};
}

/* γ of a spatial loop: c_b − c_a of its two ends, at the loop's point. */
static void write_spatial_products(const km_loop *loop, const km_slot_motion *slot, km_vec3 point, double *gamma) {
  km_twist a = shift_to_point(slot[loop->slot[0]].product, point);
  km_twist b = shift_to_point(slot[loop->slot[1]].product, km_vec3_sub(point, loop->origin_offset));
  km_twist c = km_twist_axpy(-1.0, a, b);
  const double values[6] = {c.v.x, c.v.y, c.v.z, c.w.x, c.w.y, c.w.z};
  for (int r = 0; r < loop->lambda; ++r)
    gamma[loop->row_start + r] = values[loop->rows[r]];
}

/* ∂γ/∂q̇_j of a spatial loop, by the entries of J. */
static void write_spatial_derivatives(const km_mechanism *m, const km_program *program, const km_loop *loop,
                                      const km_twist *h, const km_slot_motion *slot, km_vec3 point, double *slopes) {
  const km_vec3 o[2] = {point, km_vec3_sub(point, loop->origin_offset)};
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    const km_step *step = &m->steps[program->step_start + entry->step];
    int side = entry->side < 0.0;
    km_twist twist_beyond = km_twist_axpy(-1.0, slot[step->to].twist, slot[loop->slot[side]].twist);
    for (int k = 0; k < km_primitive_freedom(step->primitive); ++k) {
      km_twist column = h[3 * entry->step + k];
      km_twist c =
          km_twist_axpy(1.0, km_twist_bracket(slot[step->from].twist, column), km_twist_bracket(column, twist_beyond));
      c = shift_to_point(c, o[side]);
      const double values[6] = {c.v.x, c.v.y, c.v.z, c.w.x, c.w.y, c.w.z};
      for (int r = 0; r < loop->lambda; ++r)
        slopes[entry->value_index + (size_t)k * entry->column_stride + (size_t)r] =
            -entry->side * values[loop->rows[r]];
    }
  }
}

/* p″(x) ẋ² of a term of a coupling, and its derivative by ẋ; 0 for a linear term. */
static double coupling_product(const km_mechanism *m, const km_state *s, const km_term *term, const double *rate,
                               double *derivative) {
  double v = rate[term->coordinate] / m->unit[term->coordinate], curvature = km_term_curvature(m, s, term);
  *derivative = 2.0 * curvature * v;
  return curvature * v * v;
}

/* Twists V and accelerations c of a program's slots, base outwards. */
static void compute_slot_motions(const km_mechanism *m, km_state *s, const km_substructure *sub,
                                 const km_program *program, const double *rate) {
  const km_twist *h = s->twist + program->twist_start;
  if (program->planar)
    compute_planar_slot_motions(program, m->planar_steps + program->step_start, h, sub->size, rate, s->slot_motion);
  else
    compute_spatial_slot_motions(m, program, h, sub->size, rate, s->slot_motion);
}

/* γ = −J̇ q̇ of all loops and couplings of a substructure. */
void km_loops_velocity_products(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *rate,
                                double *gamma) {
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    compute_slot_motions(m, s, sub, program, rate);
    for (int i = 0; i < program->loop_count; ++i) {
      int l = m->loop_order[program->loop_start + i];
      if (program->planar)
        write_planar_products(&m->loops[l], s->slot_motion, gamma);
      else
        write_spatial_products(&m->loops[l], s->slot_motion, s->row_point[l], gamma);
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    double sum = 0.0, slope;
    for (int k = 0; k < coupling->term_count; ++k)
      sum += coupling_product(m, s, &m->terms[coupling->term_start + k], rate, &slope);
    gamma[coupling->row] = -sum;
  }
}

/* ∂γ/∂q̇ of all loops and couplings, in the pattern of the Jacobian. */
void km_loops_velocity_slopes(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *rate,
                              double *slopes) {
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    const km_twist *h = s->twist + program->twist_start;
    compute_slot_motions(m, s, sub, program, rate);
    for (int i = 0; i < program->loop_count; ++i) {
      int l = m->loop_order[program->loop_start + i];
      if (program->planar)
        write_planar_derivatives(m, program, &m->loops[l], h, s->slot_motion, slopes);
      else
        write_spatial_derivatives(m, program, &m->loops[l], h, s->slot_motion, s->row_point[l], slopes);
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      double slope;
      coupling_product(m, s, term, rate, &slope);
      if (term->column >= 0)
        slopes[term->value_index] = -slope;
    }
  }
}
