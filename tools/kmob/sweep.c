/* kmob sweep: mobility numbers over a driver's range. */
#include "common/sweep.h"
#include "kmob/kmob.h"

kt_exit kmob_sweep(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "mobility", KT_SWEEP_BASE("mobility"));
  kt_options_read(&all,
                  "Mobility numbers of every joint over the range of a driver."
                  "\vColumns: step, s, q.JOINT, m.JOINT of each joint, dof, residual. --singularities adds "
                  "singular_value; --transmission adds the columns of kma sweep --transmission, from the driver to "
                  "--output: transmission_angle, virtual_coefficient, sutherland_roth, chen_angeles, "
                  "manipulability, condition_number, transmission.JOINT and pressure.JOINT, joint_force_index, "
                  "lee_duffy, zhang.",
                  argc, argv);
  return kt_sweep(&o);
}
