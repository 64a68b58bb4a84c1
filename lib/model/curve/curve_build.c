/* Curves from rows, from segments of a motion, and from a step.
 *
 *   cubic spline, M_i second derivatives at the rows, h_i = x_{i+1} − x_i, natural (M = 0 at both ends) or periodic:
 *   h_{i−1} M_{i−1} + 2 (h_{i−1} + h_i) M_i + h_i M_{i+1} = 6 ((y_{i+1} − y_i)/h_i − (y_i − y_{i−1})/h_{i−1})
 *
 * Source: de Boor, A Practical Guide to Splines. */
#include "model/curve/curve.h"

#include <math.h>

/* Rows or segments fill a period if their length differs from it by less than this part of it: rounding of decimal
 * numbers. */
static const double period_rounding = 1e-9;

km_law_curve km_curve_constant(km_arena *arena, double value) {
  double *number = KM_ARENA_NEW(arena, double, 1);
  if (number)
    *number = value;
  return (km_law_curve){.form = KM_CURVE_POLYNOMIAL, .count = 1, .numbers = number};
}

/* Columns x and y of the rows, with the row that closes a period. Returns the number of rows. */
static size_t copy_rows(const double *rows, int count, double period, double *x, double *y) {
  for (int i = 0; i < count; ++i) {
    x[i] = rows[2 * i];
    y[i] = rows[2 * i + 1];
  }
  if (period == 0.0)
    return (size_t)count;
  int last = x[count - 1] - x[0] < period * (1.0 - period_rounding) ? count : count - 1;
  x[last] = x[0] + period;
  y[last] = y[0];
  return (size_t)last + 1;
}

static void add_lines(const double *x, const double *y, size_t count, km_curve_piece *out) {
  for (size_t i = 0; i + 1 < count; ++i)
    out[i] =
        (km_curve_piece){.start = x[i], .length = x[i + 1] - x[i], .c = {y[i], (y[i + 1] - y[i]) / (x[i + 1] - x[i])}};
}

/* Second derivatives M at the rows by Gauss-Seidel sweeps. The equations are diagonally dominant by 2, so a sweep at
 * least halves the error, and 60 sweeps leave rounding. */
static void solve_spline(const double *x, const double *y, size_t count, bool is_periodic, double *M) {
  enum { SWEEPS = 60 };
  const size_t last = count - 1;
  for (int sweep = 0; sweep < SWEEPS; ++sweep) {
    for (size_t i = is_periodic ? 0 : 1; i < last; ++i) {
      size_t before = i ? i - 1 : last - 1;
      double h = x[before + 1] - x[before], k = x[i + 1] - x[i];
      double bend = (y[i + 1] - y[i]) / k - (y[before + 1] - y[before]) / h;
      M[i] = (6.0 * bend - h * M[before] - k * M[i + 1]) / (2.0 * (h + k));
      if (i == 0)
        M[last] = M[0];
    }
  }
}

static bool add_cubics(const double *x, const double *y, size_t count, bool is_periodic, km_curve_piece *out) {
  double *M = KM_NEW(double, count);
  if (!M)
    return false;
  solve_spline(x, y, count, is_periodic, M);
  for (size_t i = 0; i + 1 < count; ++i) {
    double h = x[i + 1] - x[i], here = M[i], there = M[i + 1];
    out[i] = (km_curve_piece){
        .start = x[i],
        .length = h,
        .c = {y[i], (y[i + 1] - y[i]) / h - h * (2.0 * here + there) / 6.0, 0.5 * here, (there - here) / (6.0 * h)}};
  }
  km_free(M);
  return true;
}

km_curve_fault km_curve_from_rows(const double *rows, int count, bool cubic, double period, km_arena *arena,
                                  km_law_curve *out) {
  double span = rows[2 * count - 2] - rows[0];
  if (period > 0.0 && span > period * (1.0 + period_rounding))
    return KM_CURVE_TOO_LONG;
  if (period > 0.0 && span >= period * (1.0 - period_rounding) && rows[2 * count - 1] != rows[1])
    return KM_CURVE_OPEN;
  double *x = KM_NEW(double, 2 * (size_t)count + 2), *y = x ? x + count + 1 : NULL;
  km_curve_piece *pieces = KM_ARENA_NEW(arena, km_curve_piece, (size_t)count + 1);
  bool is_ok = x && pieces;
  size_t total = is_ok ? copy_rows(rows, count, period, x, y) : 0;
  if (is_ok && total == 1)
    pieces[0] = (km_curve_piece){.start = x[0], .c = {y[0]}};
  else if (is_ok && cubic && total > 2)
    is_ok = add_cubics(x, y, total, period > 0.0, pieces);
  else if (is_ok)
    add_lines(x, y, total, pieces);
  km_free(x);
  *out = (km_law_curve){
      .form = KM_CURVE_PIECES, .count = total > 1 ? (int)total - 1 : 1, .pieces = pieces, .period = period};
  return is_ok ? KM_CURVE_OK : KM_CURVE_MEMORY;
}

km_curve_fault km_curve_from_segments(const km_motion_segment *segments, int count, double start, double period,
                                      km_arena *arena, km_law_curve *out, int *at) {
  km_curve_piece *pieces = KM_ARENA_NEW(arena, km_curve_piece, (size_t)count + 1);
  if (!pieces)
    return KM_CURVE_MEMORY;
  double time = 0.0, value = start, rate = 0.0;
  for (*at = 0; *at < count; ++*at) {
    const km_motion_segment *s = &segments[*at];
    if (s->kind == KM_SEGMENT_RISE && rate != 0.0)
      return KM_CURVE_MOVING;
    pieces[*at] = (km_curve_piece){.start = time,
                                   .length = s->duration,
                                   .c = {value, rate},
                                   .step = s->kind == KM_SEGMENT_RISE ? s->by : 0.0,
                                   .speed = s->kind == KM_SEGMENT_RATE ? s->rate - rate : 0.0,
                                   .rise = s->rise};
    value += rate * s->duration + pieces[*at].step + 0.5 * pieces[*at].speed * s->duration;
    rate = s->kind == KM_SEGMENT_RATE ? s->rate : rate;
    time += s->duration;
  }
  if (period > 0.0 && time > period * (1.0 + period_rounding))
    return KM_CURVE_TOO_LONG;
  if (period > 0.0 && rate != 0.0)
    return KM_CURVE_MOVING;
  /* The end lasts: a dwell, or a motion at the last rate. */
  pieces[count] = (km_curve_piece){.start = time, .length = HUGE_VAL, .c = {value, rate}};
  *out = (km_law_curve){.form = KM_CURVE_PIECES,
                        .count = count + 1,
                        .pieces = pieces,
                        .period = period,
                        .gain = period > 0.0 ? value - start : 0.0};
  return KM_CURVE_OK;
}

km_curve_fault km_curve_from_step(double at, double width, double before, double after, km_arena *arena,
                                  km_law_curve *out) {
  km_curve_piece *pieces = KM_ARENA_NEW(arena, km_curve_piece, 2);
  if (!pieces)
    return KM_CURVE_MEMORY;
  pieces[0] =
      width > 0.0
          ? (km_curve_piece){.start = at, .length = width, .c = {before}, .step = after - before, .rise = KM_RISE_345}
          : (km_curve_piece){.start = -HUGE_VAL, .c = {before}};
  pieces[1] = (km_curve_piece){.start = at + width, .c = {after}};
  *out = (km_law_curve){.form = KM_CURVE_PIECES, .count = 2, .pieces = pieces};
  return KM_CURVE_OK;
}
