/* kredund selfmotion: every pose that holds the effector where it is. */
#include "kredund/tracks.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/report.h"

#include <string.h>

static kt_exit write_curve(const kredund_request *r, const kredund_open *open, const kt_formats *formats,
                           const km_selfmotion *motion, const char *base) {
  kt_exit result = KT_DONE;
  if (formats->wanted[KT_CSV] || formats->wanted[KT_XLSX]) {
    km_table *table = km_selfmotion_table(km_study_arm(open->study), motion, r->ignore_limits);
    if (table)
      result = kredund_write_table(r, formats, base, "selfmotion", table);
    else
      kt_print_message(&r->common, KM_ERROR, "out of memory");
    result = table ? result : KT_NO_MEMORY;
    km_table_free(table);
  }
  if (formats->wanted[KT_JSON]) {
    km_arena arena = {0};
    km_text out = {0};
    const km_value *record =
        km_selfmotion_record(km_study_arm(open->study), motion, r->ignore_limits, open->model, &arena);
    if (record)
      km_json_write(record, &out);
    else
      out.failed = true;
    result = kt_worse(result, kt_write(&r->common, base, "selfmotion", "json", &out));
    km_arena_free(&arena);
    km_text_free(&out);
  }
  return result;
}

/* The map along the path, with the tracks of the study's methods. */
static kt_exit write_map(const kredund_request *r, const kredund_open *open, const kt_formats *formats,
                         const char *base) {
  kredund_tracks tracks = {.request = r, .open = open, .formats = *formats};
  bool pictures = formats->wanted[KT_SVG] || formats->wanted[KT_PDF] || formats->wanted[KT_PNG];
  if (!pictures)
    return KT_DONE;
  if (!km_study_bound_path(open->study) || km_arm_freedom(km_study_arm(open->study)) != 1) {
    bool alone = !formats->wanted[KT_CSV] && !formats->wanted[KT_JSON] && !formats->wanted[KT_XLSX];
    kt_print_message(&r->common, alone ? KM_ERROR : KM_NOTE, "%s: there is no map to draw: it needs %s", open->name,
                     km_study_bound_path(open->study) ? "one spare freedom" : "a path");
    return alone ? KT_PARTIAL : KT_DONE;
  }
  kt_exit result = kredund_tracks_run(&tracks);
  if (result == KT_PARTIAL)
    result = KT_DONE; /* the map shows where a method ends */
  for (int f = KT_SVG; f <= KT_PNG && result == KT_DONE; ++f)
    if (formats->wanted[f])
      result = kredund_tracks_picture(&tracks, base, "selfmotion", (kt_format)f, km_tracks_map);
  kredund_tracks_free(&tracks);
  return result;
}

/* Prints and writes the self-motion through q. */
static kt_exit deliver(const kredund_request *r, const kt_formats *formats, const kredund_open *open, const double *q) {
  const km_arm *arm = km_study_arm(open->study);
  const char *base = r->base ? r->base : open->base;
  km_selfmotion motion;
  km_error error;
  km_status status = km_selfmotion_follow(arm, q, NULL, NULL, &motion, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(&r->common, KM_ERROR, "%s: %s", open->name, error.text);
  if (!status && !r->common.quiet && !kt_is_piped(base)) {
    km_text text = {0};
    km_selfmotion_print(arm, &motion, open->name, &text);
    result = kt_print(&r->common, &text);
    km_text_free(&text);
  }
  if (!status) {
    result = kt_worse(result, write_curve(r, open, formats, &motion, base));
    result = kt_worse(result, write_map(r, open, formats, base));
  }
  km_selfmotion_free(&motion);
  return result;
}

static kt_exit run(const kredund_request *r, const kt_formats *formats, const kredund_open *open) {
  kt_exit result;
  double *q = kredund_start(r, open, &result);
  if (!q)
    return result;
  if (km_arm_freedom(km_study_arm(open->study)) < 1) {
    kt_print_message(&r->common, KM_ERROR, "%s: the arm has no freedom to spare for its task: it has no self-motion",
                     open->name);
    result = KT_PARTIAL;
  } else {
    result = deliver(r, formats, open, q);
  }
  km_free(q);
  return result;
}

kt_exit kredund_selfmotion(int argc, char **argv) {
  kredund_request request = {.common = KT_COMMON("kredund")};
  kt_options all = {0};
  kt_formats formats;
  const kt_option table[] = {{"ignore-limits", 0, NULL,
                              "Rows of the whole curve, also where joints are outside their limits", KT_FLAG,
                              &request.ignore_limits, KT_ABOUT_FILES}};
  KT_OPTIONS_ADD(&all, table);
  if (!kredund_tracks_read(&all,
                           "The poses that hold the effector at the path's start (or where the arm is): their curve, "
                           "closed or to its ends, and its arcs within the joint limits. With a path, a map of them "
                           "along it.",
                           argc, argv, &request, &formats))
    return KT_USAGE;
  kredund_open open;
  kt_exit result = kredund_bind(&request, false, &open);
  if (result == KT_DONE)
    result = run(&request, &formats, &open);
  kredund_close(&open);
  return result;
}
