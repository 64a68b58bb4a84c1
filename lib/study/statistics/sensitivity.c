/* Sensitivity of figures to parameters: Spearman's rank correlations, Sobol indices, and quantiles of bands
 * (docs/theory.md 13.4 and 13.5).
 *
 *   S_j = mean(f_B (f_ABj − f_A))/V,   T_j = mean((f_A − f_ABj)²)/(2 V)   (Saltelli 2010, Jansen 1999) */
#include "base/arguments.h"
#include "base/statistics/student_t.h"
#include "study/design_evaluation.h"
#include "study/statistics/sampler.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_BANDED = 10000 };

typedef struct ranked {
  double value;
  int index;
} ranked;

static int compare_values(const void *a, const void *b) {
  const ranked *p = a, *q = b;
  return p->value != q->value ? (p->value > q->value) - (p->value < q->value) : p->index - q->index;
}

/* Ranks; ties get their mean rank. */
static void rank(const double *values, int count, ranked *work, double *ranks) {
  for (int i = 0; i < count; ++i)
    work[i] = (ranked){values[i], i};
  qsort(work, (size_t)count, sizeof *work, compare_values);
  for (int i = 0, end; i < count; i = end) {
    for (end = i + 1; end < count && work[end].value == work[i].value;)
      ++end;
    for (int k = i; k < end; ++k)
      ranks[work[k].index] = 0.5 * (i + end - 1);
  }
}

/* Pearson's correlation of two lists of ranks. */
static double correlation_of(const double *a, const double *b, int count) {
  double middle = 0.5 * (count - 1), ab = 0.0, aa = 0.0, bb = 0.0;
  for (int i = 0; i < count; ++i) {
    ab += (a[i] - middle) * (b[i] - middle);
    aa += (a[i] - middle) * (a[i] - middle);
    bb += (b[i] - middle) * (b[i] - middle);
  }
  return aa > 0.0 && bb > 0.0 ? ab / sqrt(aa * bb) : nan("");
}

struct km_ranking {
  km_arena arena;
  int count;                                   /* designs */
  double *values;                              /* [parameters × count] values; NaN: unknown */
  double *ranks;                               /* [parameters × count] ranks among all designs */
  double *correlations[KM_MAX_DESIGN_FIGURES]; /* [parameters] NULL: not computed yet */
  /* Work arrays: */
  ranked *work;
  double *part, *part_ranks, *figures, *figure_ranks;
  int *designs;
};

void km_ranking_free(km_ranking *r) {
  if (r)
    km_arena_free(&r->arena);
  km_free(r);
}

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for rank correlations");
}

/* Allocates the ranks of all parameters. */
static km_ranking *create_ranking(int parameters, int count) {
  km_ranking *r = KM_NEW(km_ranking, 1);
  size_t capacity = (size_t)count + 1, table = (size_t)parameters * capacity;
  if (!r)
    return NULL;
  r->count = count;
  r->values = KM_ARENA_NEW(&r->arena, double, table);
  r->ranks = KM_ARENA_NEW(&r->arena, double, table);
  r->work = KM_ARENA_NEW(&r->arena, ranked, capacity);
  double **columns[] = {&r->part, &r->part_ranks, &r->figures, &r->figure_ranks};
  for (size_t i = 0; i < sizeof columns / sizeof *columns; ++i)
    *columns[i] = KM_ARENA_NEW(&r->arena, double, capacity);
  r->designs = KM_ARENA_NEW(&r->arena, int, capacity);
  if (!r->arena.failed)
    return r;
  km_ranking_free(r);
  return NULL;
}

/* Computes the ranks of the parameters of the representative designs. */
static void rank_parameters(const km_design_study *s, km_ranking *r) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  int parameters = s->def->parameter_count;
  size_t count = (size_t)r->count;
  for (size_t i = 0; i < count; ++i) {
    km_design_values(s, km_design_representative(s, (int)i, r->count), values);
    for (int p = 0; p < parameters; ++p)
      r->values[(size_t)p * count + i] = isnan(values[p]) ? s->base[p] : values[p];
  }
  for (int p = 0; p < parameters; ++p)
    rank(r->values + (size_t)p * count, r->count, r->work, r->ranks + (size_t)p * count);
}

