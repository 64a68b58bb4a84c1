/* Optimised linkages: a four-bar with the best transmission angle, whose optimum is known, and coupler curves
 * through given points. */
#include "support/designs.h"

#include <math.h>
#include <string.h>

/* A crank-rocker by the lengths of its links; D is at (ground, 0). */
static const char fourbar[] =
    "{\"model_parameters\": {\"version\": \"1.1\", \"units\": {\"angle\": \"deg\", \"length\": \"mm\"}},"
    "\"parameters\": {\"ground\": 80, \"crank\": 20, \"coupler\": 70, \"rocker\": 50, \"along\": 60, \"up\": 25,"
    "\"Bx\": \"crank*cos(60*deg)\", \"By\": \"crank*sin(60*deg)\", \"x\": \"ground-Bx\", \"square\": \"x^2+By^2\","
    "\"u\": \"(coupler^2-rocker^2)/(2*square)+1/2\", \"v\": \"sqrt(coupler^2/square-u^2)\","
    "\"Cx\": \"Bx+u*x+v*By\", \"Cy\": \"By-u*By+v*x\", \"ex\": \"(Cx-Bx)/coupler\", \"ey\": \"(Cy-By)/coupler\"},"
    "\"assemblies\": [{\"name\": \"linkage\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"crank\"},"
    "{\"name\": \"coupler\", \"frames\": [{\"name\": \"tip\", \"T\": [\"Bx+along*ex-up*ey\", \"By+along*ey+up*ex\"]}]},"
    "{\"name\": \"rocker\"}], \"joints\": ["
    "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"crank\"], \"at\": [0, 0],"
    " \"initial_displacement\": 60},"
    "{\"name\": \"B\", \"type\": \"revolute\", \"bodies\": [\"crank\", \"coupler\"], \"at\": [\"Bx\", \"By\"]},"
    "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"coupler\", \"rocker\"], \"at\": [\"Cx\", \"Cy\"]},"
    "{\"name\": \"D\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"rocker\"], \"at\": [\"ground\", 0]}]}],"
    "\"analysis\": {\"sweep\": {\"joint\": \"A\", \"range\": [0, 360], \"steps\": 36},"
    "\"mechanical_advantage\": {\"input\": \"A\", \"output\": \"D\"}}}";

static void optimise(designs *d, const char *kind, const char *algorithm, int evaluations) {
  designs_of_model(d, "", kind);
  d->def.model = NULL;
  d->def.bytes = fourbar;
  d->def.size = strlen(fourbar);
  d->optimise = (km_design_optimise){.variables = d->variables,
                                     .goal_count = 1,
                                     .algorithm = algorithm,
                                     .evaluations = evaluations,
                                     .tolerance = 1e-7,
                                     .starts = 1,
                                     .seed = 1};
  d->def.optimise = &d->optimise;
}

static void add_variable(designs *d, const char *path, double low, double high, double start) {
  d->variables[d->optimise.variable_count++] = (km_design_variable){d->def.parameter_count, low, high, start};
  designs_add_parameter(d, path);
}

/* The coupler, of 55 to 75 mm, whose least index of Sutherland and Roth is the greatest. */
static void seek_coupler(designs *d, const char *algorithm, int evaluations) {
  static const km_design_option flag = {.name = "transmission", .flag = true};
  optimise(d, "advantage", algorithm, evaluations);
  add_variable(d, "coupler", 55.0, 75.0, 72.0);
  designs_add_figure(d, "transmission", KM_DESIGN_MIN, "sutherland_roth");
  d->options[d->questions[0].option_count++] = flag;
  d->optimise.goals[0] = (km_design_goal){"transmission", true};
}

/* The best design, and its coupler. */
static int best_coupler(const km_design_study *s, double *coupler) {
  int best = km_design_study_best(s);
  assert_true(best >= 0);
  assert_int_equal(km_design_study_values(s, best, coupler, NULL), KM_OK);
  return best;
}

/* The transmission angle deviates most if crank and ground are collinear: cos μ = (b² + c² − (g ∓ a)²)/(2bc). Both
 * are equal if b² + c² = g² + a²; then cos μ = ag/(bc) (Brodell and Soni 1970). The index of Sutherland and Roth of
 * a planar four-bar is sin μ. */
