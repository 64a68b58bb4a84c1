/* Batch step with registers of four doubles. No fused multiply-add: results have the bits of the other widths. */
#ifdef KM_LANES_AVX2
#define NAME  km_batch_step_avx2
#define WIDTH 4
#include "continuation/batch/step_body.h"
#else
typedef int km_lanes_avx2_is_empty;
#endif
