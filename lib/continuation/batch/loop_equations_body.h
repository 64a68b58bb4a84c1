/* Closure errors and Jacobians in a batch, planar loops and couplings; part of step_body.h. Per lane the operations
 * are those of loop_equations.c. */

/* Pose of a planar frame: see km_lane_slot. */
typedef struct planar_pose {
  vector angle, cosine, sine, x, y;
} planar_pose;

static inline planar_pose get_planar_pose(const km_lane_slot *slot, int lane) {
  return (planar_pose){get(slot->angle.of + lane), get(slot->cosine.of + lane), get(slot->sine.of + lane),
                       get(slot->x.of + lane), get(slot->y.of + lane)};
}
static inline void put_planar_pose(km_lane_slot *slot, int lane, const planar_pose *at) {
  put(slot->angle.of + lane, at->angle);
  put(slot->cosine.of + lane, at->cosine);
  put(slot->sine.of + lane, at->sine);
  put(slot->x.of + lane, at->x);
  put(slot->y.of + lane, at->y);
}

/* Moves the pose by `value` along a prismatic joint, and writes the joint's direction as Jacobian column h. */
static inline void slide(const km_batch *l, const km_lane_step *n, vector value, double sign, km_lane_column *h,
                         planar_pose *at, int r, int first) {
  const vector c = at->cosine, s = at->sine, ux = GET(n->ux), uy = GET(n->uy);
  const vector along_x = c * ux - s * uy, along_y = s * ux + c * uy;
  value *= GET(l->inverse_size);
  PUT(h->x, sign * along_x);
  PUT(h->y, sign * along_y);
  at->x += value * along_x;
  at->y += value * along_y;
}

/* Rotates the pose by `value` about a revolute joint, and writes the joint's Jacobian column h. */
static inline void turn_hinge(vector value, double sign, km_lane_column *h, planar_pose *at, int r, int first) {
  at->angle += value;
  lanes_sincos(at->angle, &at->sine, &at->cosine);
  PUT(h->x, sign * at->y);
  PUT(h->y, -sign * at->x);
}

/* Planar forward kinematics of a program. `again`: only Newton's steps moved since the last call, so constant steps
 * are skipped. Clears lanes whose angles exceed the sine's range. The pose of the last step stays in registers. */
static INLINED void planar_steps(km_batch *l, const km_program *program, bool again, mask *valid, int first,
                                 int count) {
  const km_planar_step *fixed = l->m->planar_steps + program->step_start;
  const km_lane_step *numbers = l->steps + program->step_start;
  km_lane_slot *slots = l->slots;
  planar_pose at[REGISTERS];
  int slot = 0;              /* slot of the pose in registers */
  vector largest[REGISTERS]; /* largest angle; a NaN appears in the loops' squares */
  EACH(r) {
    at[r] = get_planar_pose(&slots[slot], AT(r));
    largest[r] = all(0.0);
  }
  for (int i = 0; i < program->step_count; ++i) {
    const km_planar_step *step = &fixed[i];
    const km_lane_step *n = &numbers[i];
    if (again && n->is_constant)
      continue;
    if (step->from != slot)
      EACH(r)
    at[r] = get_planar_pose(&slots[step->from], AT(r));
    km_lane_column *h = &l->h[program->twist_start + i];
    const km_batch_number *q = &l->q[step->coordinate];
    double sign = step->sign;
    bool slides = step->is_slide;
    EACH(r) {
      const vector c = at[r].cosine, s = at[r].sine, nx = GET(n->x), ny = GET(n->y);
      at[r].x = at[r].x + c * nx - s * ny;
      at[r].y = at[r].y + s * nx + c * ny;
      if (slides)
        slide(l, n, sign * GET(*q), sign, h, &at[r], r, first);
      else
        turn_hinge(sign * GET(*q), sign, h, &at[r], r, first);
      largest[r] = larger(size_of(at[r].angle), largest[r]);
    }
    slot = step->to;
    if (n->is_stored)
      EACH(r)
    put_planar_pose(&slots[slot], AT(r), &at[r]);
  }
  EACH(r)
  valid[r] &= at_most(largest[r], all(KM_SINCOS_MAX_ANGLE));
}

/* Wraps an angle to (-π, π], for angles up to KM_SINCOS_MAX_ANGLE. */
static inline vector wrapped(vector angle) {
  vector turns = angle * (0.5 * M_1_PI), nearest = turns + KM_ROUNDING - KM_ROUNDING;
  return pick(at_most(size_of(angle), all(M_PI)), angle, angle - 2.0 * M_PI * nearest);
}

/* Closure error of a planar loop, the logarithm of its misfit by series. Clears lanes whose angle error exceeds
 * KM_SERIES_ANGLE. */
