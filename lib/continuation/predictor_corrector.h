/* Predictor-corrector step along a motion q(s): driven (s is the scaled driver) or by arc length (s = |D q|).
 *
 *   predict : q + move(h) from the tangents and steps of the history     (theory 4.5)
 *   correct : close the loops by minimum-norm Newton steps               (theory 4.2)
 *   accept  : tests of the correction, the tangent, the rank             (theory 4.6, 4.9)
 *
 * Vectors are scaled steps, [columns] of one substructure. Private to continuation/ and local/. */
#ifndef KM_CONTINUATION_PREDICTOR_CORRECTOR_H
#define KM_CONTINUATION_PREDICTOR_CORRECTOR_H

#include "base/number/tolerances.h"
#include "continuation/hermite_curve.h"
#include "kinematics/loop_closing.h"
#include "local/constant_rank.h"
#include "local/local.h"

/* Pivot, relative to the largest entry, below which a configuration is singular: rounding errors then determine the
 * tangent. */
static const double km_singular_pivot = 1e-7;
static inline bool km_continuation_is_singular(const km_factor *p) {
  const km_factor_evidence evidence = km_factor_get_evidence(p);
  return evidence.last_pivot < km_singular_pivot * evidence.scale;
}

/* Longest step of a parameter, the move of a coordinate being at most km_max_newton_step: radians or sizes. */
static const double km_longest_step = 0.3;

/* Extrapolation limit: the history predicts steps of at most this many previous step lengths (theory 4.5). */
static const double km_continuation_extrapolation_limit = 4.0;

/* Largest difference, per unit of s, between the degree-10 and the cubic prediction; beyond it a singular
 * configuration is so near that high derivatives are unreliable. */
static const double km_continuation_predictor_agreement = 1e-3;

enum { KM_OLDER_STEPS = 3 };

/* History of the predictor: tangents and steps of previous configurations. */
typedef struct km_step_history {
  double *t;                       /* [columns] dq/ds at the present configuration */
  double *last_t, *last_move;      /* [columns] tangent at the start of the last step, and that step */
  double last_h;                   /* length of the last step in s; 0: no step yet */
  int older_count;                 /* valid entries of older_t, with several freedoms */
  double *older_t[KM_OLDER_STEPS]; /* [columns] tangents at the start of earlier steps, the latest first */
  double older_h[KM_OLDER_STEPS];  /* lengths of these steps in s */
  /* The Newton step that the last closing computed and did not apply (below 1e-9), and the last moves with these
   * steps added, the latest first; for one freedom. They are exact to rounding, as the degree-10 predictor requires. */
  double *remaining_step, *moves[KM_CURVE_MOVES]; /* [columns] */
  int equal_count;                                /* number of last steps with equal length, at most KM_CURVE_MOVES */
  /* pivots of the present configuration, for the sign test of det(pivot block) */
  int sign; /* sign of the pivot block at the last configuration */
  km_factor *reference;
} km_step_history;

typedef struct km_continuation {
  const km_mechanism *mechanism;
  km_state *state;
  int substructure;
  int coordinate, column; /* the driver; KM_NO_DRIVER: s is the arc length |D q| */
  bool ignore_limits;
  km_step_history history;
  double *next_t, *move;          /* [columns] tangent at the trial configuration, and the step that leads to it */
  double *next_remaining_step;    /* [columns] Newton step not applied there */
  double *from;                   /* configuration at the start of the step, as km_state_save */
  km_constant_rank constant_rank; /* tangents of permanently shaky mechanisms (theory 5.6) */
  double *work;                   /* [columns] */
} km_continuation;

/* Conditions under which a corrected step is accepted. */
typedef struct km_step_terms {
  double parameter;       /* value of the driver at the end of the step, scaled */
  double most_correction; /* largest |D correction| */
  double least_cosine;    /* cos of the largest angle between the tangents at both ends, in the metric D */
  int least_rank;         /* smallest rank; a lower one means a singular configuration */
  bool leaves_end;        /* the step leads back from a located turning point, where new pivots can look singular */
} km_step_terms;

/* Least cosine between the tangents of a step. */
static inline double km_least_step_cosine(double correction_ratio) {
  return 1.0 - correction_ratio * 0.4;
}
/* Terms of a step with |D move| = length. */
static inline km_step_terms km_step_terms_of(double correction_ratio, double length) {
  return (km_step_terms){.most_correction = correction_ratio * length + km_relative_zero,
                         .least_cosine = km_least_step_cosine(correction_ratio)};
}

