/* kmob motion: swings, velocities and accelerations over a driver's range. */
#include "common/sweep.h"
#include "kmob/kmob.h"

kt_exit kmob_motion(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "motion", KT_SWEEP_BASE("motion"));
  kt_options_hide(&all, "arclength"); /* a driver of constant rate has none of these */
  kt_options_hide(&all, "cycle");
  kt_options_hide(&all, "direction");
  kt_options_hide(&all, "branch");
  kt_options_hide(&all, "derivatives");
  kt_options_read(
      &all,
      "How far each joint moves, how fast, and with which acceleration, while a driver moves at a constant rate; paths of "
      "points of --point."
      "\vColumns beside those of every sweep: t; v.JOINT, a.JOINT; body.BODY.wx … wz, alphax … alphaz in radians; "
      "point.BODY/FRAME.vx … vz, ax … az, speed, path (its length so far), curvature. Without --rate they are derivatives "
      "by the driver. Accelerations are nan where several freedoms are left. JSON adds rate, swings {joint, least, "
      "least_at, greatest, greatest_at, goes_round}.",
      argc, argv);
  return kt_sweep(&o);
}
