/* kstatic sweep and kstatic report: the balance of forces over a driver's range. */
#include "common/report.h"
#include "kstatic/kstatic.h"

kt_exit kstatic_sweep(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kstatic")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "forces", KT_SWEEP_BASE("forces"));
  kt_options_read(
      &all,
      "What actuators must hold, and what every joint carries, over the range of a driver; where a load balances "
      "itself, and where forces peak. Exit status 1 if a part of the range can't be held. Forces beyond a joint's "
      "max_force are warnings."
      "\vColumns beside those of every sweep: f.JOINT of the actuators (nan where they can't hold), fbar.JOINT "
      "least-norm forces, r.JOINT.fx … tz reactions of parent on child, held (1 or 0). JSON adds events [{actuator, "
      "event (zero, peak, unbounded), s, force}], reactions_note, beyond_max_force [labels], degree_of_indeterminacy, rows_not_held, held_joints.",
      argc, argv);
  return kt_sweep(&o);
}

kt_exit kstatic_report(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kstatic")};
  kt_options all = {0};
  kt_report_options(&all, &o, "forces", KT_REPORT_BASE("forces-report"));
  kt_options_hide(&all, "point"); /* a column of tables */
  kt_options_read(&all,
                  "A report to hand on: the mechanism in its poses, what every actuator must hold, where it rests or "
                  "peaks, and the reactions at the worst pose, as PDF pages or one HTML file.",
                  argc, argv);
  return kt_report(&o);
}
