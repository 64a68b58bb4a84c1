/* Statistics, sensitivity and optimisation of studies, of functions whose answers are known in closed form. */
#include "support/designs.h"

#include "kmech/report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Ishigami and Homma (1990): sin x0 + 7 sin² x1 + 0.1 x2⁴ sin x0, each x uniform in −π … π. */
static km_status ishigami(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = sin(x[0]) + 7.0 * sin(x[1]) * sin(x[1]) + 0.1 * pow(x[2], 4.0) * sin(x[0]);
  return KM_OK;
}

static void spread_evenly(designs *d, int count, double low, double high) {
  for (int p = 0; p < d->def.parameter_count; ++p)
    d->spreads[p] = (km_design_spread){p, KM_UNIFORM, .low = low, .high = high};
  d->sample =
      (km_design_sample){.count = count, .seed = 1, .spreads = d->spreads, .spread_count = d->def.parameter_count};
  d->def.sample = &d->sample;
}

/* V = a²/8 + bπ⁴/5 + b²π⁸/18 + 1/2 and its parts, in the same reference. */
static void indices_of_ishigami(void **state) {
  (void)state;
  designs d;
  double first[3], total[3], wide[2][3], a = 7.0, b = 0.1;
  double v1 = 0.5 * pow(1.0 + b * pow(M_PI, 4.0) / 5.0, 2.0), v2 = a * a / 8.0;
  double v13 = b * b * pow(M_PI, 8.0) * 8.0 / 225.0, v = v1 + v2 + v13;
  designs_of_function(&d, ishigami, 3, 1);
  spread_evenly(&d, 4096, -M_PI, M_PI);
  d.sample.indices = true;
  km_design_study *s = designs_run(&d, NULL, 2);
  assert_int_equal(km_design_study_designs(s), 4096 * 5);
  assert_int_equal(km_design_study_indices(s, 0, first, wide[0], total, wide[1], NULL), KM_OK);
  const double firsts[3] = {v1 / v, v2 / v, 0.0}, totals[3] = {(v1 + v13) / v, v2 / v, v13 / v};
  for (int p = 0; p < 3; ++p) { /* a low-discrepancy sample of 4096 is far within the intervals of a random one */
    assert_near(first[p], firsts[p], 0.01);
    assert_near(total[p], totals[p], 0.01);
    assert_near(first[p], firsts[p], wide[0][p]);
    assert_near(total[p], totals[p], wide[1][p]);
    assert_true(wide[0][p] < 0.1 && wide[1][p] < 0.1);
  }
  km_design_study_free(s);
}

/* Ishigami's function, and its first variable alone, which most designs of a row have in common. */
static km_status ishigami_beside(void *context, const double *x, double *f, km_error *error) {
  f[1] = x[0];
  return ishigami(context, x, f, error);
}

/* Number of `seeds` random samples whose intervals contain the closed-form values: two means, the share above 0, and
 * the total indices of Ishigami's function. */
static void count_intervals(int seeds, int *held) {
  const double v1 = 0.5 * pow(1.0 + 0.1 * pow(M_PI, 4.0) / 5.0, 2.0), v2 = 49.0 / 8.0;
  const double v13 = 0.01 * pow(M_PI, 8.0) * 8.0 / 225.0, v = v1 + v2 + v13;
  const double totals[3] = {(v1 + v13) / v, v2 / v, v13 / v};
  for (int seed = 1; seed <= seeds; ++seed) {
    designs d;
    km_design_statistics st[2];
    km_design_yield y;
    double first[3], total[3], wide[2][3];
    designs_of_function(&d, ishigami_beside, 3, 2);
    d.figures[1].low = 0.0;
    spread_evenly(&d, 200, -M_PI, M_PI);
    d.sample.method = KM_SAMPLING_RANDOM;
    d.sample.seed = (unsigned long)seed;
    d.sample.indices = true;
    km_design_study *s = designs_run(&d, NULL, 1);
    for (int f = 0; f < 2; ++f)
      assert_int_equal(km_design_study_statistics(s, f, &st[f], NULL), KM_OK);
    assert_int_equal(km_design_study_yield(s, &y, NULL), KM_OK);
    assert_int_equal(km_design_study_indices(s, 0, first, wide[0], total, wide[1], NULL), KM_OK);
    held[0] += fabs(st[0].mean - 3.5) <= st[0].mean_half_width;
    held[1] += fabs(st[1].mean) <= st[1].mean_half_width;
    held[2] += y.share_low <= 0.5 && 0.5 <= y.share_high;
    for (int p = 0; p < 3; ++p)
      held[3 + p] += fabs(total[p] - totals[p]) <= wide[1][p];
    km_design_study_free(s);
  }
}

