/* Joints whose motion leads an arm out of a singular configuration (singular_joints.h). */
#include "arm/tracking/singular_joints.h"

#include <math.h>
#include <string.h>

static const double step = M_PI / 6.0;  /* radians, or a travel over the arm's length: far from the singularity */
static const double floor_value = 1e-6; /* ε: singular values below this are rounding and closing errors */
static const double regular = 1e-3;     /* least singular value over the greatest one of a regular configuration */

static double merit(const km_arm *a, km_arm_space *space, const double *q, bool *is_regular) {
  double sigma[KM_ARM_ROWS], sum = 0.0;
  km_arm_update(a, space, q);
  km_arm_singular_values(a, space, sigma);
  for (int i = 0; i < a->rows; ++i)
    sum += log(sigma[i] + floor_value);
  *is_regular = sigma[a->rows - 1] > regular * sigma[0];
  return sum;
}

/* Moves the joint by which the merit grows most. False: none does. */
static bool move_best(const km_arm *a, km_arm_space *space, km_singular_joints *out, bool *is_regular) {
  double best = merit(a, space, out->q, is_regular), place = 0.0;
  int chosen = -1;
  for (int k = 0; k < a->n; ++k)
    for (int sign = 1; sign >= -1; sign -= 2) {
      const double kept = out->q[k];
      bool ignored;
      out->q[k] = kept + sign * step;
      const bool is_within = out->q[k] >= a->low[k] && out->q[k] <= a->high[k];
      const double value = is_within ? merit(a, space, out->q, &ignored) : -HUGE_VAL;
      if (value > best + 1.0) { /* a singular value grows by e at least */
        best = value;
        chosen = k;
        place = out->q[k];
      }
      out->q[k] = kept;
    }
  if (chosen < 0)
    return false;
  out->q[chosen] = place;
  out->joint[out->count++] = chosen;
  merit(a, space, out->q, is_regular);
  return true;
}

bool km_singular_joints_find(const km_arm *a, const double *q, km_singular_joints *out) {
  km_arm_space space;
  bool is_regular;
  *out = (km_singular_joints){.count = 0};
  memcpy(out->q, q, (size_t)a->n * sizeof *q);
  if (!km_arm_space_create(a, &space))
    return false;
  merit(a, &space, q, &is_regular);
  while (!is_regular && out->count < KM_SINGULAR_JOINTS && move_best(a, &space, out, &is_regular))
    continue;
  if (!is_regular)
    out->count = 0;
  km_arm_space_free(&space);
  return true;
}
