/* Remedies: joint types that remove a redundant constraint (theory 7.4).
 *
 *   new freedom h of a joint raises the rank  <=>  |Wᵀ h|² > 1e-10,  W all left null vectors
 *   two new freedoms                           <=>  their Gram matrix (Wᵀ h_i)·(Wᵀ h_j) is regular
 *   strength = |wᵀ h| / (|w| |h|) with the redundant wrench w */
#include "base/number/vectors.h"
#include "kinematics/body_poses.h"
#include "mobility/full_jacobian.h"
#include "mobility/left_null_space.h"

/* Gram matrix of Wᵀh for one or two new freedoms h of a joint, as columns in all loops that contain it: the part of h
 * outside the range of all other columns. */
typedef struct projection_gram {
  double xx, xy, yy;
} projection_gram;

static void add_to_gram(projection_gram *out, double x, double y) {
  out->xx += x * x;
  out->xy += x * y;
  out->yy += y * y;
}

/* Adds the products of one loop's parts with the new columns to the sums x, y per vector in `work`. */
static void add_part_products(const km_left_null *null, int loop, double column[2][6], double sense, double *work) {
  for (int n = null->block_start[loop]; n < null->block_start[loop + 1]; ++n) {
    const km_left_part *part = &null->part[null->block_part[n]];
    work[2 * part->vector] += sense * km_dot(column[0], part->w, 6);
    work[2 * part->vector + 1] += sense * km_dot(column[1], part->w, 6);
  }
}

/* Adds the sums of these vectors to the Gram matrix, each once; clears `work`. */
static void collect_sums(const km_left_null *null, int loop, double *work, projection_gram *out) {
  for (int n = null->block_start[loop]; n < null->block_start[loop + 1]; ++n) {
    double *sums = work + 2 * null->part[null->block_part[n]].vector;
    add_to_gram(out, sums[0], sums[1]);
    sums[0] = sums[1] = 0.0;
  }
}

static projection_gram compute_projection_gram(const km_left_space *a, const km_left_null *null, int joint,
                                               const km_twist *h, int count, double *work) {
  const km_topology *t = &a->m->topology;
  double column[2][6] = {{0}};
  projection_gram out = {0};
  for (int n = t->joint_loop_start[joint]; n < t->joint_loop_start[joint + 1]; ++n) {
    const int loop = t->joint_loop[n].loop;
    const double s = t->joint_loop[n].sign;
    for (int i = 0; i < count; ++i)
      km_twist_entries(a->sub, h[i], a->about[loop], 1.0, column[i]);
    for (int k = null->first[loop]; k < null->first[loop + 1]; ++k)
      add_to_gram(&out, s * km_dot(column[0], null->local + 6 * k, 6), s * km_dot(column[1], null->local + 6 * k, 6));
    if (null->spanning_count)
      add_part_products(null, loop, column, s, work);
  }
  for (int n = t->joint_loop_start[joint]; n < t->joint_loop_start[joint + 1] && null->spanning_count; ++n)
    collect_sums(null, t->joint_loop[n].loop, work, &out);
  return out;
}

/* True if one or two new freedoms of a joint each raise the rank. */
static bool raises_rank(const km_left_space *a, const km_left_null *null, int joint, double *work, const km_twist *h,
                        int count) {
  projection_gram r = compute_projection_gram(a, null, joint, h, count, work);
  const double smallest_square = 1e-10; /* squared, for columns of length about 1 */
  return r.xx > smallest_square && (count == 1 || r.xx * r.yy - r.xy * r.xy > smallest_square * fmax(r.xx, r.yy));
}

/* Replacements of a joint's type. */
typedef enum swap { TO_CYLINDRICAL, TO_UNIVERSAL, TO_OTHER_UNIVERSAL, TO_SPHERICAL } swap;
enum { SWAPS = 4 };

/* Cached raises_rank: it depends on the joint and the swap only, and every redundancy of the joint's loops requires
 * it. */
