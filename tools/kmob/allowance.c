/* kmob allowance: the play that redundant constraints need for errors of the parts. */
#include "common/sweep.h"
#include "kmob/kmob.h"

kt_exit kmob_allowance(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "allowance", KT_SWEEP_BASE("allowance"));
  kt_options_read(
      &all,
      "How large the gaps of redundant constraints become when the parts have errors, the play in the joints that takes "
      "them up over the whole motion, and the joints that need it."
      "\vColumns beside those of every sweep: play.worst and play.statistical, the play that is needed over the play that "
      "the joints have (above 1 it can bind); gap.JOINT.x … rz .worst and .statistical, the misfit along or about the axes of "
      "the joint that closes the loop last. Joints can state \"tolerance\", \"clearance\" and \"stiffness\". JSON adds "
      "tolerance, clearance, states_clearance, worst, statistical, constraints, joints, play_in, remedy_set.",
      argc, argv);
  return kt_sweep(&o);
}
