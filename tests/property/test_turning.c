/* Turning: four-bars and slider-cranks against the conditions of F. Grashof (1883) and of the offset slider-crank. */
#include "support/support.h"

#include "base/random.h"
#include "kmech/space.h"
#include "model/model.h"
#include "space/driver_circuit.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { TRIALS = 7 };

/* A model in a file, as the search reads it again. */
typedef struct written_model {
  char file[64];
  fixture f;
} written_model;

static written_model write_model(const km_text *text) {
  written_model w = {.file = "turning-XXXXXX", .f = fixture_read(text->data)};
  int descriptor = mkstemp(w.file);
  assert_true(descriptor >= 0);
  FILE *stream = fdopen(descriptor, "w");
  assert_non_null(stream);
  assert_int_equal(fwrite(text->data, 1, text->size, stream), text->size);
  assert_int_equal(fclose(stream), 0);
  return w;
}

static void close_model(written_model *w) {
  fixture_close(&w->f);
  remove(w->file);
}

/* A four-bar of crank, coupler, rocker and ground, with the crank at an angle and the joint C above the diagonal. */
static written_model four_bar(const double length[4], double angle) {
  double B[2] = {length[0] * cos(angle), length[0] * sin(angle)}, ground = length[3];
  double x = ground - B[0], y = -B[1], d = hypot(x, y);
  double along = (length[1] * length[1] - length[2] * length[2] + d * d) / (2.0 * d);
  double across = sqrt(length[1] * length[1] - along * along);
  double C[2] = {B[0] + (along * x - across * y) / d, B[1] + (along * y + across * x) / d};
  double coupler = atan2(C[1] - B[1], C[0] - B[0]), rocker = atan2(C[1], C[0] - ground);
  km_text text = {0};
  assert_true(isfinite(across));
  km_text_format(
      &text,
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": ["
      "{\"name\": \"crank\", \"frames\": [{\"name\": \"end\", \"T\": [%.17g, 0, 0]}]},"
      "{\"name\": \"coupler\", \"frames\": [{\"name\": \"end\", \"T\": [%.17g, 0, 0]}]},"
      "{\"name\": \"rocker\", \"frames\": [{\"name\": \"end\", \"T\": [%.17g, 0, 0]}]}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"origin\"], [\"crank\", \"origin\"]], "
      "\"initial_displacement\": %.17g},"
      "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"crank\", \"end\"], [\"coupler\", \"origin\"]], "
      "\"initial_displacement\": %.17g},"
      "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"coupler\", \"end\"], [\"rocker\", \"end\"]], "
      "\"initial_displacement\": %.17g},"
      "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"pin\"], [\"rocker\", \"origin\"]], "
      "\"initial_displacement\": %.17g}]}],"
      "\"fixed\": {\"frames\": [{\"name\": \"pin\", \"T\": [%.17g, 0, 0]}]}}",
      length[0], length[1], length[2], angle, coupler - angle, rocker - coupler, rocker, ground);
  written_model w = write_model(&text);
  km_text_free(&text);
  return w;
}

static km_turning turning_of(const written_model *w, const char *path, double from, double to) {
  km_turning_def def = {.file = w->file, .path = path, .from = from, .to = to, .seed = 1};
  km_turning turning;
  km_error error = {0};
  if (km_turning_find(w->f.mechanism, w->f.state, &def, NULL, NULL, &turning, &error))
    fail_msg("%s", error.text);
  return turning;
}

/* The crank goes round if the shortest and the longest link are together shorter than the others, and the shortest is
 * the crank or the ground. */
static bool crank_turns(const double length[4]) {
  int shortest = 0, longest = 0;
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    shortest = length[k] < length[shortest] ? k : shortest;
    longest = length[k] > length[longest] ? k : longest;
    sum += length[k];
  }
  return 2.0 * (length[shortest] + length[longest]) < sum && (shortest == 0 || shortest == 3);
}