/* Designs of Saltelli's scheme share parameters with others of their row: intervals that take them for independent
 * hold the mean in 65 to 80 % of all samples. */
static void intervals_of_rows(void **state) {
  (void)state;
  enum { SEEDS = 300 };
  int held[6] = {0};
  count_intervals(SEEDS, held);
  for (int i = 0; i < 6; ++i)
    assert_true(held[i] >= SEEDS * 0.95 - 4.0 * sqrt(SEEDS * 0.95 * 0.05));
}

/* Ishigami's function in a unit of 2^exponent. */
static km_status ishigami_in_a_unit(void *context, const double *x, double *f, km_error *error) {
  km_status status = ishigami(NULL, x, f, error);
  f[0] = ldexp(f[0], *(int *)context);
  return status;
}

typedef struct told {
  km_design_statistics st;
  double first[3], first_half[3], total[3], total_half[3], ranks[3];
} told;

static told tell_in_a_unit(int exponent) {
  designs d;
  told t;
  designs_of_function(&d, ishigami_in_a_unit, 3, 1);
  d.def.context = &exponent;
  spread_evenly(&d, 64, -M_PI, M_PI);
  d.sample.indices = true;
  km_design_study *s = designs_run(&d, NULL, 1);
  assert_int_equal(km_design_study_statistics(s, 0, &t.st, NULL), KM_OK);
  assert_int_equal(km_design_study_indices(s, 0, t.first, t.first_half, t.total, t.total_half, NULL), KM_OK);
  assert_int_equal(km_design_study_ranks(s, 0, t.ranks, NULL), KM_OK);
  km_design_study_free(s);
  return t;
}

/* A figure's unit changes no digit of its statistics, and none of what has no unit: squares of numbers above 1e154
 * and below 1e-162 aren't doubles. */
static void no_unit_matters(void **state) {
  (void)state;
  const int exponents[] = {1018, 600, -600, -1000}; /* Ishigami's values are below 2^5 */
  const told base = tell_in_a_unit(0);
  for (int i = 0; i < 4; ++i) {
    const told t = tell_in_a_unit(exponents[i]);
    const double have[] = {t.st.mean,     t.st.deviation,    t.st.mean_half_width, t.st.least,
                           t.st.greatest, t.st.quantiles[0], t.st.quantiles[3],    t.st.quantiles[6]};
    const double want[] = {base.st.mean,     base.st.deviation,    base.st.mean_half_width, base.st.least,
                           base.st.greatest, base.st.quantiles[0], base.st.quantiles[3],    base.st.quantiles[6]};
    for (int k = 0; k < 8; ++k)
      if (!(have[k] == ldexp(want[k], exponents[i])))
        fail_msg("2^%d: number %d is %g, not %g", exponents[i], k, have[k], ldexp(want[k], exponents[i]));
    assert_memory_equal(t.first, base.first, sizeof t.first);
    assert_memory_equal(t.first_half, base.first_half, sizeof t.first);
    assert_memory_equal(t.total, base.total, sizeof t.first);
    assert_memory_equal(t.total_half, base.total_half, sizeof t.first);
    assert_memory_equal(t.ranks, base.ranks, sizeof t.first);
  }
}

/* Figures from one end of what a double holds to the other, the greatest ones last. */
static km_status ends_of_doubles(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  const double t = 2.0 * x[0] - 1.0;
  f[0] = t * 1.7e308;
  f[1] = pow(10.0, -300.0 + 608.0 * x[0]);
  return KM_OK;
}

