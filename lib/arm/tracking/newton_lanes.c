/* Baseline kernel of the batched path step (newton_lanes_body.h), and the choice of the kernel with the widest
 * registers that the processor has. */
#define NAME  km_lanes_step_plain
#define WIDTH 2
#include "arm/tracking/newton_lanes_body.h"

#ifdef KM_LANES_AVX2
unsigned km_lanes_step_avx2(const km_arm *arm, km_lanes *lanes);
#endif
#ifdef KM_LANES_AVX512
unsigned km_lanes_step_avx512(const km_arm *arm, km_lanes *lanes);
#endif

unsigned km_lanes_step(const km_arm *a, km_lanes *lanes) {
#ifdef KM_LANES_AVX512
  if (lanes->used >> 4 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq"))
    return km_lanes_step_avx512(a, lanes);
#endif
#ifdef KM_LANES_AVX2
  if (__builtin_cpu_supports("avx2"))
    return km_lanes_step_avx2(a, lanes);
#endif
  return km_lanes_step_plain(a, lanes);
}

/* Writes a value to the lanes from `first` on. The case of all lanes is separate, so that it becomes register
 * stores. */
static inline void fill_lanes(double *number, int first, double value) {
  if (first == 0)
    for (int l = 0; l < KM_LANES; ++l)
      number[l] = value;
  else
    for (int l = first; l < KM_LANES; ++l)
      number[l] = value;
}

void km_lanes_set_target(km_lanes *lanes, int first, const km_pose *target, const double *xi) {
  const double place[3] = {target->p.x, target->p.y, target->p.z};
  for (int i = 0; i < 3; ++i) {
    const km_vec3 *axis = &target->R.axis[i];
    fill_lanes(lanes->place[i], first, place[i]);
    fill_lanes(lanes->axes[i][0], first, axis->x);
    fill_lanes(lanes->axes[i][1], first, axis->y);
    fill_lanes(lanes->axes[i][2], first, axis->z);
  }
  for (int r = 0; r < 6; ++r)
    fill_lanes(lanes->xi[r], first, xi[r]);
}