typedef enum km_step_outcome {
  KM_STEP_ACCEPTED,
  KM_STEP_OPEN,    /* the loops do not close, or the configuration is singular */
  KM_STEP_TOO_LONG /* the correction or the angle between the tangents is too large */
} km_step_outcome;

bool km_step_history_reserve(km_step_history *history, const km_continuation *continuation, km_arena *arena);
/* copies into the arrays of `to` */
void km_step_history_copy(km_step_history *to, const km_step_history *from, int columns);
/* Allocates the vectors for the mechanism, state and substructure in the structure; false without memory. */
bool km_continuation_reserve(km_continuation *continuation, km_arena *arena);

static inline const km_substructure *km_continuation_sub(const km_continuation *c) {
  return &c->mechanism->substructures[c->substructure];
}
/* Returns (D a)·(D b) of scaled steps. */
double km_continuation_dot(const km_continuation *continuation, const double *a, const double *b);

/* True if the motion has one freedom: `freedom` of first order or, of constant-rank motions, their count. */
static inline bool km_continuation_has_single_freedom(const km_continuation *c, int freedom) {
  return c->constant_rank.is_active ? c->constant_rank.count == 1 : freedom <= 1;
}

/* Computes the tangent t at the state's configuration from its partition. Driven: t_driver = 1 and |D t| minimal;
 * false at a dead point of the driver. Arc length: the projection of `along` onto the null space with |D t| = 1;
 * false if less than 1e-6 of it remains. */
bool km_continuation_tangent(km_continuation *continuation, const double *along, double *t);

/* Sets the reference to the pivots of a factor. */
void km_step_history_set_reference(km_step_history *history, const km_factor *factor);
/* Clears the history: the next prediction uses the tangent alone. */
void km_step_history_begin(km_step_history *history, int columns);

/* Predicts `move` for a step h from a regular configuration. One freedom: the cubic Hermite polynomial through the
 * last two configurations, extrapolated; after eight steps of equal length the polynomial of degree 10, where both
 * agree. Several freedoms: second-order Adams-Bashforth, since the cubic is unstable (characteristic root -5).
 * Without history, or beyond the extrapolation limit: h t (theory 4.5). */
void km_continuation_predict(km_continuation *continuation, double h, bool single_freedom);
/* Applies `move`, closes the loops and computes next_t. The state stays at the trial configuration. */
km_step_outcome km_continuation_correct(km_continuation *continuation, const km_step_terms *terms);
/* Returns the coordinate that is beyond its limit at the trial configuration or, by the cubic, within the step; -1:
 * none. */
int km_continuation_limit(const km_continuation *continuation, double h);
/* Returns the step that leads to the nearer limit of a coordinate at its present rate, where the limit was found to
 * 1e-7; 0: none. Two such steps leave rounding only. */
double km_continuation_step_to_limit(const km_continuation *continuation, int coordinate);
/* Accepts the trial configuration: it enters the history and next_t becomes the present tangent. */
void km_continuation_accept(km_continuation *continuation, double h);
/* Rejects the trial configuration: the state returns to the start of the step. */
void km_continuation_reject(km_continuation *continuation);
/* Sets the driver's coordinate to the scaled value. */
void km_continuation_set_driver(km_continuation *continuation, double parameter);

/* Converts the tangent t[column · stride] to rates of all coordinates, in radians and the model's length, per unit of s
 * times `scale`. Coordinates outside the substructure have rate 0. */
void km_continuation_rates(const km_continuation *continuation, const double *t, int stride, double scale,
                           double *rates);

/* Returns the arc length of the cubic between two configurations `move` apart with unit tangents t0, t1, negative if
 * `move` opposes t0. The cubic depends on its own length, so four fixed-point iterations; five-point Gauss-Legendre
 * quadrature. */
double km_continuation_arc_length(const km_continuation *continuation, const double *move, const double *t0,
                                  const double *t1);

/* Observer of the intermediate steps of a motion; the step that reaches the target is not reported. */
typedef struct km_step_observer {
  /* s: driver or arc length, rates: of all coordinates; NULL: no observer */
  void (*notify)(void *self, double s, const double *rates);
  void *self;
  double *rates; /* [coordinate] workspace */
} km_step_observer;

#endif
