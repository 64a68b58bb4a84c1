/* One step of a batch (theory 4.12), included once for each instruction set: NAME is the function, WIDTH the number
 * of doubles of a register.
 *
 *   predict (4.5, 4.7), close the loops (4.2), tests of correction, tangents, sign of det and limits (4.6), accept
 *
 * Per lane the operations are those of driver_motion.c, predictor_corrector.c, loop_closing.c, loop_equations.c and
 * linalg/dense in the same order; nothing is contracted or summed across lanes, so a lane has the bits of a single
 * motion. A lane that needs a decision (new pivots, a limit nearby, a shorter step) keeps its position and leaves. */
#include "continuation/batch/batch_arrays.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "spatial/sincos.h"
#include "spatial/twist.h"

#include "continuation/batch/arithmetic_body.h"
#include "continuation/polynomials_body.h"

#include "continuation/batch/spatial_loops_body.h" /* includes ball joints */

#include "continuation/batch/loop_equations_body.h"

#include "continuation/batch/null_space_body.h" /* uses arithmetic */

#include "continuation/batch/loop_closing_body.h" /* uses all of them */

#include "continuation/batch/minimum_norm_path_body.h" /* uses the closing of loops */

/* True if the step has the length of the last one. */
static inline mask is_equal_step(const km_batch *l, vector h, int r, int first) {
  return at_most(size_of(h - GET(l->current.last_h)), km_relative_zero * size_of(h));
}

/* True if h is within the extrapolation limit of the last step. */
static inline mask is_within_extrapolation(const km_batch *l, vector h, int r, int first) {
  return at_most(size_of(h), km_continuation_extrapolation_limit * size_of(GET(l->current.last_h)));
}

/* Predicts h t along the tangent where the history does not apply. */
static NOT_INLINED void predict_linear(km_batch *l, const vector *h, const mask *within_limit, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->move[k], pick(within_limit[r], GET(l->move[k]), h[r] * GET(l->t[k])));
}

static INLINED void predict_cubic(km_batch *l, const lanes_cubic *c, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->move[k], lanes_cubic_value(&c[r], GET(l->last_move[k]), GET(l->last_t[k]), GET(l->t[k])));
}

/* Replaces the cubic by the polynomial of degree 10 where `far` is set and both agree. */
static INLINED void predict_degree_ten(km_batch *l, const lanes_cubic *c, const vector *h, mask *degree_ten,
                                       const mask *valid, int first, int count) {
  vector difference[REGISTERS];
  mask others[REGISTERS];
  EACH(r)
  difference[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      const vector t = GET(l->t[k]), last_t = GET(l->last_t[k]);
      const vector within_limit = lanes_cubic_value(&c[r], GET(l->last_move[k]), last_t, t);
      vector even = h[r] * (km_curve_tangents[0] * t + km_curve_tangents[1] * last_t), odd = GET(l->remaining_step[k]);
      for (int i = 0; i < KM_CURVE_MOVES; i += 2) {
        even += km_curve_moves[i] * GET(l->past[i][k]);
        odd += km_curve_moves[i + 1] * GET(l->past[i + 1][k]);
      }
      const vector step_k = even + odd;
      difference[r] = larger(size_of(step_k - within_limit), difference[r]);
      PUT(l->x[k], step_k);
      PUT(l->move[k], within_limit);
    }
  EACH(r)
  degree_ten[r] &= at_most(difference[r], km_continuation_predictor_agreement * size_of(h[r]));
  EACH(r)
  others[r] = valid[r] & ~degree_ten[r];
  if (!any(others, count)) { /* exchange of both vectors: they belong to this step only */
    km_batch_number *swap = l->x;
    l->x = l->move;
    l->move = swap;
    return;
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->move[k], pick(degree_ten[r], GET(l->x[k]), GET(l->move[k])));
}

