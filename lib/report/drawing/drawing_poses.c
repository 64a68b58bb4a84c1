/* Gathers the poses and paths that a drawing shows. */
#include "report/drawing/drawing_poses.h"

#include "base/arguments.h"
#include "base/memory.h"

#include <string.h>

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for a drawing");
}

km_status km_drawing_create(const km_mechanism *mechanism, km_drawing **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the drawing", error);
  *out = NULL;
  km_status status = km_check_given(mechanism != NULL, "mechanism", error);
  if (status)
    return status;
  *out = KM_NEW(km_drawing, 1);
  if (!*out)
    return no_memory(error);
  (*out)->mechanism = mechanism;
  return KM_OK;
}

void km_drawing_free(km_drawing *d) {
  for (size_t p = 0; d && p < d->path_count; ++p)
    km_free(d->points[p]);
  if (d) {
    km_free(d->points);
    km_free(d->paths);
    km_free(d->poses);
  }
  km_free(d);
}

static size_t bodies_of(const km_drawing *d) {
  return (size_t)d->mechanism->model->body_count;
}

/* Reserves memory for more poses. */
static bool reserve(km_drawing *d, size_t more) {
  if (d->count + more <= d->room)
    return true;
  size_t room = d->count + more > 2 * d->room ? d->count + more : 2 * d->room;
  km_pose *poses = km_resize(d->poses, room * bodies_of(d), sizeof *poses);
  if (!poses)
    return false;
  d->poses = poses;
  d->room = room;
  return true;
}

/* True if the state is of this mechanism, and the mechanism of the drawing's model. */
static km_status check_pose(const km_drawing *d, const km_mechanism *m, const km_state *state, km_error *error) {
  km_status status = km_check_given(d != NULL, "drawing", error);
  if (!status)
    status = km_check_state(m, state, error);
  if (!status && m->model != d->mechanism->model)
    status = km_fail(error, KM_USAGE, "the state is of another model than the drawing");
  return status;
}

km_status km_drawing_add_pose(km_drawing *d, const km_mechanism *m, const km_state *state, km_error *error) {
  km_status status = check_pose(d, m, state, error);
  if (status)
    return status;
  if (!reserve(d, 1))
    return no_memory(error);
  memcpy(d->poses + d->count * bodies_of(d), state->pose, bodies_of(d) * sizeof *d->poses);
  d->count++;
  return KM_OK;
}

km_status km_drawing_add_path(km_drawing *d, int frame, const char *name, km_error *error) {
  km_status status = km_check_given(d && name, "drawing or name", error);
  if (!status)
    status = km_check_index(frame, d->mechanism->model->frame_count, "frame", error);
  if (!status && d->path_count && d->paths[0].count)
    status = km_fail(error, KM_USAGE, "the other paths have points already; expected all paths before them");
  if (status)
    return status;
  km_vec3 **points = km_resize(d->points, d->path_count + 1, sizeof *points);
  d->points = points ? points : d->points;
  km_drawing_trace *paths = points ? km_resize(d->paths, d->path_count + 1, sizeof *paths) : NULL;
  d->paths = paths ? paths : d->paths;
  km_vec3 *own = paths ? KM_NEW(km_vec3, d->path_room + 1) : NULL;
  if (!own)
    return no_memory(error);
  points[d->path_count] = own;
  paths[d->path_count++] = (km_drawing_trace){.frame = frame, .name = name, .points = own};
  return KM_OK;
}

/* Reserves memory for more points of each path. */
static bool reserve_path(km_drawing *d, size_t more) {
  size_t count = d->path_count ? d->paths[0].count : 0, room = d->path_room;
  if (count + more <= room)
    return true;
  room = count + more > 2 * room ? count + more : 2 * room;
  for (size_t p = 0; p < d->path_count; ++p) {
    km_vec3 *points = km_resize(d->points[p], room, sizeof *points);
    if (!points)
      return false;
    d->paths[p].points = d->points[p] = points;
  }
  d->path_room = room;
  return true;
}

static void lead(km_drawing *d, const km_pose *poses) {
  for (size_t p = 0; p < d->path_count; ++p) {
    const km_model_frame *frame = &d->mechanism->model->frames[d->paths[p].frame];
    d->points[p][d->paths[p].count++] = km_pose_point(&poses[frame->body], frame->pose.p);
  }
}

km_status km_drawing_lead_paths(km_drawing *d, const km_mechanism *m, const km_state *state, km_error *error) {
  km_status status = check_pose(d, m, state, error);
  if (status)
    return status;
  if (!reserve_path(d, 1))
    return no_memory(error);
  lead(d, state->pose);
  return KM_OK;
}

