/* The batched path step in registers of four doubles. No fused multiply-add is used, so all kernels give the same
 * bits. */
#ifdef KM_LANES_AVX2
#define NAME  km_lanes_step_avx2
#define WIDTH 4
#include "arm/tracking/newton_lanes_body.h"
#else
typedef int km_lanes_avx2_is_empty;
#endif