/* Collects the designs whose figure has a value; returns their number. */
static int collect_values(km_design_study *s, int figure, km_ranking *r) {
  int used = 0;
  km_design_study_column(s, figure, r->figures, r->count);
  for (int i = 0; i < r->count; ++i)
    if (isfinite(r->figures[i])) {
      r->figures[used] = r->figures[i];
      r->designs[used++] = i;
    }
  return used;
}

/* Ranks of parameter p among the collected designs; NULL: its value is unknown. */
static const double *ranks_of(const km_ranking *r, int p, int used) {
  const double *values = r->values + (size_t)p * (size_t)r->count;
  if (used == 0 || isnan(values[r->designs[0]]))
    return NULL;
  if (used == r->count)
    return r->ranks + (size_t)p * (size_t)r->count;
  for (int i = 0; i < used; ++i)
    r->part[i] = values[r->designs[i]];
  rank(r->part, used, r->work, r->part_ranks);
  return r->part_ranks;
}

/* Rank correlations of one figure with all parameters. */
static void correlate(km_design_study *s, int figure, km_ranking *r, double *correlations) {
  int used = collect_values(s, figure, r);
  rank(r->figures, used, r->work, r->figure_ranks);
  for (int p = 0; p < s->def->parameter_count; ++p) {
    const double *ranks = ranks_of(r, p, used);
    correlations[p] = ranks ? correlation_of(r->figure_ranks, ranks, used) : nan("");
  }
}

km_status km_design_study_ranks(km_design_study *s, int figure, double *correlation, km_error *error) {
  km_design_statistics unused;
  km_status status = km_check_given(correlation != NULL, "place for the correlations", error);
  if (!status)
    status = km_design_study_statistics(s, figure, &unused, error);
  if (status)
    return status;
  size_t parameters = (size_t)s->def->parameter_count;
  km_ranking *r = s->ranking;
  if (!r) {
    r = s->ranking = create_ranking((int)parameters, km_design_study_column(s, figure, NULL, 0));
    if (!r)
      return no_memory(error);
    rank_parameters(s, r);
  }
  if (!r->correlations[figure]) {
    double *found = KM_ARENA_NEW(&r->arena, double, parameters + 1);
    if (!found)
      return no_memory(error);
    correlate(s, figure, r, found);
    r->correlations[figure] = found;
  }
  memcpy(correlation, r->correlations[figure], parameters * sizeof *correlation);
  return KM_OK;
}

/* Sums over rows of the terms t of an index and of the variance v. */
typedef struct sums {
  double term, terms, both; /* Σ t, Σ t², Σ t v */
} sums;

typedef struct index_sums {
  double rows, value, squares, variances; /* rows; Σ x and Σ x² of the two independent designs of each; Σ v² */
  sums first[KM_MAX_DESIGN_PARAMETERS], total[KM_MAX_DESIGN_PARAMETERS];
} index_sums;

static void add(sums *s, double term, double variance) {
  s->term += term;
  s->terms += term * term;
  s->both += term * variance;
}

/* Adds a row. Values are centred at the mean and scaled by 2^exponent, so that fourth powers neither overflow nor
 * vanish and no index depends on the unit. */
