/* The batched path step in registers of eight doubles. No fused multiply-add is used, so all kernels give the same
 * bits. */
#ifdef KM_LANES_AVX512
#define NAME  km_lanes_step_avx512
#define WIDTH 8
#include "arm/tracking/newton_lanes_body.h"
#else
typedef int km_lanes_avx512_is_empty;
#endif
