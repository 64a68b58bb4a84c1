/* One step along the path for several seven-joint arms at once: predictor, Newton's corrector, path-control column,
 * checks of limits and rates (docs/theory.md 12.4). A vector register holds WIDTH lanes; each lane is one step.
 *
 *   predictor : q = q_0 + (c1 + tan_phi c2)/z ds
 *   corrector : J x = e, moved + x orthogonal to the null vector; converged if |e| <= KM_NEWTON_CONVERGED
 *   rates     : q_dot = c1/z speed + (c2 . mean) c2,  mean = (q - q_0)/dt
 *
 * The file is included once for each instruction set; NAME is the function that it defines. */
#include "arm/tracking/seven_joint_arm.h"

#include "spatial/simd_body.h"

#define T               vector
#define BITS            word
#define FN(name)        lanes_##name
#define ZERO            ((vector){0.0})
#define NONE            ((word){0})
#define ROOT(x)         root(x)
#define SIZE(x)         ((vector)((word)(x) & ~(NONE + SIGN_BIT)))
#define SIGNED(size, x) ((vector)((word)(size) | ((word)(x) & (NONE + SIGN_BIT))))
#define MASK            mask
#define BELOW(a, b)     below((a), (b))
#define ANY(m)          (bits_of(m) != 0)
#define PICK(m, a, b)   pick((m), (a), (b))
#define SMALLER(a, b)   pick(below((a), (b)), (a), (b))
#define LARGER(a, b)    pick(below((b), (a)), (a), (b))
#define km_bits_of(x)   ((word)(x))
#define km_number_of(x) ((vector)(x))

/* Seven numbers of each lane. */
typedef struct lanes_row {
  T at[SEVEN];
} lanes_row;

static inline lanes_row lanes_row_of(const T *x, int step) {
  lanes_row row;
  UNROLLED
  for (int i = 0; i < SEVEN; ++i)
    row.at[i] = x[i * step];
  return row;
}
static inline T lanes_at(const lanes_row *row, int i) {
  return row->at[i];
}
static inline void lanes_set(lanes_row *row, int i, T x) {
  row->at[i] = x;
}
static inline lanes_row lanes_from(const lanes_row *row, int c) {
  lanes_row out = *row;
  UNROLLED
  for (int i = 0; i < c; ++i)
    out.at[i] = ZERO;
  return out;
}
/* Dot product of rows with zeros before index c, in the order of summation of km_one_product. */
static inline T lanes_product(const lanes_row *a, const lanes_row *b, int c) {
  T sum[2] = {a->at[6] * b->at[6], ZERO};
  UNROLLED
  for (int i = 0; i < 2; ++i) {
    if (2 + i >= c)
      sum[i] += a->at[2 + i] * b->at[2 + i];
    if (4 + i < c)
      continue;
    T other = a->at[4 + i] * b->at[4 + i];
    if (i >= c)
      other += a->at[i] * b->at[i];
    sum[i] += other;
  }
  return sum[0] + sum[1];
}
static inline void lanes_subtract(lanes_row *x, T s, const lanes_row *v, int c) {
  UNROLLED
  for (int i = c; i < SEVEN; ++i)
    x->at[i] -= s * v->at[i];
}

#include "spatial/sincos_body.h"

/* Sines and cosines are computed on demand: seven pairs exceed the registers. */
typedef struct lanes_angles {
  const T *x;
} lanes_angles;

static inline lanes_angles lanes_angles_of(const T *x) {
  return (lanes_angles){x};
}
static inline void lanes_sincos_of(const lanes_angles *angles, int j, T *sine, T *cosine) {
  lanes_sincos(angles->x[j], sine, cosine);
}
#include "arm/tracking/seven_joint_arm_body.h"

/* Target poses of the lanes. */
typedef struct lanes_target {
  lanes_vec3 p, axes[3];
} lanes_target;

