/* Which other type of a joint would end a redundancy. */
#include "analysis/left_null.h"
#include "analysis/whole_jacobian.h"
#include "kinematics/poses.h"

/* Wᵀh: what a new freedom h of a joint, as a column in the loops that it lies in, does along each left null vector, and
 * so beyond the reach of all other columns. */
static void beyond_reach(const km_left_space *a, const km_left_null *null, int joint, km_twist h, double *out) {
  const km_topology *t = &a->m->topology;
  int first = t->loop_start[a->index];
  double column[6];
  km_twist_entries(a->sub, h, a->about, 1.0, column);
  for (int k = 0; k < km_left_null_count(null); ++k)
    out[k] = 0.0;
  for (int i = 0; i < a->sub->loop_count; ++i) {
    int loop = t->loop[first + i];
    for (int n = t->member_start[loop]; n < t->member_start[loop + 1]; ++n) {
      if (t->member[n].joint != joint)
        continue;
      double s = km_member_sense(t, loop, &t->member[n]);
      for (int r = 0; r < 6; ++r) {
        for (int k = null->first[i]; k < null->first[i + 1]; ++k)
          out[k] += s * column[r] * null->local[6 * k + r];
        for (int k = 0; k < null->whole_count; ++k)
          out[null->local_count + k] += s * column[r] * null->whole[(size_t)k * (size_t)a->rows + (size_t)(6 * i + r)];
      }
    }
  }
}

/* Would one or two new freedoms of a joint each raise the rank? */
static bool raises_rank(const km_left_space *a, const km_left_null *null, int joint, double *work, const km_twist *h,
                        int count) {
  int vectors = km_left_null_count(null);
  double *x = work, *y = work + vectors, xx = 0.0, xy = 0.0, yy = 0.0;
  beyond_reach(a, null, joint, h[0], x);
  if (count > 1)
    beyond_reach(a, null, joint, h[1], y);
  for (int k = 0; k < vectors; ++k) {
    xx += x[k] * x[k];
    xy += count > 1 ? x[k] * y[k] : 0.0;
    yy += count > 1 ? y[k] * y[k] : 0.0;
  }
  const double least = 1e-10; /* squared: of columns of size about 1 */
  return xx > least && (count == 1 || xx * yy - xy * xy > least * fmax(xx, yy));
}

/* How squarely a twist meets the redundant wrench w (six entries): power over both sizes. */
static double meets(const km_left_space *a, km_twist h, const double *w) {
  double column[6], power = 0.0, size = 0.0, wrench = 0.0;
  km_twist_entries(a->sub, h, a->about, 1.0, column);
  for (int r = 0; r < 6; ++r) {
    power += w[r] * column[r];
    size += column[r] * column[r];
    wrench += w[r] * w[r];
  }
  return size > 0.0 && wrench > 0.0 ? fabs(power) / sqrt(size * wrench) : 0.0;
}

static void add_remedy(km_redundancy *item, km_remedy remedy) {
  int at = item->remedy_count < KM_MOST_REMEDIES ? item->remedy_count++ : KM_MOST_REMEDIES;
  while (at > 0) {
    const km_remedy *before = &item->remedies[at - 1];
    bool better = remedy.freedoms < before->freedoms ||
                  (remedy.freedoms == before->freedoms && remedy.strength > before->strength + 1e-9);
    if (!better)
      break;
    if (at < KM_MOST_REMEDIES)
      item->remedies[at] = *before;
    --at;
  }
  if (at < KM_MOST_REMEDIES)
    item->remedies[at] = remedy;
}

/* Tries the swaps of one hinge or slide of the loop against the wrench. */
static void try_joint(const km_left_space *a, const km_left_null *null, int joint, const double *w, double *work,
                      km_redundancy *item) {
  const km_joint_kind *kind = km_joint_kind_of(a->m->model->joints[joint].type);
  if (kind->freedom != 1 || a->m->held[a->m->model->joints[joint].first_coordinate] ||
      kind->motions[0].primitive == KM_HELICAL)
    return;
  bool hinge = kind->motions[0].primitive == KM_REVOLUTE;
  int k = kind->motions[0].axis;
  km_pose X = km_joint_pose(a->m, a->s, joint);
  km_twist along = km_twist_prismatic(X.R.axis[k]), about = km_twist_revolute(X.R.axis[k], X.p);
  km_twist other = hinge ? along : about; /* what makes the joint cylindrical */
  double strength = meets(a, other, w);
  if (strength > 0.02 && raises_rank(a, null, joint, work, &other, 1))
    add_remedy(item, (km_remedy){joint, "cylindrical", 1, strength});
  km_twist turns[2] = {km_twist_revolute(X.R.axis[(k + 1) % 3], X.p), km_twist_revolute(X.R.axis[(k + 2) % 3], X.p)};
  double each[2] = {meets(a, turns[0], w), meets(a, turns[1], w)};
  int best = each[1] > each[0];
  if (hinge && each[best] > 0.02 && raises_rank(a, null, joint, work, &turns[best], 1))
    add_remedy(item, (km_remedy){joint, "universal", 1, each[best]});
  if (hinge && each[best] > 0.02 && raises_rank(a, null, joint, work, turns, 2))
    add_remedy(item, (km_remedy){joint, "spherical", 2, each[best]});
}

void km_remedies_find(const km_left_space *a, const km_left_null *null, const double w[6], double *work,
                      km_redundancy *item) {
  const km_topology *t = &a->m->topology;
  for (int i = t->member_start[item->loop]; i < t->member_start[item->loop + 1]; ++i)
    try_joint(a, null, t->member[i].joint, w, work, item);
}
