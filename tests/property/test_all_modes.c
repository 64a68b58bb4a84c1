/* All assembly modes: laws on random families. */
#include "support/support.h"

#include "base/random.h"
#include "kmech/space.h"

#include "model/model.h"
#include <limits.h>

#include <stdlib.h>
#include <string.h>

static km_all_modes all_modes(const fixture *f, const int *locked, int count, unsigned long seed) {
  km_all_modes modes;
  km_error error = {0};
  const km_all_modes_def def = {.locked = locked, .locked_count = count, .seed = seed};
  if (km_all_modes_find(f->mechanism, f->state, &def, NULL, NULL, &modes, &error))
    fail_msg("%s", error.text);
  return modes;
}

/* A planar platform on three legs, each with a slide between two hinges (3-RPR), at a random pose. The legs stand in
 * the order that `first` begins, and the whole is moved by `shift`. */
typedef struct planar_platform {
  double base[3][2], top[3][2];
} planar_platform;

static planar_platform random_platform(uint64_t *random) {
  planar_platform p;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 2; ++i) {
      p.base[k][i] = 2.0 * km_uniform(random);
      p.top[k][i] = 1.0 * km_uniform(random) + 0.5;
    }
  return p;
}

static fixture build_platform(const planar_platform *p, int first, double shift) {
  km_text text = {0};
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"top\"}");
  for (int k = 0; k < 3; ++k)
    km_text_format(&text, ", {\"name\": \"a%d\"}, {\"name\": \"b%d\"}", k, k);
  km_text_add(&text, "], \"joints\": [");
  for (int i = 0; i < 3; ++i) {
    int k = (first + i) % 3;
    const double *b = p->base[k], *t = p->top[k];
    km_text_format(
        &text,
        "%s{\"name\": \"R%d\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"a%d\"], \"at\": [%.17g, %.17g]},"
        "{\"name\": \"P%d\", \"type\": \"prismatic\", \"bodies\": [\"a%d\", \"b%d\"], \"at\": [%.17g, %.17g], "
        "\"axis\": [%.17g, %.17g]},"
        "{\"name\": \"S%d\", \"type\": \"revolute\", \"bodies\": [\"b%d\", \"top\"], \"at\": [%.17g, %.17g]}",
        i ? ", " : "", k, k, b[0] + shift, b[1], k, k, k, b[0] + shift, b[1], t[0] - b[0], t[1] - b[1], k, k,
        t[0] + shift, t[1]);
  }
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static void lock_legs(const fixture *f, int locked[3]) {
  const char *const legs[] = {"P0", "P1", "P2"};
  for (int k = 0; k < 3; ++k)
    locked[k] = fixture_coordinate(f, legs[k]);
}

/* A planar platform has 6 complex assembly modes (C. Gosselin, J. Sefrioui 1991; K. H. Hunt 1983), of which an even
 * number is real. */
static void planar_platforms_have_six(void **state) {
  (void)state;
  uint64_t random = 7;
  for (int trial = 0; trial < 25; ++trial) {
    planar_platform p = random_platform(&random);
    fixture f = build_platform(&p, 0, 0.0);
    int locked[3];
    lock_legs(&f, locked);
    km_all_modes modes = all_modes(&f, locked, 3, 1);
    assert_true(modes.is_complete);
    assert_int_equal(modes.complex_solutions, 6);
    assert_true(modes.count == 2 || modes.count == 4 || modes.count == 6);
    for (int i = 0; i < modes.count; ++i) {
      assert_true(modes.evidence[i].is_certified);
      assert_at_most(modes.evidence[i].residual, 1e-11);
      for (int k = 0; k < 3; ++k)
        assert_near(modes.coordinates[i * f.model->coordinate_count + locked[k]],
                    km_state_coordinate(f.state, locked[k]), 1e-12);
    }
    km_all_modes_free(&modes);
    fixture_close(&f);
  }
}