static int compare(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Crank lengths at which all links are in line and dead points begin or end: a = |±b ± c ± d| within the range. */
static int change_points(const double length[4], double from, double to, double *out) {
  int count = 0;
  for (int signs = 0; signs < 4; ++signs) {
    double a = fabs(length[1] + (signs & 1 ? -1.0 : 1.0) * length[2] + (signs & 2 ? -1.0 : 1.0) * length[3]);
    if (a > from && a < to)
      out[count++] = a;
  }
  qsort(out, (size_t)count, sizeof *out, compare);
  return count;
}

static void four_bars_turn_as_grashof_says(void **state) {
  (void)state;
  uint64_t random = 3;
  int values = 0;
  for (int trial = 0; trial < TRIALS; ++trial) {
    double length[4], expected[4], from = 0.1, to = 2.5;
    for (int k = 0; k < 4; ++k)
      length[k] = 0.8 + 0.35 * km_uniform(&random);
    length[0] = 0.45;
    written_model w = four_bar(length, 1.2);
    km_turning t = turning_of(&w, "crank.end.x", from, to);
    double links = length[1] + length[2] + length[3];
    int count = change_points(length, from, to, expected);
    assert_int_equal(t.point_count, count);
    for (int i = 0; i < count; ++i) {
      assert_near(t.points[i].number, expected[i], 1e-9 * (to - from));
      assert_near(sin(t.points[i].driver), 0.0, 1e-6);
      bool is_stretched = fabs(expected[i] - links) < 1e-12; /* the other links can just reach round the crank */
      assert_int_equal(t.points[i].kind, is_stretched ? KM_TURNING_ISOLATED : KM_TURNING_CROSSING);
      ++values;
    }
    for (int i = 0; i < t.interval_count; ++i) {
      double at[4] = {0.5 * (t.intervals[i].from + t.intervals[i].to), length[1], length[2], length[3]};
      if (!t.intervals[i].is_assembled)
        continue;
      assert_true(t.intervals[i].turns == crank_turns(at));
      assert_int_equal(t.intervals[i].dead_points > 0, !crank_turns(at));
    }
    for (size_t k = 0; k < km_table_rows(t.curves); ++k) { /* coupler and rocker are in line */
      const double *row = km_table_row(t.curves, k);
      double a = row[1], angle = row[3];
      double diagonal = sqrt(a * a + length[3] * length[3] - 2.0 * a * length[3] * cos(angle));
      assert_at_most(fmin(fabs(diagonal - length[1] - length[2]), fabs(diagonal - fabs(length[1] - length[2]))), 1e-9);
    }
    km_turning_free(&t);
    close_model(&w);
  }
  assert_true(values >= TRIALS);
}

/* Square of the rod's length that models/rssr.json has with the crank of radius y, less the squares of the longest
 * (sense 1) or shortest (−1) distance of the crank's end at its angle A from the circle of the rocker's end. */
static double rod_excess(double y, double A, double sense) {
  double across = 10.0 + y * sin(A), in_plane = 6.0 + sense * hypot(4.0, y * cos(A));
  return 100.0 + (6.0 - y) * (6.0 - y) + 16.0 - across * across - in_plane * in_plane;
}

/* A rod between two balls, which spins: at a dead point it reaches the rocker's circle at its farthest or nearest. The
 * crank goes round until one of these fails at A = ±90°: at y = 3/2, nearest, and at y = 6, farthest. */
static void rod_reaches_the_rocker(void **state) {
  (void)state;
  char *json = read_model_text("rssr");
  km_text text = {0};
  km_text_format(&text, "%s", json);
  written_model w = write_model(&text);
  km_turning t = turning_of(&w, "B.at.1", 1.0, 9.0);
  assert_int_equal(t.point_count, 2);
  for (int i = 0; i < 2; ++i) {
    assert_near(t.points[i].number, i == 0 ? 1.5 : 6.0, 1e-8);
    assert_near(t.points[i].driver, i == 0 ? 90.0 : -90.0, 1e-4);
    assert_int_equal(t.points[i].kind, KM_TURNING_CROSSING);
  }
  assert_int_equal(t.interval_count, 3);
  assert_true(t.intervals[0].turns && !t.intervals[1].turns && !t.intervals[2].turns);
  assert_int_equal(t.intervals[2].dead_points, 4);
  assert_true(km_table_rows(t.curves) > 100);
  for (size_t k = 0; k < km_table_rows(t.curves); ++k) {
    const double *row = km_table_row(t.curves, k);
    double A = row[3] * M_PI / 180.0;
    assert_at_most(fmin(fabs(rod_excess(row[1], A, 1.0)), fabs(rod_excess(row[1], A, -1.0))), 1e-7);
  }
  km_turning_free(&t);
  close_model(&w);
  km_text_free(&text);
  km_free(json);
}

/* Swing of the crank A on the state's circuit. */
static km_driver_swing swing_of(const fixture *f) {
  km_arena arena = {0};
  km_driver_surface surface = {.m = f->mechanism, .s = f->state, .frame = -1};
  km_driver_circuit circuit;
  km_driver_swing swing;
  km_error error = {0};
  if (km_driver_circuit_create(&surface, fixture_coordinate(f, "A"), &arena, &circuit, &error) ||
      km_driver_surface_begin(&surface, &arena, &error) || km_driver_circuit_follow(&circuit, &swing, &error))
    fail_msg("%s", error.text);
  km_arena_free(&arena);
  return swing;
}

/* The swing of a crank beside a spinning rod is the same from every configuration of the circuit, also from those next
 * to a dead point, and to both of its ends. */
static void a_swing_is_that_of_its_circuit(void **state) {
  (void)state;
  enum { STARTS = 60 };
  const char *const radius[] = {"[0, 3, 0]", "[0, 7, 0]"};
  char *json = read_model_text("rssr");
  for (int i = 0; i < 2; ++i) {
    char *longer = edited(json, "\"B\"", "[0, 1, 0]", radius[i]);
    fixture f = fixture_read(longer);
    int A = fixture_coordinate(&f, "A");
    double degree = M_PI / 180.0, own[8];
    const km_driver_swing expected = swing_of(&f);
    assert_int_equal(km_state_coordinates(f.mechanism, f.state, own, NULL), KM_OK);
    assert_false(expected.turns);
    assert_int_equal(expected.dead_points, 2);
    assert_true(expected.high > expected.low);
    for (int k = 1; k < STARTS; ++k) {
      double near = pow(10.0, -0.1 * k), share = k % 2 ? near : 1.0 - near;
      const km_hold start = {A, (expected.low + share * (expected.high - expected.low)) / degree};
      assert_int_equal(km_state_set_coordinates(f.mechanism, f.state, own, NULL), KM_OK);
      assert_int_equal(km_state_move_to(f.mechanism, f.state, &start, 1, NULL), KM_OK);
      km_driver_swing swing = swing_of(&f);
      assert_int_equal(swing.dead_points, 2);
      assert_near(swing.low, expected.low, 1e-8);
      assert_near(swing.high, expected.high, 1e-8);
    }
    fixture_close(&f);
    km_free(longer);
  }
  km_free(json);
}

static bool stop_after(void *context, double done) {
  int *left = context;
  (void)done;
  return (*left)-- > 0;
}

/* A search that is ended has the curves and critical values found by then, in the same order, and no interval. */
static void a_stopped_search_keeps_its_curves(void **state) {
  (void)state;
  const double length[4] = {0.45, 1.0, 0.9, 0.8};
  written_model w = four_bar(length, 1.2);
  km_turning all = turning_of(&w, "crank.end.x", 0.1, 1.0), t;
  const km_turning_def def = {.file = w.file, .path = "crank.end.x", .from = 0.1, .to = 1.0, .seed = 1};
  km_error error;
  size_t most = 0, fewest = SIZE_MAX;
  int stopped = 0;
  for (int calls = 0;; ++stopped, calls += 5) {
    int left = calls;
    km_status status = km_turning_find(w.f.mechanism, w.f.state, &def, stop_after, &left, &t, &error);
    if (status == KM_OK)
      break;
    assert_int_equal(status, KM_CANCELLED);
    assert_true(t.is_stopped);
    assert_true(t.is_complete == (t.modes > 0)); /* all modes are found before the first curve */
    assert_int_equal(t.interval_count, 0);
    assert_true(t.curve_count <= all.curve_count && t.point_count <= all.point_count);
    size_t rows = km_table_rows(t.curves), width = km_table_columns(t.curves);
    for (size_t r = 0; r < rows; ++r)
      assert_memory_equal(km_table_row(t.curves, r), km_table_row(all.curves, r), width * sizeof(double));
    most = rows > most ? rows : most;
    fewest = rows < fewest ? rows : fewest;
    km_turning_free(&t);
  }
  assert_true(stopped >= 3 && fewest == 0 && most > 0);
  assert_int_equal(t.gap, KM_GAP_NONE);
  km_turning_free(&t);
  km_turning_free(&all);
  close_model(&w);
}

static void refusals(void **state) {
  (void)state;
  const double length[4] = {0.45, 1.0, 0.9, 0.8};
  written_model w = four_bar(length, 1.2);
  const km_turning_def good = {.file = w.file, .path = "crank.end.x", .from = 0.1, .to = 1.0};
  km_turning_def bad[] = {good, good, good, good, good, good};
  km_turning t;
  km_error error;
  bad[0].driver = 99;
  bad[1].path = "crank.end.r";
  bad[2].from = 1.0;
  bad[3].steps = -1;
  bad[4].to = HUGE_VAL;
  bad[5].file = NULL;
  for (int k = 0; k < 6; ++k) {
    assert_int_equal(km_turning_find(w.f.mechanism, w.f.state, &bad[k], NULL, NULL, &t, &error), KM_USAGE);
    km_turning_free(&t);
  }
  km_turning_def missing = good;
  missing.file = "there-is-no-such-file.json";
  assert_int_equal(km_turning_find(w.f.mechanism, w.f.state, &missing, NULL, NULL, &t, &error), KM_IO);
  km_turning_free(&t);
  assert_string_equal(km_turning_kind_name(KM_TURNING_CUSP), "cusp");
  assert_string_equal(km_turning_kind_name((km_turning_kind)9), "");
  close_model(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(four_bars_turn_as_grashof_says),
                                     cmocka_unit_test(rod_reaches_the_rocker),
                                     cmocka_unit_test(a_swing_is_that_of_its_circuit),
                                     cmocka_unit_test(a_stopped_search_keeps_its_curves), cmocka_unit_test(refusals)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
