/* Loop errors and Jacobians of several drives in vectors: a part of lanes_body.h. */

/* planar_steps of loops.c. Returns the lanes whose angles the sines are good for. */
static inline mask steps(km_drive_lanes *l, const km_program *program, int g) {
  const km_planar_step *fixed = l->m->planar_steps + program->step_start;
  const km_lane_step *numbers = l->steps + program->step_start;
  km_lane_slot *slots = l->slots;
  vector most = all(0.0);
  PUT(slots[0].angle, all(0.0));
  PUT(slots[0].cosine, all(1.0));
  PUT(slots[0].sine, all(0.0));
  PUT(slots[0].x, all(0.0));
  PUT(slots[0].y, all(0.0));
  for (int i = 0; i < program->step_count; ++i) {
    const km_planar_step *step = &fixed[i];
    const km_lane_step *n = &numbers[i];
    const km_lane_slot *from = &slots[step->from];
    km_lane_slot *to = &slots[step->to];
    km_lane_column *h = &l->h[program->twist_start + i];
    vector c = GET(from->cosine), s = GET(from->sine), value = step->sign * GET(l->q[step->coordinate]);
    vector nx = GET(n->x), ny = GET(n->y), angle = GET(from->angle);
    vector x = GET(from->x) + c * nx - s * ny, y = GET(from->y) + s * nx + c * ny;
    if (step->slides) {
      vector ux = c * GET(n->ux) - s * GET(n->uy), uy = s * GET(n->ux) + c * GET(n->uy);
      value *= GET(l->inverse_size);
      PUT(h->x, step->sign * ux);
      PUT(h->y, step->sign * uy);
      PUT(h->turn, all(0.0));
      x += value * ux;
      y += value * uy;
    } else {
      angle += value;
      lanes_sincos(angle, &s, &c);
      most = larger(size_of(angle), most);
      PUT(h->x, step->sign * y);
      PUT(h->y, -step->sign * x);
      PUT(h->turn, all(step->sign));
    }
    PUT(to->angle, angle);
    PUT(to->cosine, c);
    PUT(to->sine, s);
    PUT(to->x, x);
    PUT(to->y, y);
  }
  return most <= all(KM_SINCOS_MOST);
}

/* wrapped of loops.c. Where the number of turns is near a half, rounding decides: those lanes leave. */
static inline vector wrapped(vector angle, mask *fit) {
  const double magic = 6755399441055744.0; /* 1.5 · 2⁵²: adding it rounds to a whole number */
  vector turns = angle * (0.5 * M_1_PI), whole = turns + magic - magic;
  mask within = size_of(angle) <= all(M_PI);
  *fit &= within | (size_of(turns - whole) < all(0.25));
  return pick(within, angle, angle - 2.0 * M_PI * whole);
}

