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

#ifdef __SSE2__
#include <immintrin.h>
#endif

typedef double vector __attribute__((vector_size(8 * WIDTH)));
typedef int64_t mask __attribute__((vector_size(8 * WIDTH)));
typedef uint64_t word __attribute__((vector_size(8 * WIDTH)));

#define T            vector
#define BITS         word
#define NONE         ((word){0})
#define FN(name)     lanes_##name
#define km_bits_of   (word)
#define km_number_of (vector)
#include "spatial/sincos_body.h"

#define SIGN_BIT ((uint64_t)1 << 63)

/* Squares of lengths that differ by less than this factor are left to the lengths. */
#define SURE (1.0 - 1e-9)

/* Newton needs three or four steps; where it takes more, the drive alone goes on. */
enum { MOST_ITERATIONS = 8 };

/* a > b ? a : b, as the processor's maximum. */
static inline vector larger(vector a, vector b) {
#if WIDTH == 8
  return (vector)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif WIDTH == 4
  return (vector)_mm256_max_pd((__m256d)a, (__m256d)b);
#elif defined __SSE2__
  return (vector)_mm_max_pd((__m128d)a, (__m128d)b);
#else
  return (vector){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}

static inline vector root(vector a) {
#if WIDTH == 8
  return (vector)_mm512_sqrt_pd((__m512d)a);
#elif WIDTH == 4
  return (vector)_mm256_sqrt_pd((__m256d)a);
#elif defined __SSE2__
  return (vector)_mm_sqrt_pd((__m128d)a);
#else
  return (vector){sqrt(a[0]), sqrt(a[1])};
#endif
}

/* Numbers lie where doubles may: and they change no pointer, which memcpy might. */
typedef double stored __attribute__((vector_size(8 * WIDTH), aligned(8)));
static inline vector get(const double *number) {
  return *(const stored *)number;
}
static inline void put(double *number, vector value) {
  *(stored *)number = value;
}
static inline vector pick(mask m, vector a, vector b) { /* a where the mask is set */
  return (vector)(((mask)a & m) | ((mask)b & ~m));
}
static inline vector size_of(vector a) {
  return (vector)((mask)a & INT64_MAX);
}
static inline vector all(double value) {
  return (vector){0.0} + value;
}
static inline unsigned bits_of(mask m) {
#if WIDTH == 8
  return (unsigned)_mm512_movepi64_mask((__m512i)m);
#elif WIDTH == 4
  return (unsigned)_mm256_movemask_pd((__m256d)m);
#elif defined __SSE2__
  return (unsigned)_mm_movemask_pd((__m128d)m);
#else
  return (unsigned)(m[0] & 1) | (unsigned)(m[1] & 1) << 1;
#endif
}
static inline mask mask_of(unsigned bits) {
  mask m = {0};
  for (int i = 0; i < WIDTH; ++i)
    m[i] = -(int64_t)(bits >> i & 1);
  return m;
}

/* Below, g is the first lane of the register: lanes g … g + WIDTH-1 are worked on. */
#define GET(number)        get((number).of + g)
#define PUT(number, value) put((number).of + g, (value))

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
  return (sum - sum == all(0.0)) & (largest_b <= 2.0 * pivoted_b) &
         (largest_inverse * GET(l->smallest_pivot) <= all(10.0));
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
