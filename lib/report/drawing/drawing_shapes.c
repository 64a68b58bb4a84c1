/* Shapes of bodies and joints independent of the configuration: points, colours, styles. */
#include "report/drawing/drawing_parts.h"

static const double same = 1e-6; /* relative to the mechanism's size: nearer points are merged */

static void add_point(km_shape *shape, km_vec3 point, double near) {
  for (int i = 0; i < shape->count; ++i)
    if (km_vec3_norm(km_vec3_sub(shape->points[i], point)) <= near)
      return;
  shape->points[shape->count++] = point;
}

/* The largest distance from a body's origin to its frames. */
static double size_of(const km_model *model) {
  double size = 0.0;
  for (int f = 0; f < model->frame_count; ++f)
    if (model->frames[f].body)
      size = fmax(size, km_vec3_norm(model->frames[f].pose.p));
  return size;
}

static void add_joints(const km_model *model, km_shape *shapes, double near) {
  for (int j = 0; j < model->joint_count; ++j)
    for (int end = 0; end < 2; ++end) {
      const km_model_frame *frame = &model->frames[model->joints[j].frame[end]];
      add_point(&shapes[frame->body], frame->pose.p, near);
      shapes[frame->body].joints++;
    }
}

/* Frames that no joint uses are the feet, tips and tools. A body's own origin is none of them. */
static void add_frames(const km_model *model, km_shape *shapes, double near) {
  for (int f = 0, before = -1; f < model->frame_count; ++f) {
    const km_model_frame *frame = &model->frames[f];
    bool origin = frame->body != before;
    before = frame->body;
    if (!origin && frame->body)
      add_point(&shapes[frame->body], frame->pose.p, near);
  }
}

/* A body at the end of a chain without any frames, such as a pendulum: up to its centre of mass. */
static void add_centres(const km_model *model, km_shape *shapes, double near) {
  for (int b = 1; b < model->body_count; ++b)
    if (shapes[b].joints == 1 && shapes[b].count == 1 && model->bodies[b].mass > 0.0)
      add_point(&shapes[b], model->bodies[b].center_of_mass, near);
}

/* The bodies that joints connect a body to: neighbour[first[body] … first[body + 1]-1], where first[body + 1] is the
 * next free place of a body while they are listed. */
static void list_neighbours(const km_model *model, int *first, int *neighbour) {
  for (int j = 0; j < model->joint_count; ++j)
    for (int end = 0; end < 2; ++end)
      first[km_joint_body(model, j, end) + 2]++;
  for (int b = 0; b < model->body_count; ++b)
    first[b + 2] += first[b + 1];
  for (int j = 0; j < model->joint_count; ++j)
    for (int end = 0; end < 2; ++end)
      neighbour[first[km_joint_body(model, j, end) + 1]++] = km_joint_body(model, j, !end);
}

/* In turn, but never that of a body next to it: without black and the grey of the ground. */
static void choose_colours(const km_model *model, const int *first, const int *neighbour, km_shape *shapes) {
  static const int palette[] = {0, 5, 2, 4, 6, 1, 7};
  enum { COLOURS = sizeof palette / sizeof palette[0] };
  shapes[0].colour = -1;
  for (int b = 1, next = 0; b < model->body_count; ++b) {
    bool taken[COLOURS] = {false};
    for (int i = first[b]; i < first[b + 1]; ++i)
      for (int c = 0; c < COLOURS; ++c)
        taken[c] = taken[c] || (neighbour[i] < b && shapes[neighbour[i]].colour == palette[c]);
    int choice = next;
    for (int c = 0; c < COLOURS && taken[choice]; ++c)
      choice = (choice + 1) % COLOURS;
    shapes[b].colour = palette[choice];
    next = (choice + 1) % COLOURS;
  }
}

