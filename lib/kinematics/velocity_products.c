/* The accelerations that constant rates make around the loops, and how they change with the rates. */
#include "kinematics/loop_equations.h"

/* Symbols: V twist of a slot against its base, ξ = h q̇ the twist of a step, c acceleration of a slot where q̈ = 0.
 * A column h is fixed in what carries the step, so ḣ = ad(V) h and c_to = c_from + ad(V_from) ξ. Around a closed loop
 * both sides turn alike: the point about which rows are taken may move. In a plane a twist is (x, y, turn), and
 * ad(V) ξ = (V_y ξ_t − V_t ξ_y, V_t ξ_x − V_x ξ_t, 0). By a rate the end's acceleration changes by ad(V_from) h, and through
 * the twists of the slots behind by ad(h) (V_end − V_to). */

static void planar_motions(const km_program *program, const km_planar_step *steps, const km_twist *h, double size,
                           const double *rate, km_slot_motion *slot) {
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

static void planar_slopes(const km_mechanism *m, const km_program *program, const km_loop *loop, const km_twist *h,
                          const km_slot_motion *slot, double *slopes) {
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    const km_planar_step *step = &m->planar_steps[program->step_start + entry->step];
    km_vec3 own = h[entry->step].v, end = slot[loop->slot[entry->side < 0.0]].twist.v;
    km_vec3 c = km_vec3_add(km_planar_bracket(slot[step->from].twist.v, own),
                            km_planar_bracket(own, km_vec3_sub(end, slot[step->to].twist.v)));
    const double values[3] = {c.x, c.y, 0.0};
    for (int r = 0; r < loop->lambda; ++r)
      slopes[entry->value_index + (size_t)r] = -entry->side * values[loop->rows[r]];
  }
}

static void planar_loop(const km_loop *loop, const km_slot_motion *slot, double *gamma) {
  km_vec3 c = km_vec3_sub(slot[loop->slot[1]].product.v, slot[loop->slot[0]].product.v);
  const double values[3] = {c.x, c.y, 0.0};
  for (int r = 0; r < loop->lambda; ++r)
    gamma[loop->row_start + r] = values[loop->rows[r]];
}

static void spatial_motions(const km_mechanism *m, const km_program *program, const km_twist *h, double size,
                            const double *rate, km_slot_motion *slot) {
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

/* The acceleration of a loop's end about the point of its rows, which lies `o` from the origin of that branch. */
static km_twist about(km_twist c, km_vec3 o) {
  return (km_twist){km_vec3_add(c.v, km_vec3_cross(c.w, o)), c.w};
}

static void spatial_loop(const km_loop *loop, const km_slot_motion *slot, km_vec3 place, double *gamma) {
  km_twist a = about(slot[loop->slot[0]].product, place);
  km_twist b = about(slot[loop->slot[1]].product, km_vec3_sub(place, loop->origin_offset));
  km_twist c = km_twist_axpy(-1.0, a, b);
  const double values[6] = {c.v.x, c.v.y, c.v.z, c.w.x, c.w.y, c.w.z};
  for (int r = 0; r < loop->lambda; ++r)
    gamma[loop->row_start + r] = values[loop->rows[r]];
}

static void spatial_slopes(const km_mechanism *m, const km_program *program, const km_loop *loop, const km_twist *h,
                           const km_slot_motion *slot, km_vec3 place, double *slopes) {
  const km_vec3 o[2] = {place, km_vec3_sub(place, loop->origin_offset)};
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    const km_step *step = &m->steps[program->step_start + entry->step];
    int side = entry->side < 0.0;
    km_twist behind = km_twist_axpy(-1.0, slot[step->to].twist, slot[loop->slot[side]].twist);
    for (int k = 0; k < km_primitive_freedom(step->primitive); ++k) {
      km_twist own = h[3 * entry->step + k];
      km_twist c = km_twist_axpy(1.0, km_twist_bracket(slot[step->from].twist, own), km_twist_bracket(own, behind));
      c = about(c, o[side]);
      const double values[6] = {c.v.x, c.v.y, c.v.z, c.w.x, c.w.y, c.w.z};
      for (int r = 0; r < loop->lambda; ++r)
        slopes[entry->value_index + (size_t)k * entry->column_stride + (size_t)r] =
            -entry->side * values[loop->rows[r]];
    }
  }
}

/* p″(x) ẋ² of a term of a coupling, and its derivative by ẋ; 0 where it is linear. */
static double bend(const km_mechanism *m, const km_state *s, const km_term *term, const double *rate,
                   double *slope_of) {
  double v = rate[term->coordinate] / m->unit[term->coordinate], curvature = km_term_curvature(m, s, term);
  *slope_of = 2.0 * curvature * v;
  return curvature * v * v;
}

/* Sets slot_motion of a program's slots. */
static void move_slots(const km_mechanism *m, km_state *s, const km_substructure *sub, const km_program *program,
                       const double *rate) {
  const km_twist *h = s->twist + program->twist_start;
  if (program->planar)
    planar_motions(program, m->planar_steps + program->step_start, h, sub->size, rate, s->slot_motion);
  else
    spatial_motions(m, program, h, sub->size, rate, s->slot_motion);
}

void km_loops_velocity_products(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *rate,
                                double *gamma) {
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    move_slots(m, s, sub, program, rate);
    for (int i = 0; i < program->loop_count; ++i) {
      int l = m->loop_order[program->loop_start + i];
      if (program->planar)
        planar_loop(&m->loops[l], s->slot_motion, gamma);
      else
        spatial_loop(&m->loops[l], s->slot_motion, s->row_point[l], gamma);
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    double sum = 0.0, slope;
    for (int k = 0; k < coupling->term_count; ++k)
      sum += bend(m, s, &m->terms[coupling->term_start + k], rate, &slope);
    gamma[coupling->row] = -sum;
  }
}

void km_loops_velocity_slopes(const km_mechanism *m, km_state *s, const km_substructure *sub, const double *rate,
                              double *slopes) {
  for (int p = 0; p < sub->program_count; ++p) {
    const km_program *program = &m->programs[sub->program_start + p];
    const km_twist *h = s->twist + program->twist_start;
    move_slots(m, s, sub, program, rate);
    for (int i = 0; i < program->loop_count; ++i) {
      int l = m->loop_order[program->loop_start + i];
      if (program->planar)
        planar_slopes(m, program, &m->loops[l], h, s->slot_motion, slopes);
      else
        spatial_slopes(m, program, &m->loops[l], h, s->slot_motion, s->row_point[l], slopes);
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      double slope;
      bend(m, s, term, rate, &slope);
      if (term->column >= 0)
        slopes[term->value_index] = -slope;
    }
  }
}
