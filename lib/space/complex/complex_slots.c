/* Poses of the slots of a spatial program over the complex numbers (complex_loops.h).
 *
 *   X_to = X_from · before · exp(h q),   h = (p × a; a), (a; 0), or the three of a ball (docs/theory.md 2.1)
 *   a ball at X_b = X_from · before, with the displacement T of the hinges and slides from it to its hub:
 *     R_hub = R_b R(Q),   p_hub = p_b + R_hub T_Rᵀ T_p,   X_to = (R_hub T_Rᵀ, p_b)
 *
 * The hub is the body behind the ball where most chains meet. T has parts of 1e5 beside a pole: with the rotation of
 * the ball's own body as the unknown, the rounding of T would pass to the hub and all chains there. */
#include "space/complex/complex_vectors.h"

#include "model/joint_type.h"
#include "space/complex/complex_loops.h"

static const km_complex_pose identity = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};

/* R a for a real vector a. */
static void rotate_real(km_wide (*R)[3], km_vec3 a, km_wide *out) {
  for (int k = 0; k < 3; ++k)
    out[k] = a.x * R[0][k] + a.y * R[1][k] + a.z * R[2][k];
}

void km_complex_pose_product(km_complex_pose *X, const km_pose *Y, bool has_rotation, km_complex_pose *out) {
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

void km_complex_quaternion_rotation(const km_wide *Q, km_wide R[3][3]) {
  km_wide w = Q[0], x = Q[1], y = Q[2], z = Q[3];
  km_wide ww = w * w, xx = x * x, yy = y * y, zz = z * z, share = 1.0L / (ww + xx + yy + zz), twice = 2.0L * share;
  const km_wide r[3][3] = {
      {share * (ww + xx - yy - zz), twice * (x * y + w * z), twice * (z * x - w * y)},
      {twice * (x * y - w * z), share * (ww - xx + yy - zz), twice * (y * z + w * x)},
      {twice * (z * x + w * y), twice * (y * z - w * x), share * (ww - xx - yy + zz)},
  };
  memcpy(R, r, sizeof r);
}

/* Unit twist of a rotation about `axis` through p, times sign. */
static void turning_twist(double sign, const km_wide *axis, const km_wide *p, km_complex *h) {
  km_complex through[3];
  km_complex_narrow(p, 3, through);
  for (int k = 0; k < 3; ++k)
    h[3 + k] = (km_complex)(sign * axis[k]);
  km_complex_cross(through, h + 3, h);
}

/* Applies the motion of a hinge or slide to the pose of its frame and computes its unit twist. */
static void apply_motion(const km_complex_closure *c, const km_step *step, const km_wide *x, km_complex_pose *X,
                         km_complex *h) {
  km_wide number = x[c->start_of[km_complex_column(c, step->coordinate)]];
  const km_wide *axis = X->R[step->axis];
  if (step->primitive == KM_PRISMATIC) {
    for (int k = 0; k < 3; ++k) {
      h[k] = (km_complex)(step->sign * axis[k]);
      h[3 + k] = 0.0;
      X->p[k] += number * (step->sign * axis[k]);
    }
    return;
  }
  turning_twist(step->sign, axis, X->p, h);
  long double angle = step->sign * creall(number), growth = expl(-step->sign * cimagl(number));
  long double cosine = cosl(angle), sine = sinl(angle), sum = 0.5L * (growth + 1.0L / growth),
              difference = 0.5L * (growth - 1.0L / growth);
  km_wide C = km_wide_of(sum * cosine, difference * sine), S = km_wide_of(sum * sine, -difference * cosine);
  km_wide *u = X->R[(step->axis + 1) % 3], *v = X->R[(step->axis + 2) % 3];
  for (int k = 0; k < 3; ++k) {
    km_wide uk = C * u[k] + S * v[k];
    v[k] = C * v[k] - S * u[k];
    u[k] = uk;
  }
}

/* The displacement T from a ball to its hub. w != NULL: adds the angular velocity of the hub relative to the ball's
 * body, at the rates of the unknowns, along the axes of that body. */
static km_complex_pose hub_displacement(const km_complex_closure *c, const km_complex_hub *hub, const km_wide *x,
                                        const km_complex *rates, km_complex *w) {
  km_complex_pose T = identity;
  for (int i = 0; i < hub->count; ++i) {
    const km_step *step = hub->chain[i];
    int unknown = c->unknown_of[km_complex_column(c, step->coordinate)];
    km_complex h[6];
    km_complex_pose_product(&T, &step->before, step->has_rotation, &T);
    apply_motion(c, step, x, &T, h);
    for (int k = 0; w && unknown >= 0 && k < 3; ++k)
      w[k] += rates[unknown] * h[3 + k];
  }
  return T;
}

/* Applies a ball's motion to the pose of its frame, computes its unit twists, and places its hub. */
static void apply_ball(const km_complex_closure *c, const km_step *step, const km_wide *x, km_complex_pose *X,
                       km_complex (*h)[6]) {
  int column = km_complex_column(c, step->coordinate);
  const km_complex_hub *hub = &c->hub[column];
  km_wide Q[3][3], R[3][3], u[3];
  for (int k = 0; k < 3; ++k)
    turning_twist(1.0, X->R[k], X->p, h[k]);
  km_complex_quaternion_rotation(&x[c->start_of[column]], Q);
  for (int k = 0; k < 3; ++k)
    km_wide_rotate(X->R, Q[k], R[k]);
  if (hub->count == 0) {
    memcpy(X->R, R, sizeof R);
    return;
  }
  km_complex_pose T = hub_displacement(c, hub, x, NULL, NULL), *at = &c->slot[hub->chain[hub->count - 1]->to];
  km_wide_rotate_back(T.R, T.p, u);
  memcpy(at->R, R, sizeof R);
  km_wide_rotate(R, u, at->p);
  for (int k = 0; k < 3; ++k) {
    const km_wide row[3] = {T.R[0][k], T.R[1][k], T.R[2][k]};
    km_wide_rotate(R, row, X->R[k]);
    at->p[k] += X->p[k];
  }
}

void km_complex_compute_slots(const km_complex_closure *c, const km_program *program, const km_wide *x) {
  c->slot[0] = identity;
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &c->m->steps[program->step_start + i];
    km_complex_pose X;
    km_complex_pose_product(&c->slot[step->from], &step->before, step->has_rotation, &X);
    if (step->primitive == KM_BALL)
      apply_ball(c, step, x, &X, &c->twist[3 * i]);
    else
      apply_motion(c, step, x, &X, c->twist[3 * i]);
    if (!c->is_hub[program->step_start + i])
      c->slot[step->to] = X;
  }
}