static INLINED void compute_planar_error(km_batch *l, int index, mask *valid, int first, int count) {
  const km_loop *loop = &l->m->loops[index];
  km_lane_planar_loop *n = &l->planar_loops[index];
  km_lane_loop *out = &l->loops[index];
  const km_lane_slot *a = &l->slots[loop->slot[0]], *b = &l->slots[loop->slot[1]];
  double *error = l->error->of;
  bool local = loop->has_moving_point;
  EACH(r) {
    vector ac = GET(a->cosine), as = GET(a->sine), bc = GET(b->cosine), bs = GET(b->sine);
    vector ca0 = GET(n->closing_point[0][0]), ca1 = GET(n->closing_point[0][1]), cb0 = GET(n->closing_point[1][0]),
           cb1 = GET(n->closing_point[1][1]);
    vector ax = GET(a->x) + ac * ca0 - as * ca1, ay = GET(a->y) + as * ca0 + ac * ca1;
    vector bx = GET(b->x) + bc * cb0 - bs * cb1, by = GET(b->y) + bs * cb0 + bc * cb1;
    vector apart_x = GET(n->origin_offset[0]), apart_y = GET(n->origin_offset[1]);
    vector dx = ax - bx - apart_x, dy = ay - by - apart_y;
    vector turn = wrapped(GET(a->angle) - GET(b->angle) + GET(n->turn));
    valid[r] &= below(size_of(turn), all(KM_SERIES_ANGLE));
    vector t2 = turn * turn, t4 = t2 * t2;
    vector cosine = 1.0 - 0.5 * t2 + t4 * (1.0 / 24.0);
    vector sine = turn * (1.0 - t2 * (1.0 / 6.0) + t4 * (1.0 / 120.0));
    vector alpha = 1.0 - t2 * (1.0 / 12.0) - t4 * (1.0 / 720.0);
    vector px = cosine * dx - sine * dy, py = sine * dx + cosine * dy;
    vector ex = alpha * px + 0.5 * turn * py, ey = alpha * py - 0.5 * turn * px;
    vector ox = local ? ax : GET(n->point[0]), oy = local ? ay : GET(n->point[1]);
    PUT(n->origin[0][0], ox);
    PUT(n->origin[0][1], oy);
    PUT(n->origin[1][0], ox - apart_x);
    PUT(n->origin[1][1], oy - apart_y);
    const vector vz = GET(out->fixed[0]), wx = GET(out->fixed[1]), wy = GET(out->fixed[2]);
    PUT(out->square, ex * ex + ey * ey + vz * vz + (wx * wx + wy * wy + turn * turn));
    put(error + out->row[0] + AT(r), ex - turn * (oy - ay));
    put(error + out->row[1] + AT(r), ey + turn * (ox - ax));
    put(error + out->row[2] + AT(r), turn);
  }
}

/* Writes a planar loop's entries of J: v + w × r of each column. */
static INLINED void set_planar_entries(km_batch *l, int index, const km_lane_column *h, int first, int count) {
  const km_loop *loop = &l->m->loops[index];
  const km_lane_planar_loop *n = &l->planar_loops[index];
  double *J = l->J->of;
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_lane_entry *entry = &l->entries[loop->entry_start + i];
    const km_lane_column *column = &h[entry->step];
    const km_batch_number *origin = n->origin[entry->side < 0.0];
    const double side = entry->side, w = entry->turn;
    EACH(r) {
      put(J + entry->position[0] + AT(r), side * (GET(column->x) - w * GET(origin[1])));
      put(J + entry->position[1] + AT(r), side * (GET(column->y) + w * GET(origin[0])));
      put(J + entry->position[2] + AT(r), all(side * w));
    }
  }
}

/* Computes the error of a linear coupling and its entries of J. */
static inline void compute_coupling(km_batch *l, int index, vector *square, mask *valid, int first, int count) {
  const km_coupling *coupling = &l->m->couplings[index];
  EACH(r) {
    vector sum = -GET(l->couplings[index].constant);
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &l->m->terms[coupling->term_start + k];
      vector coefficient = GET(l->coefficients[coupling->term_start + k]);
      if (term->column >= 0)
        PUT(l->J[term->value_index], coefficient);
      sum += coefficient * (GET(l->q[term->coordinate]) / GET(l->term_unit[coupling->term_start + k]));
    }
    PUT(l->error[coupling->row], sum);
    valid[r] &= is_finite(sum);
    square[r] = larger(sum * sum, square[r]);
  }
}

static INLINED void update_planar(km_batch *l, const km_program *program, bool again, mask *valid, int first,
                                  int count) {
  planar_steps(l, program, again, valid, first, count);
  for (int i = 0; i < program->loop_count; ++i) {
    int index = l->m->loop_order[program->loop_start + i];
    compute_planar_error(l, index, valid, first, count);
    set_planar_entries(l, index, l->h + program->twist_start, first, count);
  }
}

/* Computes all closure errors and J, as km_loops_update, and square = 6 · residual². Clears lanes with errors that
 * are not finite or too large for the series. */
static INLINED void update(km_batch *l, bool again, vector *square, mask *valid, int first, int count) {
  const km_mechanism *m = l->m;
  EACH(r)
  square[r] = all(0.0);
  for (int i = 0; i < l->elimination.fill_count; ++i) {
    double *place = l->J->of + l->elimination.fill[i];
    EACH(r)
    put(place + AT(r), all(0.0));
  }
  for (int p = 0; p < l->sub->program_count; ++p) {
    const km_program *program = &m->programs[l->sub->program_start + p];
    if (program->planar)
      update_planar(l, program, again, valid, first, count);
    else
      update_spatial(l, program, valid, first, count);
  }
  for (int i = 0; i < l->sub->loop_count; ++i) {
    const km_lane_loop *loop = &l->loops[m->loop_order[l->sub->loop_start + i]];
    EACH(r) {
      vector sum = GET(loop->square);
      valid[r] &= is_finite(sum);
      square[r] = larger(sum, square[r]);
    }
  }
  for (int i = 0; i < l->sub->coupling_count; ++i)
    compute_coupling(l, l->sub->coupling_start + i, square, valid, first, count);
}
