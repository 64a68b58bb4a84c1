/* One step of several drives in vectors, included once for each instruction set: NAME is the function, WIDTH the number of
 * doubles of a register.
 *
 * What is computed for a lane is what drive.c, continuation.c, closure.c, loops.c and linalg/dense/register_elimination.c compute for one
 * drive, operation for operation: nothing is contracted, nothing summed across lanes, so a lane has the bits of a drive
 * that goes alone. A lane that needs a decision (new pivots, a limit near, a shorter step) is left where it was. */
#include "continuation/batch/batch_arrays.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "spatial/sincos.h"
#include "spatial/twist.h"

#include "continuation/batch/arithmetic_body.h"
#include "continuation/batch/spatial_loops_body.h" /* on balls */

#include "continuation/batch/loop_equations_body.h"

#include "continuation/batch/null_space_body.h" /* on arithmetic */

#include "continuation/batch/loop_closing_body.h" /* on all of them */

#include "continuation/batch/minimum_norm_path_body.h" /* on closure */

/* Of continuation.c: is a step as long as the last one? */
static inline mask as_long(const km_batch *l, vector h, int r, int first) {
  return at_most(size_of(h - GET(l->here.last_h)), km_continuation_same * size_of(h));
}

/* Is the last step long enough to tell of one of h? */
static inline mask is_near(const km_batch *l, vector h, int r, int first) {
  return at_most(size_of(h), km_continuation_farther * size_of(GET(l->here.last_h)));
}

/* Where the last step tells nothing, or there is none: along the tangent. */
static APART void set_out(km_batch *l, const vector *h, const mask *near, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->move[k], pick(near[r], GET(l->move[k]), h[r] * GET(l->t[k])));
}

/* The cubic through the last two poses and their tangents, as its weights in a step of h. */
typedef struct cubic {
  vector last_h, h00, h10, h11;
} cubic;

static inline cubic cubic_of(vector h, vector last_h) {
  const vector u = h / last_h + 1.0;
  return (cubic){last_h, 2.0 * u * u * u - 3.0 * u * u + 1.0, u * u * u - 2.0 * u * u + u, u * u * u - u * u};
}

static inline vector along_cubic(const cubic *c, vector last_move, vector last_t, vector t) {
  return -c->h00 * last_move + c->last_h * (c->h10 * last_t + c->h11 * t);
}

static WITHIN void follow_cubic(km_batch *l, const cubic *c, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->move[k], along_cubic(&c[r], GET(l->last_move[k]), GET(l->last_t[k]), GET(l->t[k])));
}

/* look_farther of continuation.c: the polynomial through nine poses in place of the cubic, where `far` is set and they agree. */
static WITHIN void look_farther(km_batch *l, const cubic *c, const vector *h, mask *far, const mask *fit, int first,
                                int count) {
  vector apart[TOGETHER];
  mask others[TOGETHER];
  EACH(r)
  apart[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      const vector t = GET(l->t[k]), last_t = GET(l->last_t[k]);
      const vector near = along_cubic(&c[r], GET(l->last_move[k]), last_t, t);
      vector even = h[r] * (km_curve_tangents[0] * t + km_curve_tangents[1] * last_t), odd = GET(l->rest[k]);
      for (int i = 0; i < KM_CURVE_MOVES; i += 2) {
        even += km_curve_moves[i] * GET(l->past[i][k]);
        odd += km_curve_moves[i + 1] * GET(l->past[i + 1][k]);
      }
      const vector way = even + odd;
      apart[r] = larger(size_of(way - near), apart[r]);
      PUT(l->x[k], way);
      PUT(l->move[k], near);
    }
  EACH(r)
  far[r] &= at_most(apart[r], km_continuation_agreement * size_of(h[r]));
  EACH(r)
  others[r] = fit[r] & ~far[r];
  if (!any(others, count)) { /* the two change places: both are this step's alone */
    km_batch_number *ways = l->x;
    l->x = l->move;
    l->move = ways;
    return;
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->move[k], pick(far[r], GET(l->x[k]), GET(l->move[k])));
}

/* km_continuation_predict, of one freedom. A step as long as the last one is near. */
static WITHIN void continue_curve(km_batch *l, const vector *h, const mask *fit, int first, int count) {
  cubic c[TOGETHER];
  mask near[TOGETHER], lost[TOGETHER], far[TOGETHER];
  const bool has_balls = l->m->ball_count > 0;
  EACH(r) {
    near[r] = is_near(l, h[r], r, first);
    lost[r] = ~near[r];
    c[r] = cubic_of(h[r], GET(l->here.last_h));
    far[r] = fit[r] & as_long(l, h[r], r, first) & equal(GET(l->here.equal_count), all(KM_CURVE_MOVES));
  }
  if (!has_balls && any(far, count))
    look_farther(l, c, h, far, fit, first, count);
  else
    follow_cubic(l, c, first, count);
  if (any(lost, count))
    set_out(l, h, near, first, count);
}

