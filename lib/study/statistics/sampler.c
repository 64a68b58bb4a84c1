/* Samples: points of the unit cube by number, and parameter values by quantiles of their distributions
 * (docs/theory.md 13.2).
 *
 *   random: SplitMix64 hash of (seed, i, d)     Latin hypercube: (π_d(i) + u)/n, π_d a Feistel permutation
 *   Sobol : Sobol's sequence, shifted modulo 1 by a hash of the seed
 *
 * Any design is computed without those before it. */
#include "study/statistics/sampler.h"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_qrng.h>
#include <math.h>

struct km_sampler {
  const km_design_sample *sample;
  int dimensions;
  gsl_qrng *sequence; /* Sobol's sequence */
  int next;           /* next row of the sequence */
  int row;            /* row in `point`; −1: none */
  double point[2 * KM_MAX_DESIGN_PARAMETERS];
};

int km_sampler_dimensions(const km_design_sample *s) {
  return s->spread_count * (s->indices ? 2 : 1);
}

int km_sampler_width(const km_design_sample *s) {
  return s->indices ? s->spread_count + 2 : 1;
}

int km_sampler_designs(const km_design_sample *s) {
  return s->count * km_sampler_width(s);
}

static uint64_t mix(uint64_t z) {
  z += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

static uint64_t hash(unsigned long seed, uint64_t index, uint64_t dimension) {
  return mix(mix(mix(seed) ^ index) ^ dimension);
}

double km_random_at(unsigned long seed, uint64_t index, uint64_t dimension) {
  return ((double)(hash(seed, index, dimension) >> 11) + 0.5) * 0x1p-53;
}

/* Permutation of 0 … count − 1 by a key: a Feistel network on the next power of 4, iterated until the result is in
 * range. */
static uint64_t permutation(uint64_t i, uint64_t count, uint64_t key) {
  unsigned half = 1;
  while (count > (uint64_t)1 << (2 * half))
    ++half;
  uint64_t mask = ((uint64_t)1 << half) - 1;
  do {
    uint64_t left = i >> half, right = i & mask;
    for (uint64_t round = 0; round < 4; ++round) {
      uint64_t next = left ^ (mix(key + round * 0x632BE59BD9B4E019u + right) & mask);
      left = right;
      right = next;
    }
    i = left << half | right;
  } while (i >= count);
  return i;
}

km_sampler *km_sampler_create(const km_design_sample *sample) {
  km_sampler *s = KM_NEW(km_sampler, 1);
  if (!s)
    return NULL;
  *s = (km_sampler){.sample = sample, .dimensions = km_sampler_dimensions(sample), .row = -1};
  if (sample->method == KM_SAMPLING_SOBOL)
    s->sequence = gsl_qrng_alloc(gsl_qrng_sobol, (unsigned)s->dimensions);
  if (sample->method == KM_SAMPLING_SOBOL && !s->sequence) {
    km_free(s);
    return NULL;
  }
  return s;
}

void km_sampler_free(km_sampler *s) {
  if (!s)
    return;
  if (s->sequence)
    gsl_qrng_free(s->sequence);
  km_free(s);
}

/* Point of Sobol's sequence, shifted modulo 1 by a hash of the seed. */
static void compute_sobol_row(km_sampler *s, int row) {
  if (row < s->next) {
    gsl_qrng_init(s->sequence);
    s->next = 0;
  }
  for (; s->next <= row; ++s->next)
    gsl_qrng_get(s->sequence, s->point);
  for (int d = 0; d < s->dimensions; ++d) {
    double u = s->point[d] + km_random_at(s->sample->seed, UINT64_MAX, (uint64_t)d);
    u -= floor(u);
    s->point[d] = u > 0.0 ? u : 0x1p-54;
  }
}

/* Point of the unit cube for a row. */
static void compute_row(km_sampler *s, int row) {
  const km_design_sample *sample = s->sample;
  if (row == s->row)
    return;
  s->row = row;
  if (sample->method == KM_SAMPLING_SOBOL) {
    compute_sobol_row(s, row);
    return;
  }
  for (int d = 0; d < s->dimensions; ++d) {
    double u = km_random_at(sample->seed, (uint64_t)row, (uint64_t)d);
    if (sample->method == KM_SAMPLING_LATIN) {
      uint64_t key = hash(sample->seed, UINT64_MAX - 1, (uint64_t)d);
      u = ((double)permutation((uint64_t)row, (uint64_t)sample->count, key) + u) / sample->count;
    }
    s->point[d] = u;
  }
}

/* Quantile u of a truncated normal distribution; uses the smaller tail for accuracy. */
static double truncated_normal(const km_design_spread *s, double u) {
  double a = (s->low - s->mean) / s->deviation, b = (s->high - s->mean) / s->deviation, z;
  if (a > 0.0)
    z = gsl_cdf_ugaussian_Qinv((1.0 - u) * gsl_cdf_ugaussian_Q(a) + u * gsl_cdf_ugaussian_Q(b));
  else
    z = gsl_cdf_ugaussian_Pinv((1.0 - u) * gsl_cdf_ugaussian_P(a) + u * gsl_cdf_ugaussian_P(b));
  return fmin(s->high, fmax(s->low, s->mean + s->deviation * z));
}

static double quantile(const km_design_spread *s, double u) {
  if (s->distribution == KM_UNIFORM)
    return s->low + (s->high - s->low) * u;
  return s->distribution == KM_NORMAL ? s->mean + s->deviation * gsl_cdf_ugaussian_Pinv(u) : truncated_normal(s, u);
}

/* Parameter values of a design: quantiles of its point; with indices, Saltelli's exchanged columns. */
void km_sampler_values(km_sampler *s, int design, int parameter_count, double *values) {
  const km_design_sample *sample = s->sample;
  int spreads = sample->spread_count;
  if (sample->method == KM_SAMPLING_LIST) {
    for (int p = 0; p < parameter_count; ++p)
      values[p] = sample->list[(size_t)design * (size_t)parameter_count + (size_t)p];
    return;
  }
  int width = km_sampler_width(sample), part = design % width;
  compute_row(s, design / width);
  for (int k = 0; k < spreads; ++k) /* Saltelli's scheme: A, B, then A with one column of B */
    values[sample->spreads[k].parameter] =
        quantile(&sample->spreads[k], s->point[part == 1 || part == k + 2 ? spreads + k : k]);
}
