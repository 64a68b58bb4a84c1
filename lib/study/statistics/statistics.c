/* Statistics of a study's results: moments, quantiles, yield. One pass over the store, cached until the next run
 * (docs/theory.md 13.3). */
#include "base/arguments.h"
#include "base/statistics/running_moments.h"
#include "base/statistics/student_t.h"
#include "study/design_evaluation.h"
#include "study/optimisation/goals.h"
#include "study/statistics/mean_uncertainty.h"
#include "study/statistics/sampler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double probabilities[KM_DESIGN_QUANTILES] = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};
static const double z = 1.959963984540054; /* 0.975 quantile of the normal distribution */

struct km_statistics_cache {
  km_design_yield yield;
  km_design_statistics figures[KM_MAX_DESIGN_FIGURES];
  km_moments moments[KM_MAX_DESIGN_FIGURES];
  km_rows rows[KM_MAX_DESIGN_FIGURES]; /* row sums of the figures, scaled as the moments */
  km_rows good_rows;                   /* row sums of 1 for an accepted design, else 0 */
  double *representatives;             /* [figures × kept_count] values of the representative designs */
  int representative_count, representatives_so_far;
};

double km_design_quantile(int k) {
  return k >= 0 && k < KM_DESIGN_QUANTILES ? probabilities[k] : nan("");
}

