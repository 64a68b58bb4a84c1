/* Which other type of a joint would end a redundancy. */
#include "kinematics/body_poses.h"
#include "mobility/full_jacobian.h"
#include "mobility/left_null_space.h"

/* Wᵀh for one or two new freedoms h of a joint, as columns in the loops that it lies in: what they do along the left
 * null vectors W, and so beyond the reach of all other columns. Kept as the squares and the product of the two. */
typedef struct reach {
  double xx, xy, yy;
} reach;

static void add_reach(reach *out, double x, double y) {
  out->xx += x * x;
  out->xy += x * y;
  out->yy += y * y;
}

static double dot6(const double *a, const double *b) {
  double sum = 0.0;
  for (int r = 0; r < 6; ++r)
    sum += a[r] * b[r];
  return sum;
}

/* What the parts of one loop make of the new columns, added to those vectors' x and y in `work`. */
static void add_parts(const km_left_null *null, int loop, double column[2][6], double sense, double *work) {
  for (int n = null->at_start[loop]; n < null->at_start[loop + 1]; ++n) {
    const km_left_part *part = &null->part[null->at[n]];
    work[2 * part->vector] += sense * dot6(column[0], part->w);
    work[2 * part->vector + 1] += sense * dot6(column[1], part->w);
  }
}

/* The sums of those vectors, each once; `work` is 0 again. */
static void take_sums(const km_left_null *null, int loop, double *work, reach *out) {
  for (int n = null->at_start[loop]; n < null->at_start[loop + 1]; ++n) {
    double *sums = work + 2 * null->part[null->at[n]].vector;
    add_reach(out, sums[0], sums[1]);
    sums[0] = sums[1] = 0.0;
  }
}

static reach beyond_reach(const km_left_space *a, const km_left_null *null, int joint, const km_twist *h, int count,
                          double *work) {
  const km_topology *t = &a->m->topology;
  double column[2][6] = {{0}};
  reach out = {0};
  for (int n = a->first_place[joint]; n < a->first_place[joint + 1]; ++n) {
    const km_loop_place *place = &a->place[n];
    double s = km_member_sign(&t->member[place->member]);
    for (int i = 0; i < count; ++i)
      km_twist_entries(a->sub, h[i], a->about[place->loop], 1.0, column[i]);
    for (int k = null->first[place->loop]; k < null->first[place->loop + 1]; ++k)
      add_reach(&out, s * dot6(column[0], null->local + 6 * k), s * dot6(column[1], null->local + 6 * k));
    if (null->whole_count)
      add_parts(null, place->loop, column, s, work);
  }
  for (int n = a->first_place[joint]; n < a->first_place[joint + 1] && null->whole_count; ++n)
    take_sums(null, a->place[n].loop, work, &out);
  return out;
}

/* Would one or two new freedoms of a joint each raise the rank? */
static bool raises_rank(const km_left_space *a, const km_left_null *null, int joint, double *work, const km_twist *h,
                        int count) {
  reach r = beyond_reach(a, null, joint, h, count, work);
  const double least = 1e-10; /* squared: of columns of size about 1 */
  return r.xx > least && (count == 1 || r.xx * r.yy - r.xy * r.xy > least * fmax(r.xx, r.yy));
}

/* The swaps that a joint can be given. */
typedef enum swap { TO_CYLINDRICAL, TO_UNIVERSAL, TO_OTHER_UNIVERSAL, TO_SPHERICAL } swap;
enum { SWAPS = 4 };

/* The same, remembered: it depends on the joint and the swap alone, and a joint is asked for by every redundancy of its
 * loops. */
static bool helps(const km_left_space *a, const km_left_null *null, int joint, swap to, double *work, const km_twist *h,
                  int count) {
  signed char *known = &a->helps[SWAPS * joint + (int)to];
  if (*known == 0)
    *known = raises_rank(a, null, joint, work, h, count) ? 1 : -1;
  return *known > 0;
}

/* How squarely a twist meets the redundant wrench w (six entries, about `about`): power over both sizes. */
static double meets(const km_left_space *a, km_vec3 about, km_twist h, const double *w) {
  double column[6], power = 0.0, size = 0.0, wrench = 0.0;
  km_twist_entries(a->sub, h, about, 1.0, column);
  for (int r = 0; r < 6; ++r) {
    power += w[r] * column[r];
    size += column[r] * column[r];
    wrench += w[r] * w[r];
  }
  return size > 0.0 && wrench > 0.0 ? fabs(power) / sqrt(size * wrench) : 0.0;
}

static void add_remedy(km_redundancy *item, km_remedy remedy) {
  int at = item->remedy_count < KM_MAX_REMEDIES ? item->remedy_count++ : KM_MAX_REMEDIES;
  while (at > 0) {
    const km_remedy *before = &item->remedies[at - 1];
    bool better = remedy.freedoms < before->freedoms ||
                  (remedy.freedoms == before->freedoms && remedy.strength > before->strength + 1e-9);
    if (!better)
      break;
    if (at < KM_MAX_REMEDIES)
      item->remedies[at] = *before;
    --at;
  }
  if (at < KM_MAX_REMEDIES)
    item->remedies[at] = remedy;
}

/* Tries the swaps of one hinge or slide of the loop against the wrench. */
static void try_joint(const km_left_space *a, const km_left_null *null, int joint, int place, const double *w,
                      double *work, km_redundancy *item) {
  km_vec3 point = a->about[place];
  const km_joint_kind *kind = km_joint_kind_of(a->m->model->joints[joint].type);
  if (kind->freedom != 1 || a->m->held[a->m->model->joints[joint].first_coordinate] ||
      kind->motions[0].primitive == KM_HELICAL)
    return;
  bool hinge = kind->motions[0].primitive == KM_REVOLUTE;
  int k = kind->motions[0].axis;
  km_pose X = km_joint_pose(a->m, a->s, joint);
  km_twist along = km_twist_prismatic(X.R.axis[k]), about = km_twist_revolute(X.R.axis[k], X.p);
  km_twist other = hinge ? along : about; /* what makes the joint cylindrical */
  double strength = meets(a, point, other, w);
  if (strength > 0.02 && helps(a, null, joint, TO_CYLINDRICAL, work, &other, 1))
    add_remedy(item, (km_remedy){joint, "cylindrical", 1, strength});
  km_twist turns[2] = {km_twist_revolute(X.R.axis[(k + 1) % 3], X.p), km_twist_revolute(X.R.axis[(k + 2) % 3], X.p)};
  double each[2] = {meets(a, point, turns[0], w), meets(a, point, turns[1], w)};
  int best = each[1] > each[0];
  if (hinge && each[best] > 0.02 &&
      helps(a, null, joint, best ? TO_OTHER_UNIVERSAL : TO_UNIVERSAL, work, &turns[best], 1))
    add_remedy(item, (km_remedy){joint, "universal", 1, each[best]});
  if (hinge && each[best] > 0.02 && helps(a, null, joint, TO_SPHERICAL, work, turns, 2))
    add_remedy(item, (km_remedy){joint, "spherical", 2, each[best]});
}

void km_remedies_find(const km_left_space *a, const km_left_null *null, int place, const double w[6], double *work,
                      km_redundancy *item) {
  const km_topology *t = &a->m->topology;
  for (int i = t->member_start[item->loop]; i < t->member_start[item->loop + 1]; ++i)
    try_joint(a, null, t->member[i].joint, place, w, work, item);
}