/* A random Watt-Baranov truss: k triangles on a fixed polygon, joined in a ring by k bars. */
static fixture random_truss(int k, uint64_t *random) {
  km_text text = {0};
  double pin[5][2], next[5][2], last[5][2];
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < 2; ++j) {
      pin[i][j] = (j ? sin(2.0 * M_PI * i / k) : cos(2.0 * M_PI * i / k)) + 0.2 * km_uniform(random);
      next[i][j] = pin[i][j] + 0.5 * km_uniform(random);
      last[i][j] = pin[i][j] + 0.5 * km_uniform(random);
    }
  km_text_add(&text, "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int i = 0; i < k; ++i)
    km_text_format(&text, "%s{\"name\": \"t%d\"}, {\"name\": \"l%d\"}", i ? ", " : "", i, i);
  km_text_add(&text, "], \"joints\": [");
  for (int i = 0; i < k; ++i) {
    int n = (i + 1) % k;
    km_text_format(
        &text,
        "%s{\"name\": \"G%d\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"t%d\"], \"at\": [%.17g, %.17g]},"
        "{\"name\": \"A%d\", \"type\": \"revolute\", \"bodies\": [\"t%d\", \"l%d\"], \"at\": [%.17g, %.17g]},"
        "{\"name\": \"B%d\", \"type\": \"revolute\", \"bodies\": [\"l%d\", \"t%d\"], \"at\": [%.17g, %.17g]}",
        i ? ", " : "", i, i, pin[i][0], pin[i][1], i, i, i, next[i][0], next[i][1], i, i, n, last[n][0], last[n][1]);
  }
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* A truss of k triangles has 2^(k+1) − 2 complex modes: 6 for k = 2, a coupler curve of degree 6 and a circle, and 126
 * for the 13 links of k = 6 (N. Rojas 2012). An even number of them is real. */
static void trusses_have_a_power_of_two_less_two(void **state) {
  (void)state;
  uint64_t random = 5;
  for (int trial = 0; trial < 12; ++trial) {
    int k = 2 + trial % 4;
    fixture f = random_truss(k, &random);
    km_all_modes modes = all_modes(&f, NULL, 0, 1);
    assert_true(modes.is_complete);
    assert_int_equal(modes.complex_solutions, (1 << (k + 1)) - 2);
    assert_int_equal(modes.count % 2, 0);
    for (int i = 0; i < modes.count; ++i) {
      assert_true(modes.evidence[i].is_certified);
      assert_at_most(modes.evidence[i].residual, 1e-11);
    }
    km_all_modes_free(&modes);
    fixture_close(&f);
  }
}

/* Sorted values of one joint over all modes. */
static int compare_numbers(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static void sorted_angles(const fixture *f, const km_all_modes *modes, const char *label, double *out) {
  int c = fixture_coordinate(f, label);
  for (int i = 0; i < modes->count; ++i)
    out[i] = remainder(modes->coordinates[i * f->model->coordinate_count + c], 2.0 * M_PI);
  qsort(out, (size_t)modes->count, sizeof *out, compare_numbers);
}

/* The set of modes depends neither on the random numbers, nor on the order of the joints, nor on the place of the
 * inertial frame. */
static void modes_depend_on_the_mechanism_only(void **state) {
  (void)state;
  uint64_t random = 11;
  for (int trial = 0; trial < 8; ++trial) {
    planar_platform p = random_platform(&random);
    double angles[3][6];
    int count = 0;
    for (int variant = 0; variant < 3; ++variant) {
      fixture f = build_platform(&p, variant, 10.0 * variant);
      int locked[3];
      lock_legs(&f, locked);
      km_all_modes modes = all_modes(&f, locked, 3, (unsigned long)variant + 5);
      assert_true(modes.is_complete);
      if (variant == 0)
        count = modes.count;
      assert_int_equal(modes.count, count);
      sorted_angles(&f, &modes, "R1", angles[variant]);
      for (int i = 0; i < count; ++i)
        assert_near(angles[variant][i], angles[0][i], 1e-7);
      km_all_modes_free(&modes);
      fixture_close(&f);
    }
  }
}

/* Random starts find no mode that the complete list lacks. */
static void random_starts_find_no_other(void **state) {
  (void)state;
  const char *const names[] = {"fourbar",      "klann",   "jansen",       "brake",
                               "toggle_press", "andrews", "scissor_lift", "rssr"};
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
    fixture f = fixture_open(names[k]);
    int driver = km_sweep_plan_default(f.model).coordinate;
    km_all_modes all = all_modes(&f, &driver, 1, 1);
    km_modes some;
    assert_int_equal(km_modes_find(f.mechanism, f.state, driver, 300, 1, NULL, NULL, &some, NULL), KM_OK);
    assert_true(all.is_complete);
    assert_int_equal(all.count - all.outside, some.count);
    km_modes_free(&some);
    km_all_modes_free(&all);
    fixture_close(&f);
  }
}

/* A bar on a hinge, and a second one from its end to a fixed pin: the knee is on either side, at the intersections of
 * two circles. */
static void two_bars_meet_in_two_points(void **state) {
  (void)state;
  uint64_t random = 3;
  for (int trial = 0; trial < 20; ++trial) {
    double knee[2] = {0.8 * km_uniform(&random), 0.8 * km_uniform(&random)}, pin = 1.5 + 0.5 * km_uniform(&random);
    km_text text = {0};
    km_text_format(
        &text,
        "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"p\"}, {\"name\": "
        "\"q\"}], \"joints\": [{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"p\"], \"at\": "
        "[0, 0]}, {\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"p\", \"q\"], \"at\": [%.17g, %.17g]}, "
        "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"q\"], \"at\": [%.17g, 0]}]}]}",
        knee[0], knee[1], pin);
    fixture f = fixture_read(text.data);
    km_all_modes modes = all_modes(&f, NULL, 0, 1);
    assert_true(modes.is_complete);
    assert_int_equal(modes.count, 2);
    /* The mirror image of the knee in the line of the pins: A turns by −2 atan2(y, x). */
    assert_near(sin(modes.coordinates[3 + fixture_coordinate(&f, "A")]), sin(-2.0 * atan2(knee[1], knee[0])), 1e-9);
    km_all_modes_free(&modes);
    km_text_free(&text);
    fixture_close(&f);
  }
}

/* The platform's legs fixed at one length each: the modes of 40 complex ones come in mirror pairs. */
static void a_symmetric_platform_has_mirror_modes(void **state) {
  (void)state;
  fixture f = fixture_open("stewart");
  const char *const legs[] = {"P1", "P2", "P3", "P4", "P5", "P6"};
  int locked[6];
  for (int k = 0; k < 6; ++k)
    locked[k] = fixture_coordinate(&f, legs[k]);
  km_all_modes modes = all_modes(&f, locked, 6, 1);
  assert_true(modes.is_complete);
  assert_int_equal(modes.complex_solutions, 40);
  assert_int_equal(modes.count % 2, 0);
  km_all_modes_free(&modes);
  fixture_close(&f);
}

/* A double parallelogram moves although it counts as a structure: it is never complete. */
static void a_self_motion_is_never_complete(void **state) {
  (void)state;
  fixture f = fixture_open("peaucellier");
  int driver = km_sweep_plan_default(f.model).coordinate;
  km_all_modes modes = all_modes(&f, &driver, 1, 1);
  assert_false(modes.is_complete);
  assert_int_equal(modes.gap, KM_GAP_MOVES);
  bool moves = false;
  for (int i = 0; i < modes.count; ++i) {
    moves = moves || modes.evidence[i].moves;
    assert_false(modes.evidence[i].moves && modes.evidence[i].is_certified);
  }
  assert_true(moves);
  km_all_modes_free(&modes);
  fixture_close(&f);
}

/* A strut's length is never negative, and limits leave modes out. */
static void struts_and_limits(void **state) {
  (void)state;
  const char *lid =
      "{\"fixed\": {\"frames\": [{\"name\": \"f\", \"T\": [0.2, -0.5]}]},"
      " \"assemblies\": [{\"name\": \"l\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"lid\", \"frames\": [{\"name\": "
      "\"e\", \"T\": [1, 0.1]}]}], \"joints\": [{\"name\": \"H\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"lid\"], "
      "\"at\": [0, 0]}], \"struts\": [{\"name\": \"g\", \"from\": \"fixed/f\", \"to\": \"lid/e\", \"planar\": true}]}]}";
  fixture f = fixture_read(lid);
  int hinge = fixture_coordinate(&f, "H"), strut = fixture_coordinate(&f, "g");
  km_all_modes modes = all_modes(&f, &hinge, 1, 1);
  assert_true(modes.is_complete);
  assert_int_equal(modes.count, 1);
  km_all_modes_free(&modes);
  modes = all_modes(&f, &strut, 1, 1);
  assert_true(modes.is_complete);
  assert_int_equal(modes.count, 2);
  km_all_modes_free(&modes);
  fixture_close(&f);
  char *limited = edited(lid, "\"H\"", "\"at\": [0, 0]", "\"at\": [0, 0], \"limits\": [-0.5, 0.5]");
  f = fixture_read(limited);
  strut = fixture_coordinate(&f, "g");
  const km_all_modes_def def = {.locked = &strut, .locked_count = 1, .within_limits = true};
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, NULL, NULL, &modes, NULL), KM_OK);
  assert_int_equal(modes.count, 1);
  assert_int_equal(modes.outside, 1);
  km_all_modes_free(&modes);
  km_free(limited);
  fixture_close(&f);
}

