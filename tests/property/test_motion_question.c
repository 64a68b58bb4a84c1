/* Velocities and accelerations of the question "motion" against closed forms and differences of its own rows; swings
 * against closed forms. */
#include "support/support.h"

#include "kmech/question.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static km_question *motion(fixture *f, int steps, double rate, const char *point) {
  km_question *q;
  km_error error;
  const int driver = km_sweep_plan_default(f->model).coordinate;
  const km_option_value rates = {.coordinates = &driver, .settings = &rate, .count = 1};
  km_sweep_point traced = {.name = point};
  const km_option_value points = {.points = &traced, .count = 1};
  const char *names[2];
  char copy[64];
  assert_int_equal(km_question_create(f->mechanism, "motion", &q, NULL), KM_OK);
  assert_int_equal(km_question_set(q, "steps", &(km_option_value){.whole = steps}, NULL), KM_OK);
  assert_int_equal(km_question_set(q, "rate", &rates, NULL), KM_OK);
  if (point) {
    strcpy(copy, point);
    names[0] = strtok(copy, "/");
    names[1] = strtok(NULL, "/");
    assert_int_equal(km_model_find_frame(f->model, names, 2, &traced.frame, NULL), KM_OK);
    assert_int_equal(km_question_set(q, "point", &points, NULL), KM_OK);
  }
  if (km_question_compute(q, f->state, &error))
    fail_msg("%s", error.text);
  return q;
}

/* The piston of the slider-crank (crank r, rod l), x = r cos A + sqrt(l² − r² sin² A), for the rate ω. */
static void slider_crank(void **unused) {
  (void)unused;
  const double r = 0.6, l = 1.5, w = 7.0;
  fixture f = fixture_open("slider_crank");
  km_question *q = motion(&f, 120, w, "piston/origin");
  const km_table *t = km_question_table(q);
  for (size_t i = 0; i < km_table_rows(t); ++i) {
    double A = table_cell(t, i, "q.A"), root = sqrt(l * l - r * r * sin(A) * sin(A)), sc = sin(A) * cos(A);
    double first = -r * sin(A) - r * r * sc / root;
    double second = -r * cos(A) - r * r * cos(2.0 * A) / root - pow(r, 4) * sc * sc / pow(root, 3);
    assert_near(fabs(table_cell(t, i, "v.B")), fabs(w * first), 1e-10);
    assert_near(fabs(table_cell(t, i, "a.B")), fabs(w * w * second), 1e-9);
    assert_near(table_cell(t, i, "point.piston/origin.speed"), fabs(w * first), 1e-10);
    assert_near(table_cell(t, i, "body.crank.wx"), w, 1e-12);
    assert_near(table_cell(t, i, "body.piston.wx"), 0.0, 1e-12);
    assert_near(table_cell(t, i, "t"), (table_cell(t, i, "s") - table_cell(t, 0, "s")) / w, 1e-14);
  }
  assert_near(table_cell(t, km_table_rows(t) - 1, "point.piston/origin.path"), 4.0 * r, 1e-9);
  const km_motion_sweep *sweep = km_question_velocities(q);
  const km_swing *slide = &sweep->swings[1], *rod = &sweep->swings[2];
  assert_near(slide->high - slide->low, 2.0 * r, 1e-10);
  assert_near(rod->high - rod->low, 2.0 * asin(r / l), 1e-10);
  assert_true(sweep->swings[0].goes_round && sweep->swings[3].goes_round && !rod->goes_round);
  km_question_free(q);
  fixture_close(&f);
}

/* Fourth-order central difference of a column over equal steps h. */
static double slope(const km_table *t, size_t i, int column, double h) {
  return (km_table_row(t, i - 2)[column] - 8.0 * km_table_row(t, i - 1)[column] + 8.0 * km_table_row(t, i + 1)[column] -
          km_table_row(t, i + 2)[column]) /
         (12.0 * h);
}

/* `derivative` is the slope of `column`, to 1e-6 of its largest value, by h⁴ of 2000 rows; rounding counts
 * where it stays near 0. */
