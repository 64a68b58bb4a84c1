/* Closure errors and Jacobians by the compiled programs of steps (docs/theory.md 2.3, 2.5).
 *
 *   X_to = X_from · before · exp(h q)          pose of each slot, from the base outwards
 *   e    = log(X_a X_b⁻¹),   J_j = ±h_j        at a point o of the loop: v(o) = v + ω × o
 *   plane: slots are (angle, x, y), twists (v_x, v_y, ω)
 *
 * Rows are taken at a point of the loop, since loops far from each other on one base would lose digits about a common
 * point. A loop with all rows of v and ω may take the moving point where its frames meet; otherwise o is fixed in the
 * base. */
#include "kinematics/loop_equations.h"

#include "kinematics/primitive_motion.h"

/* Angle in [−π, π] that differs from `angle` by full turns. */
static inline double wrapped_angle(double angle) {
  if (fabs(angle) <= M_PI)
    return angle;
  double turns = angle * (0.5 * M_1_PI),
         full_turns = fabs(turns) < 1e12 ? turns + KM_ROUNDING - KM_ROUNDING : round(turns);
  return angle - 2.0 * M_PI * full_turns;
}

/* Forward kinematics of a planar program: poses of the slots and unit twists h of the steps, base outwards. */
static void compute_planar_poses(const km_program *program, const km_planar_step *steps, const double *q, double size,
                                 km_planar_pose *slot, km_twist *h) {
  double inverse = 1.0 / size;
  slot[0] = (km_planar_pose){0.0, 1.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < program->step_count; ++i) {
    const km_planar_step *step = &steps[i];
    const km_planar_pose *from = &slot[step->from];
    double c = from->cosine, s = from->sine, value = step->sign * q[step->coordinate];
    double x = from->x + c * step->x - s * step->y;
    double y = from->y + s * step->x + c * step->y;
    if (step->is_slide) {
      double ux = c * step->ux - s * step->uy, uy = s * step->ux + c * step->uy;
      value *= inverse;
      slot[step->to] = (km_planar_pose){from->angle, c, s, x + value * ux, y + value * uy};
      h[i] = (km_twist){{step->sign * ux, step->sign * uy, 0.0}, {0.0, 0.0, 0.0}};
    } else {
      double angle = from->angle + value, sine, cosine;
      km_sincos(angle, &sine, &cosine);
      slot[step->to] = (km_planar_pose){angle, cosine, sine, x, y};
      h[i] = (km_twist){{step->sign * y, -step->sign * x, step->sign}, {0.0, 0.0, 0.0}};
    }
  }
}

/* Closure error of a planar loop, the logarithm in SE(2): v = V⁻¹ p, V⁻¹ = [[α, φ/2], [−φ/2, α]], α = (φ/2) cot(φ/2),
 * about the point (x, y) of the first frame. Returns (v_x, v_y, φ). */
static km_vec3 planar_closure_error(const km_loop *loop, const km_planar_pose *slot, double point[2]) {
  const km_planar_pose *a = &slot[loop->slot[0]], *b = &slot[loop->slot[1]];
  const double *ca = loop->planar_closing_point[0], *cb = loop->planar_closing_point[1];
  double ax = a->x + a->cosine * ca[0] - a->sine * ca[1], ay = a->y + a->sine * ca[0] + a->cosine * ca[1];
  double bx = b->x + b->cosine * cb[0] - b->sine * cb[1], by = b->y + b->sine * cb[0] + b->cosine * cb[1];
  double dx = ax - bx - loop->planar_origin_offset[0], dy = ay - by - loop->planar_origin_offset[1];
  double angle_error = wrapped_angle(a->angle - b->angle + loop->planar_closing_angle);
  point[0] = ax;
  point[1] = ay;
  double cosine, sine, alpha;
  if (fabs(angle_error) < KM_SERIES_ANGLE) {
    double t2 = angle_error * angle_error, t4 = t2 * t2;
    cosine = 1.0 - 0.5 * t2 + t4 * (1.0 / 24.0);
    sine = angle_error * (1.0 - t2 * (1.0 / 6.0) + t4 * (1.0 / 120.0));
    alpha = 1.0 - t2 * (1.0 / 12.0) - t4 * (1.0 / 720.0);
  } else {
    km_sincos(angle_error, &sine, &cosine);
    alpha = 0.5 * angle_error * cos(0.5 * angle_error) / sin(0.5 * angle_error);
  }
  double px = cosine * dx - sine * dy, py = sine * dx + cosine * dy;
  return (km_vec3){alpha * px + 0.5 * angle_error * py, alpha * py - 0.5 * angle_error * px, angle_error};
}