static bool stop_at_once(void *context, double done) {
  (void)context;
  (void)done;
  return false;
}

typedef struct stop {
  int left; /* calls until the search is ended */
} stop;

static bool stop_after(void *context, double done) {
  stop *s = context;
  (void)done;
  return s->left-- > 0;
}

/* A search that is ended has some of the modes, proved, the state's own first; a later end has as many or more. */
static void a_stopped_search_keeps_its_modes(void **state) {
  (void)state;
  fixture f = fixture_open("scissor_lift");
  int driver;
  km_all_modes all, modes;
  km_error error;
  assert_int_equal(km_model_find_coordinate(f.model, "S", &driver, NULL), KM_OK);
  const km_all_modes_def def = {.locked = &driver, .locked_count = 1, .seed = 1};
  size_t n = (size_t)km_model_coordinate_count(f.model);
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, NULL, NULL, &all, NULL), KM_OK);
  int most = 0, stopped = 0;
  for (int calls = 0; calls < 4096; calls = 2 * calls + 1) {
    stop s = {calls};
    km_status status = km_all_modes_find(f.mechanism, f.state, &def, stop_after, &s, &modes, &error);
    if (status == KM_CANCELLED) {
      ++stopped;
      assert_int_equal(modes.gap, KM_GAP_STOPPED);
      assert_false(modes.is_complete);
    }
    assert_true(modes.count >= 1 && modes.count <= all.count);
    for (int i = 0; i < modes.count; ++i) {
      bool is_known = false;
      for (int k = 0; k < all.count; ++k) {
        double distance = 0.0;
        for (size_t c = 0; c < n; ++c)
          distance = fmax(distance, fabs(modes.coordinates[(size_t)i * n + c] - all.coordinates[(size_t)k * n + c]));
        is_known = is_known || distance < 1e-9;
      }
      assert_true(is_known && modes.evidence[i].is_certified);
    }
    most = modes.count > most ? modes.count : most;
    km_all_modes_free(&modes);
  }
  assert_true(stopped >= 3);
  assert_int_equal(most, all.count);
  km_all_modes_free(&all);
  fixture_close(&f);
}