/* Predicts a step with one freedom, as km_continuation_predict. */
static INLINED void predict_single_freedom(km_batch *l, const vector *h, const mask *valid, int first, int count) {
  lanes_cubic c[REGISTERS];
  mask within_limit[REGISTERS], beyond_limit[REGISTERS], degree_ten[REGISTERS];
  const bool has_balls = l->m->ball_count > 0;
  EACH(r) {
    within_limit[r] = is_within_extrapolation(l, h[r], r, first);
    beyond_limit[r] = ~within_limit[r];
    c[r] = lanes_cubic_weights(h[r], GET(l->current.last_h));
    degree_ten[r] =
        valid[r] & is_equal_step(l, h[r], r, first) & equal(GET(l->current.equal_count), all(KM_CURVE_MOVES));
  }
  if (!has_balls && any(degree_ten, count))
    predict_degree_ten(l, c, h, degree_ten, valid, first, count);
  else
    predict_cubic(l, c, first, count);
  if (any(beyond_limit, count))
    predict_linear(l, h, within_limit, first, count);
}

/* Predicts `move`. Clears lanes where a coordinate moves too far, or where a slide may diverge. */
static INLINED void predict(km_batch *l, const vector *h, vector *error_ratio, mask *valid, int first, int count) {
  EACH(r)
  error_ratio[r] = all(0.0);
  if (l->extra_freedoms == 0)
    predict_single_freedom(l, h, valid, first, count);
  else
    predict_minimum_norm_path(l, h, error_ratio, valid, first, count);
  for (int k = 0; k < l->sub->columns; ++k) {
    EACH(r)
    valid[r] &= at_most(size_of(GET(l->move[k])), all(km_max_newton_step));
    if (l->is_length[k])
      EACH(r)
    valid[r] &= at_most(size_of(GET(l->from[k])), (km_driver_motion_diverging - 1.0) * GET(l->unit[k]));
  }
}

/* Chooses the step towards the target; `arrives`: it reaches the target. */
static inline void choose_step(const km_batch *l, vector *h, mask *arrives, int first, int count) {
  EACH(r) {
    vector left = GET(l->target) - GET(l->current.s), largest = GET(l->current.largest);
    arrives[r] = at_most(size_of(left), largest * (1.0 + km_root_rounding));
    h[r] = pick(arrives[r], left, (vector)((word)largest | ((word)left & SIGN_BIT)));
  }
}

/* Clears lanes whose target is outside the driver's limits and, with several freedoms, lanes without usable history. */
static inline void check_targets(const km_batch *l, const vector *h, mask *valid, int first, int count) {
  EACH(r) {
    vector s = GET(l->current.s), goal = GET(l->target);
    vector slack = 1e-12 * (1.0 + size_of(goal));
    vector high = larger(s, GET(l->driver_high)), low = -larger(-s, -GET(l->driver_low));
    valid[r] &= at_most(goal, high + slack) & at_most(low - slack, goal) & ~equal(h[r], all(0.0));
    if (l->extra_freedoms > 0)
      valid[r] &= is_within_extrapolation(l, h[r], r, first);
  }
}

/* Clears lanes where a coordinate may be near a limit: outside by more than rounding at the end or, by the convex
 * hull of the cubic, within the step. */
static inline void check_limits(const km_batch *l, const vector *h, mask *valid, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k) {
    if (!l->is_limited[k])
      continue;
    EACH(r) {
      vector from = GET(l->from[k]), to = GET(l->q[coordinate[k]]), unit = GET(l->unit[k]);
      vector hull = unit * size_of(h[r]) * larger(size_of(GET(l->t[k])), size_of(GET(l->next_t[k])));
      valid[r] &= below(larger(from, to) + hull, GET(l->high[k])) & below(GET(l->low[k]), -larger(-from, -to) - hull);
    }
  }
}

