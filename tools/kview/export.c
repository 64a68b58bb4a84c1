/* kview export: the motion as one page that needs no server. */
#include "kview/kview.h"
#include "kview/messages.h"
#include "kview/page.h"

#include "kmech/base.h"

#include <stdio.h>
#include <string.h>

enum { STEPS = 200 };

typedef struct options {
  kt_common common;
  const char *model, *file;
} options;

/* One answer of the session as a string in base64. */
static km_status add_answer(kv_session *s, const char *message, km_text *out, km_error *error) {
  kv_answer answer;
  kv_answer_message(s, message, strlen(message), &answer);
  km_status status = answer.fault.status;
  if (status)
    *error = answer.fault;
  if (!status) {
    kv_add_comma(out);
    km_text_add(out, "\"");
    km_text_base64(out, answer.bytes.data, answer.bytes.size);
    out->failed = out->failed || answer.bytes.failed;
    km_text_add(out, "\"");
  }
  km_text_free(&answer.bytes);
  return status;
}

/* The poses of the question's rows, one after another. */
static km_status add_poses(kv_session *s, km_text *out, km_error *error) {
  const km_table *table = km_question_table(s->question);
  int n = km_model_coordinate_count(s->model);
  km_span span = km_table_span(table, "q.");
  km_text poses = {0};
  km_status status = span.count == (size_t)n ? KM_OK : km_fail(error, KM_INTERNAL, "a sweep without all coordinates");
  for (size_t r = 0; r < km_table_rows(table) && !status; ++r) {
    status = kv_session_place(s, km_table_row(table, r) + span.first, error);
    if (!status)
      kv_add_pose(s, 0, &poses);
  }
  km_text_add(out, ",\"poses\":\"");
  km_text_base64(out, poses.data, poses.size);
  out->failed = out->failed || poses.failed;
  km_text_add(out, "\"");
  km_text_free(&poses);
  return status;
}

static void question_text(const kv_session *s, int kind, char *out, size_t size) {
  km_sweep_plan plan = km_sweep_plan_default(s->model);
  km_port input, output;
  int ends[2] = {-1, -1};
  if (km_port_default(s->model, false, &input) && km_port_default(s->model, true, &output) &&
      input.kind == KM_PORT_JOINT && output.kind == KM_PORT_JOINT) {
    ends[0] = input.coordinate;
    ends[1] = output.coordinate;
  }
  bool length = plan.coordinate < 0;
  int count =
      snprintf(out, size, "1 ask %d %d %.17g %.17g %d", kind, plan.coordinate, length ? plan.arclength : plan.from,
               length ? 0.0 : plan.to, length && plan.steps < 1000 ? plan.steps : STEPS);
  if (ends[0] >= 0)
    snprintf(out + count, size - (size_t)count, " %d %d", ends[0], ends[1]);
}

/* True if there are forces or masses. */
static bool has_forces(const km_model *model) {
  bool some = km_model_load_count(model) > 0 || km_model_actuator_count(model) > 0;
  double center[3];
  for (int b = 1; b <= km_model_body_count(model); ++b)
    some = some || km_model_body_mass(model, b, center) > 0.0;
  return some;
}

static km_status add_tables(kv_session *s, km_text *out, km_error *error) {
  char text[256];
  km_port end;
  bool lever = km_port_default(s->model, false, &end) && end.kind == KM_PORT_JOINT;
  km_status status = KM_OK;
  km_text_add(out, ",\"tables\":[");
  int count = 0;
  while (kv_question_kind(s, count) >= 0)
    ++count;
  while (count-- > 0 && !status) { /* mobility last: the poses are its rows */
    const char *name = km_question_kind_name(kv_question_kind(s, count));
    bool forces = strcmp(name, "forces") == 0, clearance = strcmp(name, "clearance") == 0;
    if ((strcmp(name, "advantage") == 0 && !lever) || (forces && !has_forces(s->model)))
      continue;
    question_text(s, count, text, sizeof text);
    status = add_answer(s, text, out, error);
    if (status == KM_USAGE && clearance) /* each two bodies are joined or overlap */
      status = KM_OK;
  }
  km_text_add(out, "]");
  return status;
}

