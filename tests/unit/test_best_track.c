/* Choice of the best of several tracks. */
#include "support/support.h"

#include "kmech/report.h"

#include "arm/tracking/track.h"

#include <math.h>

enum { COUNT = 3 };

static km_track track(double way, double least, double mean, double travel, double rate) {
  km_track t = {.end = {.s = way}};
  t.summary.objective_min = least;
  t.summary.objective_mean = mean;
  t.summary.joint_travel = travel;
  t.summary.rate = rate;
  return t;
}

/* Wherever the best one stands. */
static void expect_first(km_track best, km_track second, km_track third) {
  for (int place = 0; place < COUNT; ++place) {
    km_track *items[COUNT];
    items[place] = &best;
    items[(place + 1) % COUNT] = &second;
    items[(place + 2) % COUNT] = &third;
    const km_tracks all = {.items = items, .count = COUNT};
    assert_int_equal(km_tracks_best(&all), place);
  }
}

static void ties_are_decided_by_what_follows(void **state) {
  (void)state;
  const double last = 1e-12; /* rounding decides nothing */
  expect_first(track(2, 0, 0, 9, 9), track(1, 5, 5, 1, 1), track(1.5, 9, 9, 1, 1));
  expect_first(track(1, 0.5, 0.6, 9, 9), track(1, 0.4, 0.7, 1, 1), track(1, 0.3, 0.9, 1, 1));
  expect_first(track(1, 0.32, 0.44, 9, 9), track(1, 0.32 + last, 0.43, 1, 1), track(1, 0.32 + last, 0.42, 1, 1));
  expect_first(track(1, 0.32, 0.44, 2, 9), track(1, 0.32 + last, 0.44 + last, 3, 1), track(1, 0.3, 0.44, 1, 1));
  expect_first(track(1, 0.32, 0.44, 2, 3), track(1, 0.32 + last, 0.44, 2 - last, 4), track(1, 0.32, 0.44, 2, 5));
  expect_first(track(1, 0.32, 0.44, 2, 3), track(1, (double)NAN, 0.5, 1, 1), track(1, (double)NAN, 0.6, 1, 1));
  const km_track same = track(1, 0.32, 0.44, 2, 3);
  km_track copies[COUNT] = {same, same, same}, *items[COUNT] = {&copies[0], &copies[1], &copies[2]};
  const km_tracks all = {.items = items, .count = COUNT};
  assert_int_equal(km_tracks_best(&all), 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(ties_are_decided_by_what_follows)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
