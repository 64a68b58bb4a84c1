/* kredund report: tracks as a document. */
#include "common/report.h"
#include "kredund/tracks.h"

static kt_exit deliver(const kredund_tracks *t, kt_report_head *head, bool html, const char *base) {
  const kt_common *common = &t->request->common;
  km_text out = {0};
  km_error error;
  kt_exit result = kt_report_head_complete(common, head, t->open->pose.model, t->open->model);
  if (result != KT_DONE)
    return result;
  km_status status = km_tracks_report(&t->all, &head->header, html, &out, &error);
  result = kt_exit_of(status);
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", t->open->name, error.text);
  else
    result = kt_report_write(common, base, t->open->base, "track-report", html, &out);
  km_text_free(&out);
  return result;
}

kt_exit kredund_report(int argc, char **argv) {
  kredund_request r = {.common = KT_COMMON("kredund")};
  kt_options all = {0};
  kt_report_head head = {0};
  bool html;
  kredund_arm_options(&all, &r);
  kredund_method_options(&all, &r);
  const kt_option pose[] = {KT_POSE(r.common)};
  KT_OPTIONS_ADD(&all, pose);
  kt_report_head_options(&all, &head, &r.formats, &r.base, KT_REPORT_BASE("track-report"));
  kt_common_options(&all, &r.common, KT_USES_JOBS | KT_USES_SEED | KT_USES_MODEL);
  kt_options_read(
      &all,
      "A report to hand on: the best track along the path, each joint's margin and rate against its limits, "
      "the methods side by side, the arm along the path and plots, as PDF pages or one HTML file.",
      argc, argv);
  if (!kt_report_format(r.formats, r.base, &html))
    return kt_usage(&r.common, "--format", r.formats, "pdf or html, as -o says");
  if (kt_is_piped(r.base))
    return kt_usage(&r.common, "-o", "-", "a file");
  kredund_open open;
  kredund_tracks tracks = {.request = &r, .open = &open};
  kt_exit result = kt_report_head_read(&r.common, &head);
  if (result != KT_DONE)
    return result;
  result = kredund_bind(&r, true, &open);
  if (result == KT_DONE) {
    result = kredund_tracks_run(&tracks);
    if (result == KT_DONE || result == KT_PARTIAL)
      result = kt_worse(result, deliver(&tracks, &head, html, r.base));
  }
  kredund_tracks_free(&tracks);
  kredund_close(&open);
  kt_report_head_free(&head);
  return result;
}
