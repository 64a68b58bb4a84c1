/* Arms with seven joints for a whole pose: one spare freedom. A kernel of fixed size, for one pose and for eight side by
 * side with the same bits. */
#ifndef KM_ARM_SEVEN_H
#define KM_ARM_SEVEN_H

#include "arm/arm.h"
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
  return arm->n == SEVEN && arm->task == KM_TASK_POSE;
}
/* Below this ratio of R's diagonal the Jacobian is left to pivoting. */
#define KM_SEVEN_REGULAR 1e-6

#define T                double
#define BITS             uint64_t
#define FN(name)         km_one_##name
#define ZERO             0.0
#define NONE             ((uint64_t)0)
#define ROOT(x)          sqrt(x)
#define SIZE(x)          fabs(x)
#define SIGNED(size, x)  copysign((size), (x))
#define MASK             bool
#define BELOW(a, b)      ((a) < (b))
#define ANY(mask)        (mask)
#define PICK(mask, a, b) ((mask) ? (a) : (b))
#define SMALLER(a, b)    ((a) < (b) ? (a) : (b))
#define LARGER(a, b)     ((a) > (b) ? (a) : (b))
#define km_bits_of       km_double_bits
#define km_number_of     km_bits_double
#include "arm/seven_body.h"
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

/* Eight poses side by side, lane by lane in the last index. */
enum { KM_LANES = 8 };
typedef struct km_lanes {
  double q[SEVEN][KM_LANES];     /* in: where Newton begins; out: the poses */
  double moved[SEVEN][KM_LANES]; /* how far this is from the predictor, in and out */
  double most[KM_LANES];         /* how far it may be */
  double path[SEVEN + 1][KM_LANES], null[SEVEN][KM_LANES];
  bool want_sigma;
  double sigma[6][KM_LANES];  /* singular values in no order, if they are wanted */
  unsigned used, evaluations; /* lanes (bits) that count; Jacobians that these took */
} km_lanes;

/* Newton's steps to a pose, then the columns for a unit twist xi[6], of every lane. Returns the lanes (bits) that
 * arrive at regular poses; the others are undefined. The same bits as one by one. */
unsigned km_lanes_reach(const km_arm *arm, const km_pose *target, const double *xi, km_lanes *lanes);

#endif
