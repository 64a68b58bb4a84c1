/* Loads as arrows that end at the points where they act. */
#include "report/canvas/palette.h"
#include "report/drawing/drawing_parts.h"

static const double arrow_length = 30, head_length = 7, head_half = 3; /* points on a page of the default size */

/* The force along the inertial axes. */
static km_vec3 force_of(const km_scene *scene, const km_applied_load *load) {
  const km_model_frame *frame = &scene->mechanism->model->frames[load->frame];
  km_pose pose = km_pose_product(&scene->pose[frame->body], &frame->pose);
  return load->turning ? km_rotate(&pose.R, load->force) : load->force;
}

static bool inside(km_rectangle place, km_spot at) {
  return at.x >= place.left && at.x <= place.left + place.width && at.y >= place.top &&
         at.y <= place.top + place.height;
}

bool km_load_arrow(const km_studio *s, const km_scene *scene, int index, km_spot out[2]) {
  const km_model *model = scene->mechanism->model;
  const km_applied_load *load = &model->loads[index];
  const km_model_frame *frame = &model->frames[load->frame];
  km_vec3 force = force_of(scene, load);
  double size = km_vec3_norm(force);
  if (!(size > 0.0))
    return false;
  km_spot point = km_project(&s->view, km_pose_point(&scene->pose[frame->body], frame->pose.p));
  km_spot way = km_project_direction(&s->view, km_vec3_scale(1.0 / size, force));
  double length = hypot(way.x, way.y), reach = arrow_length * s->size;
  if (length < 0.1)
    return false; /* it points at the viewer */
  way = (km_spot){way.x / length * reach, way.y / length * reach, 0};
  out[0] = (km_spot){point.x - way.x, point.y - way.y, point.depth};
  out[1] = point;
  if (inside(s->place, out[0]))
    return true;
  out[0] = point; /* only the other side is free: the arrow begins at the point */
  out[1] = (km_spot){point.x + way.x, point.y + way.y, point.depth};
  return true;
}

static void draw_arrow(const km_studio *s, const km_spot ends[2]) {
  const km_colour colour = km_palette_text(KM_LOAD_COLOUR);
  const km_pen pen = {.colour = colour, .width = 1.4 * s->size};
  double x = ends[1].x - ends[0].x, y = ends[1].y - ends[0].y, length = hypot(x, y), head = head_length * s->size,
         half = head_half * s->size;
  x /= length;
  y /= length;
  const km_canvas_point neck = {ends[1].x - x * head, ends[1].y - y * head};
  const km_canvas_point corners[3] = {
      {ends[1].x, ends[1].y}, {neck.x - y * half, neck.y + x * half}, {neck.x + y * half, neck.y - x * half}};
  km_canvas_line(s->canvas, &pen, (km_canvas_point){ends[0].x, ends[0].y}, neck);
  km_canvas_polygon(s->canvas, colour, corners, 3);
}

void km_studio_draw_loads(const km_studio *s, const km_scene *scene) {
  km_spot ends[2];
  for (int i = 0; i < scene->mechanism->model->load_count && s->drawing->loads; ++i)
    if (km_load_arrow(s, scene, i, ends))
      draw_arrow(s, ends);
}