int km_compare_numbers(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

void km_quantiles_of(const double *sorted, int count, double out[KM_DESIGN_QUANTILES]) {
  for (int k = 0; k < KM_DESIGN_QUANTILES; ++k) {
    double at = probabilities[k] * (count - 1);
    int i = (int)at;
    double next = i + 1 < count ? sorted[i + 1] : 0.0; /* halved, because the difference of two large numbers can
                                                        * overflow */
    out[k] = count == 0      ? nan("")
             : i + 1 < count ? 2.0 * (0.5 * sorted[i] + (at - i) * (0.5 * next - 0.5 * sorted[i]))
                             : sorted[count - 1];
  }
}

void km_design_free_statistics(km_design_study *s) {
  if (s->collected)
    km_free(s->collected->representatives);
  km_free(s->collected);
  km_ranking_free(s->ranking);
  s->collected = NULL;
  s->ranking = NULL;
}

/* Adds a value of a figure to moments, row sums and extremes. */
static void add_value(km_statistics_cache *c, const km_design_study *s, int f, int design, double x) {
  km_design_statistics *st = &c->figures[f];
  if (!isfinite(x))
    return;
  ++st->count;
  km_rows_scale(&c->rows[f], km_moments_add(&c->moments[f], x));
  km_rows_add(&c->rows[f], km_moments_scaled(&c->moments[f], x));
  st->good += km_design_is_within(s->figures[f], x);
  if (st->count == 1 || x < st->least) {
    st->least = x;
    st->least_design = design;
  }
  if (st->count == 1 || x > st->greatest) {
    st->greatest = x;
    st->greatest_design = design;
  }
}

/* Adds the result of a design to yield and figures. */
static void add_design(km_statistics_cache *c, const km_design_study *s, int design, const km_design_result *r) {
  c->yield.outcomes[r->outcome]++;
  if (r->outcome != KM_DESIGN_MISSING) {
    bool good = km_design_study_accepts(s, r);
    c->yield.count++;
    c->yield.good += good;
    km_rows_add(&c->good_rows, good);
  }
  bool is_representative = c->representatives_so_far < c->representative_count &&
                           design == km_design_representative(s, c->representatives_so_far, c->representative_count);
  for (int f = 0; f < s->figure_count; ++f) {
    add_value(c, s, f, design, r->figures[f]);
    if (is_representative)
      c->representatives[(size_t)f * (size_t)c->representative_count + (size_t)c->representatives_so_far] =
          r->figures[f];
  }
  c->representatives_so_far += is_representative;
}

/* Wilson's interval of a share, valid also if few designs fail (E. Wilson 1927). At most two designs of each row
 * count as independent, because a few failures don't determine the design effect. */
static void wilson(km_design_yield *y, const km_rows *rows) {
  double n = y->count, p = n > 0.0 ? y->good / n : nan("");
  n /= fmax(km_rows_effect(rows, n * p * (1.0 - p)), 0.5 * rows->width);
  double middle = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
  double half = z * sqrt(p * (1.0 - p) / n + z * z / (4.0 * n * n)) / (1.0 + z * z / n);
  y->share = p;
  y->share_low = y->good == 0 ? 0.0 : fmax(0.0, middle - half);
  y->share_high = y->good == y->count ? 1.0 : fmin(1.0, middle + half);
}

/* Quantiles, mean, deviation and half width t s/√n_e of a figure. */
static void finish_figure(km_statistics_cache *c, int f, double *sorted) {
  km_design_statistics *st = &c->figures[f];
  const double *column = c->representatives + (size_t)f * (size_t)c->representative_count;
  int count = 0;
  for (int i = 0; i < c->representative_count; ++i)
    if (isfinite(column[i]))
      sorted[count++] = column[i];
  qsort(sorted, (size_t)count, sizeof *sorted, km_compare_numbers);
  km_quantiles_of(sorted, count, st->quantiles);
  st->mean = km_moments_mean(&c->moments[f]);
  st->deviation = km_moments_deviation(&c->moments[f]);
  double effect = km_rows_effect(&c->rows[f], c->moments[f].squares);
  double independent = st->count / effect;
  st->mean_half_width = st->count > 1 ? km_student(independent - 1.0) * (st->deviation / sqrt(independent)) : nan("");
  if (st->count == 0)
    st->mean = st->least = st->greatest = nan("");
}

static void set_rows(km_statistics_cache *c, const km_design_study *s) {
  c->good_rows.width = s->def->sample ? km_sampler_width(s->def->sample) : 1;
  for (int f = 0; f < s->figure_count; ++f)
    c->rows[f].width = c->good_rows.width;
}

static void end_row(km_statistics_cache *c, const km_design_study *s) {
  km_rows_next(&c->good_rows);
  for (int f = 0; f < s->figure_count; ++f)
    km_rows_next(&c->rows[f]);
}

/* One pass over all results: yields, moments, row sums, representative values. */
static km_status collect(km_design_study *s, km_error *error) {
  int designs = km_design_study_designs(s);
  km_statistics_cache *c = KM_NEW(km_statistics_cache, 1);
  double *sorted = NULL;
  km_design_result r;
  if (!c)
    return km_fail(error, KM_MEMORY, "out of memory for statistics");
  s->collected = c;
  c->representative_count = designs < KM_MAX_RANKED_DESIGNS ? designs : KM_MAX_RANKED_DESIGNS;
  c->representatives = KM_NEW(double, (size_t)c->representative_count *(size_t)s->figure_count + 1);
  sorted = KM_NEW(double, (size_t)c->representative_count + 1);
  for (int f = 0; f < s->figure_count; ++f)
    c->figures[f].least_design = c->figures[f].greatest_design = -1;
  set_rows(c, s);
  km_status status = c->representatives && sorted ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for statistics");
  for (int i = 0; i < designs && !status; ++i) {
    status = km_design_study_result(s, i, &r, error);
    if (!status)
      add_design(c, s, i, &r);
    if ((i + 1) % (int)c->good_rows.width == 0)
      end_row(c, s);
  }
  for (int f = 0; f < s->figure_count && !status; ++f)
    finish_figure(c, f, sorted);
  wilson(&c->yield, &c->good_rows);
  km_free(sorted);
  if (status)
    km_design_free_statistics(s);
  return status;
}

static km_status require_statistics(km_design_study *s, int figure, km_error *error) {
  km_status status = km_check_given(s != NULL, "study", error);
  if (!status)
    status = km_check_index(figure, s->figure_count, "figure", error);
  return status || s->collected ? status : collect(s, error);
}

km_status km_design_study_statistics(km_design_study *s, int figure, km_design_statistics *out, km_error *error) {
  km_status status = km_check_given(out != NULL, "place for the statistics", error);
  if (!status)
    status = require_statistics(s, figure, error);
  if (!status)
    *out = s->collected->figures[figure];
  return status;
}

km_status km_design_study_yield(km_design_study *s, km_design_yield *out, km_error *error) {
  km_status status = km_check_given(s && out, "study or place for the yield", error);
  if (!status && !s->collected)
    status = collect(s, error);
  if (!status)
    *out = s->collected->yield;
  return status;
}

bool km_design_study_is_complete(km_design_study *s) {
  km_design_yield y;
  return !km_design_study_yield(s, &y, NULL) && y.outcomes[KM_DESIGN_MISSING] == 0 && !s->ended_early;
}

int km_design_study_column(km_design_study *s, int figure, double *values, int capacity) {
  if (require_statistics(s, figure, NULL))
    return 0;
  const km_statistics_cache *c = s->collected;
  int count = c->representative_count < capacity ? c->representative_count : capacity;
  if (values && count > 0)
    memcpy(values, c->representatives + (size_t)figure * (size_t)c->representative_count,
           (size_t)count * sizeof *values);
  return c->representative_count;
}
