/* Closing the loops of several drives in vectors: a part of lanes_body.h. */

/* Squares of lengths that differ by less than this factor are left to the lengths. */
#define SURE (1.0 - 1e-9)

/* Newton needs three or four steps; where it takes more, the drive alone goes on. */
enum { MOST_ITERATIONS = 8 };

/* km_partition_refactor: the reduced matrix in J, B and its largest entry. Clears the lanes whose pivots don't serve any more. */
static WITHIN void factor(km_batch *l, vector *largest_b, mask *fit, int first, int count) {
  const km_recorded_elimination *replay = &l->replay;
  const int *scale = replay->scales;
  const km_recorded_elimination_update *update = replay->updates;
  double *J = l->J->of;
  vector largest_inverse[TOGETHER], sum[TOGETHER], inverse[TOGETHER];
  word sign[TOGETHER];
  EACH(r) {
    largest_inverse[r] = largest_b[r] = sum[r] = all(0.0);
    sign[r] = NONE;
  }
  for (int s = 0; s < replay->rank; ++s) {
    const km_recorded_elimination_step *step = &replay->steps[s];
    EACH(r) {
      inverse[r] = 1.0 / get(J + step->pivot + AT(r));
      PUT(l->inverse[s], inverse[r]);
      largest_inverse[r] = larger(size_of(inverse[r]), largest_inverse[r]);
      sign[r] ^= (word)inverse[r];
    }
    for (const int *end = scale + step->scale_count; scale < end; ++scale) {
      double *x = J + *scale;
      EACH(r)
      put(x + AT(r), get(x + AT(r)) * inverse[r]);
    }
    for (const km_recorded_elimination_update *end = update + step->update_count; update < end; ++update) {
      double *x = J + update->x;
      const double *a = J + update->l, *u = J + update->u;
      EACH(r)
      put(x + AT(r), get(x + AT(r)) - get(a + AT(r)) * get(u + AT(r)));
    }
  }
  km_batch_number *B = l->B;
  for (int c = replay->rank; c < replay->column_count; ++c) {
    const km_batch_number *column = l->J + replay->column[c] * replay->row_count;
    for (int i = 0; i < replay->rank; ++i, ++B) {
      const km_batch_number *entry = &column[replay->row[i]];
      EACH(r) {
        vector b = GET(*entry) * GET(l->inverse[i]);
        PUT(*B, b);
        largest_b[r] = larger(size_of(b), largest_b[r]);
        sum[r] += b;
      }
    }
  }
  EACH(r) {
    PUT(l->next_sign, (vector)((word)all(1.0) | (sign[r] & SIGN_BIT)));
    vector pivoted_b = larger(GET(l->pivoted_b), all(1.0));
    fit[r] &= is_finite(sum[r]) & at_most(largest_b[r], km_max_b_growth * pivoted_b) &
              at_most(largest_inverse[r] * GET(l->smallest_pivot), all(km_max_pivot_shrinkage));
  }
}