km_shape *km_shapes_make(const km_model *model, km_arena *arena) {
  km_shape *shapes = KM_ARENA_NEW(arena, km_shape, (size_t)model->body_count);
  int *room = KM_ARENA_NEW(arena, int, (size_t)model->body_count);
  int *first = KM_ARENA_NEW(arena, int, (size_t)model->body_count + 2);
  int *neighbour = KM_ARENA_NEW(arena, int, 2 * (size_t)model->joint_count);
  if (arena->failed)
    return NULL;
  for (int f = 0; f < model->frame_count; ++f)
    room[model->frames[f].body]++;
  for (int b = 0; b < model->body_count; ++b)
    shapes[b].points = KM_ARENA_NEW(arena, km_vec3, (size_t)room[b] + 1);
  if (arena->failed)
    return NULL;
  double near = same * size_of(model);
  add_joints(model, shapes, near);
  add_frames(model, shapes, near);
  add_centres(model, shapes, near);
  list_neighbours(model, first, neighbour);
  choose_colours(model, first, neighbour, shapes);
  return shapes;
}

/* The direction of a slide in the body at one of its ends. */
static km_vec3 slide_axis(const km_model *model, int joint, int end) {
  const km_model_joint *def = &model->joints[joint];
  return model->frames[def->frame[end]].pose.R.axis[def->type - KM_TX];
}

/* True if all points of the body lie on the line of the prismatic joint: then it is drawn as a cylinder or rod. */
static bool is_slender(const km_model *model, const km_shape *shapes, int joint, int end, double near) {
  const km_model_frame *frame = &model->frames[model->joints[joint].frame[end]];
  const km_shape *shape = &shapes[frame->body];
  km_vec3 axis = slide_axis(model, joint, end);
  for (int i = 0; i < shape->count; ++i)
    if (km_vec3_norm(km_vec3_cross(axis, km_vec3_sub(shape->points[i], frame->pose.p))) > near)
      return false;
  return frame->body != 0;
}

/* As long as the shortest stroke allows, so that it keeps its length in every pose. */
static double barrel_length(const km_model *model, int joint) {
  const km_model_coordinate *c = &model->coordinates[model->joints[joint].first_coordinate];
  return isfinite(c->low) && c->low > 0.0 ? 0.85 * c->low : 0.6 * fabs(c->position);
}

static km_mark slide_mark(const km_model *model, const km_shape *shapes, int joint, double near) {
  bool slender[2] = {is_slender(model, shapes, joint, 0, near), is_slender(model, shapes, joint, 1, near)};
  if (slender[0] && slender[1])
    return (km_mark){KM_LOOK_ACTUATOR, 0, barrel_length(model, joint)};
  bool child_guides = km_joint_body(model, joint, 1) == 0 || (slender[0] && km_joint_body(model, joint, 0) != 0);
  return (km_mark){KM_LOOK_SLIDER, child_guides, 0.0};
}

km_mark *km_marks_make(const km_model *model, const km_shape *shapes, km_arena *arena) {
  static const km_look looks[KM_JOINT_TYPES] = {
      [KM_RIGID] = KM_LOOK_WELD,         [KM_SPHERICAL] = KM_LOOK_BALL,  [KM_FLOAT] = KM_LOOK_FREE,
      [KM_CYLINDRICAL] = KM_LOOK_SLEEVE, [KM_UNIVERSAL] = KM_LOOK_CROSS, [KM_PLANAR] = KM_LOOK_TABLE,
      [KM_SCREW] = KM_LOOK_SCREW}; /* Rx, Ry, Rz: KM_LOOK_PIN */
  km_mark *marks = KM_ARENA_NEW(arena, km_mark, (size_t)model->joint_count);
  double near = same * size_of(model);
  for (int j = 0; marks && j < model->joint_count; ++j) {
    km_joint_type type = model->joints[j].type;
    if (type == KM_TX || type == KM_TY || type == KM_TZ)
      marks[j] = slide_mark(model, shapes, j, near);
    else
      marks[j] = (km_mark){looks[type], km_joint_body(model, j, 1) == 0, 0.0};
  }
  return marks;
}