/* Singular modes of a search that is ended are listed too, as moving unless that was shown not to be so; also of one
 * that is ended where it judges the last mode. */
static void a_stopped_search_keeps_singular_modes(void **state) {
  (void)state;
  fixture f = fixture_open("peaucellier");
  int driver = km_sweep_plan_default(f.model).coordinate, moving = 0;
  const km_all_modes_def def = {.locked = &driver, .locked_count = 1, .seed = 1};
  stop whole = {INT_MAX};
  km_all_modes modes;
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, stop_after, &whole, &modes, NULL), KM_OK);
  km_all_modes_free(&modes);
  int calls = INT_MAX - whole.left;
  const int ends[] = {0, calls / 8, calls / 4, calls / 2, calls - 1};
  for (size_t k = 0; k < sizeof ends / sizeof *ends; ++k) {
    stop s = {ends[k]};
    assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, stop_after, &s, &modes, NULL), KM_CANCELLED);
    assert_int_equal(modes.gap, KM_GAP_STOPPED);
    assert_true(modes.count >= 1);
    for (int i = 0; i < modes.count; ++i) {
      assert_int_equal(modes.evidence[i].moves, modes.evidence[i].is_singular);
      moving += modes.evidence[i].moves;
    }
    km_all_modes_free(&modes);
  }
  assert_true(moving >= 2);
  fixture_close(&f);
}

static void refusals(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_all_modes modes;
  km_error error = {0};
  km_all_modes_def def = {0};
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, NULL, NULL, &modes, &error), KM_USAGE);
  assert_non_null(strstr(error.text, "can still move in 1 way"));
  int driver = 0;
  def = (km_all_modes_def){.locked = &driver, .locked_count = 1};
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, stop_at_once, NULL, &modes, &error), KM_CANCELLED);
  km_all_modes_free(&modes);
  driver = 99;
  assert_int_equal(km_all_modes_find(f.mechanism, f.state, &def, NULL, NULL, &modes, &error), KM_USAGE);
  assert_string_equal(km_mode_gap_name(KM_GAP_MOVES), "self-motion");
  assert_string_equal(km_mode_gap_name(KM_GAP_STOPPED), "stopped");
  assert_string_equal(km_mode_gap_name((km_mode_gap)77), "");
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(planar_platforms_have_six),
                                     cmocka_unit_test(trusses_have_a_power_of_two_less_two),
                                     cmocka_unit_test(modes_depend_on_the_mechanism_only),
                                     cmocka_unit_test(random_starts_find_no_other),
                                     cmocka_unit_test(two_bars_meet_in_two_points),
                                     cmocka_unit_test(a_symmetric_platform_has_mirror_modes),
                                     cmocka_unit_test(a_self_motion_is_never_complete),
                                     cmocka_unit_test(struts_and_limits),
                                     cmocka_unit_test(a_stopped_search_keeps_its_modes),
                                     cmocka_unit_test(a_stopped_search_keeps_singular_modes),
                                     cmocka_unit_test(refusals)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
