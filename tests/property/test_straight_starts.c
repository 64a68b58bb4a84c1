/* Loops drawn straight, where the start is a stationary point of the gap, and planar loops whose pins lie at different
 * heights.
 *
 * A loop of n hinges with parallel axes closes if and only if its longest link is at most as long as the others
 * together. */
#include "support/support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A chain of `count` - 1 links along x from the origin to a pin at (ground, 0, height), all displacements 0; `closing`
 * is the type of the last joint. The caller frees the text. */
static char *straight_chain(const double *length, int count, const char *closing, double height) {
  km_text text = {0};
  km_text_format(
      &text,
      "{\"model_parameters\": {\"version\": \"1.0\"}, \"fixed\": {\"frames\": [{\"name\": \"pin\", \"T\": [%.17g, 0, %.17g]}]},"
      " \"assemblies\": [{\"name\": \"a\", \"bodies\": [",
      length[count - 1], height);
  for (int i = 0; i + 1 < count; ++i)
    km_text_format(&text, "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"end\", \"T\": [%.17g, 0, 0]}]}",
                   i ? ", " : "", i, length[i]);
  km_text_add(&text, "], \"joints\": [");
  for (int i = 0; i + 1 < count; ++i)
    km_text_format(&text, "{\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [\"%s%d%s\", \"b%d\"]}, ", i,
                   i ? "b" : "fixed", i ? i - 1 : 0, i ? "/end" : "", i);
  km_text_format(&text,
                 "{\"name\": \"last\", \"type\": \"%s\", \"body_frame_pairs\": [\"b%d/end\", \"fixed/pin\"]}]}]}",
                 closing, count - 2);
  char *fixed = text.data ? strstr(text.data, "fixed0") : NULL;
  assert_non_null(fixed);
  memmove(fixed + 5, fixed + 6, strlen(fixed + 6) + 1);
  return text.data;
}

static double excess(const double *length, int count) {
  double longest = 0.0, sum = 0.0;
  for (int i = 0; i < count; ++i) {
    longest = fmax(longest, length[i]);
    sum += length[i];
  }
  return 2.0 * longest - sum;
}

static void straight_loops_close_where_lengths_allow(void **state) {
  (void)state;
  int closed = 0, open = 0;
  for (uint64_t seed = 1; seed <= 600; ++seed) {
    randomness r = {seed};
    double length[6];
    int count = 3 + (int)(seed % 4);
    for (int i = 0; i < count; ++i)
      length[i] = uniform(&r, 0.1, seed % 3 ? 2.0 : 5.0);
    double over = excess(length, count);
    char *text = straight_chain(length, count, seed % 5 ? "Rz" : "spherical", 0.0);
    fixture f;
    km_error error;
    km_status status = fixture_try(text, &f, &error);
    km_free(text);
    assert_int_equal(status, over > 0.0 ? KM_MODEL : KM_OK);
    if (over > 0.0) {
      const char *told = strstr(error.text, " m longer than the others together");
      assert_non_null(told);
      while (told[-1] != ' ')
        --told;
      assert_near(strtod(told, NULL), over, 1e-3 * over);
    } else {
      km_mobility mobility;
      km_mobility_compute(f.mechanism, f.state, &mobility);
      assert_at_most(mobility.residual, 1e-12);
      assert_int_equal(mobility.mobility, count - 3 > 0 ? count - 3 : 0);
    }
    closed += over <= 0.0;
    open += over > 0.0;
    fixture_close(&f);
  }
  assert_true(closed > 300 && open > 50);
}

/* The motion doesn't depend on the height of the last pin. */
static void pins_at_any_height_move_alike(void **state) {
  (void)state;
  static const double length[] = {0.3, 0.9, 0.7, 1.0};
  static const char *const closing[] = {"Rz", "spherical"};
  for (int type = 0; type < 2; ++type) {
    double level[3];
    for (int i = 0; i < 8; ++i) {
      double height = i ? 1e-6 * pow(7.0, i) * (i % 2 ? 1.0 : -1.0) : 0.0;
      char *text = straight_chain(length, 4, closing[type], height);
      fixture f = fixture_read(text);
      km_free(text);
      km_error error;
      km_mobility mobility;
      km_hold turn = {0, 0.5};
      assert_int_equal(km_state_move_to(f.mechanism, f.state, &turn, 1, &error), KM_OK);
      km_mobility_compute(f.mechanism, f.state, &mobility);
      assert_int_equal(mobility.mobility, 1);
      assert_at_most(mobility.residual, 1e-12);
      for (int c = 0; c < 3; ++c) {
        if (i == 0)
          level[c] = km_mobility_number(f.state, c);
        assert_near(km_mobility_number(f.state, c), level[c], 1e-9);
      }
      fixture_close(&f);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(straight_loops_close_where_lengths_allow),
                                     cmocka_unit_test(pins_at_any_height_move_alike)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
