/* Parameter values of a sample's designs. Private to study/. */
#ifndef KM_STUDY_STATISTICS_SAMPLER_H
#define KM_STUDY_STATISTICS_SAMPLER_H

#include "study/design_study.h"

#include <stdint.h>

enum { KM_MAX_SOBOL = 40 };

/* Dimensions of a row of the sample in the unit cube; twice as many for Saltelli's two matrices. */
int km_sampler_dimensions(const km_design_sample *sample);
/* Number of designs of a row; km_sampler_designs: in total. */
int km_sampler_width(const km_design_sample *sample);
int km_sampler_designs(const km_design_sample *sample);

/* Creates a sampler; NULL: out of memory. */
km_sampler *km_sampler_create(const km_design_sample *sample);
void km_sampler_free(km_sampler *sampler);
/* Sets the values of a design's sampled parameters (of all, for a list); other values are unchanged. Not
 * thread-safe; ascending order is fastest. */
void km_sampler_values(km_sampler *sampler, int design, int parameter_count, double *values);

/* Pseudo-random number u(seed, index, dimension) in (0, 1). */
double km_random_at(unsigned long seed, uint64_t index, uint64_t dimension);

#endif
