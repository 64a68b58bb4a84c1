/* The options that the commands about one pose share. */
#include "common/pose.h"

void kt_request_options(kt_options *out, kt_request *r, bool settable, const char *base_help) {
  const kt_option set[] = {KT_SET(&r->sets, "Move a joint to a value; the loops follow")};
  const kt_option shared[] = {
      KT_HOLD(&r->holds, KT_HOLD_RIGID),
      KT_MODE(r->common),
      KT_POSE(r->common),
      {"format", 0, "FORMAT", "table (default) or json", KT_WORD("table or json"), &r->json, KT_ABOUT_FILES},
      KT_BASE(&r->base, base_help),
  };
  if (settable)
    KT_OPTIONS_ADD(out, set);
  KT_OPTIONS_ADD(out, shared);
  out->operand = (kt_operand){"model", "MODEL", true, &r->model, NULL};
}

kt_exit kt_request_open(const kt_request *r, kt_pose *out) {
  return kt_open(&r->common, r->model, &r->holds, &r->sets, out);
}

kt_exit kt_answer(const kt_request *r, const char *result, const km_text *text) {
  return r->base ? kt_write(&r->common, r->base, result, r->json ? "json" : "txt", text) : kt_print(&r->common, text);
}