/* planar_loop of loops.c. Returns the lanes whose misfit is small. */
static inline mask close_loop(km_drive_lanes *l, int index, const km_lane_column *h, int g) {
  const km_loop *loop = &l->m->loops[index];
  const km_lane_loop *n = &l->loops[index];
  const km_lane_slot *a = &l->slots[loop->slot[0]], *b = &l->slots[loop->slot[1]];
  vector ac = GET(a->cosine), as = GET(a->sine), bc = GET(b->cosine), bs = GET(b->sine);
  vector ca0 = GET(n->close[0][0]), ca1 = GET(n->close[0][1]), cb0 = GET(n->close[1][0]), cb1 = GET(n->close[1][1]);
  vector ax = GET(a->x) + ac * ca0 - as * ca1, ay = GET(a->y) + as * ca0 + ac * ca1;
  vector bx = GET(b->x) + bc * cb0 - bs * cb1, by = GET(b->y) + bs * cb0 + bc * cb1;
  vector apart_x = GET(n->apart[0]), apart_y = GET(n->apart[1]);
  vector dx = ax - bx - apart_x, dy = ay - by - apart_y;
  mask fit = mask_of(~0u);
  vector turn = wrapped(GET(a->angle) - GET(b->angle) + GET(n->turn), &fit);
  fit &= size_of(turn) < all(KM_SMALL_MISFIT);
  vector t2 = turn * turn, t4 = t2 * t2;
  vector cosine = 1.0 - 0.5 * t2 + t4 * (1.0 / 24.0);
  vector sine = turn * (1.0 - t2 * (1.0 / 6.0) + t4 * (1.0 / 120.0));
  vector alpha = 1.0 - t2 * (1.0 / 12.0) - t4 * (1.0 / 720.0);
  vector px = cosine * dx - sine * dy, py = sine * dx + cosine * dy;
  vector ex = alpha * px + 0.5 * turn * py, ey = alpha * py - 0.5 * turn * px;
  vector ox = loop->local ? ax : GET(n->point[0]), oy = loop->local ? ay : GET(n->point[1]);
  vector behind_x = ox - apart_x, behind_y = oy - apart_y;
  vector values[3] = {ex - turn * (oy - ay), ey + turn * (ox - ax), turn};
  PUT(l->misfit[3 * index], ex);
  PUT(l->misfit[3 * index + 1], ey);
  PUT(l->misfit[3 * index + 2], turn);
  for (int r = 0; r < loop->lambda; ++r)
    PUT(l->error[loop->row_start + r], values[loop->rows[r]]);
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &l->m->entries[loop->entry_start + i];
    const km_lane_column *column = &h[entry->step];
    bool back = entry->side < 0.0;
    vector w = GET(column->turn);
    vector v[3] = {GET(column->x) - w * (back ? behind_y : oy), GET(column->y) + w * (back ? behind_x : ox), w};
    for (int r = 0; r < loop->lambda; ++r)
      PUT(l->J[entry->at + (size_t)r], entry->side * v[loop->rows[r]]);
  }
  return fit;
}

/* Six times the square of a loop's residual. */
static inline vector loop_square(const km_drive_lanes *l, int index, int g) {
  const km_lane_loop *n = &l->loops[index];
  vector ex = GET(l->misfit[3 * index]), ey = GET(l->misfit[3 * index + 1]), turn = GET(l->misfit[3 * index + 2]);
  vector vz = GET(n->fixed[0]), wx = GET(n->fixed[1]), wy = GET(n->fixed[2]);
  return ex * ex + ey * ey + vz * vz + (wx * wx + wy * wy + turn * turn);
}

/* km_loops_update, and six times the square of km_loops_residual. Returns the lanes that the formulas are good for. */
static inline mask update(km_drive_lanes *l, int g, vector *square) {
  const km_mechanism *m = l->m;
  mask fit = mask_of(~0u);
  vector largest = all(0.0);
  for (int i = 0; i < l->replay.fill_count; ++i)
    PUT(l->J[l->replay.fill[i]], all(0.0));
  for (int p = 0; p < l->sub->program_count; ++p) {
    const km_program *program = &m->programs[l->sub->program_start + p];
    fit &= steps(l, program, g);
    for (int i = 0; i < program->loop_count; ++i) {
      int index = m->loop_order[program->loop_start + i];
      fit &= close_loop(l, index, l->h + program->twist_start, g);
      vector sum = loop_square(l, index, g);
      fit &= sum - sum == all(0.0);
      largest = larger(sum, largest);
    }
  }
  for (int i = 0; i < l->sub->coupling_count; ++i) {
    const km_coupling *coupling = &m->couplings[l->sub->coupling_start + i];
    vector sum = -GET(l->couplings[l->sub->coupling_start + i].constant);
    for (int k = 0; k < coupling->term_count; ++k) {
      const km_term *term = &m->terms[coupling->term_start + k];
      vector coefficient = GET(l->coefficients[coupling->term_start + k]);
      if (term->column >= 0)
        PUT(l->J[term->at], coefficient);
      sum += coefficient * (GET(l->q[term->coordinate]) / GET(l->term_unit[coupling->term_start + k]));
    }
    PUT(l->error[coupling->row], sum);
    fit &= sum - sum == all(0.0);
    largest = larger(sum * sum, largest);
  }
  *square = largest;
  return fit;
}
