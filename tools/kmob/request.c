/* The options of kmob's commands about one pose. */
#include "kmob/kmob.h"

kmob_request kmob_read_request(int argc, char **argv, const char *about, kmob_asking asking) {
  kmob_request r = {.pose = {.common = KT_COMMON("kmob")}};
  kt_options all = {0};
  const kt_option modes[] = {{"modes", 0, NULL, "List the other assembly modes at this value of the driver", KT_FLAG,
                              &r.modes, KT_ABOUT_MODEL}};
  const kt_option strict[] = {{"strict", 0, NULL, "Exit status 1 for remarks too", KT_FLAG, &r.strict, KT_ABOUT_MODEL}};
  kt_request_options(&all, &r.pose, asking != KMOB_INFO, KT_REQUEST_BASE("RESULT"));
  if (asking == KMOB_CHECKS)
    KT_OPTIONS_ADD(&all, strict);
  else
    KT_OPTIONS_ADD(&all, modes);
  kt_common_options(&all, &r.pose.common, KT_USES_FLOAT | (asking == KMOB_CHECKS ? 0 : KT_USES_SEED));
  kt_options_read(&all, about, argc, argv);
  return r;
}
