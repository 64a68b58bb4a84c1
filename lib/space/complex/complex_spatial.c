/* Spatial loops over the complex numbers (complex_closure.h).
 *
 *   X_to = X_from · before · exp(h q),  h = (p × a; a), (a; 0), or the three of a ball (docs/theory.md 2.1)
 *   E = X_a X_b⁻¹;  errors: E(o) − o and 2 g,  g = tan(θ/2) axis = vee(R − Rᵀ) / (1 + tr R),  R = E_R Gᵀ
 *   ∂E(o)/∂q = h.v + h.ω × E(o),   ∂(2g)/∂q = ω + ω × g + g (ω·g)     joints on side a; those on side b by −E h
 *
 * Products of vectors have no conjugate, so the transpose inverts a rotation. o is the loop's point, or the moving
 * point where side b ends. */
#include "space/complex/complex_loops.h"

#include "model/joint_type.h"

#include <string.h>

static void cross(const km_complex *a, const km_complex *b, km_complex *out) {
  km_complex x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  out[0] = x;
  out[1] = y;
  out[2] = z;
}

static km_complex dot(const km_complex *a, const km_complex *b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* R a for a real vector a. */
static void rotate_real(km_wide (*R)[3], km_vec3 a, km_wide *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = a.x * R[0][k] + a.y * R[1][k] + a.z * R[2][k];
}

static void rotate(km_complex (*R)[3], const km_complex *a, km_complex *out) {
  km_complex r[3];
  for (int k = 0; k < 3; ++k)
    r[k] = a[0] * R[0][k] + a[1] * R[1][k] + a[2] * R[2][k];
  memcpy(out, r, sizeof r);
}

static void rotate_wide(km_wide (*R)[3], const km_wide *a, km_wide *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = a[0] * R[0][k] + a[1] * R[1][k] + a[2] * R[2][k];
}

static void narrow(const km_wide *a, int count, km_complex *out) {
  for (int k = 0; k < count; ++k)
    out[k] = (km_complex)a[k];
}

/* X · Y for a real pose Y. */
static void pose_product(km_complex_pose *X, const km_pose *Y, bool has_rotation, km_complex_pose *out) {
  km_complex_pose r;
  for (int k = 0; k < 3; ++k)
    if (has_rotation)
      rotate_real(X->R, Y->R.axis[k], r.R[k]);
    else
      memcpy(r.R[k], X->R[k], sizeof r.R[k]);
  rotate_real(X->R, Y->p, r.p);
  for (int k = 0; k < 3; ++k)
    r.p[k] += X->p[k];
  *out = r;
}

/* Unit twist of a rotation about `axis` through p, times sign. */
static void turning_twist(double sign, const km_wide *axis, const km_wide *p, km_complex *h) {
  km_complex through[3];
  narrow(p, 3, through);
  for (int k = 0; k < 3; ++k)
    h[3 + k] = (km_complex)(sign * axis[k]);
  cross(through, h + 3, h);
}

/* Rotation matrix, by columns, of the quaternion Q / sqrt(Q·Q), or of its conjugate if sign < 0. */
static void quaternion_rotation(const km_wide *Q, double sign, km_wide R[3][3]) {
  km_wide w = Q[0], x = Q[1], y = Q[2], z = Q[3], share = 1.0L / csqrtl(w * w + x * x + y * y + z * z);
  w *= share;
  x *= sign * share;
  y *= sign * share;
  z *= sign * share;
  const km_wide r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (z * x - w * y)},
                           {2 * (x * y - w * z), 1 - 2 * (z * z + x * x), 2 * (y * z + w * x)},
                           {2 * (z * x + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
  memcpy(R, r, sizeof r);
}

/* Applies a step's motion to the pose of its frame and computes its unit twists. */
static void apply_motion(const km_complex_closure *c, const km_step *step, const km_wide *x, km_complex_pose *X,
                         km_complex (*h)[6]) {
  const km_wide *number = &x[c->start_of[km_complex_column(c, step->coordinate)]];
  const km_wide *axis = X->R[step->axis];
  if (step->primitive == KM_PRISMATIC) {
    for (int k = 0; k < 3; ++k) {
      h[0][k] = (km_complex)(step->sign * axis[k]);
      h[0][3 + k] = 0.0;
      X->p[k] += *number * (step->sign * axis[k]);
    }
  } else if (step->primitive == KM_REVOLUTE) {
    turning_twist(step->sign, axis, X->p, h[0]);
    long double angle = step->sign * creall(*number), growth = expl(-step->sign * cimagl(*number));
    long double cosine = cosl(angle), sine = sinl(angle), sum = 0.5L * (growth + 1.0L / growth),
                difference = 0.5L * (growth - 1.0L / growth);
    km_wide C = km_wide_of(sum * cosine, difference * sine), S = km_wide_of(sum * sine, -difference * cosine);
    km_wide *u = X->R[(step->axis + 1) % 3], *v = X->R[(step->axis + 2) % 3];
    for (int k = 0; k < 3; ++k) {
      km_wide uk = C * u[k] + S * v[k];
      v[k] = C * v[k] - S * u[k];
      u[k] = uk;
    }
  } else { /* a ball joint */
    km_wide turn[3][3], after[3][3];
    quaternion_rotation(number, step->sign, turn);
    for (int k = 0; k < 3; ++k)
      rotate_wide(X->R, turn[k], after[k]);
    for (int k = 0; k < 3; ++k)
      turning_twist(step->sign, step->sign > 0.0 ? X->R[k] : after[k], X->p, h[k]);
    memcpy(X->R, after, sizeof after);
  }
}

static void compute_slots(const km_complex_closure *c, const km_program *program, const km_wide *x) {
  c->slot[0] = (km_complex_pose){{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &c->m->steps[program->step_start + i];
    km_complex_pose *to = &c->slot[step->to];
    pose_product(&c->slot[step->from], &step->before, step->has_rotation, to);
    apply_motion(c, step, x, to, &c->twist[3 * i]);
  }
}

/* Gibbs vector of R Gᵀ. */
static void gibbs_vector(km_wide (*R)[3], const km_complex *P, km_complex g[3]) {
  km_wide G[3][3], T[3][3];
  if (P) {
    const km_wide wide[4] = {P[0], P[1], P[2], P[3]};
    quaternion_rotation(wide, 1.0, G);
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        T[j][k] = R[0][k] * G[0][j] + R[1][k] * G[1][j] + R[2][k] * G[2][j];
    R = T;
  }
  km_wide share = 1.0L / (1.0L + R[0][0] + R[1][1] + R[2][2]);
  g[0] = (km_complex)(share * (R[1][2] - R[2][1]));
  g[1] = (km_complex)(share * (R[2][0] - R[0][2]));
  g[2] = (km_complex)(share * (R[0][1] - R[1][0]));
}

/* Displacement E of a loop: its rotation (columns), image of o, Gibbs vector g, and o on side b. A loop that a joint
 * closes uses only `image` and `o`, the ends of its two sides. */
typedef struct loop_displacement {
  km_complex R[3][3], image[3], g[3], o[3];
} loop_displacement;

/* Computes E and the errors of positions of a loop that a joint closes. */
static void compare_ends(const km_loop *loop, const km_complex_pose *a, const km_complex_pose *b, loop_displacement *E,
                         km_complex errors[6]) {
  const double offset[3] = {loop->origin_offset.x, loop->origin_offset.y, loop->origin_offset.z};
  narrow(a->p, 3, E->image);
  narrow(b->p, 3, E->o);
  for (int k = 0; k < 3; ++k)
    errors[k] = (km_complex)(a->p[k] - b->p[k] - offset[k]);
}

/* Computes E and the errors of a loop with a fixed point. */
static void displace(km_complex_loop here, const km_complex_pose *a, const km_complex_pose *b, loop_displacement *E,
                     km_complex errors[6]) {
  const km_loop *loop = here.loop;
  const double offset[3] = {loop->origin_offset.x, loop->origin_offset.y, loop->origin_offset.z};
  const double point[3] = {loop->point[0].x, loop->point[0].y, loop->point[0].z};
  km_wide R[3][3], from[3], image[3];
  for (int j = 0; j < 3; ++j)
    for (int k = 0; k < 3; ++k) /* R = R_a R_bᵀ */
      R[j][k] = a->R[0][k] * b->R[0][j] + a->R[1][k] * b->R[1][j] + a->R[2][k] * b->R[2][j];
  for (int k = 0; k < 3; ++k)
    from[k] = point[k] - offset[k] - b->p[k];
  rotate_wide(R, from, image);
  gibbs_vector(R, here.P, E->g);
  for (int k = 0; k < 3; ++k) {
    image[k] += a->p[k];
    errors[k] = (km_complex)(image[k] - point[k]);
    errors[3 + k] = 2.0 * E->g[k];
    E->o[k] = point[k] - offset[k];
    narrow(R[k], 3, E->R[k]);
  }
  narrow(image, 3, E->image);
}

/* Column of J of the unit twist h of a joint on one side; of positions alone if the point moves. */
static void loop_column(bool has_moving_point, loop_displacement *E, double side, const km_complex *h,
                        km_complex column[6]) {
  km_complex w[3], v[3];
  memcpy(w, h + 3, sizeof w);
  cross(w, side > 0.0 ? E->image : E->o, v);
  for (int k = 0; k < 3; ++k)
    column[k] = side * (v[k] + h[k]);
  if (has_moving_point)
    return;
  if (side < 0.0) {
    rotate(E->R, column, column);
    rotate(E->R, w, w);
  }
  cross(w, E->g, column + 3);
  km_complex along = dot(w, E->g);
  for (int k = 0; k < 3; ++k)
    column[3 + k] = side * (w[k] + column[3 + k] + along * E->g[k]);
}

static void evaluate_loop(const km_complex_closure *c, const km_program *program, km_complex_loop here,
                          const km_complex_values *out) {
  const km_loop *loop = here.loop;
  loop_displacement E;
  km_complex errors[6] = {0}, column[6] = {0};
  km_complex_pose a, b;
  pose_product(&c->slot[loop->slot[0]], &loop->closing_frame[0], !here.has_moving_point, &a);
  pose_product(&c->slot[loop->slot[1]], &loop->closing_frame[1], !here.has_moving_point, &b);
  if (here.has_moving_point)
    compare_ends(loop, &a, &b, &E, errors);
  else
    displace(here, &a, &b, &E, errors);
  for (int r = 0; out->F && r < loop->lambda; ++r)
    if (c->equation_of[loop->row_start + r] >= 0)
      out->F[c->equation_of[loop->row_start + r]] = errors[loop->rows[r]];
  for (int i = 0; out->J && i < loop->entry_count; ++i) {
    const km_entry *entry = &c->m->entries[loop->entry_start + i];
    int freedom = km_primitive_freedom(c->m->steps[program->step_start + entry->step].primitive);
    for (int k = 0; k < freedom; ++k) {
      if (c->unknown_of[entry->column + k] < 0)
        continue;
      loop_column(here.has_moving_point, &E, entry->side, c->twist[3 * entry->step + k], column);
      for (int r = 0; r < loop->lambda; ++r)
        km_complex_store(c, out, loop->row_start + r, entry->column + k, column[loop->rows[r]]);
    }
  }
}

/* Adds w·p of a point and its wrench (w; p × w). */
static void add_force(const km_complex *w, const km_wide *place, km_complex *wrench, km_complex_values *out) {
  km_complex moment[3], p[3];
  narrow(place, 3, p);
  cross(p, w, moment);
  out->value += dot(w, p);
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
    pose_product(&c->slot[loop->slot[i % 2]], &loop->closing_frame[i % 2], false, &X);
    add_force(weight.end[i].p, X.p, c->wrench[loop->slot[i % 2]], out);
  }
  for (int i = program->step_count - 1; i >= 0; --i) {
    const km_step *step = &c->m->steps[program->step_start + i];
    const km_complex_pose *X = &c->slot[step->to];
    km_complex *behind = c->wrench[step->to], *before = c->wrench[step->from], moment[3], axis[3];
    add_force(weight.slot[i].p, X->p, behind, out);
    for (int j = 0; j < 3; ++j) {
      narrow(X->R[j], 3, axis);
      out->value += dot(weight.slot[i].R[j], axis);
      cross(axis, weight.slot[i].R[j], moment);
      for (int k = 0; k < 3; ++k)
        behind[3 + k] += moment[k];
    }
    int column = km_complex_column(c, step->coordinate), freedom = km_primitive_freedom(step->primitive);
    for (int k = 0; out->gradient && k < freedom; ++k)
      if (c->unknown_of[column + k] >= 0)
        out->gradient[c->unknown_of[column + k]] +=
            dot(behind, c->twist[3 * i + k]) + dot(behind + 3, c->twist[3 * i + k] + 3);
    for (int k = 0; k < 6; ++k)
      before[k] += behind[k];
  }
}

void km_complex_spatial(const km_complex_closure *c, const km_program *program, const km_wide *x,
                        km_program_weight weight, km_complex_values *out) {
  compute_slots(c, program, x);
  for (int i = 0; i < program->loop_count; ++i)
    evaluate_loop(c, program, km_complex_loop_at(c, program->loop_start + i, out), out);
  if (weight.slot)
    add_functional(c, program, weight, out);
}

static km_vec3 real_part(const km_wide *a) {
  return (km_vec3){(double)creall(a[0]), (double)creall(a[1]), (double)creall(a[2])};
}

/* The ball's rotation T before the closing frame C: R T C = R_b, so T = Rᵀ R_b Cᵀ; a reversed joint has the inverse. */
void km_complex_close_spatial(const km_complex_closure *c, const km_program *program, const km_loop *loop, int i,
                              km_wide *x) {
  const km_step *step = &c->m->steps[program->step_start + i];
  km_complex_pose before, b;
  km_rotation T, C = loop->closing_frame[0].R, other, middle;
  compute_slots(c, program, x);
  pose_product(&c->slot[step->from], &step->before, step->has_rotation, &before);
  pose_product(&c->slot[loop->slot[1]], &loop->closing_frame[1], true, &b);
  for (int k = 0; k < 3; ++k) {
    middle.axis[k] = real_part(before.R[k]);
    other.axis[k] = real_part(b.R[k]);
  }
  middle = km_rotation_inverse(&middle);
  C = km_rotation_inverse(&C);
  T = km_rotation_product(&middle, &other);
  T = km_rotation_product(&T, &C);
  km_quaternion Q = km_rotation_quaternion(&T);
  km_wide *number = &x[c->start_of[km_complex_column(c, step->coordinate)]];
  number[0] = Q.w;
  number[1] = step->sign * Q.x;
  number[2] = step->sign * Q.y;
  number[3] = step->sign * Q.z;
}

void km_complex_spatial_extent(const km_complex_closure *c, const km_program *program, const km_wide *x,
                               km_program_weight weight, km_complex_extent *extent) {
  compute_slots(c, program, x);
  for (int i = 0; i < 2 * program->loop_count; ++i) {
    const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + i / 2]];
    km_complex_pose X;
    pose_product(&c->slot[loop->slot[i % 2]], &loop->closing_frame[i % 2], false, &X);
    for (int k = 0; k < 3; ++k)
      if (weight.end[i].p[k] != 0.0)
        km_complex_extend(extent, (km_complex)X.p[k]);
  }
  for (int i = 0; i < program->step_count; ++i) {
    const km_complex_pose *X = &c->slot[c->m->steps[program->step_start + i].to];
    for (int k = 0; k < 3; ++k) {
      if (weight.slot[i].p[k] != 0.0)
        km_complex_extend(extent, (km_complex)X->p[k]);
      for (int j = 0; j < 3; ++j)
        if (weight.slot[i].R[k][j] != 0.0)
          km_complex_extend(extent, (km_complex)X->R[k][j]);
    }
  }
}