/* Clears lanes with |D correction| above the allowed part of |D move|; compared by squares. */
static inline void check_correction(const km_batch *l, const vector *correction, mask *valid, int first, int count) {
  const double part = km_correction_ratio;
  vector square[REGISTERS];
  mask corrected[REGISTERS];
  EACH(r) {
    corrected[r] = ~equal(correction[r], all(0.0));
    square[r] = all(0.0);
  }
  if (!any(corrected, count))
    return;
  add_product(l, l->move, l->move, square, first, count);
  EACH(r)
  valid[r] &= at_most(correction[r], SURE * part * part * square[r]);
}

/* Clears lanes whose tangents differ too much or, with one freedom, whose sign of det changed; compared by squares. */
static INLINED void check_tangents(const km_batch *l, mask *valid, int first, int count) {
  const double cosine = km_least_step_cosine(km_correction_ratio);
  vector along[REGISTERS], before[REGISTERS], after[REGISTERS];
  EACH(r)
  along[r] = before[r] = after[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k) /* three products (D a)·(D b) at once */
    EACH(r) {
      const vector weight = GET(l->weight[k]), t = GET(l->t[k]), next = GET(l->next_t[k]);
      const vector weighed = weight * t * weight;
      along[r] += weighed * next;
      before[r] += weighed * t;
      after[r] += weight * next * weight * next;
    }
  EACH(r)
  valid[r] &= below(all(0.0), along[r]) & at_most(cosine * cosine * (before[r] * after[r]), SURE * along[r] * along[r]);
  for (int r = 0; r < count && l->extra_freedoms == 0; ++r)
    valid[r] &= equal(GET(l->next_sign), GET(l->sign));
}

/* Writes the last move, `way`, in place of the oldest one; km_batch_rotate_history then orders the moves. */
static INLINED void push_move(km_batch *l, int k, vector step_k, mask took, int r, int first) {
  km_batch_number *to = &l->past[KM_CURVE_MOVES - 1][k];
  vector x = GET(l->x[k]), remaining_step = GET(l->remaining_step[k]);
  PUT(*to, pick(took, step_k + (x - remaining_step), GET(*to)));
  PUT(l->remaining_step[k], pick(took, x, remaining_step));
}

/* Updates the number of equal steps. */
static inline void count_equal_steps(km_batch *l, const vector *h, const mask *took, int first, int count) {
  EACH(r) {
    vector equals = GET(l->current.equal_count), most = all(KM_CURVE_MOVES);
    vector grown = pick(below(equals, most), equals + 1.0, most);
    PUT(l->current.equal_count, pick(took[r], pick(is_equal_step(l, h[r], r, first), grown, all(1.0)), equals));
  }
}

/* Returns the next step size: doubled if the error ratio permits it. */
static inline vector next_step_size(vector step, vector h, vector error_ratio, bool single_freedom) {
  vector longer = 2.0 * step;
  vector longest = pick(below(longer, all(km_longest_step)), longer, all(km_longest_step));
  if (single_freedom) /* no error ratio with one freedom */
    return longest;
  vector share = step / size_of(h), square = share * share;
  return pick(below(error_ratio * (16.0 * (square * square)), all(km_driver_motion_growth_limit)), longest, step);
}