static void assert_derivative(const km_table *t, int column, int derivative) {
  double h = table_cell(t, 1, "t") - table_cell(t, 0, "t"), largest = 1e-2, worst = 0.0;
  for (size_t i = 2; i + 2 < km_table_rows(t); ++i) {
    double found = km_table_row(t, i)[derivative];
    assert_true(isfinite(found));
    largest = fmax(largest, fabs(found));
    worst = fmax(worst, fabs(found - slope(t, i, column, h)));
  }
  if (!(worst < 1e-6 * largest))
    fail_msg("%s: off by %g of %g", km_table_name(t, (size_t)derivative), worst, largest);
}

/* Planar, spatial and overconstrained linkages: rates of joints, and of a point. */
static void rates_are_slopes(void **unused) {
  (void)unused;
  static const struct {
    const char *model, *point;
  } cases[] = {{"fourbar", "coupler/point"}, {"jansen", "leg/foot"}, {"bennett", NULL},
               {"toggle_press", NULL},       {"klann", NULL},        {"sarrus3", NULL},
               {"peaucellier", NULL}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    fixture f = fixture_open(cases[k].model);
    km_question *q = motion(&f, 2000, 1.3, cases[k].point);
    const km_table *t = km_question_table(q);
    for (int c = 0; c < km_model_coordinate_count(f.model); ++c) {
      char name[80];
      int columns[3];
      for (int d = 0; d < 3; ++d) {
        snprintf(name, sizeof name, "%c.%s", "qva"[d], km_model_coordinate_label(f.model, c));
        columns[d] = km_table_find(t, name);
      }
      assert_derivative(t, columns[0], columns[1]);
      assert_derivative(t, columns[1], columns[2]);
    }
    for (int x = 0; x < 3 && cases[k].point; ++x) {
      char name[80];
      int columns[3];
      for (int d = 0; d < 3; ++d) {
        snprintf(name, sizeof name, "point.%s.%s%c", cases[k].point, d == 0 ? "" : d == 1 ? "v" : "a", "xyz"[x]);
        columns[d] = km_table_find(t, name);
      }
      assert_derivative(t, columns[0], columns[1]);
      assert_derivative(t, columns[1], columns[2]);
    }
    km_question_free(q);
    fixture_close(&f);
  }
}

/* A pin at radius R on a body that turns about a fixed hinge: speed ω R, curvature 1/R, path 2π R. */
static void circle(void **unused) {
  (void)unused;
  fixture f = fixture_open("fourbar");
  km_question *q = motion(&f, 90, 2.0, "crank/end");
  const km_table *t = km_question_table(q);
  size_t last = km_table_rows(t) - 1;
  double radius = table_cell(t, 0, "point.crank/end.speed") / 2.0;
  assert_true(radius > 0.1);
  for (size_t i = 0; i <= last; ++i) {
    assert_near(table_cell(t, i, "point.crank/end.speed"), 2.0 * radius, 1e-12);
    assert_near(table_cell(t, i, "point.crank/end.curvature"), 1.0 / radius, 1e-9);
  }
  assert_near(table_cell(t, last, "point.crank/end.path"), 2.0 * M_PI * radius, 1e-11);
  km_question_free(q);
  fixture_close(&f);
}

/* Several freedoms leave accelerations open; a rate belongs to the driver. */
static void limits_of_the_question(void **unused) {
  (void)unused;
  static const int other = 1;
  static const double rate = 1.0, none = 0.0;
  fixture f = fixture_open("delta");
  km_question *q = motion(&f, 4, 1.0, NULL);
  km_error e;
  assert_true(isnan(table_cell(km_question_table(q), 2, "a.A1")) &&
              isfinite(table_cell(km_question_table(q), 2, "v.A1")));
  km_option_value rates = {.coordinates = &other, .settings = &rate, .count = 1};
  assert_int_equal(km_question_set(q, "rate", &rates, &e), KM_OK);
  assert_int_equal(km_question_compute(q, f.state, &e), KM_USAGE);
  assert_non_null(strstr(e.text, "isn't the driver"));
  rates.settings = &none;
  assert_int_equal(km_question_set(q, "rate", &rates, &e), KM_OK);
  assert_int_equal(km_question_compute(q, f.state, &e), KM_USAGE);
  assert_int_equal(km_question_compute_here(q, f.state, &e), KM_USAGE);
  km_question_free(q);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(slider_crank), cmocka_unit_test(rates_are_slopes),
                                     cmocka_unit_test(circle), cmocka_unit_test(limits_of_the_question)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
