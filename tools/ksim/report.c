/* ksim report: a run, or with --inverse an inverse motion, as a document. */
#include "common/report.h"
#include "ksim/ksim.h"

#include <string.h>

/* True if --inverse is on the command line: its options are those of ksim inverse. */
static bool is_inverse(int argc, char **argv) {
  bool found = false;
  for (int i = 1; i < argc; ++i)
    found = found || strcmp(argv[i], "--inverse") == 0;
  return found;
}

kt_exit ksim_report(int argc, char **argv) {
  const bool inverse = is_inverse(argc, argv);
  bool given = false;
  kt_sweep_options o = {.common = KT_COMMON("ksim"), .tell = ksim_tell};
  kt_options all = {0};
  const kt_option table[] = {
      {"inverse", 0, NULL, "About a prescribed motion, with the options of ksim inverse", KT_FLAG, &given,
       KT_ABOUT_MODEL},
  };
  kt_report_options(&all, &o, inverse ? "inverse" : "run", KT_REPORT_BASE("run-report") " (or inverse-report)");
  KT_OPTIONS_ADD(&all, table);
  kt_options_hide(&all, "frame"); /* columns of tables */
  kt_options_hide(&all, "forces");
  kt_options_read(&all,
                  "A report to hand on: the motion over time with its energies, or what a prescribed motion takes "
                  "(--inverse); driving forces, bearing loads, events and poses, as PDF pages or one HTML file.",
                  argc, argv);
  if (given != inverse)
    return kt_usage(&o.common, "--inverse", "shortened, or in place of a value", "the whole word on its own");
  kt_question_set(&o.asked, "reactions");
  return kt_report(&o);
}
