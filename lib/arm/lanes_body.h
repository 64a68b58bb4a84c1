/* Newton's steps in vectors of four, included once for each instruction set: NAME is the function. */
#include "arm/seven.h"

typedef double lane4 __attribute__((vector_size(32)));
typedef int64_t bits4 __attribute__((vector_size(32)));
typedef uint64_t word4 __attribute__((vector_size(32)));

static inline lane4 root4(lane4 x) {
  return (lane4){sqrt(x[0]), sqrt(x[1]), sqrt(x[2]), sqrt(x[3])};
}
static inline lane4 pick4(bits4 mask, lane4 a, lane4 b) { /* a where the mask is set */
  return (lane4)(((bits4)a & mask) | ((bits4)b & ~mask));
}

static inline bool any4(bits4 mask) {
  return (mask[0] | mask[1] | mask[2] | mask[3]) != 0;
}

#define T                lane4
#define BITS             word4
#define FN(name)         four_##name
#define ZERO             ((lane4){0.0, 0.0, 0.0, 0.0})
#define SIGN             (NONE + ((uint64_t)1 << 63))
#define NONE             ((word4){0, 0, 0, 0})
#define ROOT(x)          root4(x)
#define MASK             bits4
#define ANY(mask)        any4(mask)
#define PICK(mask, a, b) pick4((mask), (a), (b))
#define SMALLER(a, b)    pick4((bits4)((a) < (b)), (a), (b))
#define LARGER(a, b)     pick4((bits4)((a) > (b)), (a), (b))
#define km_bits_of(x)    ((word4)(x))
#define km_number_of(x)  ((lane4)(x))
#include "arm/seven_body.h"

static inline unsigned set4(bits4 mask) { /* lane by lane a bit */
  return (mask[0] ? 1u : 0u) | (mask[1] ? 2u : 0u) | (mask[2] ? 4u : 0u) | (mask[3] ? 8u : 0u);
}

/* What is left to the target: e[6]; lanes whose turn isn't small are taken out. Returns its length. */
static inline lane4 left4(const km_arm *a, const four_seven *k, const km_pose *target, lane4 *e, bits4 *fit) {
  lane4 sine2, trace;
  four_vec v = {target->p.x - k->p.x, target->p.y - k->p.y, target->p.z - k->p.z};
  four_vec w = four_turn_left(k->R, &target->R, &sine2, &trace);
  *fit &= (bits4)(sine2 < ZERO + KM_SMALL_TURN) & (bits4)(trace > ZERO + 1.0);
  e[0] = v.x;
  e[1] = v.y;
  e[2] = v.z;
  e[3] = w.x;
  e[4] = w.y;
  e[5] = w.z;
  return root4(a->shrink * four_dot(v, v) + four_dot(w, w));
}

static inline bits4 regular4(const four_seven *k) {
  return (bits4)(k->least > k->largest * KM_SEVEN_REGULAR);
}

unsigned NAME(const km_arm *a, const km_pose *target, const double *xi, km_lanes *io);
unsigned NAME(const km_arm *a, const km_pose *target, const double *xi, km_lanes *io) {
  four_seven k;
  lane4 q[SEVEN], x[SEVEN], e[6], path[SEVEN + 1], moved[SEVEN], most;
  bits4 fit = ~(bits4){0, 0, 0, 0}, active = fit;
  for (int i = 0; i < SEVEN; ++i) {
    memcpy(&q[i], io->q[i], sizeof q[i]);
    moved[i] = ZERO;
  }
  memcpy(&most, io->most, sizeof most);
  for (int step = 0;; ++step) {
    four_forward(a, q, &k);
    io->evaluations += (unsigned)__builtin_popcount(set4(active) & io->used);
    lane4 left = left4(a, &k, target, e, &fit);
    fit &= (bits4)(left < ZERO + KM_NEWTON_FAR);
    active = fit & (bits4)(left > ZERO + KM_NEWTON_DONE);
    if (!any4(active))
      break;
    if (step == KM_NEWTON_MOST) {
      fit &= ~active;
      break;
    }
    four_factor(&k);
    fit &= regular4(&k);
    four_solve(&k, e, x);
    lane4 sum = ZERO;
    for (int i = 0; i < SEVEN; ++i) {
      moved[i] = pick4(active, moved[i] + x[i], moved[i]);
      q[i] = pick4(active, q[i] + x[i], q[i]);
      sum += moved[i] * moved[i];
    }
    fit &= (bits4)(root4(sum) <= most) | ~active;
  }
  four_factor(&k);
  fit &= regular4(&k);
  for (int r = 0; r < 6; ++r)
    e[r] = ZERO + xi[r];
  four_solve(&k, e, x);
  four_path_column(x, path);
  for (int i = 0; i < SEVEN; ++i) {
    memcpy(io->q[i], &q[i], sizeof q[i]);
    memcpy(io->null[i], &k.null[i], sizeof q[i]);
    memcpy(io->jacobian[i], k.jacobian[i], sizeof io->jacobian[i]);
  }
  memcpy(io->path, path, sizeof io->path);
  if (io->want_sigma) {
    lane4 sigma[6];
    four_singular_values(&k, sigma);
    memcpy(io->sigma, sigma, sizeof io->sigma);
  }
  return set4(fit);
}