/* Writes closure error and Jacobian columns ±h of a planar loop, shifted to its row point. */
static void update_planar_loop(const km_mechanism *m, const km_loop *loop, const km_planar_pose *slot,
                               const km_twist *h, km_twist *misfit, double *error, double *J) {
  double point[2];
  km_vec3 e = planar_closure_error(loop, slot, point);
  const double *o = loop->has_moving_point ? point : loop->planar_point;
  const double ox[2] = {o[0], o[0] - loop->planar_origin_offset[0]},
               oy[2] = {o[1], o[1] - loop->planar_origin_offset[1]};
  const double values[3] = {e.x - e.z * (oy[0] - point[1]), e.y + e.z * (ox[0] - point[0]), e.z};
  *misfit = (km_twist){{e.x, e.y, loop->fixed_misfit[2]}, {loop->fixed_misfit[3], loop->fixed_misfit[4], e.z}};
  for (int r = 0; r < loop->lambda; ++r)
    error[loop->row_start + r] = values[loop->rows[r]];
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    int side = entry->side < 0.0;
    km_vec3 v = h[entry->step].v;
    const double column[3] = {v.x - v.z * oy[side], v.y + v.z * ox[side], v.z};
    double *out = J + entry->value_index;
    for (int r = 0; r < loop->lambda; ++r)
      out[r] = entry->side * column[loop->rows[r]];
  }
}

/* Closure errors and Jacobian of all loops of a planar program. */
static void update_planar(const km_mechanism *m, km_state *s, const km_substructure *sub, const km_program *program) {
  km_twist *h = s->twist + program->twist_start;
  compute_planar_poses(program, m->planar_steps + program->step_start, s->q, sub->size, s->planar_slot, h);
  for (int i = 0; i < program->loop_count; ++i) {
    int l = m->loop_order[program->loop_start + i];
    update_planar_loop(m, &m->loops[l], s->planar_slot, h, &s->misfit[l], km_state_error(s, sub),
                       km_state_jacobian(s, sub));
  }
}

/* Pose after one step's motion from X; its unit twists into h. */
static km_pose apply_spatial_motion(const km_step *step, km_pose X, const km_state *s, double size, km_twist *h) {
  double value = step->sign * s->q[step->coordinate];
  if (step->primitive == KM_PRISMATIC)
    value /= size;
  const km_quaternion *ball = step->primitive == KM_BALL ? &s->ball[step->ball] : NULL;
  return km_motion_step((km_motion){step->primitive, step->axis}, step->sign, step->pitch, value, ball, X, h);
}

/* Forward kinematics of a spatial program: poses of the slots and unit twists of the steps, base outwards. */
static void compute_spatial_poses(const km_mechanism *m, km_state *s, const km_program *program, double size) {
  s->slot[0] = km_pose_identity();
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &m->steps[program->step_start + i];
    const km_pose *from = &s->slot[step->from];
    km_pose X = {step->has_rotation ? km_rotation_product(&from->R, &step->before.R) : from->R,
                 km_pose_point(from, step->before.p)};
    s->slot[step->to] = apply_spatial_motion(step, X, s, size, s->twist + program->twist_start + 3 * i);
  }
}

/* Writes closure error and Jacobian columns ±h of a spatial loop, shifted to its row point. */
static void update_spatial_loop(const km_mechanism *m, const km_program *program, const km_loop *loop,
                                const km_state *s, km_twist *misfit, km_vec3 *row_point, double *error, double *J) {
  km_pose a = km_pose_product(&s->slot[loop->slot[0]], &loop->closing_frame[0]);
  km_pose b = km_pose_product(&s->slot[loop->slot[1]], &loop->closing_frame[1]);
  km_vec3 first = loop->has_moving_point ? a.p : loop->point[0];
  *row_point = first;
  const km_vec3 o[2] = {first, km_vec3_sub(first, loop->origin_offset)};
  b.p = km_vec3_add(km_vec3_sub(b.p, a.p), loop->origin_offset);
  km_pose b_inverse = km_pose_inverse(&b), E = {km_rotation_product(&a.R, &b_inverse.R), km_rotate(&a.R, b_inverse.p)};
  *misfit = km_twist_log(&E);
  km_vec3 e = km_vec3_add(misfit->v, km_vec3_cross(misfit->w, km_vec3_sub(first, a.p)));
  const double values[6] = {e.x, e.y, e.z, misfit->w.x, misfit->w.y, misfit->w.z};
  for (int r = 0; r < loop->lambda; ++r)
    error[loop->row_start + r] = values[loop->rows[r]];
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    int freedom = km_primitive_freedom(m->steps[program->step_start + entry->step].primitive);
    int side = entry->side < 0.0;
    for (int k = 0; k < freedom; ++k) {
      const km_twist *h = &s->twist[program->twist_start + 3 * entry->step + k];
      km_vec3 v = km_vec3_add(h->v, km_vec3_cross(h->w, o[side]));
      const double column[6] = {v.x, v.y, v.z, h->w.x, h->w.y, h->w.z};
      double *out = J + entry->value_index + (size_t)k * entry->column_stride;
      for (int r = 0; r < loop->lambda; ++r)
        out[r] = entry->side * column[loop->rows[r]];
    }
  }
}

/* Closure errors and Jacobian of all loops of a spatial program. */
static void update_spatial(const km_mechanism *m, km_state *s, const km_substructure *sub, const km_program *program) {
  compute_spatial_poses(m, s, program, sub->size);
  for (int i = 0; i < program->loop_count; ++i) {
    int l = m->loop_order[program->loop_start + i];
    update_spatial_loop(m, program, &m->loops[l], s, &s->misfit[l], &s->row_point[l], km_state_error(s, sub),
                        km_state_jacobian(s, sub));
  }
}