static void largest_numbers_are_shown(void **state) {
  (void)state;
  designs d;
  km_error error;
  designs_of_function(&d, ends_of_doubles, 1, 2);
  spread_evenly(&d, 200, 0.0, 1.0);
  km_design_study *s = designs_run(&d, NULL, 1);
  for (int f = 0; f < 2; ++f) {
    km_design_statistics st;
    assert_int_equal(km_design_study_statistics(s, f, &st, NULL), KM_OK);
    const double finite[] = {st.mean,     st.deviation,    st.mean_half_width, st.least,
                             st.greatest, st.quantiles[1], st.quantiles[5]};
    for (int k = 0; k < 7; ++k)
      if (!isfinite(finite[k]))
        fail_msg("figure %d: number %d is %g", f, k, finite[k]);
    const km_designs_plot plots[] = {KM_DESIGNS_HISTOGRAM, KM_DESIGNS_CONVERGENCE, KM_DESIGNS_SCATTER};
    for (int k = 0; k < 3; ++k) {
      km_text picture = {0};
      /* Axes end at 1e300: hardly any value of the first figure can be drawn. */
      km_status status = km_designs_picture(s, &d.def, "study", plots[k], f, 0, KM_PICTURE_SVG, &picture, &error);
      if (status && !(f == 0 && status == KM_NO_RESULT))
        fail_msg("picture %d of figure %d: %s", k, f, error.text);
      assert_true(status || (!strstr(picture.data, "nan") && !strstr(picture.data, "inf")));
      km_text_free(&picture);
    }
  }
  km_text table = {0};
  assert_int_equal(km_designs_print(s, &d.def, "study", &table, &error), KM_OK);
  assert_null(strstr(table.data, " - "));
  assert_null(strstr(table.data, "inf"));
  km_text_free(&table);
  km_design_study_free(s);
}

static km_status itself(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0];
  return KM_OK;
}

/* The interval of three normal numbers contains the mean in 95 % of all samples, too; that of a known deviation
 * would in 81 %. */
static void intervals_of_few(void **state) {
  (void)state;
  enum { SEEDS = 600 };
  int held = 0;
  for (int seed = 1; seed <= SEEDS; ++seed) {
    designs d;
    km_design_statistics st;
    designs_of_function(&d, itself, 1, 1);
    spread_evenly(&d, 3, 0.0, 0.0);
    d.spreads[0] = (km_design_spread){0, KM_NORMAL, .mean = 2.0, .deviation = 0.5};
    d.sample.method = KM_SAMPLING_RANDOM;
    d.sample.seed = (unsigned long)seed;
    km_design_study *s = designs_run(&d, NULL, 1);
    assert_int_equal(km_design_study_statistics(s, 0, &st, NULL), KM_OK);
    held += fabs(st.mean - 2.0) <= st.mean_half_width;
    km_design_study_free(s);
  }
  double spread = 4.0 * sqrt(SEEDS * 0.95 * 0.05);
  assert_near(held, SEEDS * 0.95, spread);
}

/* No design of 2 in each of 10 independent rows is good, or all are. */
static void no_good_row(void **state) {
  (void)state;
  designs d;
  km_design_yield y;
  for (int good = 0; good < 2; ++good) {
    designs_of_function(&d, ishigami, 3, 1);
    d.figures[0].low = good ? -1e9 : 1e9;
    spread_evenly(&d, 10, -M_PI, M_PI);
    d.sample.indices = true;
    km_design_study *s = designs_run(&d, NULL, 1);
    assert_int_equal(km_design_study_yield(s, &y, NULL), KM_OK);
    assert_near(y.share_high - y.share_low, 3.841458820694124 / 23.841458820694124, 1e-12);
    km_design_study_free(s);
  }
}

static km_status ranks_function(void *context, const double *x, double *f, km_error *error) {
  (void)context;
  f[0] = exp(3.0 * x[0]);
  f[1] = -x[1] * x[1] * x[1];
  return x[0] > 0.9 ? km_fail(error, KM_DIVERGED, "beyond 0.9") : KM_OK;
}

