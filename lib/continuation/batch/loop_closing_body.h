/* Newton iteration that closes the loops in a batch (theory 4.2, 4.12); part of step_body.h.
 *
 *   J_p x = -e_p, |D x| minimal with several freedoms;   q <- exp(x) q
 *
 * Comparisons use squares of lengths, without roots and quotients; where a margin SURE could decide otherwise than
 * the lengths do, the lane leaves the batch. */

/* Margin of comparisons of squares. */
#define SURE (1.0 - 1e-9)

/* Three or four iterations are usual; a lane that needs more continues singly. */
enum { MOST_ITERATIONS = 8 };

/* Gauss-Jordan elimination with the recorded pivots, as km_factor_refactor: leaves the reduced matrix in J, and B
 * with its largest entry. Clears lanes whose pivots became unstable (growth monitor, theory 3.3). */
static INLINED void refactor(km_batch *l, vector *largest_b, mask *valid, int first, int count) {
  const km_recorded_elimination *elimination = &l->elimination;
  const int *scale = elimination->scales;
  const km_recorded_elimination_update *update = elimination->updates;
  double *J = l->J->of;
  vector largest_inverse[REGISTERS], sum[REGISTERS], inverse[REGISTERS];
  word sign[REGISTERS];
  EACH(r) {
    largest_inverse[r] = largest_b[r] = sum[r] = all(0.0);
    sign[r] = NONE;
  }
  for (int s = 0; s < elimination->rank; ++s) {
    const km_recorded_elimination_step *step = &elimination->steps[s];
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
  for (int c = elimination->rank; c < elimination->column_count; ++c) {
    const km_batch_number *column = l->J + elimination->column[c] * elimination->row_count;
    for (int i = 0; i < elimination->rank; ++i, ++B) {
      const km_batch_number *entry = &column[elimination->row[i]];
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
    vector pivoted_b = larger(GET(l->max_b_at_search), all(1.0));
    valid[r] &= is_finite(sum[r]) & at_most(largest_b[r], km_max_b_growth * pivoted_b) &
                at_most(largest_inverse[r] * GET(l->smallest_pivot), all(km_max_pivot_shrinkage));
  }
}

/* Replaces Newton's step x by the minimum-norm step of several freedoms. */
static NOT_INLINED void replace_by_minimum_norm(km_batch *l, vector *largest, int first, int count) {
  compute_null_vectors(l, 0, l->extra_freedoms, first, count);
  minimum_norm_step(l, l->x, l->next_t, first, count);
  EACH(r) {
    PUT(l->x[l->column], all(0.0));
    largest[r] = all(0.0);
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  largest[r] = larger(size_of(GET(l->x[k])), largest[r]);
}

/* Computes Newton's step x = -J⁻¹ e from the elimination, as loop_closing.c. `error`: sum of squares of the primary
 * rows' errors, `largest`: largest entry of x. */
static INLINED void newton_step(km_batch *l, vector *error, vector *largest, int first, int count) {
  const km_recorded_elimination *elimination = &l->elimination;
  const double *J = l->J->of;
  double *y = l->y->of;
  EACH(r)
  error[r] = largest[r] = all(0.0);
  for (int i = 0; i < elimination->row_count; ++i)
    EACH(r)
  PUT(l->y[i], GET(l->error[i]));
  for (const km_recorded_elimination_update *turn = elimination->rhs_updates,
                                            *end = turn + elimination->rhs_update_count;
       turn < end; ++turn) {
    double *x = y + turn->x;
    const double *a = J + turn->l, *u = y + turn->u;
    EACH(r)
    put(x + AT(r), get(x + AT(r)) - get(a + AT(r)) * get(u + AT(r)));
  }
  for (int i = 0; i < elimination->rank; ++i) {
    int row = elimination->row[i], column = elimination->column[i];
    EACH(r) {
      vector x = -(GET(l->y[row]) * GET(l->inverse[i])), e = GET(l->error[row]);
      PUT(l->x[column], x);
      largest[r] = larger(size_of(x), largest[r]);
      error[r] += e * e;
    }
  }
  for (int c = elimination->rank; c < elimination->column_count; ++c)
    EACH(r)
  PUT(l->x[elimination->column[c]], all(0.0));
  if (l->extra_freedoms > 0)
    replace_by_minimum_norm(l, largest, first, count);
}

/* Adds a scaled step to the coordinates where the mask is set. */
static INLINED void apply_step(km_batch *l, const km_batch_number *step, const mask *where, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  if (l->m->ball_count > 0)
    rotate_ball_joints(l, step, where, first, count);
  for (int k = 0; k < l->sub->columns; ++k) {
    km_batch_number *to = &l->q[coordinate[k]];
    bool is_length = l->is_length[k];
    EACH(r) {
      vector q = GET(*to), by = GET(step[k]);
      PUT(*to, pick(where[r], q + (is_length ? GET(l->unit[k]) * by : by), q));
    }
  }
}

/* Computes the tolerance scale 1 + 1e-3 max|q|, limited (theory 4.1). */
static inline void compute_tolerance_scale(const km_batch *l, vector *tolerance_scale, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  EACH(r)
  tolerance_scale[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k) {
    if (l->is_ball[k])
      continue;
    const km_batch_number *at = &l->q[coordinate[k]];
    bool is_length = l->is_length[k];
    EACH(r) {
      vector q = GET(*at);
      tolerance_scale[r] = larger(size_of(is_length ? q / GET(l->unit[k]) : q), tolerance_scale[r]);
    }
  }
  EACH(r) {
    vector grown = 1.0 + tolerance_scale[r] / km_max_tolerance_scale();
    tolerance_scale[r] = pick(below(grown, all(km_max_tolerance_scale())), grown, all(km_max_tolerance_scale()));
  }
}

static inline bool any(const mask *m, int count) {
  mask some = {0};
  EACH(r)
  some |= m[r];
  return bits_of(some) != 0;
}

/* Closes the loops from the prediction, as km_loops_close. Leaves in `trying` the lanes that closed; `correction`:
 * sum of the squares of the steps times their number, an upper bound of the square of their sum; `largest_b`: as
 * refactor. */
static INLINED void close_loops(km_batch *l, mask *trying, vector *correction, vector *largest_b, int first,
                                int count) {
  vector tolerance_scale[REGISTERS], primary[REGISTERS], most[REGISTERS], sum[REGISTERS];
  mask done[REGISTERS], going[REGISTERS];
  int moves = 0;
  compute_tolerance_scale(l, tolerance_scale, first, count);
  EACH(r) {
    vector smallest = tolerance_scale[r] * km_solved_rounding, tolerance = GET(l->closure_tolerance);
    primary[r] = smallest * smallest * (double)l->elimination.rank;
    most[r] = 6.0 * SURE * larger(tolerance * tolerance, smallest * smallest);
    sum[r] = all(0.0);
    done[r] = mask_of(0);
  }
  for (; moves < MOST_ITERATIONS; ++moves) {
    vector square[REGISTERS], step[REGISTERS], error[REGISTERS], moved[REGISTERS];
    const double settled = moves == 0 ? km_solved_rounding : km_relative_zero;
    update(l, moves > 0, square, trying, first, count);
    refactor(l, largest_b, trying, first, count);
    newton_step(l, error, step, first, count);
    EACH(r) {
      mask small = at_most(error[r], SURE * primary[r]);
      trying[r] &= below(square[r], all(6.0 * SURE * km_pivot_reuse_residual * km_pivot_reuse_residual)) &
                   (small | below(primary[r], error[r] * SURE));
      mask found = trying[r] & ~done[r] & small & at_most(step[r], tolerance_scale[r] * settled);
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
    apply_step(l, l->x, going, first, count);
  }
  EACH(r) {
    correction[r] = sum[r] * (double)moves;
    trying[r] &= done[r];
  }
}
