/* Loop errors and Jacobians of several drives in vectors, in a plane and as a whole: a part of lanes_body.h. */

/* A frame in a plane: see km_lane_slot. */
typedef struct planar_place {
  vector angle, cosine, sine, x, y;
} planar_place;

static inline planar_place get_place(const km_lane_slot *slot, int lane) {
  return (planar_place){get(slot->angle.of + lane), get(slot->cosine.of + lane), get(slot->sine.of + lane),
                        get(slot->x.of + lane), get(slot->y.of + lane)};
}
static inline void put_place(km_lane_slot *slot, int lane, const planar_place *at) {
  put(slot->angle.of + lane, at->angle);
  put(slot->cosine.of + lane, at->cosine);
  put(slot->sine.of + lane, at->sine);
  put(slot->x.of + lane, at->x);
  put(slot->y.of + lane, at->y);
}

/* The place behind a slide, or a hinge, by `value`. */
static inline void slide(const km_batch *l, const km_lane_step *n, vector value, double sign, km_lane_column *h,
                         planar_place *at, int r, int first) {
  const vector c = at->cosine, s = at->sine, ux = GET(n->ux), uy = GET(n->uy);
  const vector along_x = c * ux - s * uy, along_y = s * ux + c * uy;
  value *= GET(l->inverse_size);
  PUT(h->x, sign * along_x);
  PUT(h->y, sign * along_y);
  at->x += value * along_x;
  at->y += value * along_y;
}
static inline void turn_hinge(vector value, double sign, km_lane_column *h, planar_place *at, int r, int first) {
  at->angle += value;
  lanes_sincos(at->angle, &at->sine, &at->cosine);
  PUT(h->x, sign * at->y);
  PUT(h->y, -sign * at->x);
}

/* planar_steps of loops.c; `again`: only Newton has moved since the last time. Clears the lanes whose angles are too large for
 * the sines. A step that follows the one before it finds its place in registers. */
static WITHIN void steps(km_batch *l, const km_program *program, bool again, mask *fit, int first, int count) {
  const km_planar_step *fixed = l->m->planar_steps + program->step_start;
  const km_lane_step *numbers = l->steps + program->step_start;
  km_lane_slot *slots = l->slots;
  planar_place at[TOGETHER];
  int slot = 0;             /* whose place that is */
  vector largest[TOGETHER]; /* angle; one that is no number shows in the loops' squares */
  EACH(r) {
    at[r] = get_place(&slots[slot], AT(r));
    largest[r] = all(0.0);
  }
  for (int i = 0; i < program->step_count; ++i) {
    const km_planar_step *step = &fixed[i];
    const km_lane_step *n = &numbers[i];
    if (again && n->still)
      continue;
    if (step->from != slot)
      EACH(r)
    at[r] = get_place(&slots[step->from], AT(r));
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
    if (n->kept)
      EACH(r)
    put_place(&slots[slot], AT(r), &at[r]);
  }
  EACH(r)
  fit[r] &= at_most(largest[r], all(KM_SINCOS_MOST));
}

/* wrapped of loops.c, for the angles of lanes that fit (KM_SINCOS_MOST). */
static inline vector wrapped(vector angle) {
  vector turns = angle * (0.5 * M_1_PI), whole = turns + KM_ROUNDING - KM_ROUNDING;
  return pick(at_most(size_of(angle), all(M_PI)), angle, angle - 2.0 * M_PI * whole);
}

/* planar_error of loops.c. Clears the lanes whose misfit is large. */
static WITHIN void find_misfit(km_batch *l, int index, mask *fit, int first, int count) {
  const km_loop *loop = &l->m->loops[index];
  km_lane_planar_loop *n = &l->planar_loops[index];
  km_lane_loop *out = &l->loops[index];
  const km_lane_slot *a = &l->slots[loop->slot[0]], *b = &l->slots[loop->slot[1]];
  double *error = l->error->of;
  bool local = loop->has_moving_point;
  EACH(r) {
    vector ac = GET(a->cosine), as = GET(a->sine), bc = GET(b->cosine), bs = GET(b->sine);
    vector ca0 = GET(n->close[0][0]), ca1 = GET(n->close[0][1]), cb0 = GET(n->close[1][0]), cb1 = GET(n->close[1][1]);
    vector ax = GET(a->x) + ac * ca0 - as * ca1, ay = GET(a->y) + as * ca0 + ac * ca1;
    vector bx = GET(b->x) + bc * cb0 - bs * cb1, by = GET(b->y) + bs * cb0 + bc * cb1;
    vector apart_x = GET(n->apart[0]), apart_y = GET(n->apart[1]);
    vector dx = ax - bx - apart_x, dy = ay - by - apart_y;
    vector turn = wrapped(GET(a->angle) - GET(b->angle) + GET(n->turn));
    fit[r] &= below(size_of(turn), all(KM_SERIES_TURN));
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

/* The loop's entries of J; planar_loop of loops.c. */
static WITHIN void set_entries(km_batch *l, int index, const km_lane_column *h, int first, int count) {
  const km_loop *loop = &l->m->loops[index];
  const km_lane_planar_loop *n = &l->planar_loops[index];
  double *J = l->J->of;
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_lane_entry *entry = &l->entries[loop->entry_start + i];
    const km_lane_column *column = &h[entry->step];
    const km_batch_number *origin = n->origin[entry->side < 0.0];
    const double side = entry->side, w = entry->turn;
    EACH(r) {
      put(J + entry->at[0] + AT(r), side * (GET(column->x) - w * GET(origin[1])));
      put(J + entry->at[1] + AT(r), side * (GET(column->y) + w * GET(origin[0])));
      put(J + entry->at[2] + AT(r), all(side * w));
    }
  }
}

/* The error of a coupling, and its entries of J. */
static inline void set_coupling(km_batch *l, int index, vector *square, mask *fit, int first, int count) {
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
    fit[r] &= is_finite(sum);
    square[r] = larger(sum * sum, square[r]);
  }
}

static WITHIN void update_planar(km_batch *l, const km_program *program, bool again, mask *fit, int first, int count) {
  steps(l, program, again, fit, first, count);
  for (int i = 0; i < program->loop_count; ++i) {
    int index = l->m->loop_order[program->loop_start + i];
    find_misfit(l, index, fit, first, count);
    set_entries(l, index, l->h + program->twist_start, first, count);
  }
}

/* km_loops_update, and six times the square of km_loops_residual. Clears the lanes that the formulas aren't good for. */
static WITHIN void update(km_batch *l, bool again, vector *square, mask *fit, int first, int count) {
  const km_mechanism *m = l->m;
  EACH(r)
  square[r] = all(0.0);
  for (int i = 0; i < l->replay.fill_count; ++i) {
    double *place = l->J->of + l->replay.fill[i];
    EACH(r)
    put(place + AT(r), all(0.0));
  }
  for (int p = 0; p < l->sub->program_count; ++p) {
    const km_program *program = &m->programs[l->sub->program_start + p];
    if (program->planar)
      update_planar(l, program, again, fit, first, count);
    else
      update_spatial(l, program, fit, first, count);
  }
  for (int i = 0; i < l->sub->loop_count; ++i) {
    const km_lane_loop *loop = &l->loops[m->loop_order[l->sub->loop_start + i]];
    EACH(r) {
      vector sum = GET(loop->square);
      fit[r] &= is_finite(sum);
      square[r] = larger(sum, square[r]);
    }
  }
  for (int i = 0; i < l->sub->coupling_count; ++i)
    set_coupling(l, l->sub->coupling_start + i, square, fit, first, count);
}