static inline lanes_vec3 read_vec(km_batch_number *components, int first) {
  return (lanes_vec3){get(components[0] + first), get(components[1] + first), get(components[2] + first)};
}

/* Pose error e[6] = (position, rotation vector) from the current to the target pose. Clears the lanes of *valid
 * whose rotation isn't small. Returns the norm of e, positions scaled by arm->position_weight. */
static inline vector pose_error(const km_arm *a, const lanes_seven *k, const lanes_target *target, vector *e,
                                mask *valid) {
  vector sine2, write_track;
  lanes_vec3 v = {target->p.x - k->p.x, target->p.y - k->p.y, target->p.z - k->p.z};
  lanes_vec3 w = lanes_rotation_error(k->R, target->axes, &sine2, &write_track);
  *valid &= below(sine2, all(KM_SMALL_ROTATION)) & below(all(1.0), write_track);
  e[0] = v.x;
  e[1] = v.y;
  e[2] = v.z;
  e[3] = w.x;
  e[4] = w.y;
  e[5] = w.z;
  return root(a->position_weight * lanes_vec3_dot(v, v) + lanes_vec3_dot(w, w));
}

static inline mask is_regular(const lanes_seven *k) {
  return below(k->max_pivot * KM_SEVEN_MIN_PIVOT_RATIO, k->min_pivot);
}

/* Predictor (km_path_node_predict) of the lanes from `first` on: q = q_0 + step + moved, where moved is the
 * extrapolated correction. Returns the largest correction allowed: half the step. */
static inline vector predict(const km_batch_start *from, int first, vector *q, vector *moved) {
  vector inverse = 1.0 / get(from->z + first), tan_phi = get(from->tan_phi + first), ds = get(from->ds + first);
  vector square = ZERO, far = ZERO;
  for (int i = 0; i < SEVEN; ++i) {
    vector step = (get(from->path[i] + first) + tan_phi * get(from->null[i] + first)) * inverse * ds;
    square += step * step;
    moved[i] = 2.0 * get(from->last[i] + first) - get(from->before[i] + first);
    far += moved[i] * moved[i];
    q[i] = get(from->q[i] + first) + step;
  }
  vector most = 0.5 * root(square) + 1e-12;
  mask is_near = at_most(root(far), most);
  for (int i = 0; i < SEVEN; ++i) {
    moved[i] = pick(is_near, moved[i], ZERO);
    q[i] += moved[i];
  }
  return most;
}

/* Predictor and Newton's corrector of the lanes first … first + WIDTH - 1, which end at q[7]. Returns the lanes that
 * converged at regular configurations. The Jacobian there is factored, with the minimum-norm rates for the unit
 * twists xi. */
static inline mask newton_steps(const km_arm *a, km_lanes *io, int first, vector *q, lanes_seven *k) {
  const lanes_target target = {
      read_vec(io->place, first),
      {read_vec(io->axes[0], first), read_vec(io->axes[1], first), read_vec(io->axes[2], first)}};
  vector e[6], moved[SEVEN], most = predict(&io->start, first, q, moved), far = ZERO, jacobians = ZERO;
  mask valid = mask_of(io->used >> first & ((1u << WIDTH) - 1)), active = valid;
  for (int i = 0; i < SEVEN; ++i) {
    far += moved[i] * moved[i];
    valid &= at_most(size_of(q[i]), all(0.5 * KM_SINCOS_MAX_ANGLE));
  }
  mask extrapolated = below(ZERO, far);
  for (int step = 0;; ++step) {
    lanes_forward(a, q, k);
    jacobians += pick(active, all(1.0), ZERO);
    vector rest = pose_error(a, k, &target, e, &valid);
    valid &= below(rest, all(KM_NEWTON_DIVERGED));
    active = valid & (below(all(KM_NEWTON_CONVERGED), rest) | extrapolated);
    extrapolated = mask_of(0); /* an extrapolated correction needs one step at least, which removes its component along
                           * the null vector */
    if (!ANY(active) || step == KM_NEWTON_MAX_STEPS)
      break;
    lanes_factor_qr(k);
    lanes_find_null(k);
    valid &= is_regular(k);
    lanes_row x = lanes_solve(k, e, -lanes_along_null(k, moved));
    vector sum = ZERO;
    for (int i = 0; i < SEVEN; ++i) {
      moved[i] = pick(active, moved[i] + x.at[i], moved[i]);
      q[i] = pick(active, q[i] + x.at[i], q[i]);
      sum += moved[i] * moved[i];
    }
    valid &= at_most(root(sum), most) | ~active;
  }
  for (int i = 0; i < SEVEN; ++i)
    put(io->moved[i] + first, moved[i]);
  put(io->jacobians + first, jacobians);
  for (int r = 0; r < 6; ++r)
    e[r] = get(io->xi[r] + first);
  lanes_factor(k, e);
  return valid & ~active & is_regular(k);
}

