/* kma sweep and kma report: mechanical advantage over a driver's range. */
#include "common/report.h"
#include "kma/kma.h"

/* The kinds of --point on a sweep. */
static void explain_points(kt_options *all) {
  kt_question_explain(
      all, "point", "BODY/FRAME[:DX,DY,DZ]",
      "With a direction: a point as output (a second one: as input before it); without: add the path of a "
      "frame's origin (repeatable)");
}

/* A point with a direction is an end, one without is a path to add. */
static bool part_points(kt_sweep_options *o) {
  kt_texts *points = kt_question_texts(&o->asked, "point"), ends = {0};
  int paths = 0;
  for (int i = 0; i < points->count; ++i)
    if (kt_direction(points->items[i]))
      ends.items[ends.count++] = points->items[i];
    else
      points->items[paths++] = points->items[i];
  points->count = paths;
  return kma_place_points(&o->common, &o->asked, &ends);
}

kt_exit kma_sweep(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kma")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "advantage", KT_SWEEP_BASE("advantage"));
  explain_points(&all);
  kt_options_read(
      &all,
      "Mechanical advantage of an input over an output over the range of a driver, with its dead points and extremes."
      "\vColumns beside those of every sweep: ma.INPUT/OUTPUT, with a unit such as _rad/mm where it mixes an angle and "
      "a length (inf, nan where infinite, undefined); force_ratio.INPUT/OUTPUT with the joints' friction, where there "
      "is some; with --transmission transmission_angle, virtual_coefficient, sutherland_roth, chen_angeles, "
      "manipulability, condition_number, transmission.JOINT and pressure.JOINT of each hinge between moving links "
      "of a planar linkage, joint_force_index, and lee_duffy and zhang over their greatest values. JSON adds input, output, method, toggles [{state, s}], minimum and maximum "
      "{value, s, state}, held_joints.",
      argc, argv);
  return part_points(&o) ? kt_sweep(&o) : KT_USAGE;
}

kt_exit kma_report(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kma")};
  kt_options all = {0};
  kt_report_options(&all, &o, "advantage", KT_REPORT_BASE("advantage-report"));
  kt_question_explain(&all, "point", "BODY/FRAME:DX,DY,DZ",
                      "A point along a direction as output (a second one: as input before it)");
  kt_options_read(
      &all,
      "A report to hand on: the mechanism in its poses, the leverage curve with its extremes and dead points, "
      "transmission metrics and a table, as PDF pages or one HTML file.",
      argc, argv);
  return part_points(&o) ? kt_report(&o) : KT_USAGE;
}