/* A figure that grows with a parameter, however crookedly, has rank correlation 1. */
static void ranks(void **state) {
  (void)state;
  designs d;
  double correlation[2];
  km_design_yield y;
  designs_of_function(&d, ranks_function, 2, 2);
  d.figures[1].low = -0.125; /* x1 below a half */
  spread_evenly(&d, 4000, 0.0, 1.0);
  km_design_study *s = designs_run(&d, NULL, 1);
  assert_int_equal(km_design_study_ranks(s, 0, correlation, NULL), KM_OK);
  assert_near(correlation[0], 1.0, 1e-12);
  assert_near(correlation[1], 0.0, 4.0 / sqrt(3600.0));
  assert_int_equal(km_design_study_ranks(s, 1, correlation, NULL), KM_OK);
  assert_near(correlation[1], -1.0, 1e-12);
  assert_int_equal(km_design_study_yield(s, &y, NULL), KM_OK);
  assert_near(y.share, 0.45, 4.0 * sqrt(0.45 * 0.55 / 4000.0));
  assert_true(y.share_low < y.share && y.share < y.share_high);
  assert_near(y.share_high - y.share_low, 2.0 * 1.96 * sqrt(0.45 * 0.55 / 4000.0), 1e-4);
  assert_near(y.outcomes[KM_DESIGN_FAULTY], 400.0, 4.0 * sqrt(4000.0 * 0.09));
  assert_string_equal(designs_result(s, 0).reason[0] ? "beyond 0.9" : "", designs_result(s, 0).reason);
  km_design_study_free(s);
}

/* Designs have the same figures, however often and in whatever order they are evaluated. */
static void ranks_of_all_designs(void **state) {
  (void)state;
  designs d;
  double once[2], again[2];
  designs_of_function(&d, ranks_function, 2, 2);
  spread_evenly(&d, 4000, 0.0, 0.9);
  km_design_study *s = designs_run(&d, NULL, 1);
  assert_int_equal(km_design_study_ranks(s, 1, once, NULL), KM_OK);
  assert_near(once[0], 0.0, 4.0 / sqrt(4000.0));
  assert_near(once[1], -1.0, 1e-12);
  assert_int_equal(km_design_study_ranks(s, 0, again, NULL), KM_OK);
  assert_near(again[0], 1.0, 1e-12);
  assert_int_equal(km_design_study_ranks(s, 1, again, NULL), KM_OK);
  assert_memory_equal(once, again, sizeof once);
  km_design_study_free(s);
}

/* Wilson's interval of 0 of 10 is 0 to z²/(n + z²). */
static void no_good_design(void **state) {
  (void)state;
  designs d;
  km_design_yield y;
  designs_of_function(&d, ranks_function, 2, 2);
  d.figures[0].low = 1e9;
  spread_evenly(&d, 10, 0.0, 0.5);
  km_design_study *s = designs_run(&d, NULL, 1);
  assert_int_equal(km_design_study_yield(s, &y, NULL), KM_OK);
  assert_near(y.share_low, 0.0, 0.0);
  assert_near(y.share_high, 3.841458820694124 / 13.841458820694124, 1e-12);
  km_design_study_free(s);
}

static void known_quantiles(void **state) {
  (void)state;
  designs d;
  km_design_statistics st;
  static double list[101][2];
  designs_of_function(&d, ranks_function, 2, 2);
  for (int i = 0; i <= 100; ++i)
    list[i][1] = cbrt((i * 37) % 101);
  d.sample = (km_design_sample){.method = KM_SAMPLING_LIST, .count = 101, .list = list[0]};
  d.def.sample = &d.sample;
  km_design_study *s = designs_run(&d, NULL, 1);
  assert_int_equal(km_design_study_statistics(s, 1, &st, NULL), KM_OK);
  assert_near(st.mean, -50.0, 1e-12);
  assert_near(st.deviation, sqrt(101.0 * 102.0 / 12.0), 1e-10);
  for (int k = 0; k < KM_DESIGN_QUANTILES; ++k)
    assert_near(st.quantiles[k], -100.0 + 100.0 * km_design_quantile(k), 1e-11);
  assert_near(st.least, -100.0, 1e-12);
  assert_near(list[st.least_design][1], cbrt(100.0), 1e-14);
  km_design_study_free(s);
}

