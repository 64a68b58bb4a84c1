/* Nearly singular linkages written in several ways. */
#include "support/linkages.h"
#include "support/motion_families.h"

#include "kinematics/body_poses.h"
#include "mobility/rank_evidence.h"

#include <stdio.h>

/* A four-bar in space that is nearly folded. */
static linkage folded(randomness *r, double height) {
  km_vec3 z = random_direction(r), x = km_vec3_perpendicular(z), y = km_vec3_cross(z, x), at[4], along[4];
  double reach[4] = {0.0, uniform(r, 0.3, 0.8), uniform(r, 1.2, 1.8), uniform(r, 0.9, 1.1)};
  for (int j = 0; j < 4; ++j) {
    at[j] = km_vec3_axpy(reach[j], x, km_vec3_scale(height * uniform(r, -1, 1), y));
    along[j] = z;
  }
  return hinged_loop(at, along, 4);
}

/* Three bars between two bodies whose lines nearly meet, or two such pairs in a row. */
static linkage nearly_concurrent(randomness *r, double miss) {
  km_vec3 z = {0, 0, 1};
  linkage l = {.bodies = 4, .joints = 6};
  for (int k = 0; k < 3; ++k) {
    double angle = 2.1 * k + uniform(r, 0, 1), near = uniform(r, 0.3, 0.8), far = near + uniform(r, 0.3, 0.8);
    km_vec3 d = {cos(angle), sin(angle), 0}, side = {-d.y, d.x, 0};
    km_vec3 off = km_vec3_scale(miss * uniform(r, 0.3, 1), side);
    l.joint[2 * k] = (axis_joint){0, 1 + k, false, km_vec3_axpy(far, d, off), z};
    l.joint[2 * k + 1] = (axis_joint){1 + k, 4, false, km_vec3_axpy(near, d, off), z};
  }
  return l;
}

static void swap_joints(linkage *l, int a, int b) {
  axis_joint keep = l->joint[a];
  l->joint[a] = l->joint[b];
  l->joint[b] = keep;
}

static linkage rewritten(const linkage *l, randomness *r) {
  linkage out = *l;
  bool mirror = below(r, 2);
  for (int j = out.joints - 1; j > 0; --j)
    swap_joints(&out, j, below(r, j + 1));
  for (int j = 0; j < out.joints; ++j) {
    axis_joint *joint = &out.joint[j];
    if (mirror) {
      joint->at.x = -joint->at.x;
      joint->along.x = -joint->along.x;
    }
    if (below(r, 2)) {
      int parent = joint->parent;
      joint->parent = joint->child;
      joint->child = parent;
    }
  }
  return out;
}

static km_rank_evidence judge(const linkage *l, randomness *r, int *mobility) {
  char *json = linkage_text(l, (writing){.own_frames = below(r, 2)}, r);
  fixture f = fixture_read(json);
  km_rank_evidence e;
  km_mobility found;
  km_mobility_compute(f.mechanism, f.state, &found);
  km_poses_compute(f.mechanism, f.state);
  assert_int_equal(km_rank_evidence_find(f.mechanism, f.state, 0, &e, NULL), KM_OK);
  *mobility = found.mobility;
  km_free(json);
  fixture_close(&f);
  return e;
}

bool family_rank_flags(uint64_t seed) {
  randomness r = {seed};
  double small = pow(10.0, uniform(&r, -7, -3));
  linkage l = below(&r, 2) ? folded(&r, small) : nearly_concurrent(&r, small);
  int mobility;
  km_rank_evidence first = judge(&l, &r, &mobility);
  for (int i = 0; i < 6; ++i) {
    int again;
    linkage other = rewritten(&l, &r);
    km_rank_evidence e = judge(&other, &r, &again);
    /* The pose is closed to 1e-15, over the singular value: so far it may be another one. */
    double drift = fabs(e.kept - first.kept), pose = 1e-14 / fmin(e.kept, first.kept);
    bool same = e.doubtful == first.doubtful || fabs(first.kept - 1e-5) < pose;
    if (same && (again == mobility || first.doubtful) && (drift < pose + 1e-6 * first.kept || again != mobility))
      continue;
    fprintf(stderr, "ranks of seed %llu: kept %.10g dropped %.3g %d, mobility %d; rewritten %.10g %.3g %d, %d\n",
            (unsigned long long)seed, first.kept, first.dropped, first.doubtful, mobility, e.kept, e.dropped,
            e.doubtful, again);
    return false;
  }
  return true;
}

/* The last pivot of a linkage as it is written, and the verdict. */
static double last_pivot(const linkage *l, randomness *r, bool *doubtful) {
  char *json = linkage_text(l, (writing){0}, r);
  fixture f = fixture_read(json);
  km_mobility found;
  km_substructure_mobility e;
  km_rank_evidence verdict;
  km_mobility_compute(f.mechanism, f.state, &found);
  km_poses_compute(f.mechanism, f.state);
  km_substructure_evidence(f.mechanism, f.state, 0, &e);
  assert_int_equal(km_rank_evidence_find(f.mechanism, f.state, 0, &verdict, NULL), KM_OK);
  *doubtful = verdict.doubtful;
  km_free(json);
  fixture_close(&f);
  return e.last_pivot;
}

pivot_range mirrored_pivots(uint64_t seed, double height) {
  randomness r = {seed};
  pivot_range out = {.least = 1.0};
  linkage l = folded(&r, height);
  for (int i = 0; i < 32; ++i) {
    bool doubtful;
    linkage other = rewritten(&l, &r);
    double pivot = last_pivot(&other, &r, &doubtful);
    out.least = fmin(out.least, pivot);
    out.most = fmax(out.most, pivot);
    out.doubtful += doubtful;
    out.count++;
  }
  return out;
}
