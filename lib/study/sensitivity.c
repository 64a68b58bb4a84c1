/* Which parameter matters: rank correlations, Sobol's indices, and quantiles along a motion. */
#include "base/check.h"
#include "study/ask.h"
#include "study/sampler.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_BANDED = 10000 };
static const double z = 1.959963984540054;

typedef struct ranked {
  double value;
  int index;
} ranked;

static int by_value(const void *a, const void *b) {
  const ranked *p = a, *q = b;
  return p->value != q->value ? (p->value > q->value) - (p->value < q->value) : p->index - q->index;
}

/* Ranks with ties at their mean. */
static void rank(const double *values, int count, ranked *work, double *ranks) {
  for (int i = 0; i < count; ++i)
    work[i] = (ranked){values[i], i};
  qsort(work, (size_t)count, sizeof *work, by_value);
  for (int i = 0, end; i < count; i = end) {
    for (end = i + 1; end < count && work[end].value == work[i].value;)
      ++end;
    for (int k = i; k < end; ++k)
      ranks[work[k].index] = 0.5 * (i + end - 1);
  }
}

static double correlation_of(const double *a, const double *b, int count) {
  double middle = 0.5 * (count - 1), ab = 0.0, aa = 0.0, bb = 0.0;
  for (int i = 0; i < count; ++i) {
    ab += (a[i] - middle) * (b[i] - middle);
    aa += (a[i] - middle) * (a[i] - middle);
    bb += (b[i] - middle) * (b[i] - middle);
  }
  return aa > 0.0 && bb > 0.0 ? ab / sqrt(aa * bb) : nan("");
}

/* The designs whose figure has a value. */
static int gather(km_design_study *s, int figure, double *figures, int *designs, int count) {
  int used = 0;
  km_design_study_column(s, figure, figures, count);
  for (int i = 0; i < count; ++i)
    if (isfinite(figures[i])) {
      figures[used] = figures[i];
      designs[used++] = i;
    }
  return used;
}

km_status km_design_study_ranks(km_design_study *s, int figure, double *correlation, km_error *error) {
  km_design_statistics unused;
  km_status status = km_check_given(correlation != NULL, "place for the correlations", error);
  if (!status)
    status = km_design_study_statistics(s, figure, &unused, error);
  if (status)
    return status;
  km_arena arena = {0};
  int parameters = s->def->parameter_count, count = km_design_study_column(s, figure, NULL, 0);
  size_t room = (size_t)count + 1;
  double *figures = KM_ARENA_NEW(&arena, double, room), *values = KM_ARENA_NEW(&arena, double, room);
  double *figure_ranks = KM_ARENA_NEW(&arena, double, room), *ranks = KM_ARENA_NEW(&arena, double, room);
  double *table = KM_ARENA_NEW(&arena, double, room *(size_t)(parameters + 1));
  int *designs = KM_ARENA_NEW(&arena, int, room);
  ranked *work = KM_ARENA_NEW(&arena, ranked, room);
  if (arena.failed) {
    km_arena_free(&arena);
    return km_fail(error, KM_MEMORY, "out of memory for rank correlations");
  }
  int used = gather(s, figure, figures, designs, count);
  rank(figures, used, work, figure_ranks);
  for (int i = 0; i < used; ++i)
    km_design_values(s, designs[i], table + (size_t)i * (size_t)parameters);
  for (int p = 0; p < parameters; ++p) {
    for (int i = 0; i < used; ++i) {
      double x = table[(size_t)i * (size_t)parameters + (size_t)p];
      values[i] = isnan(x) ? s->base[p] : x;
    }
    bool known = used > 0 && !isnan(values[0]);
    if (known)
      rank(values, used, work, ranks);
    correlation[p] = known ? correlation_of(figure_ranks, ranks, used) : nan("");
  }
  km_arena_free(&arena);
  return KM_OK;
}

/* Sums over terms, for their mean and its error. */
typedef struct sums {
  double count, sum, squares;
} sums;

static void add(sums *s, double x) {
  s->count += 1.0;
  s->sum += x;
  s->squares += x * x;
}

static double mean_of(const sums *s) {
  return s->sum / s->count;
}

static double half_width(const sums *s) {
  double mean = mean_of(s);
  return z * sqrt(fmax(0.0, s->squares / s->count - mean * mean) / s->count);
}

