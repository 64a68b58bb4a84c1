/* One step along a motion: predicted, closed, judged, and remembered for the next. Shared by drives, whose parameter is
 * the driver's coordinate, and by motions that are followed by arc length. Private to kinematics/. */
#ifndef KM_CONTINUATION_PREDICTOR_CORRECTOR_H
#define KM_CONTINUATION_PREDICTOR_CORRECTOR_H

#include "continuation/hermite_curve.h"
#include "kinematics/state.h"
#include "local/constant_rank_motion.h"

/* So close to a singular pose, by its last pivot, that the tangent is noise. */
static inline bool km_continuation_is_singular(const km_partition *p) {
  static const double singular = 1e-7;
  return p->last_pivot < singular * p->scale;
}

/* Farther than this many last steps, the last step says nothing. */
static const double km_continuation_farther = 4.0;

/* Steps are as long as each other to within this part, as far as the prediction goes. */
static const double km_continuation_same = 1e-9;
/* Predictions by nine poses and by two may differ by this, per unit of the parameter; else a singular pose is too near for
 * so many terms. */
static const double km_continuation_agreement = 1e-3;

enum { KM_OLDER_STEPS = 3 };

/* What the next step depends on, beside the pose. */
typedef struct km_step_history {
  double *t;                       /* [columns] the present tangent, per unit of the parameter */
  double *last_t, *last_move;      /* [columns] tangent where the last step began, and the step */
  double last_h;                   /* its length in the parameter; 0: there is none */
  int older_count;                 /* where more freedoms than one are left: steps before the last one that count */
  double *older_t[KM_OLDER_STEPS]; /* [columns] the tangents where they began, the latest step first */
  double older_h[KM_OLDER_STEPS];  /* their lengths */
  /* Where one freedom is left: Newton's step that closing the last pose has left undone, below 1e-9, and the last moves with
   * it, the latest first, in which nothing but rounding is left. */
  double *rest, *moves[KM_CURVE_MOVES]; /* [columns] */
  int equal_count;                      /* last steps that are as long as each other, so many at most */
  km_partition reference;               /* pivots of the present pose, to compare signs with */
} km_step_history;

typedef struct km_continuation {
  const km_mechanism *mechanism;
  km_state *state;
  int substructure;
  int coordinate, column; /* the driver; KM_NO_DRIVER: the parameter is the arc length |D q| */
  bool ignore_limits;
  km_step_history course;
  double *next_t, *move;   /* [columns] tangent of the pose that was tried last, and the way to it */
  double *next_rest;       /* [columns] Newton's step that was left undone there */
  double *from;            /* saved pose where the step begins */
  km_constant_rank steady; /* where the mechanism shakes all along the motion */
  double *work;            /* [columns] */
} km_continuation;

/* What a step has to keep to. */
typedef struct km_step_terms {
  double parameter;       /* of a driver: the value that it gets, scaled */
  double most_correction; /* scaled length of all that closing the loops may move */
  double least_cosine;    /* between the tangents */
  int least_rank;         /* less is a singular pose */
  bool leaves_end;        /* it leads back from a located end, where pivots found anew may show a singular pose */
} km_step_terms;

typedef enum km_step_outcome {
  KM_STEP_ACCEPTED,
  KM_STEP_OPEN,    /* the loops don't close there, or the pose is singular */
  KM_STEP_TOO_LONG /* too long for the curve */
} km_step_outcome;

bool km_step_history_reserve(km_step_history *course, const km_continuation *continuation, km_arena *arena);
void km_step_history_copy(km_step_history *to, const km_step_history *from, int columns); /* into arrays of its own */
/* For the mechanism, state and substructure that are set. */
bool km_continuation_reserve(km_continuation *continuation, km_arena *arena);

static inline const km_substructure *km_continuation_sub(const km_continuation *c) {
  return &c->mechanism->substructures[c->substructure];
}
/* (D a)·(D b) of scaled steps. */
double km_continuation_dot(const km_continuation *continuation, const double *a, const double *b);

/* Has the motion just one freedom, of so many that first order allows? */
static inline bool km_continuation_has_single_freedom(const km_continuation *c, int freedom) {
  return c->steady.is_active ? c->steady.count == 1 : freedom <= 1;
}

/* The tangent at the state's pose from its partition. A driver's: its rate is 1 and the others move least; false at its
 * toggle. By arc length: the part of `along` that the loops allow, at unit length |D t|; false if hardly anything is
 * left. */
bool km_continuation_tangent(km_continuation *continuation, const double *along, double *t);

/* Forgets the steps that led here. */
void km_step_history_begin(km_step_history *course, int columns);

/* Into `move`, from a regular pose. A motion of one freedom: the cubic through the last two poses and their tangents,
 * continued by h; after eight steps as long as h the polynomial of degree ten through nine poses, where the two agree: it
 * often needs no correction. With more freedoms the cubic would be unstable (its other root is -5), and Adams-Bashforth's
 * second serves. Without a last step, or far beyond it, the tangent. */
void km_continuation_predict(km_continuation *continuation, double h, bool alone);
/* Goes by `move`, closes the loops and finds next_t. Leaves the state where it ended. */
km_step_outcome km_continuation_correct(km_continuation *continuation, const km_step_terms *terms);
/* The coordinate whose limit the step just tried passes or touches on its way; -1: none. */
int km_continuation_limit(const km_continuation *continuation, double h);
/* The step just tried becomes the last one; next_t the present tangent. */
void km_continuation_accept(km_continuation *continuation, double h);
/* Back to where the step began. */
void km_continuation_reject(km_continuation *continuation);
/* Gives the driver a value, scaled. */
void km_continuation_place(km_continuation *continuation, double parameter);

/* Length of the cubic that `move` spans between two poses whose tangents t0, t1 have unit length: the length that
 * reproduces itself; negative where the move runs against the tangents. Five-point Gauss-Legendre. */
double km_continuation_arc(const km_continuation *continuation, const double *move, const double *t0, const double *t1);

/* Who is told of the steps that a motion makes on the way to where it is to go, except the one that arrives there: of the
 * driver or of the arc length, and of the rates of all coordinates there. */
typedef struct km_step_watch {
  void (*stepped)(void *self, double s, const double *rates); /* NULL: nobody */
  void *self;
  double *rates; /* [coordinate] workspace */
} km_step_watch;

#endif
