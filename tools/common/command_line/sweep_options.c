/* The options of the sweep commands. */
#include "common/sweep.h"

void kt_sweep_options_add(kt_options *out, kt_sweep_options *o, const char *kind) {
  const kt_option pose[] = {
      KT_HOLD(&o->holds, KT_HOLD_RIGID),
      KT_MODE(o->common),
      KT_POSE(o->common),
      KT_SET(&o->sets, KT_SET_FIRST),
  };
  kt_question_options(out, &o->asked, kind, true);
  KT_OPTIONS_ADD(out, pose);
}

void kt_sweep_options_several(kt_options *out, kt_sweep_options *o, const char *kind, const char *base_help) {
  const kt_option files[] = {
      KT_VARY(&o->vary),
      {"joints", 0, "A,B", "The joints whose curves are drawn (default: all; of several models the driver's)", KT_TEXT,
       &o->joints, KT_ABOUT_FILES},
      {"format", 0, "LIST", KT_FORMATS_HELP, KT_FORMATS_KIND, &o->format, KT_ABOUT_FILES},
      KT_BASE(&o->base, base_help),
  };
  kt_sweep_options_add(out, o, kind);
  KT_OPTIONS_ADD(out, files);
  kt_common_options(out, &o->common, KT_USES_JOBS | KT_USES_FLOAT);
  out->operand = (kt_operand){"model", "MODEL...", true, NULL, &o->models};
}
