/* View: projection direction and scale from the inertial frame to the page. */
#include "report/drawing/drawing_parts.h"

#include <string.h>

static const double parallel = 1e-6; /* sines below this are 0 */

static const char *const words[] = {"auto", "xy", "xz", "yz", "iso"};

bool km_view_find(const char *word, km_view *view) {
  if (!word || !view)
    return false;
  for (int i = 0; i <= KM_VIEW_ISO; ++i) {
    if (strcmp(word, words[i]) != 0)
      continue;
    *view = (km_view)i;
    return true;
  }
  return false;
}

static bool along(km_vec3 a, km_vec3 b) {
  return km_vec3_norm(km_vec3_cross(a, b)) < parallel;
}
static bool across(km_vec3 a, km_vec3 b) {
  return fabs(km_vec3_dot(a, b)) < parallel;
}

/* Axes of a joint that determine a plane of motion. */
typedef struct axes {
  km_vec3 turn, slide; /* turn: the normal of a planar joint, too */
  bool turns, slides, spatial;
} axes;

static axes axes_of(const km_drawing_def *drawing, int joint) {
  const km_model *model = drawing->mechanism->model;
  const km_model_joint *def = &model->joints[joint];
  const km_model_frame *frame = &model->frames[def->frame[0]];
  const km_pose *pose = drawing->poses + drawing->full * (size_t)model->body_count + (size_t)frame->body;
  km_rotation R = km_rotation_product(&pose->R, &frame->pose.R);
  axes a = {0};
  switch (def->type) {
  case KM_RX:
  case KM_RY:
  case KM_RZ:
    a.turns = true;
    a.turn = R.axis[def->type - KM_RX];
    break;
  case KM_TX:
  case KM_TY:
  case KM_TZ:
    a.slides = true;
    a.slide = R.axis[def->type - KM_TX];
    break;
  case KM_PLANAR:
    a.turns = true;
    a.turn = R.axis[2];
    break;
  case KM_RIGID:
    break;
  default:
    a.spatial = true;
  }
  return a;
}

static bool moves_in(const axes *a, km_vec3 normal) {
  return !a->spatial && (!a->turns || along(a->turn, normal)) && (!a->slides || across(a->slide, normal));
}

/* True if all joints in loops move in the plane, and most of the others (an excavator swings on its tracks, but
 * works in a plane). */
static bool is_plane(const km_drawing_def *drawing, km_vec3 normal) {
  const km_mechanism *m = drawing->mechanism;
  int good = 0, bad = 0;
  for (int j = 0; j < m->model->joint_count; ++j) {
    axes a = axes_of(drawing, j);
    if (moves_in(&a, normal))
      ++good;
    else if (m->topology.substructure_count == 0 || m->topology.substructure_of_joint[j] >= 0)
      return false;
    else
      ++bad;
  }
  return good > 3 * bad;
}

static bool find_plane(const km_drawing_def *drawing, km_vec3 *normal) {
  static const km_vec3 planes[] = {{0, 0, 1}, {0, -1, 0}, {1, 0, 0}};
  int joints = drawing->mechanism->model->joint_count;
  bool turns = false;
  for (int j = 0; j < joints; ++j) {
    axes a = axes_of(drawing, j);
    turns = turns || a.turns;
    *normal = a.turn;
    if (a.turns && is_plane(drawing, a.turn))
      return true;
  }
  for (int i = 0; i < 3 && !turns; ++i) {
    *normal = planes[i];
    if (is_plane(drawing, *normal))
      return true;
  }
  return false;
}

static km_vec3 unit(km_vec3 a) {
  return km_vec3_scale(1.0 / km_vec3_norm(a), a);
}

/* Upward direction: opposite to gravity, or z. */
static km_vec3 upwards(const km_model *model) {
  return km_vec3_norm(model->gravity) > 0.0 ? unit(km_vec3_scale(-1.0, model->gravity)) : (km_vec3){0, 0, 1};
}

static void inspect(km_projection *view, km_vec3 toward, km_vec3 up) {
  view->toward = unit(toward);
  view->right = unit(km_vec3_cross(up, view->toward));
  view->up = km_vec3_cross(view->toward, view->right);
}

/* A plane in general position, from the side from which x (or else y) runs to the right. */
static void view_along(km_projection *view, const km_model *model, km_vec3 normal) {
  km_vec3 up = upwards(model);
  if (fabs(km_vec3_dot(up, normal)) > 0.9)
    up = fabs(normal.y) < 0.9 ? (km_vec3){0, 1, 0} : (km_vec3){0, 0, 1};
  inspect(view, normal, up);
  if (view->right.x < -parallel || (view->right.x < parallel && view->right.y < 0.0))
    inspect(view, km_vec3_scale(-1.0, normal), up);
  view->name = "view of the plane of motion";
}

/* Not exactly isometric: what is symmetric about 45 degrees would hide behind itself. */
static void view_isometric(km_projection *view, const km_model *model) {
  const double azimuth = 0.62, elevation = 0.5;
  km_vec3 up = upwards(model), side = {1, 0, 0};
  if (fabs(up.x) > 0.6)
    side = (km_vec3){0, 1, 0};
  side = unit(km_vec3_axpy(-km_vec3_dot(side, up), up, side));
  km_vec3 front = km_vec3_cross(side, up);
  km_vec3 level = km_vec3_axpy(sin(azimuth), side, km_vec3_scale(cos(azimuth), front));
  inspect(view, km_vec3_axpy(cos(elevation), level, km_vec3_scale(sin(elevation), up)), up);
  view->name = "iso view";
}

