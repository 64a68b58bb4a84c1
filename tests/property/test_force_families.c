/* Answers about forces on random mechanisms, against other equations for the same. */
#include "support/forces.h"

/* Runs a family over seeds; all must be right. */
static family_count all(bool (*family)(uint64_t, family_count *), int seeds) {
  family_count count = {0};
  int wrong = 0;
  for (int i = 0; i < seeds; ++i)
    wrong += !family((uint64_t)i, &count);
  assert_int_equal(wrong, 0);
  return count;
}

/* More seeds of a family; all must be right. */
static void also(bool (*family)(uint64_t, family_count *), const uint64_t *seeds, size_t seed_count,
                 family_count *count) {
  for (size_t i = 0; i < seed_count; ++i)
    assert_true(family(seeds[i], count));
}

/* Nothing presses where it rubs (912902); two solutions lie near each other (953210); joints that carry nothing
 * could lock themselves, so that another solution leaves this one (916188, 931551, 1538714); the load is gone before
 * the forces grow without bound. */
static void friction(void **state) {
  (void)state;
  static const uint64_t seeds[] = {912902, 953210, 916188, 931551, 1538714, 985268};
  family_count count = all(family_friction, 400);
  also(family_friction, seeds, sizeof seeds / sizeof *seeds, &count);
  assert_true(count.moves > 200);
  assert_true(count.locks > 5);
}
static void wedges(void **state) {
  (void)state;
  family_count count = all(family_wedge, 300);
  assert_true(count.moves > 100);
  assert_true(count.locks > 100);
}

/* Also a peak of a motion so curved that no single step leads back to the previous configuration (55504473). */
static void planar_forces(void **state) {
  (void)state;
  static const uint64_t seeds[] = {55504473};
  family_count count = all(family_planar_forces, 80);
  also(family_planar_forces, seeds, sizeof seeds / sizeof *seeds, &count);
  assert_true(count.zeros > 20);
  assert_true(count.poles > 15);
  assert_true(count.peaks > 20);
  assert_true(count.ends > 2);
}

/* Two freedoms: two zeros about a peak between two samples; events close to the driver's dead point, on the path to
 * it; a quotient whose terms vanish together, and peaks there; ends where n and d vanish, and have turned just
 * before; ends with different leading powers far away and near (1795711359, 8188); an actuator at rest for an
 * instant, so that n and d of the other vanish together (7777307); paths along which d decreases to rounding; a peak
 * next to a zero (66601908). */
static void two_freedoms(void **state) {
  (void)state;
  static const uint64_t seeds[] = {1795710006, 1795710074, 1795710185, 1795710264, 1795710295, 1795710332, 1795710388,
                                   1795710424, 1795710522, 1795710523, 1795710544, 1795710629, 1795710638, 1795711359,
                                   1795711661, 8188,       7777307,    4101113,    4100819,    66601908};
  family_count count = all(family_two_freedoms, 30);
  also(family_two_freedoms, seeds, sizeof seeds / sizeof *seeds, &count);
  assert_true(count.zeros > 30);
  assert_true(count.poles > 30);
  assert_true(count.peaks > 20);
}

/* Also a zero so near to a start beside a dead point that the first difference holds both signs, one as near to an
 * end, and an end where n and d vanish, which shows within its own digits only (4102671), and a peak to which the
 * way leads back from where the motion nearly ends (77101928). */
static void spatial_forces(void **state) {
  (void)state;
  static const uint64_t seeds[] = {1795713986, 8235, 4102671, 77101928};
  family_count count = all(family_spatial_forces, 150);
  also(family_spatial_forces, seeds, sizeof seeds / sizeof *seeds, &count);
  assert_true(count.zeros > 50);
  assert_true(count.poles > 30);
  assert_true(count.peaks > 30);
}

/* Also poles just past the end (3003299), peaks between two poses at which the leverage is the same but for rounding
 * (914357, 3014082), and an output that hardly moves at the end (4109301). */
static void leverage(void **state) {
  (void)state;
  static const uint64_t seeds[] = {1795716164, 1795717453, 914357, 3014082, 3003299, 3005159, 4109301};
  family_count count = all(family_leverage, 400);
  also(family_leverage, seeds, sizeof seeds / sizeof *seeds, &count);
  assert_true(count.zeros > 20);
  assert_true(count.poles > 20);
  assert_true(count.peaks > 20);
  assert_true(count.ends > 10);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(friction),       cmocka_unit_test(wedges),
                                     cmocka_unit_test(planar_forces),  cmocka_unit_test(two_freedoms),
                                     cmocka_unit_test(spatial_forces), cmocka_unit_test(leverage)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
