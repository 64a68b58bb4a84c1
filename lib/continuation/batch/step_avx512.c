/* Batch step with registers of eight doubles. No fused multiply-add: results have the bits of the other widths. */
#ifdef KM_LANES_AVX512
#define NAME  km_batch_step_avx512
#define WIDTH 8
#include "continuation/batch/step_body.h"
#else
typedef int km_lanes_avx512_is_empty;
#endif
