/* Dead points of random planar linkages: a sweep of a few rows finds those of a fine trace. */
#include "support/motion_families.h"
#include "support/planar.h"

#include "kmech/sweep.h"

#include <stdio.h>
#include <string.h>

enum { GRID = 4000, BESIDE = 3 };

/* Signs of every coordinate's entry at the places of the grid over the sweep's own range; false where a drive
 * doesn't get there. */
static bool trace(const char *text, const km_sweep_plan *plan, const km_sweep *motion, double *z) {
  fixture f = fixture_read(text);
  const int count = f.mechanism->coordinate_count;
  const double from = motion->start.position, to = motion->end.position;
  double rates[PLANAR_MOST_JOINTS];
  km_driver_motion *drive;
  bool there = true;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, plan->coordinate, true, &drive, NULL), KM_OK);
  /* A driver is at rest at its own dead point: the grid ends just before. */
  for (int i = 0; i <= GRID && there; ++i) {
    there = !km_driver_motion_move_to(drive, from + (to - from) * (i + 0.5) / (GRID + 1)).stop &&
            km_driver_motion_tangent(drive, rates);
    double square = 0.0;
    for (int c = 0; c < count; ++c)
      square += pow(f.mechanism->scale[c] * rates[c], 2.0);
    for (int c = 0; c < count; ++c)
      z[i * count + c] = f.mechanism->scale[c] * rates[c] / sqrt(square);
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
  return there;
}

/* Number of dead points of coordinate c in the trace. *sure: none is so near to another one, to an end, or to an
 * extremum of the entry that the grid may miss it; and between two of them the entry of the unit vector is large
 * enough to be seen by a few rows. */
static int changes(const double *z, int count, int c, bool *sure) {
  int found = 0, last = -BESIDE;
  double largest = 1.0;
  for (int i = 1; i <= GRID; ++i) {
    const double a = z[(i - 1) * count + c], b = z[i * count + c];
    bool turns = i < GRID && fabs(b) < fabs(a) && fabs(b) < fabs(z[(i + 1) * count + c]);
    if (turns && a * b > 0.0 && b * z[(i + 1) * count + c] > 0.0)
      *sure = *sure && fabs(b) > fmax(fabs(a) - fabs(b), fabs(z[(i + 1) * count + c]) - fabs(b));
    largest = fmax(largest, fabs(a));
    if (a * b > 0.0)
      continue;
    *sure = *sure && i - last > BESIDE && i > BESIDE && i < GRID - BESIDE && largest > 1e-3;
    last = i;
    largest = fabs(b);
    ++found;
  }
  return found;
}

/* Number of dead points reported by the sweep. *sure: none is next to an end. */
static int toggles_of(const km_mobility_sweep *sweep, int c, bool *sure) {
  const double from = sweep->motion.start.position, to = sweep->motion.end.position, near = BESIDE * (to - from) / GRID;
  int found = 0;
  for (size_t i = 0; i < sweep->toggle_count; ++i) {
    if (sweep->toggles[i].coordinate != c)
      continue;
    *sure = *sure && sweep->toggles[i].s > from + near && sweep->toggles[i].s < to - near;
    ++found;
  }
  return found;
}

bool family_dead_points(uint64_t seed) {
  static double z[(GRID + 1) * PLANAR_MOST_JOINTS];
  randomness r = {seed};
  planar linkage = planar_random(&r, 1, 1 + below(&r, 3), false);
  char *text = planar_text(&linkage);
  fixture f = fixture_read(text);
  const int count = f.mechanism->coordinate_count;
  km_sweep_plan plan = {.coordinate = below(&r, linkage.joints), .direction = -1, .steps = 4 + below(&r, 40)};
  plan.from = uniform(&r, -1.0, 0.0);
  plan.to = uniform(&r, 0.0, 1.0);
  plan.ignore_limits = true;
  km_mobility_sweep sweep;
  km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL);
  bool judged = (status == KM_OK || status == KM_PARTIAL) && sweep.motion.branch_count == 0 &&
                sweep.motion.end.position > sweep.motion.start.position + 1e-6 && trace(text, &plan, &sweep.motion, z);
  bool agrees = true;
  for (int c = 0; c < count && judged; ++c) {
    bool sure = c != plan.coordinate && f.mechanism->substructure_of[c] == sweep.motion.substructure;
    int expected = sure ? changes(z, count, c, &sure) : 0, found = toggles_of(&sweep, c, &sure);
    if (!sure || expected == found)
      continue;
    agrees = false;
    fprintf(stderr, "dead points of seed %llu: %d of joint %d in %d rows, %d in a trace, driver %d from %g to %g\n",
            (unsigned long long)seed, found, c, plan.steps + 1, expected, plan.coordinate, sweep.motion.start.position,
            sweep.motion.end.position);
  }
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
  km_free(text);
  return agrees;
}