static bool raises_rank_cached(const km_left_space *a, const km_left_null *null, int joint, swap to, double *work,
                               const km_twist *h, int count) {
  signed char *cached = &a->swap_result[SWAPS * joint + (int)to];
  if (*cached == 0)
    *cached = raises_rank(a, null, joint, work, h, count) ? 1 : -1;
  return *cached > 0;
}

/* Returns the strength |wᵀh| / (|w| |h|) of a twist against the redundant wrench w (six entries about `about`). */
static double relative_power(const km_left_space *a, km_vec3 about, km_twist h, const double *w) {
  double column[6];
  km_twist_entries(a->sub, h, about, 1.0, column);
  double power = km_dot(w, column, 6), size = km_dot(column, column, 6), wrench = km_dot(w, w, 6);
  return size > 0.0 && wrench > 0.0 ? fabs(power) / sqrt(size * wrench) : 0.0;
}

/* Inserts a remedy in the order of freedoms, then strength; the list keeps the best KM_MAX_REMEDIES. */
static void add_remedy(km_redundancy *item, km_remedy remedy) {
  int at = item->remedy_count < KM_MAX_REMEDIES ? item->remedy_count++ : KM_MAX_REMEDIES;
  while (at > 0) {
    const km_remedy *before = &item->remedies[at - 1];
    bool comes_first = remedy.freedoms < before->freedoms ||
                       (remedy.freedoms == before->freedoms && remedy.strength > before->strength + 1e-9);
    if (!comes_first)
      break;
    if (at < KM_MAX_REMEDIES)
      item->remedies[at] = *before;
    --at;
  }
  if (at < KM_MAX_REMEDIES)
    item->remedies[at] = remedy;
}

/* Tests the swaps of one hinge or slide of the loop against the wrench. */
static void test_swaps(const km_left_space *a, const km_left_null *null, int joint, int block, const double *w,
                       double *work, km_redundancy *item) {
  km_vec3 point = a->about[block];
  const km_joint_kind *kind = km_joint_kind_of(a->m->model->joints[joint].type);
  if (kind->freedom != 1 || a->m->held[a->m->model->joints[joint].first_coordinate] ||
      kind->motions[0].primitive == KM_HELICAL)
    return;
  bool hinge = kind->motions[0].primitive == KM_REVOLUTE;
  int k = kind->motions[0].axis;
  km_pose X = km_joint_pose(a->m, a->s, joint);
  km_twist along = km_twist_prismatic(X.R.axis[k]), about = km_twist_revolute(X.R.axis[k], X.p);
  km_twist other = hinge ? along : about; /* the freedom that makes the joint cylindrical */
  double strength = relative_power(a, point, other, w);
  if (strength > 0.02 && raises_rank_cached(a, null, joint, TO_CYLINDRICAL, work, &other, 1))
    add_remedy(item, (km_remedy){joint, "cylindrical", 1, strength});
  km_twist rotations[2] = {km_twist_revolute(X.R.axis[(k + 1) % 3], X.p),
                           km_twist_revolute(X.R.axis[(k + 2) % 3], X.p)};
  double strengths[2] = {relative_power(a, point, rotations[0], w), relative_power(a, point, rotations[1], w)};
  int best = strengths[1] > strengths[0];
  if (hinge && strengths[best] > 0.02 &&
      raises_rank_cached(a, null, joint, best ? TO_OTHER_UNIVERSAL : TO_UNIVERSAL, work, &rotations[best], 1))
    add_remedy(item, (km_remedy){joint, "universal", 1, strengths[best]});
  if (hinge && strengths[best] > 0.02 && raises_rank_cached(a, null, joint, TO_SPHERICAL, work, rotations, 2))
    add_remedy(item, (km_remedy){joint, "spherical", 2, strengths[best]});
}

void km_remedies_find(const km_left_space *a, const km_left_null *null, int block, const double w[6], double *work,
                      km_redundancy *item) {
  const km_topology *t = &a->m->topology;
  for (int i = t->member_start[item->loop]; i < t->member_start[item->loop + 1]; ++i)
    test_swaps(a, null, t->member[i].joint, block, w, work, item);
}
