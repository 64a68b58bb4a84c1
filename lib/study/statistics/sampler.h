/* The numbers of a sample. Private to study/. */
#ifndef KM_STUDY_STATISTICS_SAMPLER_H
#define KM_STUDY_STATISTICS_SAMPLER_H

#include "study/design_study.h"

#include <stdint.h>

enum { KM_MAX_SOBOL = 40 };

/* How many numbers between 0 and 1 a row of the sample takes: twice as many for Saltelli's two matrices. */
int km_sampler_dimensions(const km_design_sample *sample);
/* Designs of a row, and in all. */
int km_sampler_width(const km_design_sample *sample);
int km_sampler_designs(const km_design_sample *sample);

/* NULL when out of memory. */
km_sampler *km_sampler_create(const km_design_sample *sample);
void km_sampler_free(km_sampler *sampler);
/* The values of design i: of the parameters that spread (or of all, from a list); the others stay. One thread's; going
 * up is fastest. */
void km_sampler_values(km_sampler *sampler, int design, int parameter_count, double *values);

/* u(seed, index, dimension) in (0, 1), each independent of the others. */
double km_random_at(unsigned long seed, uint64_t index, uint64_t dimension);

#endif
