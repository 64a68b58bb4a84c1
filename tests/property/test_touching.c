/* Branches that cross, touch with the same tangent, or end in a cusp: equal four-bars whose cranks a rod ties, and
 * three slides coupled by s^m = z = t^k. */
#include "support/support.h"

#include "kmech/mobility.h"

#include <math.h>
#include <string.h>

/* Two equal four-bars with cranks a, couplers b, rockers c on bases of length 2, `gap` apart, whose cranks' pins a rod
 * joins. */
static fixture tied_four_bars(double a, double b, double c, double angle, double gap) {
  km_text text = {0};
  double x[2] = {0.0, gap};
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"t\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int i = 0; i < 2; ++i)
    km_text_format(&text, "{\"name\": \"crank%d\"}, {\"name\": \"coupler%d\"}, {\"name\": \"rocker%d\"}, ", i, i, i);
  km_text_add(&text, "{\"name\": \"rod\"}], \"joints\": [");
  double d = 2.0, px = a * cos(angle), py = a * sin(angle), dx = d - px, dy = -py, reach = hypot(dx, dy);
  double along = (b * b - c * c + reach * reach) / (2.0 * reach), across = sqrt(b * b - along * along);
  double cx = px + (along * dx - across * dy) / reach, cy = py + (along * dy + across * dx) / reach;
  for (int i = 0; i < 2; ++i) {
    km_text_format(
        &text,
        "{\"name\": \"A%d\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"crank%d\"], \"at\": [%.17g, 0]}, ", i, i,
        x[i]);
    km_text_format(
        &text,
        "{\"name\": \"B%d\", \"type\": \"revolute\", \"bodies\": [\"crank%d\", \"coupler%d\"], \"at\": [%.17g, %.17g]}, ",
        i, i, i, x[i] + px, py);
    km_text_format(
        &text,
        "{\"name\": \"C%d\", \"type\": \"revolute\", \"bodies\": [\"coupler%d\", \"rocker%d\"], \"at\": [%.17g, %.17g]}, ",
        i, i, i, x[i] + cx, cy);
    km_text_format(
        &text,
        "{\"name\": \"D%d\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"rocker%d\"], \"at\": [%.17g, 0]}, ", i,
        i, x[i] + d);
  }
  km_text_format(
      &text, "{\"name\": \"P\", \"type\": \"revolute\", \"bodies\": [\"rod\", \"crank0\"], \"at\": [%.17g, %.17g]}, ",
      x[0] + px, py);
  km_text_format(
      &text, "{\"name\": \"Q\", \"type\": \"revolute\", \"bodies\": [\"rod\", \"crank1\"], \"at\": [%.17g, %.17g]}]}]}",
      x[1] + px, py);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static int coordinate(const fixture *f, const char *name) {
  int found = -1;
  assert_int_equal(km_model_find_coordinate(f->model, name, &found, NULL), KM_OK);
  return found;
}

/* The cranks stand along the rod: it is a parallelogram at its change point, where a second branch crosses. Away from
 * it one motion is left, on which all joints of the twins agree. */
static void twins_agree_over_the_change_point(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    randomness r = {seed};
    fixture f = tied_four_bars(uniform(&r, 0.4, 0.6), uniform(&r, 1.7, 2.2), uniform(&r, 1.2, 1.6),
                               uniform(&r, 0.4, 1.0), uniform(&r, 4.0, 5.0));
    km_driver_motion *drive;
    int driver = coordinate(&f, "A0");
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, driver, true, &drive, NULL), KM_OK);
    for (int i = 1; i <= 60; ++i) {
      double target = (seed % 2 ? -0.05 : 0.05) * i;
      assert_int_equal(km_driver_motion_move_to(drive, target).stop, KM_STOP_NONE);
      for (int k = 0; k < 4; ++k) {
        char one[3] = {(char)('A' + k), '0', 0}, other[3] = {(char)('A' + k), '1', 0};
        assert_near(km_state_coordinate(f.state, coordinate(&f, one)),
                    km_state_coordinate(f.state, coordinate(&f, other)), 1e-7);
      }
    }
    km_driver_motion_free(drive);
    fixture_close(&f);
  }
}