static void accurate_enough(void **state) {
  (void)state;
  designs d;
  designs_of_function(&d, ishigami, 3, 1);
  spread_evenly(&d, 1000000, -M_PI, M_PI);
  d.sample.accuracy_figure = "f0";
  d.sample.accuracy = 0.1;
  int designs_asked[2];
  for (int jobs = 1; jobs <= 2; ++jobs) {
    km_design_statistics st;
    km_design_study *s = designs_run(&d, NULL, jobs);
    designs_asked[jobs - 1] = km_design_study_designs(s);
    assert_int_equal(km_design_study_statistics(s, 0, &st, NULL), KM_OK);
    assert_true(st.mean_half_width <= 0.1 && st.mean_half_width > 0.09);
    assert_near(st.mean, 3.5, 0.1);
    km_design_study_free(s);
  }
  assert_int_equal(designs_asked[0], designs_asked[1]);
}

/* A bowl with its bottom at (0.3, −0.2): 1 there. And how far the point is from the origin. */
static km_status bowl(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = 1.0 + pow(x[0] - 0.3, 2.0) + 2.0 * pow(x[1] + 0.2, 2.0) + 0.5 * (x[0] - 0.3) * (x[1] + 0.2);
  f[1] = x[0] + x[1];
  return KM_OK;
}

static void optimise_bowl(designs *d, const char *algorithm) {
  designs_of_function(d, bowl, 2, 2);
  for (int p = 0; p < 2; ++p)
    d->variables[p] = (km_design_variable){p, -1.0, 1.5, nan("")};
  d->optimise = (km_design_optimise){.variables = d->variables,
                                     .variable_count = 2,
                                     .goals = {{"f0", false}},
                                     .goal_count = 1,
                                     .algorithm = algorithm,
                                     .evaluations = 4000,
                                     .tolerance = 1e-5,
                                     .starts = 1,
                                     .seed = 7};
  d->def.optimise = &d->optimise;
}

static void every_algorithm_finds_the_bottom(void **state) {
  (void)state;
  for (int i = 0; km_design_algorithm(i); ++i) {
    designs d;
    double x[2];
    bool rough = strcmp(km_design_algorithm(i), "esch") == 0 || strcmp(km_design_algorithm(i), "isres") == 0;
    optimise_bowl(&d, km_design_algorithm(i));
    km_design_study *s = designs_run(&d, NULL, 1);
    int best = km_design_study_best(s);
    assert_true(best >= 0);
    assert_int_equal(km_design_study_values(s, best, x, NULL), KM_OK);
    assert_near(x[0], 0.3, rough ? 0.1 : 1e-3);
    assert_near(x[1], -0.2, rough ? 0.1 : 1e-3);
    km_design_study_free(s);
  }
}

/* With x0 + x1 ≥ 0.5, the minimum satisfies Lagrange's conditions. */
static void limits_are_constraints(void **state) {
  (void)state;
  static const char *const algorithms[] = {"cobyla", "slsqp", "mma", "bobyqa", "isres"};
  /* a = x0 − 0.3, b = x1 + 0.2, a + b = 0.4: 2a + b/2 = 4b + a/2 gives 1.5 a = 3.5 b */
  double b = 0.4 / (1.0 + 3.5 / 1.5), a = 0.4 - b;
  for (size_t i = 0; i < sizeof algorithms / sizeof *algorithms; ++i) {
    designs d;
    double x[2];
    optimise_bowl(&d, algorithms[i]);
    d.figures[1].low = 0.5;
    km_design_study *s = designs_run(&d, NULL, 1);
    int best = km_design_study_best(s);
    assert_true(best >= 0);
    assert_int_equal(km_design_study_values(s, best, x, NULL), KM_OK);
    double tolerance = strcmp(algorithms[i], "isres") == 0 ? 0.05 : 2e-3;
    assert_near(x[0], 0.3 + a, tolerance);
    assert_near(x[1], -0.2 + b, tolerance);
    assert_true(x[0] + x[1] >= 0.5 - 1e-8);
    km_design_study_free(s);
  }
}

