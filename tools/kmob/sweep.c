/* kmob sweep: mobility numbers over a driver's range. */
#include "common/sweep.h"
#include "kmob/kmob.h"

kt_exit kmob_sweep(int argc, char **argv) {
  kt_sweep_options o = {.common = KT_COMMON("kmob")};
  kt_options all = {0};
  kt_sweep_options_several(&all, &o, "mobility", KT_SWEEP_BASE("mobility"));
  kt_options_read(&all, "Mobility numbers of every joint over the range of a driver.", argc, argv);
  return kt_sweep(&o);
}
