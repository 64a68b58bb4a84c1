/* The error that the works of a run may have: what is dissipated and what motors give.
 *
 * A rate that errs by ε v + δ lets the kinetic energy T err by about 2 ε T + δ m v. The works may err by ε of the largest
 * T so far, or of themselves, and by δ of the energy that everything has at a radian or a characteristic length per second:
 * where they are as smooth as the motion, its steps are short enough for them too. They aren't where a body flies freely
 * while the stop that it has left still gives out what it stored. */
#include "dynamics/simulation.h"

/* The energy of all bodies and drives at a radian and a characteristic length per second. */
static double usual_energy(const km_dynamics *d) {
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
  run->usual_energy = usual_energy(run->dynamics);
  run->largest_energy = 0.0;
  km_simulation_watch_works(run);
}

void km_simulation_watch_works(km_simulation *run) {
  run->largest_energy = fmax(run->largest_energy, km_dynamics_kinetic(run->dynamics, run->state));
}

double km_simulation_rest_energy(const km_simulation *run) {
  return run->def.absolute * run->def.absolute * run->usual_energy;
}

double km_simulation_work_tolerance(const km_simulation *run, double work) {
  double size = fmax(run->largest_energy, fabs(work));
  double out = run->def.relative * size + run->def.absolute * run->usual_energy;
  return out > 0.0 ? out : HUGE_VAL; /* nothing tells yet how large works will be */
}
