/* ksim inverse: the question "inverse" about one model, several, or variants. */
#include "ksim/ksim.h"

kt_exit ksim_inverse(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("ksim"), .tell = ksim_tell};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "inverse", KT_SWEEP_BASE("inverse"));
  kt_question_explain(&all, "rate", "JOINT=RATE",
                      "Turn or move a joint at a constant rate: A=60rpm, or in the model's unit per time unit "
                      "(repeatable; beside it the model's prescribed motions count)");
  kt_question_explain(&all, "until", "T",
                      "End, in the model's time unit (default: one turn, or a longer period of the loads)");
  kt_question_explain(&all, "joints", "LIST", "Joints whose curves are drawn (default: up to eight that move)");
  kt_options_read(
      &all,
      "What a prescribed motion takes: the forces of its drives, the reactions in the joints, and the shaking force and "
      "moment on the ground; of several models or variants (--vary) with a common plot. The motion must leave no freedom. "
      "Exit status 1 if the motion can't be completed."
      "\vColumns: t; q.JOINT, v.JOINT, a.JOINT; f.JOINT, the force that drives a prescribed joint, along +q; "
      "energy_kinetic, energy_potential; loop_error; shaking.fx … tz, the sum of the inertia forces about the inertial "
      "origin; frame.BODY/FRAME.x … vx … ax; r.JOINT.fx … tz, parent on child. JSON: largest_forces (of, value, t, "
      "rms), located between rows too.",
      argc, argv);
  return kt_sweep(&o);
}