/* Slides S, T and Z with the couplings z = s^m and z = t^k. */
static fixture coupled_slides(int s_power, int t_power) {
  km_text text = {0};
  km_text_add(
      &text,
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"s\"}, {\"name\": \"t\"}, {\"name\": \"z\"}], \"joints\": [");
  static const char *const names[] = {"S", "T", "Z"};
  for (int i = 0; i < 3; ++i)
    km_text_format(&text, "%s{\"name\": \"%s\", \"type\": \"T%c\", \"body_frame_pairs\": [\"fixed\", \"%c\"]}",
                   i ? ", " : "", names[i], 'x' + i, "stz"[i]);
  km_text_add(&text, "], \"couplings\": [");
  for (int i = 0; i < 2; ++i) {
    km_text_format(&text, "%s{\"name\": \"c%d\", \"joints\": [\"Z\", \"%s\"], \"polynomial\": [0", i ? ", " : "", i,
                   names[i]);
    for (int k = 1; k <= (i ? t_power : s_power); ++k)
      km_text_format(&text, ", %d", k == (i ? t_power : s_power));
    km_text_add(&text, "]}");
  }
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* s^m = t^k near 0: one curve where m and k have no common divisor (a cusp, or a smooth one), two that touch or cross
 * where both are even. */
static void powers_of_two_slides(void **state) {
  (void)state;
  static const int powers[][3] = {{2, 3, 1}, {3, 2, 1}, {2, 2, 2}, {2, 4, 2},
                                  {4, 2, 2}, {3, 3, 1}, {3, 5, 1}, {2, 5, 1}};
  for (size_t i = 0; i < sizeof powers / sizeof *powers; ++i) {
    fixture f = coupled_slides(powers[i][0], powers[i][1]);
    km_finite_mobility found;
    assert_int_equal(km_finite_mobility_find(f.mechanism, f.state, NULL, NULL, &found, NULL), KM_OK);
    if (!found.undecided) {
      if (found.mobility != 1 || km_finite_mobility_branches(&found) != powers[i][2])
        fail_msg("s^%d = t^%d: finite mobility %d, %d motions", powers[i][0], powers[i][1], found.mobility,
                 km_finite_mobility_branches(&found));
    }
    assert_true(found.mobility == 1 || found.undecided);
    km_finite_mobility_free(&found);
    fixture_close(&f);
  }
}

/* s² = t^4 and s² = t^6: the branches s = ±t² touch at 0, s = ±t³ to a higher order; driving t over 0 keeps the smooth
 * one. */
static void drives_pass_where_branches_touch(void **state) {
  (void)state;
  for (int power = 2; power <= 3; ++power)
    for (int steps = 1; steps <= 50; steps += 7) {
      fixture f = coupled_slides(2, 2 * power);
      km_driver_motion *drive;
      int t = coordinate(&f, "T"), s = coordinate(&f, "S");
      double sign = steps % 2 ? -1.0 : 1.0, start[3] = {sign * pow(0.5, power), -0.5, pow(0.5, 2 * power)};
      assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, start, NULL), KM_OK);
      assert_int_equal(km_assemble(f.mechanism, f.state, NULL, NULL), KM_OK);
      assert_int_equal(km_driver_motion_create(f.mechanism, f.state, t, true, &drive, NULL), KM_OK);
      for (int i = 1; i <= steps; ++i) {
        double x = -0.5 + (double)i / steps;
        assert_int_equal(km_driver_motion_move_to(drive, x).stop, KM_STOP_NONE);
        assert_near(km_state_coordinate(f.state, s), sign * pow(fabs(x), power) * (power == 3 && x > 0.0 ? -1.0 : 1.0),
                    1e-7);
      }
      km_driver_motion_free(drive);
      fixture_close(&f);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(twins_agree_over_the_change_point),
                                     cmocka_unit_test(powers_of_two_slides),
                                     cmocka_unit_test(drives_pass_where_branches_touch)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