/* Many starts, on any number of threads, evaluate the same designs in the same order. */
static void starts_on_threads(void **state) {
  (void)state;
  designs d;
  double x[2], y[2];
  optimise_bowl(&d, "nelder-mead");
  d.optimise.starts = 5;
  d.optimise.evaluations = 60;
  km_design_study *one = designs_run(&d, NULL, 1), *three = designs_run(&d, NULL, 3);
  assert_int_equal(km_design_study_designs(one), km_design_study_designs(three));
  for (int i = 0; i < km_design_study_designs(one); ++i) {
    assert_int_equal(km_design_study_values(one, i, x, NULL), KM_OK);
    assert_int_equal(km_design_study_values(three, i, y, NULL), KM_OK);
    assert_memory_equal(x, y, sizeof x);
  }
  int computed = km_design_study_computed(one);
  assert_int_equal(km_design_study_lookup(one, NULL), KM_OK);
  assert_int_equal(km_design_study_designs(one), km_design_study_designs(three));
  assert_true(computed > 0);
  km_design_study_free(one);
  km_design_study_free(three);
}

/* x² and (x − 2)²: the front is 0 ≤ x ≤ 2, where √f0 + √f1 = 2 (Schaffer 1985). */
static km_status schaffer(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0] * x[0];
  f[1] = (x[0] - 2.0) * (x[0] - 2.0);
  return KM_OK;
}

static void front_of_schaffer(void **state) {
  (void)state;
  designs d;
  int front[512];
  optimise_bowl(&d, "bobyqa");
  d.def.function = schaffer;
  d.def.parameter_count = d.optimise.variable_count = 1;
  d.variables[0] = (km_design_variable){0, -4.0, 5.0, nan("")};
  d.optimise.goals[1] = (km_design_goal){"f1", false};
  d.optimise.goal_count = 2;
  d.optimise.starts = 7;
  d.optimise.evaluations = 80;
  km_design_study *s = designs_run(&d, NULL, 2);
  int count = km_design_study_front(s, front, 512);
  assert_true(count >= 9 && count <= 512);
  double last = -1.0, gap = 0.0;
  for (int i = 0; i < count; ++i) {
    km_design_result r = designs_result(s, front[i]);
    double x = sqrt(r.figures[0]);
    assert_near(x + sqrt(r.figures[1]), 2.0, 1e-6);
    assert_true(r.figures[0] > last);
    gap = fmax(gap, i ? x - sqrt(last) : x);
    last = r.figures[0];
  }
  assert_true(gap < 0.6); /* seven points between the ends: the front has no large hole */
  km_design_study_free(s);
}

/* The square of a point's distance from the origin, least, and the sum of its coordinates, greatest. */
static km_status disc(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0] * x[0] + x[1] * x[1];
  f[1] = x[0] + x[1];
  return KM_OK;
}

/* In −2 … 2 by −1 … 3 the front is the diagonal, and from (2, 2) the edge up to (2, 3). t is 0 … 1 along it. */
static void on_disc(double t, double out[2]) {
  const double x = fmin(3.0 * t, 2.0), y = 3.0 * t;
  disc(NULL, (const double[]){x, y}, out, NULL);
}

/* Where both goals count from 0 to 1 from end to end, the points that are looked for differ by 2 / 10 in what the
 * first is above the second. One whose limit is kept to 1e-3 is as near to the front. */
