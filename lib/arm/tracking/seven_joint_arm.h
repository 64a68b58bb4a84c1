/* Arms with seven joints for a whole pose: one spare freedom. A kernel of fixed size, for one pose and for eight side by
 * side with the same bits. */
#ifndef KM_ARM_TRACKING_SEVEN_JOINT_ARM_H
#define KM_ARM_TRACKING_SEVEN_JOINT_ARM_H

#include "arm/arm.h"
#include "linalg/dense/simd_pair.h"
#include "spatial/sincos.h"

#include <stdint.h>
#include <string.h>

enum { SEVEN = 7, KM_NEWTON_MOST = 16 };
/* Newton's steps end with what is left below the first, and give up above the second. */
#define KM_NEWTON_DONE 1e-12
#define KM_NEWTON_FAR  10.0
/* Turns whose sin² is below this are small. */
#define KM_SMALL_TURN 1e-4

/* Are these the arms that the kernel is for? */
static inline bool km_seven_fits(const km_arm *arm) {
  return arm->n == SEVEN && arm->rows == KM_ARM_ROWS;
}
/* Below this ratio of R's diagonal the Jacobian is left to pivoting. */
#define KM_SEVEN_REGULAR 1e-6

/* Loops of the kernel are short and wait for their sums: unrolled, they keep them in registers. */
#define UNROLLED _Pragma("GCC unroll 8")

/* Seven numbers two by two, and 0. */
typedef struct km_one_row {
  km_pair pair[4];
} km_one_row;

static inline km_one_row km_one_row_of(const double *x, int step) {
  return (km_one_row){{{x[0], x[step]}, {x[2 * step], x[3 * step]}, {x[4 * step], x[5 * step]}, {x[6 * step], 0.0}}};
}
static inline double km_one_at(const km_one_row *row, int i) {
  return row->pair[i / 2][i % 2];
}
static inline void km_one_set(km_one_row *row, int i, double x) {
  km_pair old = row->pair[i / 2];
  row->pair[i / 2] = i % 2 ? (km_pair){old[0], x} : (km_pair){x, old[1]};
}
/* As copysign, of sizes without a sign: that one goes through memory with gcc 12, and waits for it. */
static inline double km_one_signed(double size, double x) {
  const km_bits sign = {INT64_MIN, 0};
  return km_pair_or((km_pair){size, 0.0}, km_pair_and((km_pair){x, 0.0}, (km_pair)sign))[0];
}
static inline km_one_row km_one_from(const km_one_row *row, int c) {
  const km_bits second = {0, -1};
  km_one_row out = *row;
  UNROLLED
  for (int i = 0; i < c / 2; ++i)
    out.pair[i] = (km_pair){0.0, 0.0};
  if (c % 2)
    out.pair[c / 2] = km_pair_and(out.pair[c / 2], (km_pair)second);
  return out;
}
static inline double km_one_product(const km_one_row *a, const km_one_row *b, int c) {
  km_pair sum = a->pair[3] * b->pair[3];
  if (c < 4)
    sum += a->pair[1] * b->pair[1];
  if (c < 6) {
    km_pair other = a->pair[2] * b->pair[2];
    if (c < 2)
      other += a->pair[0] * b->pair[0];
    sum += other;
  }
  return sum[0] + sum[1];
}
static inline void km_one_subtract(km_one_row *x, double s, const km_one_row *v, int c) {
  UNROLLED
  for (int i = c / 2; i < 4; ++i)
    x->pair[i] -= (km_pair){s, s} * v->pair[i];
}

/* Two by two. */
typedef struct km_one_turns {
  km_two_numbers sine[4], cosine[4];
} km_one_turns;

static inline km_one_turns km_one_turns_of(const double *x) {
  const km_one_row row = km_one_row_of(x, 1);
  km_one_turns turns;
  UNROLLED
  for (int i = 0; i < 4; ++i)
    km_two_sincos(row.pair[i], &turns.sine[i], &turns.cosine[i]);
  return turns;
}
static inline void km_one_turn_of(const km_one_turns *turns, int j, double *sine, double *cosine) {
  *sine = turns->sine[j / 2][j % 2];
  *cosine = turns->cosine[j / 2][j % 2];
}

#define T                double
#define BITS             uint64_t
#define FN(name)         km_one_##name
#define ZERO             0.0
#define NONE             ((uint64_t)0)
#define ROOT(x)          sqrt(x)
#define SIZE(x)          fabs(x)
#define SIGNED(size, x)  km_one_signed((size), (x))
#define MASK             bool
#define BELOW(a, b)      ((a) < (b))
#define ANY(mask)        (mask)
#define PICK(mask, a, b) ((mask) ? (a) : (b))
#define SMALLER(a, b)    ((a) < (b) ? (a) : (b))
#define LARGER(a, b)     ((a) > (b) ? (a) : (b))
#define km_bits_of       km_double_bits
#define km_number_of     km_bits_double
#include "arm/tracking/seven_joint_arm_body.h"
#undef T
#undef BITS
#undef FN
#undef ZERO
#undef NONE
#undef ROOT
#undef SIZE
#undef SIGNED
#undef MASK
#undef BELOW
#undef ANY
#undef PICK
#undef SMALLER
#undef LARGER
#undef km_bits_of
#undef km_number_of

/* Eight steps side by side, lane by lane. */
enum { KM_LANES = 8 };
typedef double km_batch_number[KM_LANES];

/* Where each begins, and what km_node_predict reads of that node and of the way from it. */
typedef struct km_batch_start {
  km_batch_number q[SEVEN], path[SEVEN], z, null[SEVEN];
  km_batch_number last[SEVEN], before[SEVEN]; /* the expected corrector is 2 last − before */
  km_batch_number tilt, ds;
  km_batch_number per_second, speed; /* 1 over the time that the step has, and dσ/dt where it ends */
} km_batch_start;

typedef struct km_lanes {
  km_batch_start start;
  /* What each is to reach: a pose, by its place and its axes' components, and the unit twist there. */
  km_batch_number place[3], axes[3][3], xi[6];
  unsigned used; /* lanes (bits) that count; the others have numbers too */
  bool want_sigma;
  /* Out: the poses, how far they are from the predictor, and their columns. */
  km_batch_number q[SEVEN], moved[SEVEN], path[SEVEN + 1], null[SEVEN];
  km_batch_number sigma[6]; /* singular values in no order, if they are wanted */
  km_batch_number tries;    /* Jacobians that each took */
  unsigned keeps;           /* lanes that keep limits and rates, at the step's end and in its mean */
} km_lanes;

/* What lanes from `first` on are to reach: a pose, and a unit twist xi[6] there. */
void km_lanes_aim(km_lanes *lanes, int first, const km_pose *target, const double *xi);
/* The predictor, Newton's steps to the pose, then the columns for the unit twist, of every lane. Returns the lanes (bits)
 * that arrive at regular poses; the others are undefined. The same bits as one by one. */
unsigned km_lanes_reach(const km_arm *arm, km_lanes *lanes);

#endif