/* Accepts the step where `took` is set; elsewhere the lane returns to its start. `x` is the Newton step not applied. */
static INLINED void accept_step(km_batch *l, const mask *took, const mask *arrives, const vector *h,
                                const vector *error_ratio, const vector *largest_b, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  const bool single_freedom = l->extra_freedoms == 0;
  if (l->m->ball_count > 0)
    end_ball_joints(l, took, first, count);
  if (single_freedom)
    count_equal_steps(l, h, took, first, count);
  else
    push_older_tangents(l, h, took, first, count);
  for (int k = 0; k < l->sub->columns; ++k) {
    km_batch_number *to = &l->q[coordinate[k]];
    bool is_length = l->is_length[k], is_ball = l->is_ball[k];
    vector step_k[REGISTERS];
    EACH(r) {
      vector by = is_ball ? GET(l->move[k]) : GET(*to) - GET(l->from[k]);
      step_k[r] = is_length ? by / GET(l->unit[k]) : by;
    }
    if (single_freedom)
      EACH(r)
    push_move(l, k, step_k[r], took[r], r, first);
    EACH(r) {
      vector t = GET(l->t[k]);
      PUT(*to, pick(took[r], GET(*to), GET(l->from[k])));
      PUT(l->last_move[k], pick(took[r], step_k[r], GET(l->last_move[k])));
      PUT(l->last_t[k], pick(took[r], t, GET(l->last_t[k])));
      PUT(l->t[k], pick(took[r], GET(l->next_t[k]), t));
    }
  }
  EACH(r) {
    vector s = GET(l->current.s), largest = GET(l->current.largest), q = GET(l->q[l->coordinate]);
    vector longest = next_step_size(largest, h[r], error_ratio[r], single_freedom);
    mask away = took[r] & below(all(km_root_rounding), size_of(h[r]));
    PUT(l->current.largest_b, pick(took[r], largest_b[r], GET(l->current.largest_b)));
    PUT(l->current.last_h, pick(took[r], h[r], GET(l->current.last_h)));
    PUT(l->current.closed_at, pick(took[r], q, GET(l->current.closed_at)));
    PUT(l->current.s, pick(took[r], pick(arrives[r], GET(l->target), s + h[r]), s));
    PUT(l->current.largest, pick(took[r], larger(longest, all(km_singular_step)), largest));
    PUT(l->current.stopped, pick(away, all(0.0), GET(l->current.stopped)));
    if (!single_freedom)
      PUT(l->sign, pick(took[r], GET(l->next_sign), GET(l->sign)));
    PUT(l->q[l->coordinate], pick(took[r] & arrives[r], GET(l->target) * GET(l->unit[l->column]), q));
  }
}

/* Writes the unit null vector and the mobility numbers m_j = z_j² of one freedom, where `took` is set. */
static INLINED void write_numbers_of_single_freedom(km_batch *l, const mask *took, int first, int count) {
  km_batch_number *z = l->x; /* free after the corrector */
  const km_lane_row *row = l->row;
  vector sum[REGISTERS], factor[REGISTERS];
  compute_null_vector(l, 0, z, sum, first, count);
  EACH(r)
  factor[r] = 1.0 / root(sum[r]);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector unit = pick(took[r], GET(z[k]) * factor[r], GET(row->z[k]));
      PUT(row->z[k], unit);
      PUT(row->mobility_number[k], unit * unit);
    }
}

/* True where the parabola through |z| in three equidistant rows has a minimum near 0, with a margin for rounding; as
 * km_minimum_search_may_reach_zero. */
static inline mask may_touch_zero(vector a, vector b, vector c) {
  const double slack = 1.01;
  vector hull = a - b - (b - c), slope = size_of(c - a), least = -larger(-a, larger(-b, -c));
  return below(all(0.0), hull) & at_most(slope, 2.0 * slack * hull) &
         below(8.0 * hull * (b - slack * km_batch_minimum_ratio * least), slope * slope);
}

/* Finds the lanes whose pivots are valid for observers and, if observed, those in which no entry of the direction of
 * motion changed sign or came near 0 since the previous row. */
static inline void find_lanes_without_zero(const km_batch *l, mask *has_valid_pivots, mask *has_no_zero, int first,
                                           int count) {
  EACH(r)
  has_no_zero[r] = has_valid_pivots[r] = at_most(GET(l->current.largest_b), all(km_max_good_b));
  for (int k = 0; k < l->sub->columns && l->is_observed; ++k)
    EACH(r) {
      vector z = GET(l->row->z[k]), before = GET(l->previous_z[0][k]), earlier = GET(l->previous_z[1][k]);
      has_no_zero[r] &= below(all(km_relative_zero), z * before) | (equal(z, all(0.0)) & equal(before, all(0.0)));
      has_no_zero[r] &= ~may_touch_zero(size_of(earlier), size_of(before), size_of(z));
    }
}

