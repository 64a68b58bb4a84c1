/* One step of several drives in vectors, included once for each instruction set: NAME is the function, WIDTH the number of
 * doubles of a register.
 *
 * What is computed for a lane is what drive.c, continuation.c, closure.c, loops.c and partition/small.c compute for one
 * drive, operation for operation: nothing is contracted, nothing summed across lanes, so a lane has the bits of a drive
 * that goes alone. A lane that needs a decision (new pivots, a limit near, a shorter step) is left where it was. */
#include "kinematics/closure.h"
#include "kinematics/lane_store.h"
#include "kinematics/loops.h"
#include "spatial/sincos.h"

#include "kinematics/lanes_arithmetic_body.h"
#include "kinematics/lanes_loops_body.h"

/* Squares of lengths that differ by less than this factor are left to the lengths. */
#define SURE (1.0 - 1e-9)

/* Newton needs three or four steps; where it takes more, the drive alone goes on. */
enum { MOST_ITERATIONS = 8 };

/* km_partition_refactor: the reduced matrix in J, and B. Returns the lanes whose pivots still serve. */
static inline mask factor(km_drive_lanes *l, int g) {
  const km_replay *r = &l->replay;
  vector largest_inverse = all(0.0), largest_b = all(0.0), sum = all(0.0);
  word sign = {0};
  for (int s = 0; s < r->rank; ++s) {
    const km_replay_step *step = &r->steps[s];
    const int *rows = r->rows + step->target_start;
    km_lanes_number *column = l->J + (step->pivot - step->row);
    vector inverse = 1.0 / GET(l->J[step->pivot]);
    PUT(l->inverse[s], inverse);
    largest_inverse = larger(size_of(inverse), largest_inverse);
    sign ^= (word)inverse;
    for (int i = 0; i < step->target_count; ++i)
      PUT(column[rows[i]], GET(column[rows[i]]) * inverse);
    for (int k = 0; k < step->column_count; ++k) {
      km_lanes_number *x = l->J + r->columns[step->column_start + k];
      vector u = GET(x[step->row]);
      for (int i = 0; i < step->target_count; ++i)
        PUT(x[rows[i]], GET(x[rows[i]]) - GET(column[rows[i]]) * u);
    }
  }
  const km_lanes_number *last = l->J + r->column[r->rank] * r->row_count;
  for (int i = 0; i < r->rank; ++i) {
    vector b = GET(last[r->row[i]]) * GET(l->inverse[i]);
    PUT(l->B[i], b);
    largest_b = larger(size_of(b), largest_b);
    sum += b;
  }
  PUT(l->largest_b, largest_b);
  PUT(l->next_sign, (vector)((word)all(1.0) | (sign & SIGN_BIT)));
  vector pivoted_b = larger(GET(l->pivoted_b), all(1.0));
  return (sum - sum == all(0.0)) & (largest_b <= km_most_growth_of_b * pivoted_b) &
         (largest_inverse * GET(l->smallest_pivot) <= all(km_most_shrinking));
}

/* newton_step of closure.c, of one freedom, which the driver has. Returns the largest entry. */
static inline vector newton(km_drive_lanes *l, int g) {
  const km_replay *r = &l->replay;
  vector largest = all(0.0);
  for (int i = 0; i < r->row_count; ++i)
    PUT(l->y[i], GET(l->error[i]));
  for (int s = 0; s < r->rank; ++s) {
    const km_replay_step *step = &r->steps[s];
    const int *rows = r->rows + step->target_start;
    const km_lanes_number *column = l->J + (step->pivot - step->row);
    vector u = GET(l->y[step->row]);
    for (int i = 0; i < step->target_count; ++i)
      PUT(l->y[rows[i]], GET(l->y[rows[i]]) - GET(column[rows[i]]) * u);
  }
  for (int i = 0; i < r->rank; ++i) {
    vector x = -(GET(l->y[r->row[i]]) * GET(l->inverse[i]));
    PUT(l->x[r->column[i]], x);
    largest = larger(size_of(x), largest);
  }
  PUT(l->x[l->column], all(0.0));
  return largest;
}

/* (D a)·(D b) */
static inline vector product(const km_drive_lanes *l, const km_lanes_number *a, const km_lanes_number *b, int g) {
  vector sum = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k) {
    vector weight = GET(l->weight[k]);
    sum += weight * GET(a[k]) * weight * GET(b[k]);
  }
  return sum;
}

static inline vector primary_square(const km_drive_lanes *l, int g) {
  vector sum = all(0.0);
  for (int i = 0; i < l->replay.rank; ++i) {
    vector e = GET(l->error[l->replay.row[i]]);
    sum += e * e;
  }
  return sum;
}

/* Adds a scaled step where the mask is set. */
static inline void move(km_drive_lanes *l, const km_lanes_number *step, mask where, int g) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k) {
    vector q = GET(l->q[coordinate[k]]), by = GET(step[k]);
    PUT(l->q[coordinate[k]], pick(where, q + (l->is_length[k] ? GET(l->unit[k]) * by : by), q));
  }
}