static void best_transmission_angle(void **state) {
  (void)state;
  static const char *const algorithms[] = {"cobyla", "bobyqa", "nelder-mead", "direct"};
  double coupler = sqrt(80.0 * 80.0 + 20.0 * 20.0 - 50.0 * 50.0), angle = acos(20.0 * 80.0 / (coupler * 50.0)), found;
  for (size_t i = 0; i < sizeof algorithms / sizeof *algorithms; ++i) {
    designs d;
    seek_coupler(&d, algorithms[i], 200);
    km_design_study *s = designs_run(&d, NULL, 1);
    int best = best_coupler(s, &found);
    assert_near(found, coupler, 0.01);
    assert_near(designs_result(s, best).figures[0], sin(angle), 1e-4);
    km_design_study_free(s);
  }
}

/* The angle with crank and ground in the same direction must not be nearer to 90 degrees than with a coupler of 68
 * mm: then that coupler is the optimum for every algorithm. Each may evaluate hundreds of designs. */
static void every_algorithm_keeps_limits(void **state) {
  (void)state;
  double cosine = (68.0 * 68.0 + 50.0 * 50.0 - 60.0 * 60.0) / (2.0 * 68.0 * 50.0), limit = sqrt(1.0 - cosine * cosine),
         found;
  for (int i = 0; km_design_algorithm(i); ++i) {
    designs d;
    seek_coupler(&d, km_design_algorithm(i), 400);
    designs_add_figure(&d, "shortest", KM_DESIGN_AT, "sutherland_roth");
    d.figures[1].at = 0.0;
    d.figures[1].high = limit;
    km_design_study *s = designs_run(&d, NULL, 1);
    int best = best_coupler(s, &found);
    assert_near(found, 68.0, 1.0); /* unit 20 mm; the start is 4 mm away */
    assert_true(designs_result(s, best).figures[0] <= limit + 1e-9);
    km_design_study_free(s);
  }
}

/* Points of the curve that the file's own linkage traces. */
static int trace(double points[][3], int room) {
  fixture f = fixture_read(fourbar);
  int frame, count = 0;
  static const char *const path[] = {"coupler", "tip"};
  km_error error;
  km_driver_motion *drive;
  assert_int_equal(km_model_find_frame(f.model, path, 2, &frame, &error), KM_OK);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, true, &drive, &error), KM_OK);
  for (; count < room; ++count) {
    assert_int_equal(km_driver_motion_move_to(drive, 10.0 + 30.0 * count).stop, KM_STOP_NONE);
    km_poses_compute(f.mechanism, f.state);
    km_frame_position(f.mechanism, f.state, frame, points[count]);
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
  return count;
}

/* Path synthesis: from other lengths to those that generated the points. */
static void coupler_curve_through_points(void **state) {
  (void)state;
  enum { POINTS = 12 };
  double points[POINTS][3];
  static const double lengths[] = {20.0, 70.0, 60.0, 25.0};
  static const double steps = 360.0;
  designs d;
  optimise(&d, "mobility", "subplex", 1500);
  add_variable(&d, "crank", 15.0, 28.0, 24.0);
  add_variable(&d, "coupler", 60.0, 80.0, 74.0);
  add_variable(&d, "along", 40.0, 80.0, 50.0);
  add_variable(&d, "up", 0.0, 50.0, 35.0);
  designs_add_figure(&d, "distance", KM_DESIGN_DISTANCE, "coupler/tip");
  designs_set_number(&d, "steps", &steps);
  d.figures[0].point_count = trace(points, POINTS);
  d.figures[0].points = points[0];
  d.optimise.goals[0] = (km_design_goal){"distance", false};
  km_design_study *s = designs_run(&d, NULL, 1);
  double found[4];
  int best = km_design_study_best(s);
  assert_true(best >= 0);
  assert_true(designs_result(s, 0).figures[0] > 3.0);
  /* chords of the curve at every degree are within their sagitta, (1°)²/8 of a radius below 60 mm, of it */
  assert_true(designs_result(s, best).figures[0] < 60.0 * pow(M_PI / 180.0, 2.0) / 8.0);
  assert_int_equal(km_design_study_values(s, best, found, NULL), KM_OK);
  for (int k = 0; k < 4; ++k)
    assert_near(found[k], lengths[k], 0.05);
  km_design_study_free(s);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(best_transmission_angle),
                                     cmocka_unit_test(every_algorithm_keeps_limits),
                                     cmocka_unit_test(coupler_curve_through_points)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
