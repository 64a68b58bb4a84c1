/* Error allowed for the works of a run: dissipated work and motor work (docs/theory.md 11.5).
 *
 *   tolerance = ε max(T_max, |work|) + δ E_1      T_max largest kinetic energy so far
 *   E_1 = energy of all bodies and drives at a rate of one radian and one characteristic length per second
 *
 * A rate error of ε v + δ changes the kinetic energy by about 2 ε T + δ m v. Works that are as smooth as the motion
 * satisfy this tolerance with the motion's own steps. They aren't where a body flies freely while the stop that it
 * left still relaxes. */
#include "dynamics/simulation.h"

/* Kinetic energy of all bodies and drives at one radian and one characteristic length per second. */
static double unit_energy(const km_dynamics *d) {
  const km_mechanism *m = d->mechanism;
  double second = m->model->units.time->si, sum = 0.0;
  for (int n = 1; n < d->tree.node_count; ++n) {
    const km_inertia *of = &d->tree.nodes[n].inertia;
    sum += of->m * m->length * m->length + of->I.xx + of->I.yy + of->I.zz;
  }
  for (int c = 0; d->armature && c < m->coordinate_count; ++c)
    sum += d->armature[c] / (m->scale[c] * m->scale[c]);
  return 0.5 * sum * second * second;
}

void km_simulation_begin_works(km_simulation *run) {
  run->unit_energy = unit_energy(run->dynamics);
  run->largest_energy = 0.0;
  km_simulation_update_works(run);
}

void km_simulation_update_works(km_simulation *run) {
  run->largest_energy = fmax(run->largest_energy, km_dynamics_kinetic(run->dynamics, run->state));
}

double km_simulation_rest_energy(const km_simulation *run) {
  return run->def.absolute * run->def.absolute * run->unit_energy;
}

double km_simulation_work_tolerance(const km_simulation *run, double work) {
  double size = fmax(run->largest_energy, fabs(work));
  double out = run->def.relative * size + run->def.absolute * run->unit_energy;
  return out > 0.0 ? out : HUGE_VAL; /* the size of the works is still unknown */
}
