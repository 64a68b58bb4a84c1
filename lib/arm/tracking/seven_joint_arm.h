/* Kernel of fixed size for arms with seven joints and a pose task (one spare freedom): types and entry points. It
 * exists for one configuration (km_one_*) and for batches of eight (km_lanes_*), which give the same bits
 * (docs/theory.md 12.1). */
#ifndef KM_ARM_TRACKING_SEVEN_JOINT_ARM_H
#define KM_ARM_TRACKING_SEVEN_JOINT_ARM_H

#include "arm/arm.h"
#include "linalg/dense/simd_pair.h"
#include "spatial/sincos.h"

#include <stdint.h>
#include <string.h>

enum { SEVEN = 7, KM_NEWTON_MAX_STEPS = 16 };
/* Newton's method: the iteration converged if the pose error is below the first value (rounding of unit lengths),
 * and diverged if it is above the second. */
#define KM_NEWTON_CONVERGED 1e-12
#define KM_NEWTON_DIVERGED  10.0
/* Rotations with sin²θ below this use the series of θ/sin θ, whose next term is then below 1e-15. */
#define KM_SMALL_ROTATION 1e-4

/* True if the kernel applies: seven joints, six rows. */
static inline bool km_seven_fits(const km_arm *arm) {
  return arm->n == SEVEN && arm->rows == KM_ARM_ROWS;
}
/* Below this ratio of smallest to largest diagonal entry of R, complete pivoting is used instead. */
#define KM_SEVEN_MIN_PIVOT_RATIO 1e-6

/* Short loops are unrolled, so that their sums stay in registers. */
#define UNROLLED _Pragma("GCC unroll 8")

/* Seven numbers in pairs; the eighth is 0. */
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
/* copysign for non-negative sizes; gcc 12 compiles copysign with a store and a dependent load. */
static inline double km_one_signed(double size, double x) {
  const km_bits sign = {INT64_MIN, 0};
  return km_pair_or((km_pair){size, 0.0}, km_pair_and((km_pair){x, 0.0}, (km_pair)sign))[0];
}
/* The row with zeros before index c. */
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
/* Dot product of rows with zeros before index c. */
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

/* Sines and cosines of seven angles, in pairs. */
typedef struct km_one_angles {
  km_two_numbers sine[4], cosine[4];
} km_one_angles;

static inline km_one_angles km_one_angles_of(const double *x) {
  const km_one_row row = km_one_row_of(x, 1);
  km_one_angles angles;
  UNROLLED
  for (int i = 0; i < 4; ++i)
    km_two_sincos(row.pair[i], &angles.sine[i], &angles.cosine[i]);
  return angles;
}
static inline void km_one_sincos_of(const km_one_angles *angles, int j, double *sine, double *cosine) {
  *sine = angles->sine[j / 2][j % 2];
  *cosine = angles->cosine[j / 2][j % 2];
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

/* Batches of eight steps. */
enum { KM_LANES = 8 };
typedef double km_batch_number[KM_LANES];

/* Start of each lane's step: the data that km_path_node_predict reads. */
typedef struct km_batch_start {
  km_batch_number q[SEVEN], path[SEVEN], z, null[SEVEN];
  km_batch_number last[SEVEN], before[SEVEN]; /* corrections of the last two steps; the extrapolated one is 2 last −
                                               * before */
  km_batch_number tan_phi, ds;
  km_batch_number per_second, speed; /* 1/(time of the step), and dσ/dt at its end */
} km_batch_start;

typedef struct km_lanes {
  km_batch_start start;
  /* Targets: position and axes of the pose, and the unit twist of the path there. */
  km_batch_number place[3], axes[3][3], xi[6];
  unsigned used; /* bits of the lanes in use; the other lanes hold copies */
  bool want_sigma;
  /* Results: configurations, their distances from the predictor, and their columns. */
  km_batch_number q[SEVEN], moved[SEVEN], path[SEVEN + 1], null[SEVEN];
  km_batch_number sigma[6];  /* singular values, unordered, if want_sigma */
  km_batch_number jacobians; /* Jacobians computed by each lane */
  unsigned within;           /* bits of the lanes that satisfy limits and rates, at the end of the step and in its
                             * mean */
} km_lanes;

/* Sets the target pose and its unit twist xi[6] for the lanes from `first` on. */
void km_lanes_set_target(km_lanes *lanes, int first, const km_pose *target, const double *xi);
/* Computes predictor, Newton's corrector and columns of every lane in use. Returns the bits of the lanes that
 * converged at regular configurations; results of other lanes are undefined. Each lane has the bits of a single
 * step. */
unsigned km_lanes_step(const km_arm *arm, km_lanes *lanes);

#endif