/* Writes configurations, null vectors, path-control columns and, if requested, singular values. */
static inline void write_columns(km_lanes *io, int first, const vector *q, const lanes_seven *k) {
  vector path[SEVEN + 1], sigma[6];
  lanes_path_column(k, path);
  for (int i = 0; i < SEVEN; ++i) {
    put(io->q[i] + first, q[i]);
    put(io->null[i] + first, k->null.at[i]);
    put(io->path[i] + first, path[i]);
  }
  put(io->path[SEVEN] + first, path[SEVEN]);
  if (!io->want_sigma)
    return;
  lanes_singular_values(k, sigma);
  for (int r = 0; r < 6; ++r)
    put(io->sigma[r] + first, sigma[r]);
}

/* Lanes in which no joint exceeds its rate; as joint_over_rate of tracker.c. */
static inline mask within_rates(const km_arm *a, const vector *rates) {
  mask kept = mask_of((1u << WIDTH) - 1);
  for (int i = 0; i < SEVEN; ++i)
    kept &= at_most(size_of(rates[i]), all(a->rate[i] * (1.0 + 1e-9)));
  return kept;
}

/* Lanes that satisfy limits and rates; as check_limits_and_rates of tracker.c, for steps that don't begin at the
 * path's start. */
static inline mask within_limits_and_rates(const km_arm *a, const km_lanes *io, int first, const vector *q,
                                           const lanes_seven *k) {
  mask kept = mask_of((1u << WIDTH) - 1);
  vector mean[SEVEN], rates[SEVEN], along = ZERO, entry = get(io->path[SEVEN] + first);
  for (int i = 0; i < SEVEN; ++i) {
    vector slack = 1e-12 * (1.0 + size_of(q[i]));
    kept &= at_most(q[i], a->high[i] + slack) & at_most(a->low[i] - slack, q[i]);
    mean[i] = (q[i] - get(io->start.q[i] + first)) * get(io->start.per_second + first);
    along += k->null.at[i] * mean[i];
  }
  vector scale = pick(below(ZERO, entry), get(io->start.speed + first) / entry, ZERO);
  for (int i = 0; i < SEVEN; ++i)
    rates[i] = get(io->path[i] + first) * scale + along * k->null.at[i];
  return kept & within_rates(a, mean) & within_rates(a, rates);
}

unsigned NAME(const km_arm *a, km_lanes *io);
unsigned NAME(const km_arm *a, km_lanes *io) {
  unsigned arrived = 0;
  io->within = 0;
  for (int first = 0; first < KM_LANES; first += WIDTH) {
    lanes_seven k;
    vector q[SEVEN];
    if (!(io->used >> first & ((1u << WIDTH) - 1)))
      continue;
    mask valid = newton_steps(a, io, first, q, &k);
    write_columns(io, first, q, &k);
    arrived |= bits_of(valid) << first;
    io->within |= bits_of(within_limits_and_rates(a, io, first, q, &k)) << first;
  }
  return arrived;
}