/* predict of drive.c. Clears the lanes where it leads too far, or where a slide may leave. `strain`: as in km_driver_motion. */
static WITHIN void predict(km_batch *l, const vector *h, vector *strain, mask *fit, int first, int count) {
  EACH(r)
  strain[r] = all(0.0);
  if (l->beside == 0)
    continue_curve(l, h, fit, first, count);
  else
    follow_path(l, h, strain, fit, first, count);
  for (int k = 0; k < l->sub->columns; ++k) {
    EACH(r)
    fit[r] &= at_most(size_of(GET(l->move[k])), all(km_driver_motion_furthest));
    if (l->is_length[k])
      EACH(r)
    fit[r] &= at_most(size_of(GET(l->from[k])), (km_driver_motion_away - 1.0) * GET(l->unit[k]));
  }
}

/* The step that the step control allows towards the target; `arrives`: it leads there. */
static inline void choose_step(const km_batch *l, vector *h, mask *arrives, int first, int count) {
  EACH(r) {
    vector left = GET(l->target) - GET(l->here.s), largest = GET(l->here.largest);
    arrives[r] = at_most(size_of(left), largest * km_driver_motion_reach);
    h[r] = pick(arrives[r], left, (vector)((word)largest | ((word)left & SIGN_BIT)));
  }
}

/* Clears the lanes whose target doesn't lie within the driver's limits, and, of several freedoms, whose last step tells nothing. */
static inline void may_step(const km_batch *l, const vector *h, mask *fit, int first, int count) {
  EACH(r) {
    vector s = GET(l->here.s), goal = GET(l->target);
    vector slack = 1e-12 * (1.0 + size_of(goal));
    vector high = larger(s, GET(l->driver_high)), low = -larger(-s, -GET(l->driver_low));
    fit[r] &= at_most(goal, high + slack) & at_most(low - slack, goal) & ~equal(h[r], all(0.0));
    if (l->beside > 0)
      fit[r] &= is_near(l, h[r], r, first);
  }
}

/* Clears the lanes where a coordinate can have come near a limit: outside one, by more than rounding, or beyond one on the
 * way, which is no longer than the ends of the cubic's hull. */
static inline void clear_of_limits(const km_batch *l, const vector *h, mask *fit, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k) {
    if (!l->is_limited[k])
      continue;
    EACH(r) {
      vector from = GET(l->from[k]), to = GET(l->q[coordinate[k]]), unit = GET(l->unit[k]);
      vector bend = unit * size_of(h[r]) * larger(size_of(GET(l->t[k])), size_of(GET(l->next_t[k])));
      fit[r] &= below(larger(from, to) + bend, GET(l->high[k])) & below(GET(l->low[k]), -larger(-from, -to) - bend);
    }
  }
}

/* Clears the lanes that were corrected too much for the way that was predicted. By squares, as in close_loops. */
static inline void keep_to_prediction(const km_batch *l, const vector *correction, mask *fit, int first, int count) {
  const double part = km_driver_motion_tightness;
  vector square[TOGETHER];
  mask corrected[TOGETHER];
  EACH(r) {
    corrected[r] = ~equal(correction[r], all(0.0));
    square[r] = all(0.0);
  }
  if (!any(corrected, count))
    return;
  add_product(l, l->move, l->move, square, first, count);
  EACH(r)
  fit[r] &= at_most(correction[r], SURE * part * part * square[r]);
}

/* Clears the lanes that turned too sharply, or are on another branch, which one freedom shows. By squares too. */
static WITHIN void keep_to_curve(const km_batch *l, mask *fit, int first, int count) {
  const double cosine = km_driver_motion_least_cosine(km_driver_motion_tightness);
  vector along[TOGETHER], before[TOGETHER], behind[TOGETHER];
  EACH(r)
  along[r] = before[r] = behind[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k) /* three times km_step_dot */
    EACH(r) {
      const vector weight = GET(l->weight[k]), t = GET(l->t[k]), next = GET(l->next_t[k]);
      const vector weighed = weight * t * weight;
      along[r] += weighed * next;
      before[r] += weighed * t;
      behind[r] += weight * next * weight * next;
    }
  EACH(r)
  fit[r] &= below(all(0.0), along[r]) & at_most(cosine * cosine * (before[r] * behind[r]), SURE * along[r] * along[r]);
  for (int r = 0; r < count && l->beside == 0; ++r)
    fit[r] &= equal(GET(l->next_sign), GET(l->sign));
}