static km_status check_rows(const km_drawing *d, const km_table *table, km_error *error) {
  km_status status = km_check_given(d && table, "drawing or table", error);
  if (status)
    return status;
  km_span q = km_table_span(table, "q.");
  if ((int)q.count != d->mechanism->coordinate_count)
    return km_fail(error, KM_USAGE, "a table of %zu coordinates (q.); expected one of %d", q.count,
                   d->mechanism->coordinate_count);
  for (size_t r = 0; r < km_table_rows(table); ++r)
    for (size_t c = 0; c < q.count; ++c)
      if (!isfinite(km_table_row(table, r)[q.first + c]))
        return km_fail(error, KM_USAGE, "row %zu: %s isn't a finite number", r, km_table_name(table, q.first + c));
  return KM_OK;
}

km_status km_drawing_add_rows(km_drawing *d, const km_table *table, km_error *error) {
  km_state *state = NULL;
  km_status status = check_rows(d, table, error);
  if (status)
    return status;
  size_t rows = km_table_rows(table);
  double *q = KM_NEW(double, (size_t)d->mechanism->coordinate_count + 1);
  status =
      q && reserve(d, rows) && reserve_path(d, rows) ? km_state_create(d->mechanism, &state, error) : no_memory(error);
  for (size_t r = 0; r < rows && !status; ++r) {
    km_pose *poses = d->poses + d->count++ * bodies_of(d);
    km_row_pose(d->mechanism, table, r, state, q, poses);
    lead(d, poses);
  }
  km_state_free(state);
  km_free(q);
  return status;
}

int km_drawing_poses(const km_drawing *d) {
  return d ? (int)d->count : 0;
}

static bool same_pose(const km_pose *a, const km_pose *b, double length) {
  double apart = km_vec3_norm(km_vec3_sub(a->p, b->p)) / length;
  for (int k = 0; k < 3; ++k)
    apart = fmax(apart, km_vec3_norm(km_vec3_sub(a->R.axis[k], b->R.axis[k])));
  return apart < 1e-6;
}

bool km_drawing_comes_round(const km_drawing *d) {
  if (!d || d->count < 3)
    return false;
  const km_pose *last = d->poses + (d->count - 1) * bodies_of(d);
  for (size_t b = 0; b < bodies_of(d); ++b)
    if (!same_pose(&d->poses[b], &last[b], d->mechanism->length))
      return false;
  return true;
}

km_status km_drawing_define(const km_drawing *d, const km_drawing_look *look, km_drawing_def *out, km_error *error) {
  km_status status = km_check_given(d && look, "drawing or look", error);
  if (status)
    return status;
  if (d->count == 0)
    return km_fail(error, KM_USAGE, "the drawing has no pose");
  if ((int)look->view < KM_VIEW_AUTO || (int)look->view > KM_VIEW_ISO)
    return km_fail(error, KM_USAGE, "found no view; expected AUTO, XY, XZ, YZ or ISO");
  if (look->meshes && look->meshes->count != d->mechanism->model->body_count)
    return km_fail(error, KM_USAGE, "meshes of %d bodies; expected those of the mechanism's model, of %d",
                   look->meshes->count, d->mechanism->model->body_count);
  *out = (km_drawing_def){.mechanism = d->mechanism,
                          .poses = d->poses,
                          .pose_count = d->count,
                          .traces = d->paths,
                          .trace_count = d->path_count,
                          .meshes = look->meshes ? (const km_mesh *const *)look->meshes->items : NULL,
                          .view = look->view,
                          .bodies = look->bodies,
                          .loads = look->loads,
                          .title = look->title ? look->title : "",
                          .name = look->name ? look->name : "",
                          .width = look->width,
                          .height = look->height};
  return KM_OK;
}

bool km_drawing_is_planar(const km_drawing *d, km_view view) {
  km_drawing_def def;
  return !km_drawing_define(d, &(km_drawing_look){.view = view}, &def, NULL) && km_drawing_def_is_planar(&def);
}

void km_row_pose(const km_mechanism *m, const km_table *table, size_t row, km_state *state, double *q, km_pose *poses) {
  const double *values = km_table_row(table, row) + km_table_span(table, "q.").first;
  for (int c = 0; c < m->coordinate_count; ++c)
    q[c] = values[c] * km_model_coordinate_factor(m->model, c);
  km_state_set(m, state, q);
  km_poses_compute(m, state);
  memcpy(poses, state->pose, (size_t)m->topology.body_count * sizeof *poses);
}
