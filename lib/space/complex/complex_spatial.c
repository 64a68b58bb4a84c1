/* Spatial loops over the complex numbers (complex_closure.h).
 *
 *   ∂E(o)/∂q = h.v + h.ω × E(o),   ∂(2g)/∂q = ω + ω × g + g (ω·g)     joints on side a; those on side b by −E h
 *
 * h is the unit twist of a step, E the displacement of a loop (complex_chain.c); o is the loop's point, or the moving
 * point where side b ends. */
#include "space/complex/complex_chain.h"

#include "model/joint_type.h"

#include <string.h>

/* Column of J of the unit twist h of a joint on one side; of positions alone if the point moves. */
static void loop_column(bool has_moving_point, km_loop_displacement *E, double side, const km_complex *h,
                        km_complex column[6]) {
  km_complex w[3], v[3];
  memcpy(w, h + 3, sizeof w);
  km_complex_cross(w, side > 0.0 ? E->image : E->o, v);
  for (int k = 0; k < 3; ++k)
    column[k] = side * (v[k] + h[k]);
  if (has_moving_point)
    return;
  if (side < 0.0) {
    km_complex_rotate(E->R, column, column);
    km_complex_rotate(E->R, w, w);
  }
  km_complex_cross(w, E->g, column + 3);
  km_complex along = km_complex_dot(w, E->g);
  for (int k = 0; k < 3; ++k)
    column[3 + k] = side * (w[k] + column[3 + k] + along * E->g[k]);
}

static void evaluate_loop(const km_complex_closure *c, const km_program *program, int index,
                          const km_complex_values *out) {
  km_complex_loop here = km_complex_loop_at(c, program->loop_start + index, out);
  const km_loop *loop = here.loop;
  km_loop_displacement *E = &c->displacement[index];
  km_complex column[6] = {0};
  for (int r = 0; out->F && r < loop->lambda; ++r)
    if (c->equation_of[loop->row_start + r] >= 0)
      out->F[c->equation_of[loop->row_start + r]] = E->errors[loop->rows[r]];
  for (int i = 0; out->J && i < loop->entry_count; ++i) {
    const km_entry *entry = &c->m->entries[loop->entry_start + i];
    int freedom = km_primitive_freedom(c->m->steps[program->step_start + entry->step].primitive);
    for (int k = 0; k < freedom; ++k) {
      if (c->unknown_of[entry->column + k] < 0)
        continue;
      loop_column(here.has_moving_point, E, entry->side, c->twist[3 * entry->step + k], column);
      for (int r = 0; r < loop->lambda; ++r)
        km_complex_store(c, out, loop->row_start + r, entry->column + k, column[loop->rows[r]]);
    }
  }
}

/* Adds w·p of a point and its wrench (w; p × w). */
static void add_force(const km_complex *w, const km_complex *p, km_complex *wrench, km_complex_values *out) {
  km_complex moment[3];
  km_complex_cross(p, w, moment);
  out->value += km_complex_dot(w, p);
  for (int k = 0; k < 3; ++k) {
    wrench[k] += w[k];
    wrench[3 + k] += moment[k];
  }
}

/* Adds y = Σ w·p + Σ w_k·R_k over the slots and its gradient: each slot acts on the joints before it as the wrench
 * (w; p × w + Σ R_k × w_k). */
