/* Maps over two drivers: the configurations of the grid, the singularity curves, the workspace of a point. */
#include "kview/map_job.h"
#include "kview/messages.h"
#include "kview/server/time_limit.h"

#include "kmech/space.h"

#include <math.h>
#include <time.h>

enum { MOST_STEPS = 200 };
static const struct timespec look = {0, 5000000}; /* time between two looks at a map that is waited for */

static km_status add_table(const kv_call *call, const char *what, const char *note, const km_table *table,
                           km_error *error) {
  km_text header = {0};
  km_text_format(&header, "{\"question\":\"%s\",\"driver\":-1,\"branches\":0,\"stopped\":\"\"", what);
  kv_add_columns(table, &header);
  km_text_add(&header, ",\"events\":[],\"notes\":[");
  if (note)
    kv_add_string(&header, note);
  km_text_add(&header, "]}");
  km_status status = kv_add_table(call, &header, table, error);
  km_text_free(&header);
  return status;
}

void kv_map_stop(kv_session *s) {
  km_space_map map = {0};
  bool is_complete;
  km_error error;
  if (!s->job)
    return;
  kv_map_job_cancel(s->job);
  kv_map_job_end(s->job, &map, &is_complete, &error);
  km_space_map_free(&map);
  s->job = NULL;
}

/* The name of a point, "body/frame", as in columns. */
static void point_name(const km_model *model, int frame, km_text *out) {
  km_text_format(out, "%s/%s", km_model_body_name(model, km_model_frame_body(model, frame)),
                 km_model_frame_name(model, frame));
}

/* DRIVER DRIVER FROM TO FROM TO STEPS [FRAME] */
static km_status start(const kv_call *call, km_error *error) {
  kv_session *s = call->session;
  km_space_map_def def = {.frame = call->count > 7 ? kv_index(call, 7) : -1};
  km_text name = {0};
  int steps = kv_index(call, 6);
  if (steps > MOST_STEPS)
    return km_fail(error, KM_USAGE, "%d steps are more than a page shows; expected up to %d", steps, MOST_STEPS);
  if (call->count > 7 && (def.frame < 0 || def.frame >= km_model_frame_count(s->model)))
    return km_fail(error, KM_USAGE, "there is no frame %g", call->arguments[7]);
  for (int d = 0; d < 2; ++d)
    def.axis[d] = (km_space_axis){.coordinate = kv_index(call, d),
                                  .from = call->arguments[2 + 2 * d],
                                  .to = call->arguments[3 + 2 * d],
                                  .steps = steps};
  def.has_point = def.frame >= 0;
  if (def.has_point)
    point_name(s->model, def.frame, &name);
  def.point_name = name.data;
  kv_map_stop(s);
  km_status status = name.failed ? km_fail(error, KM_MEMORY, "out of memory for a map")
                                 : kv_map_job_start(s->mechanism, s->state, &def, &s->job, error);
  km_text_free(&name);
  return status;
}

/* Ends the job: its cells are the answer, its curves stay with the session. cut: why sheets are missing after a
 * cancellation. */
static km_status finish(const kv_call *call, const char *cut, km_error *error) {
  kv_session *s = call->session;
  km_space_map map = {0};
  bool is_complete = false;
  km_status status = kv_map_job_end(s->job, &map, &is_complete, error);
  const char *note = is_complete ? NULL : "There may be further sheets.";
  s->job = NULL;
  if (status == KM_CANCELLED && map.cells && km_table_rows(map.cells) > 0) { /* the finished sheets */
    note = cut;
    status = KM_OK;
  }
  if (!status)
    status = add_table(call, "map", note, map.cells, error);
  if (!status) {
    km_space_map_free(&s->map);
    s->map = map;
    map = (km_space_map){0};
  }
  km_space_map_free(&map);
  return status;
}

/* map: waits for the map, as long as the limit of time allows. */
km_status kv_map(const kv_call *call, km_error *error) {
  kv_limit limit = kv_limit_begin();
  km_status status = start(call, error);
  if (status)
    return status;
  while (kv_map_job_done(call->session->job) < 1.0 && kv_limit_goes_on(&limit, 0.0))
    nanosleep(&look, NULL);
  kv_map_job_cancel(call->session->job);
  status = finish(call, "Sheets and curves are missing: the map took too long; state fewer steps or a smaller range.",
                  error);
  return kv_limit_report(status, "the map", error);
}

static km_status tell_done(const kv_call *call) {
  km_text_format(&call->answer->bytes, "{\"kind\":\"mapping\",\"request\":%u,\"done\":%.3f}", call->request,
                 kv_map_job_done(call->session->job));
  return KM_OK;
}

/* mapping: begins a map, which goes on while the page does. */
km_status kv_mapping(const kv_call *call, km_error *error) {
  km_status status = start(call, error);
  return status ? status : tell_done(call);
}

static km_status no_job(km_error *error) {
  return km_fail(error, KM_USAGE, "no map is being computed: a change of the design, or an undo, has ended it");
}

/* mapped: how far the map is; its cells where it is finished. */
km_status kv_mapped(const kv_call *call, km_error *error) {
  kv_map_job *job = call->session->job;
  return !job ? no_job(error) : kv_map_job_done(job) < 1.0 ? tell_done(call) : finish(call, "", error);
}

/* stop: ends the map; its finished sheets. */
km_status kv_stop(const kv_call *call, km_error *error) {
  kv_map_job *job = call->session->job;
  if (!job)
    return no_job(error);
  kv_map_job_cancel(job);
  return finish(call, "Sheets and curves are missing: the map was stopped.", error);
}

/* singular: the singularity curves of the last map. */
km_status kv_singular(const kv_call *call, km_error *error) {
  const km_table *curves = call->session->map.curves;
  return curves ? add_table(call, "singular", NULL, curves, error)
                : km_fail(error, KM_USAGE, "there is no map yet, whose singularity curves could be told");
}

/* boundary: the outline of the workspace of the last map's point. */
km_status kv_boundary(const kv_call *call, km_error *error) {
  const km_space_map *map = &call->session->map;
  if (!map->boundary)
    return km_fail(error, KM_USAGE, "there is no map yet with a point, whose workspace could be told");
  km_text note = {0};
  if (isfinite(map->workspace_area))
    km_text_format(&note, "area %.6g %s², %d hole%s", map->workspace_area,
                   km_model_units(call->session->model).length->suffix, map->hole_count,
                   map->hole_count == 1 ? "" : "s");
  else
    km_text_add(&note, "the outline isn't closed: a curve is missing");
  km_status status = note.failed ? km_fail(error, KM_MEMORY, "out of memory for a workspace")
                                 : add_table(call, "boundary", note.data, map->boundary, error);
  km_text_free(&note);
  return status;
}