/* Horner's scheme for a polynomial term and its derivative. */
double km_term_value(const km_mechanism *m, const km_state *s, const km_term *term, double *slope) {
  double x = s->q[term->coordinate] / m->unit[term->coordinate], value = 0.0;
  *slope = term->coefficient;
  if (term->curve_count == 0)
    return term->coefficient * x;
  *slope = 0.0;
  for (int k = term->curve_count - 1; k >= 0; --k) {
    *slope = *slope * x + value;
    value = value * x + m->curves[term->curve_start + k];
  }
  return value;
}

/* Horner's scheme for the second derivative of a polynomial term. */
double km_term_curvature(const km_mechanism *m, const km_state *s, const km_term *term) {
  double x = s->q[term->coordinate] / m->unit[term->coordinate];
  double value = 0.0, slope = 0.0, curvature = 0.0;
  for (int k = term->curve_count - 1; k >= 0; --k) {
    curvature = curvature * x + 2.0 * slope;
    slope = slope * x + value;
    value = value * x + m->curves[term->curve_start + k];
  }
  return curvature;
}

/* Errors of the couplings, and the Jacobian entries of polynomial terms. */
static void update_couplings(const km_mechanism *m, km_state *s, const km_substructure *sub) {
  double *error = km_state_error(s, sub), *J = km_state_jacobian(s, sub), slope;
  for (int i = 0; i < sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[sub->coupling_start + i];
    double sum = -coupling->constant;
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      sum += km_term_value(m, s, term, &slope);
      if (term->curve_count > 0 && term->column >= 0)
        J[term->value_index] = slope;
    }
    error[coupling->row] = sum;
  }
}

/* True if errors and Jacobian belong to the present configuration. Couplings contain held coordinates, which a saved
 * configuration omits, so substructures with couplings are always evaluated. */
static bool is_cached(const km_mechanism *m, const km_state *s, const km_substructure *sub,
                      const km_cached_configuration *cached) {
  return cached->is_valid && cached->mechanism_version == m->version && sub->coupling_count == 0 &&
         km_state_is_at(s, sub, cached->coordinates);
}

/* Evaluates closure errors and Jacobian of a substructure by all its programs and couplings. */
void km_loops_recompute(const km_mechanism *m, km_state *s, const km_substructure *sub) {
  km_cached_configuration *cached = &s->cached[sub - m->substructures];
  for (int i = 0; i < sub->program_count; ++i) {
    const km_program *program = &m->programs[sub->program_start + i];
    if (program->planar)
      update_planar(m, s, sub, program);
    else
      update_spatial(m, s, sub, program);
  }
  update_couplings(m, s, sub);
  if (s->has_locked[sub - m->substructures])
    km_state_clear_locked(s, sub);
  cached->is_valid = false;
}

/* Stores the present configuration as the one that errors and Jacobian belong to. */
void km_loops_cache(const km_mechanism *m, km_state *s, const km_substructure *sub) {
  km_cached_configuration *cached = &s->cached[sub - m->substructures];
  km_state_save(s, sub, cached->coordinates);
  cached->is_valid = true;
  cached->mechanism_version = m->version;
}

/* Evaluates errors and Jacobian unless they are cached. */
void km_loops_update(const km_mechanism *m, km_state *s, const km_substructure *sub) {
  if (is_cached(m, s, sub, &s->cached[sub - m->substructures]))
    return;
  if (s->cached[sub - m->substructures].mechanism_version != m->version)
    km_factor_forget(s->factor[sub - m->substructures]);
  km_loops_recompute(m, s, sub);
  km_loops_cache(m, s, sub);
}

/* Restores a configuration and evaluates it. */
void km_loops_restore_cached(const km_mechanism *m, km_state *s, int index, const double *saved) {
  const km_substructure *sub = &m->substructures[index];
  km_state_restore(s, sub, saved);
  km_loops_update(m, s, sub);
  km_state_invalidate_pivots(s, index);
}

/* Residual √(eᵀe/6) of the worst loop or coupling. */
double km_loops_worst(const km_mechanism *m, const km_state *s, const km_substructure *sub, int *worst) {
  double largest = 0.0;
  *worst = -1;
  for (int i = 0; i < sub->loop_count; ++i) {
    int l = m->loop_order[sub->loop_start + i];
    const km_twist *e = &s->misfit[l];
    double rms = sqrt((km_vec3_dot(e->v, e->v) + km_vec3_dot(e->w, e->w)) / 6.0);
    if (!(rms <= largest)) {
      largest = rms;
      *worst = l;
    }
  }
  for (int i = 0; i < sub->coupling_count; ++i) {
    double e = fabs(s->error[sub->error_start + m->couplings[sub->coupling_start + i].row]) / sqrt(6.0);
    if (!(e <= largest)) {
      largest = e;
      *worst = -1;
    }
  }
  return largest;
}

double km_loops_residual(const km_mechanism *m, const km_state *s, const km_substructure *sub) {
  int worst;
  return km_loops_worst(m, s, sub, &worst);
}