/* grow_moves of continuation.c: the last move, `way`, takes the place of the oldest one; see km_batch_extend_history. */
static WITHIN void take_move(km_batch *l, int k, vector way, mask took, int r, int first) {
  km_batch_number *to = &l->past[KM_CURVE_MOVES - 1][k];
  vector x = GET(l->x[k]), rest = GET(l->rest[k]);
  PUT(*to, pick(took, way + (x - rest), GET(*to)));
  PUT(l->rest[k], pick(took, x, rest));
}

/* The same of its count of equal steps. */
static inline void count_equal(km_batch *l, const vector *h, const mask *took, int first, int count) {
  EACH(r) {
    vector equals = GET(l->here.equal_count), most = all(KM_CURVE_MOVES);
    vector grown = pick(below(equals, most), equals + 1.0, most);
    PUT(l->here.equal_count, pick(took[r], pick(as_long(l, h[r], r, first), grown, all(1.0)), equals));
  }
}

/* lengthen of drive.c. */
static inline vector lengthened(vector step, vector h, vector strain, bool alone) {
  vector longer = 2.0 * step;
  vector longest = pick(below(longer, all(km_driver_longest_step)), longer, all(km_driver_longest_step));
  if (alone) /* there is no strain */
    return longest;
  vector share = step / size_of(h), square = share * share;
  return pick(below(strain * (square * square), all(km_driver_motion_easy)), longest, step);
}

/* km_continuation_accept where `took` is set, and what walk does after it; elsewhere back to where the step began. `x` is what
 * Newton has left undone. */
static WITHIN void accept(km_batch *l, const mask *took, const mask *arrives, const vector *h, const vector *strain,
                          const vector *largest_b, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  const bool alone = l->beside == 0;
  if (l->m->ball_count > 0)
    end_balls(l, took, first, count);
  if (alone)
    count_equal(l, h, took, first, count);
  else
    grow_older(l, h, took, first, count);
  for (int k = 0; k < l->sub->columns; ++k) {
    km_batch_number *to = &l->q[coordinate[k]];
    bool is_length = l->is_length[k], is_ball = l->is_ball[k];
    vector way[TOGETHER];
    EACH(r) {
      vector by = is_ball ? GET(l->move[k]) : GET(*to) - GET(l->from[k]);
      way[r] = is_length ? by / GET(l->unit[k]) : by;
    }
    if (alone)
      EACH(r)
    take_move(l, k, way[r], took[r], r, first);
    EACH(r) {
      vector t = GET(l->t[k]);
      PUT(*to, pick(took[r], GET(*to), GET(l->from[k])));
      PUT(l->last_move[k], pick(took[r], way[r], GET(l->last_move[k])));
      PUT(l->last_t[k], pick(took[r], t, GET(l->last_t[k])));
      PUT(l->t[k], pick(took[r], GET(l->next_t[k]), t));
    }
  }
  EACH(r) {
    vector s = GET(l->here.s), largest = GET(l->here.largest), q = GET(l->q[l->coordinate]);
    vector longest = lengthened(largest, h[r], strain[r], alone);
    mask away = took[r] & below(all(km_driver_motion_leaves), size_of(h[r]));
    PUT(l->here.largest_b, pick(took[r], largest_b[r], GET(l->here.largest_b)));
    PUT(l->here.last_h, pick(took[r], h[r], GET(l->here.last_h)));
    PUT(l->here.closed_at, pick(took[r], q, GET(l->here.closed_at)));
    PUT(l->here.s, pick(took[r], pick(arrives[r], GET(l->target), s + h[r]), s));
    PUT(l->here.largest, pick(took[r], larger(longest, all(km_driver_motion_least_first)), largest));
    PUT(l->here.stopped, pick(away, all(0.0), GET(l->here.stopped)));
    if (!alone)
      PUT(l->sign, pick(took[r], GET(l->next_sign), GET(l->sign)));
    PUT(l->q[l->coordinate], pick(took[r] & arrives[r], GET(l->target) * GET(l->unit[l->column]), q));
  }
}

