/* Random limits: the rows of a sweep lie within them wherever the mechanism's own pose is. */
#include "support/motion_families.h"
#include "support/support.h"

#include "kmech/model.h"
#include "model/model.h"

#include <stdio.h>

enum { GRID = 2000 };

/* The watched coordinate with the driver at from … to, limits ignored. */
static void trace(const char *name, int driver, int watched, double start, double from, double to, double *q) {
  fixture f = fixture_open(name);
  km_driver_motion *drive;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, driver, true, &drive, NULL), KM_OK);
  km_driver_motion_move_to(drive, start);
  for (int i = 0; i <= GRID; ++i) {
    assert_int_equal(km_driver_motion_move_to(drive, from + (to - from) * i / GRID).stop, KM_STOP_NONE);
    q[i] = f.state->q[watched];
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
}

/* Number of entries (+1) or exits (−1) of the trace. *narrow: a piece is too short for the grid. */
static int passages(const double *q, double low, double high, int sign, bool *narrow) {
  int count = 0, last = 0;
  for (int i = 1; i <= GRID; ++i) {
    bool before = q[i - 1] >= low && q[i - 1] <= high, now = q[i] >= low && q[i] <= high;
    if (before == now)
      continue;
    *narrow = *narrow || i - last < 12 || GRID - i < 12;
    last = i;
    count += now == (sign > 0);
  }
  return count;
}

bool family_limits(uint64_t seed) {
  static const char *const names[] = {"fourbar", "slider_crank", "bennett", "klann"};
  randomness r = {seed};
  const char *name = names[below(&r, 4)];
  fixture f = fixture_open(name);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  double length = plan.to - plan.from, base = plan.from;
  double start = base + length * uniform(&r, 0.05, 0.95);
  plan.from = base + length * uniform(&r, 0.05, 0.95);
  plan.to = base + length * uniform(&r, 0.05, 0.95);
  plan.steps = 1 + below(&r, 40);
  int watched = below(&r, f.model->coordinate_count);
  static double way[GRID + 1], range[GRID + 1];
  trace(name, plan.coordinate, watched, start, start, plan.from, way);
  trace(name, plan.coordinate, watched, start, plan.from, plan.to, range);
  double least = HUGE_VAL, most = -HUGE_VAL, widest = 0.0; /* the last one: between two places of the grid */
  for (int i = 0; i <= GRID; ++i) {
    least = fmin(least, fmin(way[i], range[i]));
    most = fmax(most, fmax(way[i], range[i]));
    if (i > 0)
      widest = fmax(widest, fmax(fabs(way[i] - way[i - 1]), fabs(range[i] - range[i - 1])));
  }
  double low = uniform(&r, least, most), high = uniform(&r, low, most + 0.3 * (most - least));
  bool narrow = most - least < 1e-3 || high - low < 2.0 * widest; /* the grid may miss it */
  /* Once inside, the way to FROM must not lead out again. */
  bool out_on_the_way = passages(way, low, high, -1, &narrow) > 0;
  bool all = range[0] >= low && range[0] <= high && passages(range, low, high, -1, &narrow) == 0 && !out_on_the_way;
  bool some = passages(way, low, high, 1, &narrow) + passages(range, low, high, 1, &narrow) > 0 ||
              (way[0] >= low && way[0] <= high);

  km_driver_motion *drive;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, plan.coordinate, true, &drive, NULL), KM_OK);
  km_driver_motion_move_to(drive, start);
  km_driver_motion_free(drive);
  double factor = km_model_coordinate_factor(f.model, watched);
  assert_int_equal(km_model_set_limits(f.model, watched, low / factor, high / factor, NULL), KM_OK);
  assert_int_equal(km_mechanism_renumber(f.mechanism, NULL), KM_OK);
  km_mobility_sweep sweep;
  km_status status = km_mobility_sweep_run(f.mechanism, f.state, &plan, &sweep, NULL);
  size_t rows = km_table_rows(sweep.motion.table);
  bool agrees = narrow || (status == (all ? KM_OK : some ? KM_PARTIAL : KM_NO_RESULT) && (rows > 0) == some);
  for (size_t i = 0; i < rows && agrees; ++i) {
    double q = km_table_row(sweep.motion.table, i)[2 + watched] * factor, slack = 1e-9 * (1.0 + fabs(q));
    agrees = narrow || (q >= low - slack && q <= high + slack);
  }
  if (!agrees)
    fprintf(stderr, "limits of seed %llu: %s, %s in [%g, %g], from %g over %g to %g: status %d, %zu rows\n",
            (unsigned long long)seed, name, km_model_coordinate_label(f.model, watched), low, high, start, plan.from,
            plan.to, (int)status, rows);
  km_mobility_sweep_free(&sweep);
  fixture_close(&f);
  return agrees;
}