km_projection km_view_make(const km_drawing_def *drawing) {
  static const km_vec3 normals[] = {{0, 0, 1}, {0, -1, 0}, {1, 0, 0}};
  static const char *const names[] = {"view of the xy plane", "view of the xz plane", "view of the yz plane"};
  const km_model *model = drawing->mechanism->model;
  km_projection view = {.scale = 1.0};
  km_view asked = drawing->view;
  km_vec3 normal;
  bool plane = find_plane(drawing, &normal);
  if (asked == KM_VIEW_AUTO && !plane)
    asked = KM_VIEW_ISO;
  for (int i = 0; i < 3 && asked == KM_VIEW_AUTO; ++i)
    if (along(normal, normals[i]))
      asked = (km_view)(KM_VIEW_XY + i);
  if (asked == KM_VIEW_AUTO) {
    view_along(&view, model, normal);
  } else if (asked == KM_VIEW_ISO) {
    view_isometric(&view, model);
  } else {
    inspect(&view, normals[asked - KM_VIEW_XY], asked == KM_VIEW_XY ? (km_vec3){0, 1, 0} : (km_vec3){0, 0, 1});
    view.name = names[asked - KM_VIEW_XY];
  }
  view.planar = plane && along(normal, view.toward);
  return view;
}

bool km_drawing_def_is_planar(const km_drawing_def *drawing) {
  return km_view_make(drawing).planar;
}

static void take(km_extent *extent, const km_projection *view, km_vec3 point) {
  km_vec3 from = km_vec3_sub(point, extent->origin);
  const double at[2] = {km_vec3_dot(view->right, from), km_vec3_dot(view->up, from)};
  for (int k = 0; k < 2; ++k) {
    if (!isfinite(at[k]))
      continue;
    extent->low[k] = fmin(extent->low[k], at[k]);
    extent->high[k] = fmax(extent->high[k], at[k]);
  }
}

/* The first point of a body that has any: far from it the inertial origin may lie. */
static km_vec3 some_point(const km_drawing_def *drawing, const km_shape *shapes) {
  for (int b = 0; b < drawing->mechanism->model->body_count; ++b)
    if (shapes[b].count)
      return km_pose_point(&drawing->poses[b], shapes[b].points[0]);
  return (km_vec3){0, 0, 0};
}

km_extent km_extent_of(const km_drawing_def *drawing, const km_shape *shapes, const km_projection *view) {
  int bodies = drawing->mechanism->model->body_count;
  km_extent extent = {.origin = some_point(drawing, shapes)};
  for (size_t p = 0; p < drawing->pose_count; ++p)
    for (int b = 0; b < bodies; ++b)
      for (int i = 0; i < shapes[b].count; ++i)
        take(&extent, view, km_pose_point(&drawing->poses[p * (size_t)bodies + (size_t)b], shapes[b].points[i]));
  for (size_t p = 0; p < drawing->pose_count && drawing->meshes; ++p)
    for (int b = 0; b < bodies; ++b)
      for (int i = 0; drawing->meshes[b] && i < drawing->meshes[b]->vertex_count; ++i)
        take(&extent, view,
             km_pose_point(&drawing->poses[p * (size_t)bodies + (size_t)b], drawing->meshes[b]->vertices[i]));
  for (size_t t = 0; t < drawing->trace_count; ++t)
    for (size_t i = 0; i < drawing->traces[t].count; ++i)
      take(&extent, view, drawing->traces[t].points[i]);
  return extent;
}

void km_projection_fit(km_projection *view, const km_extent *extent, km_rectangle inner) {
  double width = extent->high[0] - extent->low[0], height = extent->high[1] - extent->low[1];
  double scale = fmin(width > 0.0 ? inner.width / width : HUGE_VAL, height > 0.0 ? inner.height / height : HUGE_VAL);
  view->scale = isfinite(scale) && scale > 0.0 ? scale : 1.0;
  view->middle = (km_canvas_point){inner.left + 0.5 * inner.width, inner.top + 0.5 * inner.height};
  km_vec3 middle = km_vec3_axpy(0.5 * (extent->low[0] + extent->high[0]), view->right,
                                km_vec3_scale(0.5 * (extent->low[1] + extent->high[1]), view->up));
  view->centre = km_vec3_add(extent->origin, middle);
}

km_spot km_project_direction(const km_projection *view, km_vec3 direction) {
  return (km_spot){km_vec3_dot(view->right, direction), -km_vec3_dot(view->up, direction),
                   km_vec3_dot(view->toward, direction)};
}

km_spot km_project(const km_projection *view, km_vec3 point) {
  km_spot at = km_project_direction(view, km_vec3_sub(point, view->centre));
  return (km_spot){view->middle.x + view->scale * at.x, view->middle.y + view->scale * at.y, view->scale * at.depth};
}