/* km_partition_null_space and km_mobility_numbers, of one freedom, of the lanes that `took` the step. */
static WITHIN void set_numbers_of_one(km_batch *l, const mask *took, int first, int count) {
  km_batch_number *z = l->x; /* Newton is through */
  const km_lane_row *row = l->row;
  vector sum[TOGETHER], factor[TOGETHER];
  set_null_vector(l, 0, z, sum, first, count);
  EACH(r)
  factor[r] = 1.0 / root(sum[r]);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector unit = pick(took[r], GET(z[k]) * factor[r], GET(row->z[k]));
      PUT(row->z[k], unit);
      PUT(row->numbers[k], unit * unit);
    }
}

/* km_minimum_search_is_zero of sweep/dead_points.c at rows that are equally far from each other, and where that is so but for rounding. */
static inline mask may_dip(vector a, vector b, vector c) {
  const double slack = 1.01;
  vector bend = a - b - (b - c), slope = size_of(c - a), least = -larger(-a, larger(-b, -c));
  return below(all(0.0), bend) & at_most(slope, 2.0 * slack * bend) &
         below(8.0 * bend * (b - slack * km_driver_motion_dip * least), slope * slope);
}

/* Lanes whose pivots serve whoever looks at the row; and those of them, where it counts, in which no entry of the direction of
 * motion has changed its sign, or come near 0, since the row before. */
static inline void find_quiet(const km_batch *l, mask *sound, mask *quiet, int first, int count) {
  EACH(r)
  quiet[r] = sound[r] = at_most(GET(l->here.largest_b), all(km_max_good_b));
  for (int k = 0; k < l->sub->columns && l->looks; ++k)
    EACH(r) {
      vector z = GET(l->row->z[k]), before = GET(l->before[0][k]), earlier = GET(l->before[1][k]);
      quiet[r] &= below(all(km_driver_motion_quiet), z * before) | (equal(z, all(0.0)) & equal(before, all(0.0)));
      quiet[r] &= ~may_dip(size_of(earlier), size_of(before), size_of(z));
    }
}

/* km_loops_residual, of the lanes that `took` the step. */
static inline void set_residual(km_batch *l, const mask *took, int first, int count) {
  vector largest[TOGETHER];
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
  PUT(l->here.residual, pick(took[r], largest[r], GET(l->here.residual)));
}

/* One step of lanes first … first + count · WIDTH-1. */
static inline unsigned step(km_batch *l, unsigned wanted, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  vector h[TOGETHER], strain[TOGETHER], correction[TOGETHER], largest_b[TOGETHER];
  mask arrives[TOGETHER], took[TOGETHER], sound[TOGETHER], quiet[TOGETHER];
  unsigned taken = 0;
  EACH(r)
  took[r] = mask_of(wanted >> AT(r));
  choose_step(l, h, arrives, first, count);
  may_step(l, h, took, first, count);
  if (!any(took, count))
    return 0;
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->from[k], GET(l->q[coordinate[k]]));
  if (l->m->ball_count > 0)
    save_balls(l, first, count);
  predict(l, h, strain, took, first, count);
  move(l, l->move, took, first, count);
  EACH(r) {
    vector q = GET(l->q[l->coordinate]);
    PUT(l->q[l->coordinate], pick(took[r], (GET(l->here.s) + h[r]) * GET(l->unit[l->column]), q));
  }
  close_loops(l, took, correction, largest_b, first, count);
  set_next_tangent(l, first, count);
  keep_to_prediction(l, correction, took, first, count);
  keep_to_curve(l, took, first, count);
  clear_of_limits(l, h, took, first, count);
  accept(l, took, arrives, h, strain, largest_b, first, count);
  if (l->beside == 0)
    set_numbers_of_one(l, took, first, count);
  else
    set_numbers_of_several(l, took, first, count);
  set_residual(l, took, first, count);
  find_quiet(l, sound, quiet, first, count);
  EACH(r) {
    taken |= bits_of(took[r]) << AT(r);
    l->sound |= bits_of(sound[r]) << AT(r);
    l->quiet |= bits_of(quiet[r]) << AT(r);
    l->there |= bits_of(took[r] & arrives[r]) << AT(r);
  }
  return taken;
}

/* Two registers at a time, where lanes of both are wanted. */
unsigned NAME(km_batch *lanes, unsigned wanted) {
  const unsigned own = (1u << WIDTH) - 1;
  unsigned took = 0;
  lanes->there = 0;
  lanes->sound &= ~wanted;
  lanes->quiet &= ~wanted;
  for (int first = 0; first < KM_BATCH_LANES; first += TOGETHER * WIDTH) {
    unsigned one = wanted >> first & own, other = wanted >> (first + WIDTH) & own;
    if (one && other)
      took |= step(lanes, wanted, first, TOGETHER);
    else if (one || other)
      took |= step(lanes, wanted, one ? first : first + WIDTH, 1);
  }
  return took;
}
