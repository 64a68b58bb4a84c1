/* The lanes for every processor, and the choice between them and those with wider registers. */
#define NAME  km_lanes_reach_plain
#define WIDTH 2
#include "arm/lanes_body.h"

#ifdef KM_LANES_AVX2
unsigned km_lanes_reach_avx2(const km_arm *arm, const km_pose *target, const double *xi, km_lanes *lanes);
#endif
#ifdef KM_LANES_AVX512
unsigned km_lanes_reach_avx512(const km_arm *arm, const km_pose *target, const double *xi, km_lanes *lanes);
#endif

unsigned km_lanes_reach(const km_arm *a, const km_pose *target, const double *xi, km_lanes *lanes) {
#ifdef KM_LANES_AVX512
  if (lanes->used >> 4 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return km_lanes_reach_avx512(a, target, xi, lanes);
#endif
#ifdef KM_LANES_AVX2
  if (__builtin_cpu_supports("avx2"))
    return km_lanes_reach_avx2(a, target, xi, lanes);
#endif
  return km_lanes_reach_plain(a, target, xi, lanes);
}