/* Writes the residual of the worst loop, as km_loops_residual, where `took` is set. */
static inline void write_residual(km_batch *l, const mask *took, int first, int count) {
  vector largest[REGISTERS];
  EACH(r)
  largest[r] = all(0.0);
  for (int i = 0; i < l->sub->loop_count; ++i) {
    const km_lane_loop *loop = &l->loops[l->m->loop_order[l->sub->loop_start + i]];
    EACH(r)
    largest[r] = larger(GET(loop->square), largest[r]);
  }
  EACH(r)
  largest[r] = root(largest[r] / all(6.0));
  for (int i = 0; i < l->sub->coupling_count; ++i) {
    const km_batch_number *error = &l->error[l->m->couplings[l->sub->coupling_start + i].row];
    EACH(r)
    largest[r] = larger(size_of(GET(*error)) / all(sqrt(6.0)), largest[r]);
  }
  EACH(r)
  PUT(l->current.residual, pick(took[r], largest[r], GET(l->current.residual)));
}

/* Takes one step of lanes first … first + count · WIDTH − 1; returns those that took it. */
static inline unsigned step_registers(km_batch *l, unsigned wanted, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  vector h[REGISTERS], error_ratio[REGISTERS], correction[REGISTERS], largest_b[REGISTERS];
  mask arrives[REGISTERS], took[REGISTERS], has_valid_pivots[REGISTERS], has_no_zero[REGISTERS];
  unsigned taken = 0;
  EACH(r)
  took[r] = mask_of(wanted >> AT(r));
  choose_step(l, h, arrives, first, count);
  check_targets(l, h, took, first, count);
  if (!any(took, count))
    return 0;
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->from[k], GET(l->q[coordinate[k]]));
  if (l->m->ball_count > 0)
    save_ball_joints(l, first, count);
  predict(l, h, error_ratio, took, first, count);
  apply_step(l, l->move, took, first, count);
  EACH(r) {
    vector q = GET(l->q[l->coordinate]);
    PUT(l->q[l->coordinate], pick(took[r], (GET(l->current.s) + h[r]) * GET(l->unit[l->column]), q));
  }
  close_loops(l, took, correction, largest_b, first, count);
  compute_next_tangent(l, first, count);
  check_correction(l, correction, took, first, count);
  check_tangents(l, took, first, count);
  check_limits(l, h, took, first, count);
  accept_step(l, took, arrives, h, error_ratio, largest_b, first, count);
  if (l->extra_freedoms == 0)
    write_numbers_of_single_freedom(l, took, first, count);
  else
    write_numbers_of_several_freedoms(l, took, first, count);
  write_residual(l, took, first, count);
  find_lanes_without_zero(l, has_valid_pivots, has_no_zero, first, count);
  EACH(r) {
    taken |= bits_of(took[r]) << AT(r);
    l->has_valid_pivots |= bits_of(has_valid_pivots[r]) << AT(r);
    l->has_no_zero |= bits_of(has_no_zero[r]) << AT(r);
    l->at_target |= bits_of(took[r] & arrives[r]) << AT(r);
  }
  return taken;
}

/* Takes one step of the wanted lanes, two registers at a time where both have wanted lanes. */
unsigned NAME(km_batch *lanes, unsigned wanted) {
  const unsigned register_mask = (1u << WIDTH) - 1;
  unsigned took = 0;
  lanes->at_target = 0;
  lanes->has_valid_pivots &= ~wanted;
  lanes->has_no_zero &= ~wanted;
  for (int first = 0; first < KM_BATCH_LANES; first += REGISTERS * WIDTH) {
    unsigned one = wanted >> first & register_mask, other = wanted >> (first + WIDTH) & register_mask;
    if (one && other)
      took |= step_registers(lanes, wanted, first, REGISTERS);
    else if (one || other)
      took |= step_registers(lanes, wanted, one ? first : first + WIDTH, 1);
  }
  return took;
}