static inline vector grain(const km_drive_lanes *l, int g) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  vector largest = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k) {
    vector q = GET(l->q[coordinate[k]]);
    largest = larger(size_of(l->is_length[k] ? q / GET(l->unit[k]) : q), largest);
  }
  vector coarse = 1.0 + km_grain_growth * largest;
  return pick(coarse < all(km_grain_most), coarse, all(km_grain_most));
}

/* km_loops_close from a prediction. Returns the lanes that closed; `correction`: sum of the squares of what Newton moved,
 * times the number of moves, which is no less than the square of their sum.
 *
 * Squares stand for lengths, so that roots and quotients aren't waited for. Where that could decide otherwise than the
 * lengths do, the lane leaves. */
static inline mask close_loops(km_drive_lanes *l, mask trying, vector *correction, int g) {
  vector coarse = grain(l, g), least = coarse * km_closed, tolerance = GET(l->closure_tolerance);
  vector primary = least * least * (double)l->replay.rank,
         most = 6.0 * SURE * larger(tolerance * tolerance, least * least);
  vector sum = all(0.0);
  mask done = mask_of(0);
  int moves = 0;
  for (; moves < MOST_ITERATIONS; ++moves) {
    vector square;
    trying &= update(l, g, &square) & (square < all(6.0 * SURE * km_near_closed * km_near_closed));
    trying &= factor(l, g);
    vector step = newton(l, g), error = primary_square(l, g);
    mask small = error <= SURE * primary;
    trying &= small | (error * SURE > primary);
    mask found = trying & ~done & small & (step <= coarse * km_settled);
    trying &= ~found | (square <= most);
    done |= found;
    trying &= done | (step <= all(km_longest_newton));
    mask going = trying & ~done;
    if (!bits_of(going))
      break;
    sum = pick(going, sum + product(l, l->x, l->x, g), sum);
    move(l, l->x, going, g);
  }
  *correction = sum * (double)moves;
  return trying & done;
}

/* km_curve_ahead: the cubic through the last two poses and their tangents, continued by h. */
static inline void predict(km_drive_lanes *l, vector h, int g) {
  vector last_h = GET(l->last_h), u = h / last_h + 1.0;
  vector h00 = 2.0 * u * u * u - 3.0 * u * u + 1.0, h10 = u * u * u - 2.0 * u * u + u, h11 = u * u * u - u * u;
  for (int k = 0; k < l->sub->columns; ++k)
    PUT(l->move[k], -h00 * GET(l->last_move[k]) + last_h * (h10 * GET(l->last_t[k]) + h11 * GET(l->t[k])));
}

/* The step that the step control allows towards the target; `arrives`: it leads there. */
static inline vector choose_step(const km_drive_lanes *l, mask *arrives, int g) {
  vector left = GET(l->target) - GET(l->s), largest = GET(l->largest);
  *arrives = size_of(left) <= largest;
  return pick(*arrives, left, (vector)((word)largest | ((word)left & SIGN_BIT)));
}

/* The lanes whose target lies within the driver's limits, and whose step isn't too long for the cubic. */
static inline mask may_step(const km_drive_lanes *l, vector h, int g) {
  vector s = GET(l->s), goal = GET(l->target);
  vector slack = 1e-12 * (1.0 + size_of(goal));
  vector high = larger(s, GET(l->driver_high)), low = -larger(-s, -GET(l->driver_low));
  mask within = (goal <= high + slack) & (goal >= low - slack);
  return within & (h != all(0.0)) & (size_of(h) <= km_continuation_farther * size_of(GET(l->last_h)));
}

/* Lanes where no coordinate can have come near a limit: outside one, by more than rounding, or beyond one on the way, which
 * is no longer than the ends of the cubic's hull. */
static inline mask clear_of_limits(const km_drive_lanes *l, vector h, int g) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  mask clear = mask_of(~0u);
  for (int k = 0; k < l->sub->columns; ++k) {
    if (!l->is_limited[k])
      continue;
    vector from = GET(l->from[k]), to = GET(l->q[coordinate[k]]), unit = GET(l->unit[k]);
    vector bend = unit * size_of(h) * larger(size_of(GET(l->t[k])), size_of(GET(l->next_t[k])));
    clear &= (larger(from, to) + bend < GET(l->high[k])) & (-larger(-from, -to) - bend > GET(l->low[k]));
  }
  return clear;
}

static inline void set_next_tangent(km_drive_lanes *l, int g) {
  for (int i = 0; i < l->replay.rank; ++i)
    PUT(l->next_t[l->replay.column[i]], -GET(l->B[i]));
  PUT(l->next_t[l->column], all(1.0));
}

