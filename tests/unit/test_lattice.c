/* Ball lattices: every direction occurs, and none twice. */
#include "support/support.h"

#include "arm/methods/ball_lattice.h"

#include <math.h>

static int find(const km_lattice *l, int freedom, const double *point) {
  int found = 0;
  for (int i = 0; i < l->count; ++i) {
    bool same = true;
    for (int k = 0; k < freedom; ++k)
      same = same && fabs(l->points[i * freedom + k] - point[k]) < 1e-12;
    found += same;
  }
  return found;
}

/* A point is there once, and with it its mirror image on each axis and the one with two axes exchanged. The points
 * on an axis are a step apart from end to end; no point of the lattice within the ball is left out. */
static void directions_are_alike(void **state) {
  (void)state;
  enum { MOST = 6 };
  const double radius = 0.7;
  for (int freedom = 1; freedom <= MOST; ++freedom)
    for (int wanted = 1; wanted <= 12; ++wanted) {
      km_arena arena = {0};
      km_lattice l;
      assert_true(km_lattice_create(freedom, radius, wanted, &arena, &l));
      assert_true(l.count <= 33 && l.steps_per_radius <= wanted && l.steps_per_radius <= 8);
      assert_int_equal(l.is_coarse, l.steps_per_radius < wanted);
      for (int i = 0; i < l.count; ++i) {
        double image[MOST], square = 0.0;
        for (int k = 0; k < freedom; ++k)
          square += l.points[i * freedom + k] * l.points[i * freedom + k];
        assert_true(sqrt(square) <= radius * (1.0 + 1e-12));
        for (int k = -1; k < freedom; ++k)
          for (int other = 0; other < freedom; ++other) {
            memcpy(image, l.points + i * freedom, (size_t)freedom * sizeof *image);
            if (k >= 0) {
              double kept = image[k];
              image[k] = -image[other];
              image[other] = kept;
            }
            assert_int_equal(find(&l, freedom, image), 1);
          }
      }
      for (int k = 0; k < freedom; ++k)
        for (int step = -l.steps_per_radius; step <= l.steps_per_radius; ++step) {
          double on_axis[MOST] = {0};
          on_axis[k] = radius * step / l.steps_per_radius;
          assert_int_equal(find(&l, freedom, on_axis), 1);
        }
      km_arena_free(&arena);
    }
}

static void counts(void **state) {
  (void)state;
  static const int expected[][3] = {{0, 5, 1},  {1, 1, 3}, {1, 8, 17}, {2, 1, 5},  {2, 2, 13},
                                    {2, 3, 29}, {3, 1, 7}, {3, 2, 33}, {20, 1, 41}};
  for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
    km_arena arena = {0};
    km_lattice l;
    assert_true(km_lattice_create(expected[i][0], 1.0, expected[i][1], &arena, &l));
    assert_int_equal(l.count, expected[i][2]);
    assert_false(l.is_coarse);
    km_arena_free(&arena);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(directions_are_alike), cmocka_unit_test(counts)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
