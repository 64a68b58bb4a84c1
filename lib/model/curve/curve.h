/* Curves: functions f of one variable x, a time or a joint's value (radians or the model's length unit), with two
 * derivatives (docs/theory.md 11.8 and 11.11). Private to the library. */
#ifndef KM_MODEL_CURVE_CURVE_H
#define KM_MODEL_CURVE_CURVE_H

#include "model/curve/expression.h"

#include <stdbool.h>
#include <stddef.h>

/* Forms of a curve. */
typedef enum km_curve_form {
  KM_CURVE_NONE,
  KM_CURVE_POLYNOMIAL, /* Σ c_k x^k */
  KM_CURVE_SINE,       /* c_0 + c_1 sin(c_2 x + c_3) */
  KM_CURVE_PIECES,     /* pieces, constant outside them */
  KM_CURVE_EXPRESSION  /* expression of x */
} km_curve_form;

/* Forms of a piece over z = (x − start)/length, 0 ≤ z ≤ 1. A rise s(z) goes from 0 to 1 and is at rest at both ends. */
typedef enum km_rise { KM_RISE_CYCLOIDAL, KM_RISE_345, KM_RISE_TRAPEZOID, KM_RISES } km_rise;

/* Words of the rises in the format; rise with a word, -1 if there is none. */
const char *km_rise_word(km_rise rise);
int km_rise_find(const char *word);
/* out = ∫s dz from 0, s, ds/dz, d²s/dz² at z, 0 ≤ z ≤ 1. */
void km_rise_at(km_rise rise, double z, double out[4]);

typedef struct km_curve_piece {
  double start, length; /* length of the last piece may be 0: a constant value */
  double c[4];          /* Σ c_k (x − start)^k, */
  double step, speed;   /* + step · s(z) + speed · length · ∫s dz */
  km_rise rise;
} km_curve_piece;

typedef struct km_law_curve {
  km_curve_form form;
  int count;             /* number of coefficients or pieces */
  const double *numbers; /* [count] coefficients; [4] of a sine */
  const km_curve_piece *pieces;
  const km_expression *expression;
  double period; /* > 0: f(x + period) = f(x) + gain, by the pieces from the first start on; 0: not periodic */
  double gain;
} km_law_curve;

/* f, f', f'' at x. O(log count). */
void km_curve_at(const km_law_curve *curve, double x, double out[3]);
/* f alone. */
double km_curve_value(const km_law_curve *curve, double x);

/* Constant curve. NULL numbers: no memory. */
km_law_curve km_curve_constant(km_arena *arena, double value);

/* Result of building a curve from rows or segments. */
typedef enum km_curve_fault {
  KM_CURVE_OK,
  KM_CURVE_MEMORY,
  KM_CURVE_TOO_LONG, /* the rows or segments take more than a period */
  KM_CURVE_OPEN,     /* the row a period after the first has another value */
  KM_CURVE_MOVING,   /* a rise begins, or a periodic list ends, at a rate that isn't 0; a jump of the rate */
} km_curve_fault;

/* Curve through rows (x, f), x increasing, joined by lines or by a cubic spline: natural, or periodic if period > 0.
 * A periodic table needn't repeat its first row. */
km_curve_fault km_curve_from_rows(const double *rows, int count, bool cubic, double period, km_arena *arena,
                                  km_law_curve *out);

/* A part of a motion: a rise by `by` from rest to rest, a change of the rate to `rate`, or (`kind` 0) on at the
 * present rate. */
typedef struct km_motion_segment {
  enum { KM_SEGMENT_KEEP, KM_SEGMENT_RISE, KM_SEGMENT_RATE } kind;
  km_rise rise;
  double duration, by, rate;
} km_motion_segment;

/* Motion that begins at x = 0 with the value `start`, at rest. A period longer than all segments ends with a dwell.
 * `at`: index of the segment at fault. */
km_curve_fault km_curve_from_segments(const km_motion_segment *segments, int count, double start, double period,
                                      km_arena *arena, km_law_curve *out, int *at);

/* Step from `before` to `after` at x = at; width > 0: by the 3-4-5 rise from `at` on. */
km_curve_fault km_curve_from_step(double at, double width, double before, double after, km_arena *arena,
                                  km_law_curve *out);

#endif