static km_status add_patches(kv_session *s, km_text *out, km_error *error) {
  km_status status = KM_OK;
  km_text_add(out, ",\"patches\":[");
  for (int b = 0; b <= km_model_body_count(s->model) && !status; ++b)
    for (int part = 0; part < km_body_patch_count(s->model, b) && !status; ++part) {
      char text[64];
      snprintf(text, sizeof text, "1 patch %d %d", b, part);
      status = add_answer(s, text, out, error);
    }
  km_text_add(out, "]");
  return status;
}

static km_status record(kv_session *s, km_text *out, km_error *error) {
  km_status status = kv_session_load(s, error);
  if (status)
    return status;
  km_text_add(out, "{\"model\":");
  kv_describe(s, 0, out);
  status = add_tables(s, out, error);
  if (!status)
    status = add_patches(s, out, error);
  if (!status)
    status = add_poses(s, out, error);
  km_text_add(out, "}");
  return status;
}

/* The page with the recording where its template leaves a place for it. */
static bool compose(const km_text *recording, km_text *out) {
  static const char mark[] = "<!--recorded-->";
  const char *page = (const char *)kv_page, *place = NULL;
  for (size_t i = 0; i + sizeof mark < kv_page_size && !place; ++i)
    place = memcmp(page + i, mark, sizeof mark - 1) == 0 ? page + i : NULL;
  if (!place || recording->failed)
    return false;
  km_text_bytes(out, page, (size_t)(place - page));
  km_text_add(out, "<script id=\"recording\" type=\"application/json\">");
  km_text_bytes(out, recording->data, recording->size);
  km_text_add(out, "</script>");
  place += sizeof mark - 1;
  km_text_bytes(out, place, kv_page_size - (size_t)(place - page));
  return !out->failed;
}

static kt_exit write_page(const options *o, const km_text *recording) {
  km_text page = {0};
  bool made = compose(recording, &page);
  if (!made)
    kt_print_message(&o->common, KM_ERROR, "out of memory for the page");
  kt_exit written = made ? kt_write_file(&o->common, o->file, &page) : KT_NO_MEMORY;
  km_text_free(&page);
  return written;
}

kt_exit kview_export(int argc, char **argv) {
  options o = {.common = KT_COMMON("kview")};
  kt_options all = {0};
  const kt_option table[] = {
      {"base", 'o', "FILE", "Write this page (default: the model's name with .html); - is the standard output", KT_TEXT,
       &o.file, KT_ABOUT_FILES},
      {"pose", 0, "NAME", "Start from this one of the poses that the model names", KT_TEXT, &o.common.pose,
       KT_ABOUT_MODEL},
  };
  KT_OPTIONS_ADD(&all, table);
  kt_common_options(&all, &o.common, KT_USES_FLOAT);
  all.operand = (kt_operand){"model", "MODEL", true, &o.model, NULL};
  kt_options_read(&all, "Write the motion of analysis.sweep as one page: poses, curves, slider. It needs no server.",
                  argc, argv);
  char name[256 + 8];
  if (!o.file) {
    kt_base_name(o.model, name, 256);
    strcat(name, ".html");
    o.file = name;
  }
  char room[KT_FILE_ROOM];
  if (kt_file_name(&o.common, "html", &o.file, room) != KT_DONE)
    return KT_USAGE;
  kv_session session = {.opening = {.path = o.model,
                                    .floating = o.common.floating,
                                    .closure_tolerance = o.common.closure_tolerance,
                                    .exact = o.common.exact,
                                    .pose = o.common.pose}};
  km_text recording = {0};
  km_error error;
  km_status status = record(&session, &recording, &error);
  if (status)
    kview_say(&o.common, o.model, status, &error);
  kt_exit result = status ? kt_exit_of(status) : write_page(&o, &recording);
  km_text_free(&recording);
  kv_session_close(&session);
  return result;
}