static void points_of_front(void **state) {
  (void)state;
  enum { POINTS = 9 };
  static const char *const algorithms[] = {"cobyla", "subplex", "nelder-mead", "bobyqa"};
  for (size_t a = 0; a < sizeof algorithms / sizeof *algorithms; ++a) {
    designs d;
    int front[4400];
    optimise_bowl(&d, algorithms[a]);
    d.def.function = disc;
    d.variables[0] = (km_design_variable){0, -2.0, 2.0, nan("")};
    d.variables[1] = (km_design_variable){1, -1.0, 3.0, nan("")};
    d.optimise.goals[1] = (km_design_goal){"f1", true};
    d.optimise.goal_count = 2;
    d.optimise.starts = POINTS;
    d.optimise.evaluations = 400;
    km_design_study *s = designs_run(&d, NULL, 2);
    int count = km_design_study_front(s, front, 4400);
    for (int i = 1; i <= POINTS; ++i) {
      double low = 0.0, high = 1.0, f[2], nearest = HUGE_VAL;
      for (int step = 0; step < 50; ++step) {
        double t = 0.5 * (low + high);
        on_disc(t, f);
        *(f[0] / 13.0 - (1.0 - f[1] / 5.0) < 2.0 * i / (POINTS + 1) - 1.0 ? &low : &high) = t;
      }
      for (int k = 0; k < count; ++k) {
        km_design_result r = designs_result(s, front[k]);
        nearest = fmin(nearest, fmax(fabs(r.figures[0] - f[0]) / 13.0, fabs(r.figures[1] - f[1]) / 5.0));
      }
      assert_true(nearest < 1e-3);
    }
    km_design_study_free(s);
  }
}

static void bad_definitions(void **state) {
  (void)state;
  designs d;
  km_design_study *s;
  km_error error;
  static const char *const words[] = {"there is no algorithm \"cobyl\"; the nearest ones are \"cobyla\"",
                                      "found bounds [1.5, -1]; expected low < high",
                                      "there is no figure \"f9\"",
                                      "found 0 evaluations",
                                      "found bounds [1, 1]",
                                      "found 0; expected 1 to",
                                      "found mean 0 and deviation 0",
                                      "are the same number",
                                      "found 2 of variants"};
  for (int i = 0; i < 9; ++i) {
    optimise_bowl(&d, i == 0 ? "cobyl" : "cobyla");
    if (i == 1)
      d.variables[0] = (km_design_variable){0, 1.5, -1.0, nan("")};
    if (i == 2)
      d.optimise.goals[0].figure = "f9";
    if (i == 3)
      d.optimise.evaluations = 0;
    if (i >= 4 && i <= 6) {
      d.def.optimise = NULL;
      spread_evenly(&d, i == 5 ? 0 : 10, i == 4 ? 1.0 : 0.0, 1.0);
    }
    if (i == 6)
      d.spreads[0].distribution = KM_NORMAL;
    if (i == 7)
      d.parameters[1].path = "x0";
    if (i == 8)
      d.def.sample = &d.sample;
    assert_int_equal(km_design_study_open(&d.def, NULL, false, &s, &error), KM_USAGE);
    if (!strstr(error.text, words[i]))
      fail_msg("case %d: %s", i, error.text);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(
          indices_of_ishigami,
          "Sobol's indices of Ishigami's function, first order and total (Ishigami and Homma, 1990)",
          "an error of 0.01 from 4096 low-discrepancy samples, well below a random sample's confidence interval"),
      cmocka_unit_test(intervals_of_rows),
      cmocka_unit_test(intervals_of_few),
      cmocka_unit_test(no_unit_matters),
      cmocka_unit_test(largest_numbers_are_shown),
      cmocka_unit_test(no_good_row),
      cmocka_unit_test(ranks),
      cmocka_unit_test(ranks_of_all_designs),
      cmocka_unit_test(no_good_design),
      cmocka_unit_test(known_quantiles),
      cmocka_unit_test(accurate_enough),
      cmocka_unit_test(every_algorithm_finds_the_bottom),
      cmocka_unit_test(limits_are_constraints),
      cmocka_unit_test(starts_on_threads),
      cmocka_unit_test(front_of_schaffer),
      cmocka_unit_test(points_of_front),
      cmocka_unit_test(bad_definitions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
