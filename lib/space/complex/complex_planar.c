/* Planar loops in isotropic coordinates (complex_closure.h).
 *
 *   hinge at Z_h : Z_to = Z + U d,  U_to = U exp(iq),   ∂Z_end/∂q = i (Z_end − Z_h),   ∂W_end/∂q = −i (W_end − W_h)
 *   slide        : Z_to = Z + U (d + q u),              ∂Z_end/∂q = U u,               ∂W_end/∂q = V ū
 *   E            : Z -> Z_a + A (Z − Z_b),  W -> W_a + (W − W_b)/A,  A = U_a V_b exp(i φ_0)
 *
 * Errors are the displacement by E of the point o: a fixed one, or the moving point Z_b (complex_loops.h). */
#include "space/complex/complex_loops.h"

/* Poses of the slots and, of each step, the derivatives (Z, W) of a slide or the place (Z, W) of a hinge. */
static void compute_slots(const km_complex_closure *c, const km_program *program, const km_wide *x,
                          km_isotropic_pose *slot, km_complex (*twist)[6]) {
  const km_planar_step *steps = c->m->planar_steps + program->step_start;
  slot[0] = (km_isotropic_pose){1.0, 1.0, 0.0, 0.0};
  for (int i = 0; i < program->step_count; ++i) {
    const km_planar_step *step = &steps[i];
    const km_isotropic_pose *from = &slot[step->from];
    km_complex d = km_complex_of(step->x, step->y),
               value = step->sign * (km_complex)x[c->start_of[km_complex_column(c, step->coordinate)]];
    km_complex Z = from->Z + from->U * d, W = from->W + from->V * conj(d);
    if (step->is_slide) {
      km_complex u = km_complex_of(step->ux, step->uy), dZ = from->U * u, dW = from->V * conj(u);
      slot[step->to] = (km_isotropic_pose){from->U, from->V, Z + value * dZ, W + value * dW};
      twist[i][0] = step->sign * dZ;
      twist[i][1] = step->sign * dW;
      twist[i][2] = 0.0;
    } else {
      double growth = exp(-cimag(value)), cosine = cos(creal(value)), sine = sin(creal(value));
      km_complex turn = km_complex_of(growth * cosine, growth * sine),
                 back = km_complex_of(cosine / growth, -sine / growth);
      slot[step->to] = (km_isotropic_pose){from->U * turn, from->V * back, Z, W};
      twist[i][0] = Z;
      twist[i][1] = W;
      twist[i][2] = step->sign;
    }
  }
}

/* Errors and Jacobian of one loop. */
static void evaluate_loop(const km_complex_closure *c, const km_program *program, km_complex_loop here,
                          const km_complex_values *out) {
  const km_loop *loop = here.loop;
  const km_complex *P = here.P;
  const km_isotropic_pose *slot = c->isotropic;
  const km_isotropic_pose *a = &slot[loop->slot[0]], *b = &slot[loop->slot[1]];
  km_complex ca = km_complex_of(loop->planar_closing_point[0][0], loop->planar_closing_point[0][1]);
  km_complex cb = km_complex_of(loop->planar_closing_point[1][0], loop->planar_closing_point[1][1]);
  km_complex offset = km_complex_of(loop->planar_origin_offset[0], loop->planar_origin_offset[1]);
  km_complex phase = km_complex_of(cos(loop->planar_closing_angle), sin(loop->planar_closing_angle));
  km_complex A = a->U * b->V * phase, B = a->V * b->U * conj(phase);
  km_complex Za = a->Z + a->U * ca, Wa = a->W + a->V * conj(ca);
  km_complex Zb = b->Z + b->U * cb + offset, Wb = b->W + b->V * conj(cb) + conj(offset);
  km_complex o = here.has_moving_point ? Zb : km_complex_of(loop->planar_point[0], loop->planar_point[1]);
  km_complex o_conjugate = here.has_moving_point ? Wb : km_complex_of(loop->planar_point[0], -loop->planar_point[1]);
  /* Images of o, by which joints on side a move it, and the factors by which those on side b do. */
  km_complex Z_image = Za + A * (o - Zb), W_image = Wa + B * (o_conjugate - Wb);
  km_complex Z_factor = here.has_moving_point ? 1.0 : A, W_factor = here.has_moving_point ? 1.0 : B;
  km_complex FZ = Z_image - o, FW = W_image - o_conjugate;
  km_complex rest = P ? A * (P[0] - KM_I * P[3]) / (P[0] + KM_I * P[3]) : A; /* A / G */
  const km_complex errors[3] = {0.5 * (FZ + FW), -0.5 * KM_I * (FZ - FW), -KM_I * (rest - 1.0)};
  for (int r = 0; out->F && r < loop->lambda; ++r)
    if (c->equation_of[loop->row_start + r] >= 0)
      out->F[c->equation_of[loop->row_start + r]] = errors[loop->rows[r]];
  for (int i = 0; out->J && i < loop->entry_count; ++i) {
    const km_entry *entry = &c->m->entries[loop->entry_start + i];
    const km_complex *h = c->twist[entry->step];
    bool is_slide = c->m->planar_steps[program->step_start + entry->step].is_slide;
    km_complex dZ, dW;
    if (entry->side > 0.0) {
      dZ = is_slide ? h[0] : KM_I * h[2] * (Z_image - h[0]);
      dW = is_slide ? h[1] : -KM_I * h[2] * (W_image - h[1]);
    } else {
      dZ = -Z_factor * (is_slide ? h[0] : KM_I * h[2] * (o - offset - h[0]));
      dW = -W_factor * (is_slide ? h[1] : -KM_I * h[2] * (o_conjugate - conj(offset) - h[1]));
    }
    const km_complex column[3] = {0.5 * (dZ + dW), -0.5 * KM_I * (dZ - dW), entry->side * h[2] * rest};
    for (int r = 0; r < loop->lambda; ++r)
      km_complex_store(c, out, loop->row_start + r, entry->column, column[loop->rows[r]]);
  }
}

