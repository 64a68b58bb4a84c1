/* kredund report: the tracks of a study, or of several studies and variants, as a document. */
#include "common/report.h"
#include "common/command_line/vary.h"
#include "kredund/tracks.h"

#include <stdio.h>
#include <string.h>

enum { MOST_STUDIES = 64, NAME = 600 };

/* One study, or a variant of one. */
typedef struct report_job {
  kredund_request request;
  kredund_open open;
  kredund_tracks tracks;
  km_assignment values[KT_MOST_VARIED];
  char name[NAME];
} report_job;

typedef struct report_request {
  kredund_request request;
  kt_texts studies, vary;
  kt_variants variants;
  kt_report_head head;
  bool html;
  report_job *jobs; /* [count] */
  int count;
} report_request;

/* "iiwa_weld", "load.mass=2", or both. */
static void name_job(const report_request *r, report_job *job, int variant) {
  char study[256], values[KT_VARIANT_NAME];
  const bool varied = r->variants.number_count > 0, several = r->studies.count > 1;
  kt_variant(&r->variants, variant, job->values, values);
  kt_study_base(job->request.study, job->request.model ? job->request.model : "", study, sizeof study);
  snprintf(job->name, sizeof job->name, "%s%s%s", several || !varied ? study : "", several && varied ? ": " : "",
           varied ? values : "");
}

static kt_exit run_job(report_job *job) {
  kt_exit result = kredund_bind(&job->request, true, &job->open);
  job->tracks = (kredund_tracks){.request = &job->request, .open = &job->open};
  return result == KT_DONE ? kredund_tracks_run(&job->tracks) : result;
}

static bool has_tracks(const report_job *job) {
  return job->tracks.items != NULL;
}

static km_status make(const report_request *r, km_text *out, km_error *error) {
  km_tracks tracks[MOST_STUDIES];
  const char *names[MOST_STUDIES];
  char first[256];
  if (r->count == 1)
    return km_tracks_report(&r->jobs[0].tracks.all, &r->head.header, r->html, out, error);
  for (int i = 0; i < r->count; ++i) {
    tracks[i] = r->jobs[i].tracks.all;
    names[i] = r->jobs[i].name;
  }
  kt_study_base(r->jobs[0].request.study, r->jobs[0].request.model ? r->jobs[0].request.model : "", first,
                sizeof first);
  return km_tracks_comparison_report(tracks, names, r->count, r->studies.count > 1 ? "Paths" : first,
                                     r->variants.number_count > 0, &r->head.header, r->html, out, error);
}

static kt_exit deliver(report_request *r) {
  const kt_common *common = &r->request.common;
  const report_job *first = NULL;
  char base[4096];
  km_text out = {0};
  km_error error;
  for (int i = r->count - 1; i >= 0; --i)
    first = has_tracks(&r->jobs[i]) ? &r->jobs[i] : first;
  if (!first)
    return KT_DONE;
  kt_exit result = kt_report_head_complete(common, &r->head, first->open.pose.model, first->open.model);
  if (result != KT_DONE)
    return result;
  const km_status status = make(r, &out, &error);
  snprintf(base, sizeof base, "%s%s", first->open.base, r->count > 1 ? "-compared" : "");
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", first->open.name, error.text);
  result = status ? kt_exit_of(status) : kt_report_write(common, r->request.base, base, "track-report", r->html, &out);
  km_text_free(&out);
  return result;
}

static kt_exit run(report_request *r) {
  kt_exit result = KT_DONE;
  for (int i = 0; i < r->count; ++i) {
    report_job *job = &r->jobs[i];
    job->request = r->request;
    job->request.study = r->studies.count ? r->studies.items[i / r->variants.count] : NULL;
    job->request.values = job->values;
    job->request.value_count = r->variants.number_count;
    name_job(r, job, i % r->variants.count);
    for (int k = 0; k < i; ++k)
      if (strcmp(r->jobs[k].name, job->name) == 0) {
        kt_print_message(&r->request.common, KM_ERROR, "%s stands twice; expected studies and variants that differ",
                         job->name);
        return KT_USAGE;
      }
    result = kt_worse(result, run_job(job));
  }
  return kt_worse(result, deliver(r));
}

static void add_options(report_request *r, kt_options *all) {
  kredund_request *q = &r->request;
  kredund_arm_options(all, q);
  kredund_method_options(all, q);
  const kt_option table[] = {KT_POSE(q->common), KT_VARY(&r->vary)};
  KT_OPTIONS_ADD(all, table);
  kt_report_head_options(all, &r->head, &q->formats, &q->base, KT_REPORT_BASE("track-report"));
  kt_common_options(all, &q->common, KT_USES_JOBS | KT_USES_SEED | KT_USES_MODEL);
  all->operand = (kt_operand){"study", "STUDY...", false, NULL, &r->studies};
}

/* Reads variants and logo, and reserves the jobs. */
static kt_exit prepare(report_request *r) {
  const kt_common *common = &r->request.common;
  const int studies = r->studies.count ? r->studies.count : 1;
  if (!kt_report_format(r->request.formats, r->request.base, &r->html))
    return kt_usage(common, "--format", r->request.formats, "pdf or html, as -o says");
  if (kt_is_piped(r->request.base))
    return kt_usage(common, "-o", "-", "a file");
  if (studies > MOST_STUDIES)
    return kt_usage(common, "STUDY", "…", "at most 64 studies");
  kt_exit result = kt_variants_read(common, &r->vary, MOST_STUDIES / studies, &r->variants);
  if (result == KT_DONE)
    result = kt_report_head_read(common, &r->head);
  r->count = result == KT_DONE ? studies * r->variants.count : 0;
  r->jobs = KM_NEW(report_job, (size_t)r->count + 1);
  return r->jobs ? result : KT_NO_MEMORY;
}

kt_exit kredund_report(int argc, char **argv) {
  report_request r = {.request = {.common = KT_COMMON("kredund")}};
  kt_options all = {0};
  add_options(&r, &all);
  kt_options_read(
      &all,
      "A report to hand on: the best track along the path, each joint's margin and rate against its limits, "
      "the methods side by side, the arm along the path (in HTML as an animation beside its curves) and plots, as PDF "
      "pages or one HTML file. Of several studies, or variants of the arm, the first page says which figures differ "
      "and by how much.",
      argc, argv);
  kt_exit result = prepare(&r);
  if (result == KT_DONE)
    result = run(&r);
  for (int i = 0; i < r.count; ++i) {
    kredund_tracks_free(&r.jobs[i].tracks);
    kredund_close(&r.jobs[i].open);
  }
  km_free(r.jobs);
  kt_variants_free(&r.variants);
  kt_report_head_free(&r.head);
  return result;
}
