/* kmob motion: swings, velocities and accelerations over a driver's range. */
#include "common/report.h"
#include "kmob/kmob.h"

/* A driver of constant rate has no motion by arc length. */
static void hide_arclength(kt_options *all) {
  static const char *const names[] = {"arclength", "cycle", "direction", "branch", "derivatives"};
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
    kt_options_hide(all, names[i]);
}

kt_exit kmob_motion(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "motion", KT_SWEEP_BASE("motion"));
  hide_arclength(&all);
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

kt_exit kmob_report(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  kt_report_options(&all, &o, "motion", KT_REPORT_BASE("motion-report"));
  hide_arclength(&all);
  kt_options_read(
      &all,
      "A report to hand on: how the mechanism moves, swings, velocities and accelerations of its joints, paths "
      "and speeds of points, as PDF pages or one HTML file.",
      argc, argv);
  return kt_report(&o);
}