/* Not too much corrected, not too sharp a turn, no jump to another branch. By squares, as in close_loops. */
static inline mask keeps_to_curve(const km_drive_lanes *l, vector square, vector correction, int g) {
  const double cosine = km_drive_least_cosine(km_drive_tightness), part = km_drive_tightness;
  vector along = product(l, l->t, l->next_t, g);
  vector squares = product(l, l->t, l->t, g) * product(l, l->next_t, l->next_t, g);
  return (correction <= SURE * part * part * square) & (along > all(0.0)) &
         (SURE * along * along >= cosine * cosine * squares) & (GET(l->next_sign) == GET(l->sign));
}

/* km_continuation_accept, and what walk does after it. */
static inline void accept(km_drive_lanes *l, mask took, mask arrives, vector h, int g) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k) {
    vector way = GET(l->q[coordinate[k]]) - GET(l->from[k]), t = GET(l->t[k]);
    if (l->is_length[k])
      way /= GET(l->unit[k]);
    PUT(l->last_move[k], pick(took, way, GET(l->last_move[k])));
    PUT(l->last_t[k], pick(took, t, GET(l->last_t[k])));
    PUT(l->t[k], pick(took, GET(l->next_t[k]), t));
  }
  vector s = GET(l->s), largest = GET(l->largest), longer = 2.0 * largest, q = GET(l->q[l->coordinate]);
  vector longest = pick(longer < all(km_drive_longest), longer, all(km_drive_longest));
  mask away = took & (size_of(h) > all(km_drive_leaves));
  PUT(l->last_h, pick(took, h, GET(l->last_h)));
  PUT(l->closed_at, pick(took, q, GET(l->closed_at)));
  PUT(l->s, pick(took, pick(arrives, GET(l->target), s + h), s));
  PUT(l->largest, pick(took, larger(longest, all(km_drive_least_first)), largest));
  PUT(l->stopped, pick(away, all(0.0), GET(l->stopped)));
  PUT(l->q[l->coordinate], pick(took & arrives, GET(l->target) * GET(l->unit[l->column]), q));
}

/* km_partition_null and km_mobility_numbers, of one freedom. */
static inline void set_numbers(km_drive_lanes *l, int g) {
  const km_replay *r = &l->replay;
  vector own = GET(l->weight[l->column]), sum = own * own;
  for (int i = 0; i < r->rank; ++i) {
    int k = r->column[i];
    vector value = -GET(l->B[i]) * GET(l->weight[k]);
    PUT(l->z[k], value);
    sum += value * value;
  }
  PUT(l->z[l->column], own);
  vector factor = 1.0 / root(sum);
  for (int k = 0; k < l->sub->columns; ++k) {
    vector z = GET(l->z[k]) * factor;
    PUT(l->z[k], z);
    PUT(l->numbers[k], z * z);
  }
}

/* km_loops_residual. */
static inline void set_residual(km_drive_lanes *l, int g) {
  vector largest = all(0.0);
  for (int i = 0; i < l->sub->loop_count; ++i)
    largest = larger(loop_square(l, l->m->loop_order[l->sub->loop_start + i], g), largest);
  largest = root(largest / all(6.0));
  for (int i = 0; i < l->sub->coupling_count; ++i)
    largest = larger(size_of(GET(l->error[l->m->couplings[l->sub->coupling_start + i].row])) / all(sqrt(6.0)), largest);
  PUT(l->residual, largest);
}

static unsigned step(km_drive_lanes *l, unsigned wanted, int g) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  mask arrives;
  vector h = choose_step(l, &arrives, g), correction;
  mask trying = mask_of(wanted) & may_step(l, h, g);
  if (!bits_of(trying))
    return 0;
  predict(l, h, g);
  for (int k = 0; k < l->sub->columns; ++k) {
    trying &= size_of(GET(l->move[k])) <= all(km_drive_furthest);
    PUT(l->from[k], GET(l->q[coordinate[k]]));
  }
  vector square = product(l, l->move, l->move, g);
  move(l, l->move, trying, g);
  vector q = GET(l->q[l->coordinate]);
  PUT(l->q[l->coordinate], pick(trying, (GET(l->s) + h) * GET(l->unit[l->column]), q));
  mask took = close_loops(l, trying, &correction, g);
  set_next_tangent(l, g);
  took &= keeps_to_curve(l, square, correction, g);
  took &= clear_of_limits(l, h, g);
  for (int k = 0; k < l->sub->columns; ++k)
    PUT(l->q[coordinate[k]], pick(took, GET(l->q[coordinate[k]]), GET(l->from[k])));
  accept(l, took, arrives, h, g);
  set_numbers(l, g);
  set_residual(l, g);
  l->there |= bits_of(took & arrives) << g;
  return bits_of(took);
}

unsigned NAME(km_drive_lanes *lanes, unsigned wanted) {
  unsigned took = 0;
  lanes->there = 0;
  for (int g = 0; g < KM_DRIVE_LANES; g += WIDTH)
    took |= step(lanes, wanted >> g & ((1u << WIDTH) - 1), g) << g;
  return took;
}