/* ---- Hubs. */

/* Number of steps and loop ends at each slot. */
static void count_chains(const km_mechanism *m, const km_program *program, int *uses) {
  memset(uses, 0, (size_t)program->slot_count * sizeof *uses);
  for (int i = 0; i < program->step_count; ++i)
    ++uses[m->steps[program->step_start + i].from];
  for (int i = 0; i < program->loop_count; ++i)
    for (int side = 0; side < 2; ++side)
      ++uses[m->loops[m->loop_order[program->loop_start + i]].slot[side]];
}

/* Chooses the hub of the ball of step i of a program. uses, before: [slots] workspace; before: the step that ends at a
 * slot behind the ball, −1: none. */
static void choose_hub(const km_complex_closure *c, const km_program *program, int i, const int *uses, int *before,
                       km_arena *arena, km_complex_hub *hub) {
  const km_step *steps = c->m->steps + program->step_start;
  int best = steps[i].to, count = 0;
  for (int k = 0; k < program->slot_count; ++k)
    before[k] = -1;
  before[best] = i;
  for (int k = i + 1; k < program->step_count; ++k)
    if (before[steps[k].from] >= 0 && steps[k].primitive != KM_BALL) {
      before[steps[k].to] = k;
      best = uses[steps[k].to] > uses[best] ? steps[k].to : best;
    }
  for (int slot = best; slot != steps[i].to; slot = steps[before[slot]].from)
    ++count;
  hub->chain = km_arena_alloc(arena, (size_t)count, sizeof *hub->chain);
  hub->count = arena->failed ? 0 : count;
  for (int slot = best; slot != steps[i].to && !arena->failed; slot = steps[before[slot]].from)
    hub->chain[--count] = &steps[before[slot]];
}