static km_status add_row(km_design_study *s, int figure, int row, double middle, sums *all, sums *first, sums *total,
                         km_error *error) {
  int spreads = s->def->sample->spread_count, width = spreads + 2;
  double f[KM_MOST_DESIGN_PARAMETERS + 2];
  km_design_result r;
  for (int k = 0; k < width; ++k) {
    km_status status = km_design_study_result(s, row * width + k, &r, error);
    if (status)
      return status;
    f[k] = r.figures[figure] - middle;
  }
  for (int k = 0; k < width; ++k)
    if (!isfinite(f[k]))
      return KM_OK;
  add(all, f[0]);
  add(all, f[1]);
  for (int j = 0; j < spreads; ++j) {
    add(&first[j], f[1] * (f[j + 2] - f[0]));
    add(&total[j], 0.5 * (f[0] - f[j + 2]) * (f[0] - f[j + 2]));
  }
  return KM_OK;
}

km_status km_design_study_indices(km_design_study *s, int figure, double *first, double *first_half_width,
                                  double *total, double *total_half_width, km_error *error) {
  km_design_statistics statistics = {0};
  sums all = {0}, one[KM_MOST_DESIGN_PARAMETERS] = {{0}}, any[KM_MOST_DESIGN_PARAMETERS] = {{0}};
  km_status status = km_check_given(first && first_half_width && total && total_half_width, "place for indices", error);
  if (!status)
    status = km_design_study_statistics(s, figure, &statistics, error);
  if (!status && (!s->def->sample || !s->def->sample->indices))
    status = km_fail(error, KM_USAGE, "the study has no sample with indices; expected \"indices\": true");
  for (int row = 0; !status && row < s->def->sample->count; ++row) /* NOLINT(*NullDereference): asked above */
    status = add_row(s, figure, row, statistics.mean, &all, one, any, error);
  if (status)
    return status;
  double variance = all.squares / all.count - mean_of(&all) * mean_of(&all);
  for (int j = 0; j < s->def->sample->spread_count; ++j) {
    first[j] = mean_of(&one[j]) / variance;
    first_half_width[j] = half_width(&one[j]) / variance;
    total[j] = mean_of(&any[j]) / variance;
    total_half_width[j] = half_width(&any[j]) / variance;
  }
  return KM_OK;
}

static int quantile_row(const double *values, int designs, int rows, int row, double *sorted, double *out) {
  int count = 0;
  for (int i = 0; i < designs; ++i) {
    double x = values[(size_t)i * (size_t)rows + (size_t)row];
    if (isfinite(x))
      sorted[count++] = x;
  }
  qsort(sorted, (size_t)count, sizeof *sorted, km_compare_numbers);
  km_quantiles_of(sorted, count, out);
  return count;
}

/* The band of each design behind the one before. */
static km_status read_bands(km_design_study *s, int question, int band, int designs, double *out, km_error *error) {
  double values[KM_MOST_DESIGN_PARAMETERS];
  int rows = s->band_rows[question];
  km_arena arena = {0};
  km_design_answer *answers = km_design_answers(s, &arena);
  km_status status = answers ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for bands");
  for (int i = 0; i < designs && !status; ++i) {
    bool found;
    km_design_values(s, i, values);
    status = km_design_look_up(s, question, values, &answers[question], &found, error);
    bool there = !status && found && answers[question].outcome <= KM_DESIGN_SHORT; /* NOLINT(*NullDereference): made */
    for (int r = 0; r < rows; ++r)
      out[(size_t)i * (size_t)rows + (size_t)r] = there ? answers[question].bands[band * rows + r] : nan("");
  }
  km_arena_free(&arena);
  return status;
}

km_status km_design_study_bands(km_design_study *s, int question, int band, int *rows, double *quantiles, int *counts,
                                km_error *error) {
  km_status status = km_check_given(s && rows, "study or place for the number of rows", error);
  if (!status)
    status = km_check_index(question, s->def->question_count, "question", error);
  if (!status)
    status = km_check_index(band, s->def->questions[question].band_count, "band", error);
  if (status)
    return status;
  *rows = s->band_rows[question];
  if (!quantiles || !counts)
    return KM_OK;
  int designs = km_design_study_designs(s);
  designs = designs < MOST_BANDED ? designs : MOST_BANDED;
  double *values = KM_NEW(double, (size_t)designs *(size_t)*rows + 1), *sorted = KM_NEW(double, (size_t)designs + 1);
  status = values && sorted ? read_bands(s, question, band, designs, values, error)
                            : km_fail(error, KM_MEMORY, "out of memory for bands");
  for (int r = 0; r < *rows && !status; ++r)
    counts[r] = quantile_row(values, designs, *rows, r, sorted, quantiles + (size_t)r * KM_DESIGN_QUANTILES);
  km_free(values);
  km_free(sorted);
  return status;
}
