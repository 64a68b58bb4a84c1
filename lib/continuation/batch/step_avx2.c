/* The same lanes in registers of four doubles. No fused multiply-add: the bits stay the same. */
#ifdef KM_LANES_AVX2
#define NAME  km_batch_step_avx2
#define WIDTH 4
#include "continuation/batch/step_body.h"
#else
typedef int km_lanes_avx2_is_empty;
#endif