void km_complex_choose_hubs(km_complex_closure *c, const km_state *s, km_arena *arena) {
  const km_mechanism *m = c->m;
  int *uses = KM_ARENA_NEW(arena, int, (size_t)m->largest_slots);
  int *before = KM_ARENA_NEW(arena, int, (size_t)m->largest_slots);
  for (int i = 0; i < c->sub->program_count && !arena->failed; ++i) {
    const km_program *program = &m->programs[c->sub->program_start + i];
    if (program->planar)
      continue;
    count_chains(m, program, uses);
    for (int k = 0; k < program->step_count; ++k) {
      const km_step *step = &m->steps[program->step_start + k];
      km_complex_hub *hub = &c->hub[km_complex_column(c, step->coordinate)];
      if (step->primitive != KM_BALL)
        continue;
      if (!hub->ball && !s->locked[step->coordinate])
        choose_hub(c, program, k, uses, before, arena, hub);
      else
        hub->count = 0; /* a ball of two programs has another hub in each */
      hub->ball = step;
    }
  }
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->hub[k].count > 0)
      c->is_hub[c->hub[k].chain[c->hub[k].count - 1] - m->steps] = true;
}

void km_complex_hub_velocity(const km_complex_closure *c, int column, const km_wide *x, const km_complex *rates,
                             km_complex *w) {
  for (int k = 0; k < 3; ++k)
    w[k] = c->unknown_of[column + k] >= 0 ? rates[c->unknown_of[column + k]] : 0.0;
  const km_complex_hub *hub = &c->hub[column];
  km_complex relative[3] = {0.0, 0.0, 0.0};
  km_wide Q[3][3], own[3], sum[3];
  if (hub->count == 0)
    return;
  km_complex_pose T = hub_displacement(c, hub, x, rates, relative);
  const km_wide wide[3] = {relative[0], relative[1], relative[2]};
  km_complex_quaternion_rotation(&x[c->start_of[column]], Q);
  km_wide_rotate_back(T.R, wide, own);
  km_wide_rotate(Q, own, sum);
  for (int k = 0; k < 3; ++k)
    w[k] += (km_complex)sum[k];
}

/* Real quaternion of R(Q) T_R, or of R(Q) T_Rᵀ if `back`. */
static km_quaternion turn_along_chain(const km_complex_closure *c, int column, const km_wide *x, bool back) {
  km_complex_pose T = hub_displacement(c, &c->hub[column], x, NULL, NULL);
  km_wide Q[3][3];
  km_rotation R;
  km_complex_quaternion_rotation(&x[c->start_of[column]], Q);
  for (int k = 0; k < 3; ++k) {
    const km_wide row[3] = {T.R[0][k], T.R[1][k], T.R[2][k]};
    km_wide axis[3];
    km_wide_rotate(Q, back ? row : T.R[k], axis);
    R.axis[k] = (km_vec3){(double)creall(axis[0]), (double)creall(axis[1]), (double)creall(axis[2])};
  }
  return km_rotation_quaternion(&R);
}

km_quaternion km_complex_hub_quaternion(const km_complex_closure *c, int column, const km_wide *x) {
  return turn_along_chain(c, column, x, false);
}

km_quaternion km_complex_ball_quaternion(const km_complex_closure *c, int column, const km_wide *x) {
  return turn_along_chain(c, column, x, true);
}