static void add_functional(const km_complex_closure *c, const km_program *program, km_program_weight weight,
                           km_complex_values *out) {
  memset(c->wrench, 0, (size_t)program->slot_count * sizeof *c->wrench);
  for (int i = 0; i < 2 * program->loop_count; ++i) {
    const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + i / 2]];
    km_complex_pose X;
    km_complex_pose_product(&c->slot[loop->slot[i % 2]], &loop->closing_frame[i % 2], false, &X);
    add_force(weight.end[i].p, X.p, c->wrench[loop->slot[i % 2]], out);
  }
  for (int i = program->step_count - 1; i >= 0; --i) {
    const km_step *step = &c->m->steps[program->step_start + i];
    const km_complex_pose *X = &c->slot[step->to];
    km_complex *behind = c->wrench[step->to], *before = c->wrench[step->from], moment[3];
    add_force(weight.slot[i].p, X->p, behind, out);
    for (int j = 0; j < 3; ++j) {
      out->value += km_complex_dot(weight.slot[i].R[j], X->R[j]);
      km_complex_cross(X->R[j], weight.slot[i].R[j], moment);
      for (int k = 0; k < 3; ++k)
        behind[3 + k] += moment[k];
    }
    int column = km_complex_column(c, step->coordinate), freedom = km_primitive_freedom(step->primitive);
    for (int k = 0; out->gradient && k < freedom; ++k)
      if (c->unknown_of[column + k] >= 0)
        out->gradient[c->unknown_of[column + k]] +=
            km_complex_dot(behind, c->twist[3 * i + k]) + km_complex_dot(behind + 3, c->twist[3 * i + k] + 3);
    for (int k = 0; k < 6; ++k)
      before[k] += behind[k];
  }
}

void km_complex_spatial(const km_complex_closure *c, const km_program *program, const km_wide *x,
                        km_program_weight weight, km_complex_values *out) {
  km_complex_compute_chains(c, program, x, out);
  for (int i = 0; i < program->loop_count; ++i)
    evaluate_loop(c, program, i, out);
  if (weight.slot)
    add_functional(c, program, weight, out);
}

static km_vec3 real_part(const km_complex *a) {
  return (km_vec3){creal(a[0]), creal(a[1]), creal(a[2])};
}

/* The ball's rotation T before the closing frame C: R T C = R_b, so T = Rᵀ R_b Cᵀ. */
void km_complex_close_spatial(const km_complex_closure *c, const km_program *program, const km_loop *loop, int i,
                              km_wide *x) {
  const km_step *step = &c->m->steps[program->step_start + i];
  km_complex_pose before, b;
  km_rotation T, C = loop->closing_frame[0].R, other, middle;
  km_complex_compute_chains(c, program, x, &(km_complex_values){0});
  km_complex_pose_product(&c->slot[step->from], &step->before, step->has_rotation, &before);
  km_complex_pose_product(&c->slot[loop->slot[1]], &loop->closing_frame[1], true, &b);
  for (int k = 0; k < 3; ++k) {
    middle.axis[k] = real_part(before.R[k]);
    other.axis[k] = real_part(b.R[k]);
  }
  middle = km_rotation_inverse(&middle);
  C = km_rotation_inverse(&C);
  T = km_rotation_product(&middle, &other);
  T = km_rotation_product(&T, &C);
  km_complex_set_quaternion(km_rotation_quaternion(&T), &x[c->start_of[km_complex_column(c, step->coordinate)]]);
}

void km_complex_spatial_extent(const km_complex_closure *c, const km_program *program, const km_wide *x,
                               km_program_weight weight, km_complex_extent *extent) {
  km_complex_compute_chains(c, program, x, &(km_complex_values){0});
  for (int i = 0; i < 2 * program->loop_count; ++i) {
    const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + i / 2]];
    km_complex_pose X;
    km_complex_pose_product(&c->slot[loop->slot[i % 2]], &loop->closing_frame[i % 2], false, &X);
    for (int k = 0; k < 3; ++k)
      if (weight.end[i].p[k] != 0.0)
        km_complex_extend(extent, X.p[k]);
  }
  for (int i = 0; i < program->step_count; ++i) {
    const km_complex_pose *X = &c->slot[c->m->steps[program->step_start + i].to];
    for (int k = 0; k < 3; ++k) {
      if (weight.slot[i].p[k] != 0.0)
        km_complex_extend(extent, X->p[k]);
      for (int j = 0; j < 3; ++j)
        if (weight.slot[i].R[k][j] != 0.0)
          km_complex_extend(extent, X->R[k][j]);
    }
  }
}