/* Place (Z, W) of the end of a loop's side. */
static void side_end(const km_loop *loop, const km_isotropic_pose *slot, int side, km_complex *Z, km_complex *W) {
  const km_isotropic_pose *X = &slot[loop->slot[side]];
  km_complex d = km_complex_of(loop->planar_closing_point[side][0], loop->planar_closing_point[side][1]);
  *Z = X->Z + X->U * d;
  *W = X->W + X->V * conj(d);
}

/* Adds y = Σ weights · (U, Z, W) and its gradient, accumulated from the slots to the base: with the sums S over the
 * slots behind a joint, ∂y/∂q = i (S_U U + S_Z (Z − Z_h) − S_W (W − W_h)) of a hinge, S_Z dZ + S_W dW of a slide. */
static void add_functional(const km_complex_closure *c, const km_program *program, const km_isotropic_pose *slot,
                           km_complex (*twist)[6], km_program_weight weight, km_complex_values *out) {
  const km_planar_step *steps = c->m->planar_steps + program->step_start;
  km_complex(*sum)[6] = c->wrench; /* (Σ w_U U + w_Z Z − w_W W, Σ w_Z, Σ w_W) */
  for (int k = 0; k < program->slot_count; ++k)
    sum[k][0] = sum[k][1] = sum[k][2] = 0.0;
  for (int i = 0; i < 2 * program->loop_count; ++i) {
    const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + i / 2]];
    const km_complex *w = weight.end[i].p;
    km_complex *at = sum[loop->slot[i % 2]], Z, W;
    side_end(loop, slot, i % 2, &Z, &W);
    out->value += w[1] * Z + w[2] * W;
    at[0] += w[1] * Z - w[2] * W;
    at[1] += w[1];
    at[2] += w[2];
  }
  for (int i = program->step_count - 1; i >= 0; --i) {
    const km_isotropic_pose *to = &slot[steps[i].to];
    const km_complex *w = weight.slot[i].p;
    km_complex *behind = sum[steps[i].to], *before = sum[steps[i].from];
    out->value += w[0] * to->U + w[1] * to->Z + w[2] * to->W;
    behind[0] += w[0] * to->U + w[1] * to->Z - w[2] * to->W;
    behind[1] += w[1];
    behind[2] += w[2];
    int unknown = c->unknown_of[km_complex_column(c, steps[i].coordinate)];
    if (out->gradient && unknown >= 0)
      out->gradient[unknown] +=
          steps[i].is_slide ? behind[1] * twist[i][0] + behind[2] * twist[i][1]
                            : KM_I * twist[i][2] * (behind[0] - behind[1] * twist[i][0] + behind[2] * twist[i][1]);
    for (int k = 0; k < 3; ++k)
      before[k] += behind[k];
  }
}

void km_complex_planar(const km_complex_closure *c, const km_program *program, const km_wide *x,
                       km_program_weight weight, km_complex_values *out) {
  compute_slots(c, program, x, c->isotropic, c->twist);
  for (int i = 0; i < program->loop_count; ++i)
    evaluate_loop(c, program, km_complex_loop_at(c, program->loop_start + i, out), out);
  if (weight.slot)
    add_functional(c, program, c->isotropic, c->twist, weight, out);
}

/* A = U_a V_b exp(i φ_0) of the closed loop is 1: the hinge's angle changes by −arg A, times its sign. */
void km_complex_close_planar(const km_complex_closure *c, const km_program *program, const km_loop *loop, int i,
                             km_wide *x) {
  const km_planar_step *step = &c->m->planar_steps[program->step_start + i];
  compute_slots(c, program, x, c->isotropic, c->twist);
  km_complex A = c->isotropic[loop->slot[0]].U * c->isotropic[loop->slot[1]].V *
                 km_complex_of(cos(loop->planar_closing_angle), sin(loop->planar_closing_angle));
  x[c->start_of[km_complex_column(c, step->coordinate)]] -= step->sign * carg(A);
}

/* Cartesian parts of the slots: (Z + W)/2, (Z − W)/(2i), and of the direction U likewise. */
void km_complex_planar_extent(const km_complex_closure *c, const km_program *program, const km_wide *x,
                              km_program_weight weight, km_complex_extent *extent) {
  const km_planar_step *steps = c->m->planar_steps + program->step_start;
  compute_slots(c, program, x, c->isotropic, c->twist);
  for (int i = 0; i < 2 * program->loop_count; ++i) {
    km_complex Z, W;
    side_end(&c->m->loops[c->m->loop_order[program->loop_start + i / 2]], c->isotropic, i % 2, &Z, &W);
    if (weight.end[i].p[1] != 0.0) {
      km_complex_extend(extent, 0.5 * (Z + W));
      km_complex_extend(extent, -0.5 * KM_I * (Z - W));
    }
  }
  for (int i = 0; i < program->step_count; ++i) {
    const km_isotropic_pose *X = &c->isotropic[steps[i].to];
    if (weight.slot[i].p[0] != 0.0) {
      km_complex_extend(extent, 0.5 * (X->U + X->V));
      km_complex_extend(extent, -0.5 * KM_I * (X->U - X->V));
    }
    if (weight.slot[i].p[1] != 0.0) {
      km_complex_extend(extent, 0.5 * (X->Z + X->W));
      km_complex_extend(extent, -0.5 * KM_I * (X->Z - X->W));
    }
  }
}