static km_status add_row(km_design_study *s, int figure, int row, double middle, int exponent, index_sums *out,
                         km_error *error) {
  int spreads = s->def->sample->spread_count, width = km_sampler_width(s->def->sample);
  double f[KM_MAX_DESIGN_PARAMETERS + 2];
  km_design_result r;
  for (int k = 0; k < width; ++k) {
    km_status status = km_design_study_result(s, row * width + k, &r, error);
    if (status)
      return status;
    f[k] = ldexp(r.figures[figure], -exponent) - ldexp(middle, -exponent);
  }
  for (int k = 0; k < width; ++k)
    if (!isfinite(f[k]))
      return KM_OK;
  double squares = f[0] * f[0] + f[1] * f[1], variance = 0.5 * squares;
  out->rows += 1.0;
  out->value += f[0] + f[1];
  out->squares += squares;
  out->variances += variance * variance;
  for (int j = 0; j < spreads; ++j) {
    add(&out->first[j], f[1] * (f[j + 2] - f[0]), variance);
    add(&out->total[j], 0.5 * (f[0] - f[j + 2]) * (f[0] - f[j + 2]), variance);
  }
  return KM_OK;
}

/* Index and half width. The error of a ratio of means of t and v is that of the mean of t − ratio · v over the mean
 * of v (W. Cochran 1977, chapter 6). */
static void set_index(const sums *s, const index_sums *all, double *index, double *half_width) {
  double mean = all->value / (2.0 * all->rows), variance = all->squares / (2.0 * all->rows) - mean * mean;
  bool is_defined = all->rows > 1.0 && variance > 0.0;
  double i = s->term / all->rows / variance;
  double squares = fmax(0.0, s->terms - 2.0 * i * s->both + i * i * all->variances);
  *index = is_defined ? i : nan("");
  double error = sqrt(squares / all->rows / (all->rows - 1.0)) / variance;
  *half_width = is_defined ? km_student(all->rows - 1.0) * error : nan("");
}

km_status km_design_study_indices(km_design_study *s, int figure, double *first, double *first_half_width,
                                  double *total, double *total_half_width, km_error *error) {
  km_design_statistics statistics = {0};
  index_sums all = {0};
  km_status status = km_check_given(first && first_half_width && total && total_half_width, "place for indices", error);
  if (!status)
    status = km_design_study_statistics(s, figure, &statistics, error);
  if (!status && (!s->def->sample || !s->def->sample->indices))
    status = km_fail(error, KM_USAGE, "the study has no sample with indices; expected \"indices\": true");
  double size = fmax(fabs(statistics.least), fabs(statistics.greatest));
  int exponent = size > 0.0 ? ilogb(size) : 0;
  for (int row = 0; !status && row < s->def->sample->count; ++row) /* NOLINT(*NullDereference): checked above */
    status = add_row(s, figure, row, statistics.mean, exponent, &all, error);
  if (status)
    return status;
  for (int j = 0; j < s->def->sample->spread_count; ++j) {
    set_index(&all.first[j], &all, &first[j], &first_half_width[j]);
    set_index(&all.total[j], &all, &total[j], &total_half_width[j]);
  }
  return KM_OK;
}

/* Quantiles of one row of a band over all designs. */
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

/* Reads a band of all designs, one after the other. */
static km_status read_bands(km_design_study *s, int question, int band, int designs, double *out, km_error *error) {
  double values[KM_MAX_DESIGN_PARAMETERS];
  int rows = s->band_rows[question];
  km_arena arena = {0};
  km_design_answer *answers = km_design_answers(s, &arena);
  km_status status = answers ? KM_OK : km_fail(error, KM_MEMORY, "out of memory for bands");
  for (int i = 0; i < designs && !status; ++i) {
    bool found;
    km_design_values(s, km_design_representative(s, i, designs), values);
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
  designs = designs < MAX_BANDED ? designs : MAX_BANDED;
  double *values = KM_NEW(double, (size_t)designs *(size_t)*rows + 1), *sorted = KM_NEW(double, (size_t)designs + 1);
  status = values && sorted ? read_bands(s, question, band, designs, values, error)
                            : km_fail(error, KM_MEMORY, "out of memory for bands");
  for (int r = 0; r < *rows && !status; ++r)
    counts[r] = quantile_row(values, designs, *rows, r, sorted, quantiles + (size_t)r * KM_DESIGN_QUANTILES);
  km_free(values);
  km_free(sorted);
  return status;
}