/* Newton's step x is the least one. */
static APART void make_least(km_batch *l, vector *largest, int first, int count) {
  find_null_vectors(l, 0, l->beside, first, count);
  least_step(l, l->x, l->next_t, first, count);
  EACH(r) {
    PUT(l->x[l->column], all(0.0));
    largest[r] = all(0.0);
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  largest[r] = larger(size_of(GET(l->x[k])), largest[r]);
}

/* newton_step of closure.c. `error`: the sum of the squares of the primary rows' errors, `largest`: the step's largest entry. */
static WITHIN void newton(km_batch *l, vector *error, vector *largest, int first, int count) {
  const km_recorded_elimination *replay = &l->replay;
  const double *J = l->J->of;
  double *y = l->y->of;
  EACH(r)
  error[r] = largest[r] = all(0.0);
  for (int i = 0; i < replay->row_count; ++i)
    EACH(r)
  PUT(l->y[i], GET(l->error[i]));
  for (const km_recorded_elimination_update *turn = replay->turns, *end = turn + replay->turn_count; turn < end;
       ++turn) {
    double *x = y + turn->x;
    const double *a = J + turn->l, *u = y + turn->u;
    EACH(r)
    put(x + AT(r), get(x + AT(r)) - get(a + AT(r)) * get(u + AT(r)));
  }
  for (int i = 0; i < replay->rank; ++i) {
    int row = replay->row[i], column = replay->column[i];
    EACH(r) {
      vector x = -(GET(l->y[row]) * GET(l->inverse[i])), e = GET(l->error[row]);
      PUT(l->x[column], x);
      largest[r] = larger(size_of(x), largest[r]);
      error[r] += e * e;
    }
  }
  for (int c = replay->rank; c < replay->column_count; ++c)
    EACH(r)
  PUT(l->x[replay->column[c]], all(0.0));
  if (l->beside > 0)
    make_least(l, largest, first, count);
}

/* Adds a scaled step where the mask is set. */
static WITHIN void move(km_batch *l, const km_batch_number *step, const mask *where, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  if (l->m->ball_count > 0)
    turn_balls(l, step, where, first, count);
  for (int k = 0; k < l->sub->columns; ++k) {
    km_batch_number *to = &l->q[coordinate[k]];
    bool is_length = l->is_length[k];
    EACH(r) {
      vector q = GET(*to), by = GET(step[k]);
      PUT(*to, pick(where[r], q + (is_length ? GET(l->unit[k]) * by : by), q));
    }
  }
}

static inline void grain(const km_batch *l, vector *coarse, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  EACH(r)
  coarse[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k) {
    if (l->is_ball[k])
      continue;
    const km_batch_number *at = &l->q[coordinate[k]];
    bool is_length = l->is_length[k];
    EACH(r) {
      vector q = GET(*at);
      coarse[r] = larger(size_of(is_length ? q / GET(l->unit[k]) : q), coarse[r]);
    }
  }
  EACH(r) {
    vector grown = 1.0 + km_tolerance_scale_growth * coarse[r];
    coarse[r] = pick(below(grown, all(km_max_tolerance_scale)), grown, all(km_max_tolerance_scale));
  }
}

static inline bool any(const mask *m, int count) {
  mask some = {0};
  EACH(r)
  some |= m[r];
  return bits_of(some) != 0;
}

/* km_loops_close from a prediction. Leaves in `trying` the lanes that closed; `correction`: sum of the squares of what Newton
 * moved, times the number of moves, which is no less than the square of their sum. `largest_b`: as of factor.
 *
 * Squares stand for lengths, so that roots and quotients aren't waited for. Where that could decide otherwise than the
 * lengths do, the lane leaves. */
static WITHIN void close_loops(km_batch *l, mask *trying, vector *correction, vector *largest_b, int first, int count) {
  vector coarse[TOGETHER], primary[TOGETHER], most[TOGETHER], sum[TOGETHER];
  mask done[TOGETHER], going[TOGETHER];
  int moves = 0;
  grain(l, coarse, first, count);
  EACH(r) {
    vector least = coarse[r] * km_residual_tolerance, tolerance = GET(l->closure_tolerance);
    primary[r] = least * least * (double)l->replay.rank;
    most[r] = 6.0 * SURE * larger(tolerance * tolerance, least * least);
    sum[r] = all(0.0);
    done[r] = mask_of(0);
  }
  for (; moves < MOST_ITERATIONS; ++moves) {
    vector square[TOGETHER], step[TOGETHER], error[TOGETHER], moved[TOGETHER];
    const double settled = moves == 0 ? km_predicted_step_tolerance : km_step_tolerance;
    update(l, moves > 0, square, trying, first, count);
    factor(l, largest_b, trying, first, count);
    newton(l, error, step, first, count);
    EACH(r) {
      mask small = at_most(error[r], SURE * primary[r]);
      trying[r] &= below(square[r], all(6.0 * SURE * km_pivot_reuse_residual * km_pivot_reuse_residual)) &
                   (small | below(primary[r], error[r] * SURE));
      mask found = trying[r] & ~done[r] & small & at_most(step[r], coarse[r] * settled);
      trying[r] &= ~found | at_most(square[r], most[r]);
      done[r] |= found;
      trying[r] &= done[r] | at_most(step[r], all(km_max_newton_step));
      going[r] = trying[r] & ~done[r];
      moved[r] = sum[r];
    }
    if (!any(going, count))
      break;
    add_product(l, l->x, l->x, moved, first, count);
    EACH(r)
    sum[r] = pick(going[r], moved[r], sum[r]);
    move(l, l->x, going, first, count);
  }
  EACH(r) {
    correction[r] = sum[r] * (double)moves;
    trying[r] &= done[r];
  }
}
