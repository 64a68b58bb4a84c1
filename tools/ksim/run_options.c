/* Options shared by the commands of ksim. */
#include "ksim/ksim.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/inspect.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

kt_exit ksim_read_number(const kt_common *common, const char *option, const char *text, const char *expected,
                         double *out) {
  if (!text)
    return KT_DONE;
  return kt_number(text, out) && isfinite(*out) && *out > 0.0 ? KT_DONE : kt_usage(common, option, text, expected);
}

bool ksim_read_rate(const km_model *model, int coordinate, const char *text, double *out) {
  size_t length = strlen(text);
  char number[64];
  bool turns = length > 3 && strcmp(text + length - 3, "rpm") == 0;
  if ((turns && km_model_coordinate_is_length(model, coordinate)) || length >= sizeof number)
    return false;
  snprintf(number, sizeof number, "%.*s", (int)(turns ? length - 3 : length), text);
  if (!kt_number(number, out) || !isfinite(*out))
    return false;
  const km_units units = km_model_units(model);
  if (turns)
    *out *= 2.0 * M_PI / units.angle->si / (60.0 / units.time->si);
  return true;
}

kt_exit ksim_read_frames(const kt_common *common, const km_model *model, const kt_texts *texts,
                         const km_traced_frame **out, int *count) {
  km_traced_frame *frames = KM_NEW(km_traced_frame, (size_t)texts->count + 1);
  kt_exit result = frames ? kt_each_once(common, "--frame", texts->items, texts->count) : KT_NO_MEMORY;
  *out = frames;
  for (int i = 0; i < texts->count && result == KT_DONE; ++i) {
    frames[i].name = texts->items[i];
    result = kt_frame(common, model, "--frame", texts->items[i], &frames[i].frame);
    *count = i + 1;
  }
  return result;
}

kt_exit ksim_forces(const kt_common *common, const char *path, const kt_pose *pose, km_forces **out) {
  km_error error;
  km_status status = km_forces_create_own(pose->mechanism, out, &error);
  if (status)
    kt_print_message(common, KM_ERROR, "%s: %s", path, error.text);
  return kt_exit_of(status);
}

void ksim_print_acting(bool reactions, const km_model *model, km_text *out) {
  km_text meshing = {0};
  km_text_add(out, "  ");
  km_gravity_words(model, NULL, out);
  km_text_add(out, "\n");
  if (reactions)
    km_meshing_words(model, &meshing);
  if (meshing.size)
    km_text_format(out, "  %s\n", meshing.data);
  out->failed = out->failed || meshing.failed;
  km_text_free(&meshing);
}

void ksim_report_drives(const kt_common *common, const char *path, const kt_pose *pose, const km_history *h) {
  const km_model *model = pose->model;
  const char *time = km_model_units(model).time->suffix;
  for (int i = 0; i < h->exceeded_count; ++i) {
    const km_exceeded *e = &h->exceeded[i];
    const char *label = km_model_coordinate_label(model, e->coordinate);
    km_text unit = {0};
    if (e->of_force)
      km_push_unit(model, &(km_port){.kind = KM_PORT_JOINT, .coordinate = e->coordinate}, &unit);
    else
      km_text_format(&unit, "%s/%s", km_model_coordinate_unit(model, e->coordinate), time);
    kt_print_message(common, KM_WARNING,
                     e->of_force
                         ? "%s: the drive of joint \"%s\" gives %.6g %s at %.6g %s, more than its max_force of %.6g"
                         : "%s: joint \"%s\" moves at %.6g %s at %.6g %s, faster than its max_rate of %.6g",
                     path, label, e->most, unit.data ? unit.data : "", e->time, time, e->bound);
    km_text_free(&unit);
  }
}

void ksim_report_hinges(const kt_common *common, const char *path, const km_model *model) {
  for (int j = -1; (j = km_model_next_without_radius(model, j + 1)) >= 0;)
    kt_print_message(
        common, KM_NOTE,
        "%s: joint %s has a coefficient of friction but no radius: it turns without friction, under a thrust along its "
        "axis too",
        path, km_model_joint_label(model, j));
}

kt_exit ksim_report_limits(const kt_common *common, const char *path, const kt_pose *pose, const km_history *h) {
  const km_model *model = pose->model;
  const char *time = km_model_units(model).time->suffix;
  for (int i = 0; i < h->limit_count; ++i) {
    const km_passed_limit *limit = &h->limits[i];
    km_text by = {0};
    const char *unit = km_model_coordinate_unit(model, limit->coordinate);
    if (limit->beyond > 0.0)
      km_text_format(&by, ", by up to %.6g %s", limit->beyond, unit);
    kt_print_message(
        common, KM_WARNING,
        "%s: joint \"%s\" passes its %s limit of %.6g %s at %.6g %s%s; no stop acts there: state a stop for the joint, "
        "or widen its limits",
        path, km_model_coordinate_label(model, limit->coordinate), limit->upper ? "upper" : "lower", limit->limit, unit,
        limit->time, time, by.data ? by.data : "");
    km_text_free(&by);
  }
  return h->limit_count > 0 ? KT_PARTIAL : KT_DONE;
}

kt_exit ksim_set_limit_stops(const ksim_work *w) {
  const ksim_options *o = w->options;
  double stop[2] = {0.0, 0.0};
  km_error error;
  if (!kt_numbers(o->limit_stops, strchr(o->limit_stops, ',') ? 2 : 1, stop) ||
      km_forces_set_limit_stops(w->forces, stop[0], stop[1], &error))
    return kt_usage(&o->common, "--limit-stops", o->limit_stops,
                    "a positive stiffness, and a damping of at least 0 behind a comma");
  return KT_DONE;
}

kt_exit ksim_read_formats(const kt_common *common, const char *format, const char *base, bool beside,
                          const char *expected, kt_formats *out) {
  bool piped = kt_is_piped(base);
  if (!kt_formats_parse(common, format ? format : piped ? "csv" : "csv,svg", out))
    return KT_USAGE;
  bool tables_only = !out->wanted[KT_SVG] && !out->wanted[KT_PDF] && !out->wanted[KT_PNG];
  if (piped && (kt_formats_count(out) != 1 || !tables_only || beside))
    return kt_usage(common, "-o", "-", expected);
  return KT_DONE;
}

static kt_exit write_table(const ksim_delivery *d, kt_format format) {
  km_text out = {0};
  if (format == KT_CSV) {
    km_csv_write(d->table, &out);
  } else {
    km_arena arena = {0};
    const km_value *record = d->record(d->context, &arena);
    if (record)
      km_json_write(record, &out);
    out.failed = out.failed || !record;
    km_arena_free(&arena);
  }
  kt_exit result = kt_write(d->common, d->base, d->word, kt_format_word(format), &out);
  km_text_free(&out);
  return result;
}

static kt_exit write_plot(const ksim_delivery *d, kt_format format) {
  km_text out = {0};
  km_error error;
  km_chart *chart = NULL;
  km_status status = d->chart(d->context, &chart, &error);
  if (!status)
    status = km_chart_picture(chart, kt_picture_format(format), &out, &error);
  kt_exit result = kt_exit_of(status);
  if (status)
    kt_print_message(d->common, KM_ERROR, "%s", error.text);
  else
    result = kt_write(d->common, d->base, d->word, kt_format_word(format), &out);
  km_chart_free(chart);
  km_text_free(&out);
  return result;
}

kt_exit ksim_deliver(const ksim_delivery *d) {
  kt_exit result = KT_DONE;
  if (!d->common->quiet && !kt_is_piped(d->base))
    result = kt_print(d->common, d->summary);
  kt_note_size(d->common, (double)km_table_rows(d->table) * (double)km_table_columns(d->table) *
                              (d->formats->wanted[KT_CSV] + d->formats->wanted[KT_JSON]));
  for (int f = KT_CSV; f <= KT_JSON; ++f)
    if (d->formats->wanted[f])
      result = kt_worse(result, write_table(d, (kt_format)f));
  for (int f = KT_SVG; f <= KT_PNG; ++f)
    if (d->formats->wanted[f])
      result = kt_worse(result, write_plot(d, (kt_format)f));
  return result;
}
