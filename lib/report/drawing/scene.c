/* One pose as items on the page: bars, plates, cylinders, the ground, symbols. A body's mesh takes the place of its
 * links. */
#include "report/drawing/drawing_parts.h"

static const double bar_half = 0.85; /* unit: pin radii; half the width of a bar */
static const double far_apart = 5.0; /* unit: pin radii; shorter prismatic joints have no
                                                                * cylinder */
enum {
  LAYER_BASE,
  LAYER_LINKS,
  LAYER_GROUND,
  LAYER_SYMBOLS
}; /* order of painting in a plane; in space the depth
                                                                * decides */

/* Appends an item with `count` points; NULL when out of memory. */
static km_item *add_item(km_scene *scene, km_item_kind kind, int layer, int count) {
  km_spot *spots = KM_ARENA_NEW(scene->arena, km_spot, (size_t)count);
  if (!spots || scene->count == scene->capacity)
    return NULL;
  km_item *item = &scene->items[scene->count++];
  *item = (km_item){.kind = kind, .layer = layer, .joint = -1, .body = -1, .spots = spots, .count = count};
  return item;
}

km_pose km_joint_frame(const km_scene *scene, int joint, int end) {
  const km_model *model = scene->mechanism->model;
  const km_model_frame *frame = &model->frames[model->joints[joint].frame[end]];
  return km_pose_product(&scene->pose[frame->body], &frame->pose);
}

km_vec3 km_joint_place(const km_scene *scene, int joint) {
  const km_mark *mark = &scene->marks[joint];
  km_vec3 guide = km_joint_frame(scene, joint, mark->guide).p;
  km_vec3 guided = km_joint_frame(scene, joint, !mark->guide).p;
  return mark->look == KM_LOOK_ACTUATOR ? km_vec3_scale(0.5, km_vec3_add(guide, guided)) : guided;
}

static bool has_mesh(const km_scene *scene, int body) {
  return scene->surfaces[body].mesh != NULL;
}

bool km_joint_is_solid(const km_scene *scene, int joint) {
  const km_model *model = scene->mechanism->model;
  return has_mesh(scene, km_joint_body(model, joint, 0)) && has_mesh(scene, km_joint_body(model, joint, 1));
}

static void add_bar(km_scene *scene, int body, km_spot a, km_spot b) {
  km_item *item = add_item(scene, KM_ITEM_BAR, LAYER_LINKS, 2);
  if (!item)
    return;
  item->body = body;
  item->spots[0] = a;
  item->spots[1] = b;
  item->reach = bar_half * scene->radius;
}

/* Bodies of three points or more are plates, but bars where these are in line on the page. */
static void add_outline(km_scene *scene, int body, km_spot *spots, int count) {
  km_item *item = add_item(scene, body ? KM_ITEM_PLATE : KM_ITEM_BASE, body ? LAYER_LINKS : LAYER_BASE, 2 * count + 1);
  if (!item)
    return;
  item->body = body;
  item->reach = bar_half * scene->radius;
  item->count = km_convex_hull(spots, count, item->spots);
  if (item->count == 2)
    item->kind = body ? KM_ITEM_BAR : KM_ITEM_BASE;
}

static void add_body(km_scene *scene, int body) {
  const km_shape *shape = &scene->shapes[body];
  km_spot *spots = KM_ARENA_NEW(scene->arena, km_spot, (size_t)shape->count);
  for (int i = 0; spots && i < shape->count; ++i)
    spots[i] = km_project(scene->view, km_pose_point(&scene->pose[body], shape->points[i]));
  if (!spots || shape->count < 2)
    return;
  if (shape->count == 2)
    add_bar(scene, body, spots[0], spots[1]);
  else
    add_outline(scene, body, spots, shape->count);
}

/* Ground plate of a spatial mechanism; in a plane the hatching suffices. */
static void add_base(km_scene *scene) {
  const km_shape *shape = &scene->shapes[0];
  km_spot *spots = KM_ARENA_NEW(scene->arena, km_spot, (size_t)shape->count);
  for (int i = 0; spots && i < shape->count; ++i)
    spots[i] = km_project(scene->view, shape->points[i]);
  if (spots && shape->count > 1 && !scene->view->planar && scene->fade <= 0.0)
    add_outline(scene, 0, spots, shape->count);
}

/* Obstruction of a ground symbol in a direction by a body at the point: −0.2 none, 0.8 complete. */
static double obstruction(const km_scene *scene, const km_pose *pose, int body, km_spot at, km_spot direction) {
  double worst = 0.0;
  for (int i = 0; i < scene->shapes[body].count; ++i) {
    km_spot other = km_project(scene->view, km_pose_point(&pose[body], scene->shapes[body].points[i]));
    double length = km_spot_distance(at, other);
    if (length > scene->radius)
      worst = fmax(worst, (direction.x * (other.x - at.x) + direction.y * (other.y - at.y)) / length - 0.2);
  }
  return worst;
}

/* Direction of the ground symbol: down, unless a link leaves in that direction; the freest of four directions, in
 * this configuration or, if the symbol is fixed, in all. */
static km_spot ground_direction(const km_scene *scene, int body, km_spot at) {
  static const km_spot directions[] = {{0, 1, 0}, {-1, 0, 0}, {1, 0, 0}, {0, -1, 0}};
  static const double dislike[] = {0.0, 0.5, 0.5, 0.4};
  const size_t bodies = (size_t)scene->mechanism->model->body_count;
  double least = HUGE_VAL;
  int best = 0;
  for (int d = 0; d < 4; ++d) {
    double worst = obstruction(scene, scene->pose, body, at, directions[d]);
    for (size_t p = 0; p < scene->pose_count && scene->steady; ++p)
      worst = fmax(worst, obstruction(scene, scene->poses + p * bodies, body, at, directions[d]));
    if (worst + dislike[d] < least) {
      least = worst + dislike[d];
      best = d;
    }
  }
  return directions[best];
}

/* Ground under a joint, once for all joints in one place. */
static void add_mount(km_scene *scene, int joint, int body, km_spot at) {
  for (size_t i = 0; i < scene->count; ++i)
    if (scene->items[i].kind == KM_ITEM_MOUNT && km_spot_distance(scene->items[i].spots[0], at) < 0.5 * scene->radius)
      return;
  km_item *item = add_item(scene, KM_ITEM_MOUNT, LAYER_GROUND, 1);
  if (!item)
    return;
  item->joint = joint;
  item->spots[0] = at;
  item->spots[0].depth -= scene->radius; /* offset below the symbol */
  item->axis[0] = ground_direction(scene, body, at);
  item->reach = 3.0 * scene->radius;
}

static void add_rail(km_scene *scene, int joint, km_vec3 axis) {
  km_item *item = add_item(scene, KM_ITEM_RAIL, LAYER_GROUND, 2);
  if (!item)
    return;
  const size_t bodies = (size_t)scene->mechanism->model->body_count;
  km_vec3 place = km_joint_place(scene, joint);
  double reach[2] = {0.0, 0.0}; /* corners of the bounding box over all configurations */
  for (size_t p = 0; p < scene->pose_count; ++p) {
    km_scene other = *scene;
    other.pose = scene->poses + p * bodies;
    double along = km_vec3_dot(axis, km_vec3_sub(km_joint_place(&other, joint), place));
    reach[0] = fmin(reach[0], along);
    reach[1] = fmax(reach[1], along);
  }
  item->joint = joint;
  item->reach = 2.0 * scene->radius;
  item->axis[0] = km_project_direction(scene->view, axis);
  double past = 5.0 * scene->radius / scene->view->scale;
  for (int k = 0; k < 2; ++k)
    item->spots[k] = km_project(scene->view, km_vec3_axpy(reach[k] + (k ? past : -past), axis, place));
}

static void add_ground(km_scene *scene, int joint) {
  const km_model *model = scene->mechanism->model;
  const km_mark *mark = &scene->marks[joint];
  int end = km_joint_body(model, joint, 0) == 0 ? 0 : 1;
  if (km_joint_body(model, joint, end) != 0 || mark->look == KM_LOOK_FREE || mark->look == KM_LOOK_TABLE)
    return;
  km_pose frame = km_joint_frame(scene, joint, end);
  if (mark->look == KM_LOOK_SLIDER) {
    add_rail(scene, joint, frame.R.axis[model->joints[joint].type - KM_TX]);
  } else {
    add_mount(scene, joint, km_joint_body(model, joint, !end), km_project(scene->view, frame.p));
  }
}

static km_spot between(km_spot a, km_spot b, double t) {
  return (km_spot){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.depth + t * (b.depth - a.depth)};
}

/* A rod that slides in a cylinder, when they are far enough apart to be seen. */
static void add_actuator(km_scene *scene, int joint) {
  const km_model *model = scene->mechanism->model;
  km_spot a = km_project(scene->view, km_joint_frame(scene, joint, 0).p);
  km_spot b = km_project(scene->view, km_joint_frame(scene, joint, 1).p);
  double length = km_spot_distance(a, b);
  if (length < far_apart * scene->radius)
    return;
  double reach = fabs(km_vec3_norm(km_vec3_sub(km_joint_frame(scene, joint, 1).p, km_joint_frame(scene, joint, 0).p)));
  double part = fmin(fmax(scene->marks[joint].barrel / reach, 0.3), 0.85);
  km_item *rod = add_item(scene, KM_ITEM_ROD, LAYER_LINKS, 2);
  km_item *barrel = add_item(scene, KM_ITEM_BARREL, LAYER_LINKS, 2);
  if (!barrel || !rod)
    return;
  rod->body = km_joint_body(model, joint, 1);
  rod->spots[0] = between(a, b, 0.5 * part);
  rod->spots[1] = b;
  rod->reach = 0.5 * scene->radius;
  barrel->body = km_joint_body(model, joint, 0);
  barrel->spots[0] = a;
  barrel->spots[1] = between(a, b, part);
  barrel->reach = 1.25 * scene->radius;
  barrel->joint = rod->joint = joint;
}

/* The guide of a slide on a moving body: a bar from the body's own frame to past the box. */
static void add_guide(km_scene *scene, int joint) {
  const km_model *model = scene->mechanism->model;
  const km_mark *mark = &scene->marks[joint];
  int body = km_joint_body(model, joint, mark->guide);
  if (body == 0 || has_mesh(scene, body))
    return;
  km_pose frame = km_joint_frame(scene, joint, mark->guide);
  km_spot axis = km_project_direction(scene->view, frame.R.axis[model->joints[joint].type - KM_TX]);
  km_spot a = km_project(scene->view, frame.p), b = km_project(scene->view, km_joint_place(scene, joint));
  double past = (axis.x * (b.x - a.x) + axis.y * (b.y - a.y) < 0.0 ? -3.5 : 3.5) * scene->radius;
  if (km_spot_distance(a, b) < 3.5 * scene->radius) /* the guide extends in both directions at equal positions */
    a = (km_spot){b.x - past * axis.x, b.y - past * axis.y, b.depth - past * axis.depth};
  add_bar(scene, body, a, (km_spot){b.x + past * axis.x, b.y + past * axis.y, b.depth + past * axis.depth});
}

/* The rod on which a sleeve or nut has moved away from the frame of the guide. */
static void add_spindle(km_scene *scene, int joint) {
  const km_mark *mark = &scene->marks[joint];
  km_spot a = km_project(scene->view, km_joint_frame(scene, joint, mark->guide).p);
  km_spot b = km_project(scene->view, km_joint_place(scene, joint));
  km_item *rod = km_spot_distance(a, b) > scene->radius ? add_item(scene, KM_ITEM_ROD, LAYER_LINKS, 2) : NULL;
  if (!rod)
    return;
  rod->body = km_joint_body(scene->mechanism->model, joint, mark->guide);
  rod->joint = joint;
  rod->spots[0] = a;
  rod->spots[1] = b;
  rod->reach = 0.5 * scene->radius;
}

/* The axes that a symbol shows: of turning, or of sliding. */
static void symbol_axes(const km_scene *scene, int joint, km_item *item) {
  const km_model_joint *def = &scene->mechanism->model->joints[joint];
  km_pose parent = km_joint_frame(scene, joint, 0), child = km_joint_frame(scene, joint, 1);
  int first = def->type <= KM_TZ ? (int)def->type % 3 : 2;
  item->axis[0] = km_project_direction(scene->view, parent.R.axis[first]);
  if (def->type == KM_UNIVERSAL || def->type == KM_PLANAR)
    item->axis[0] = km_project_direction(scene->view, parent.R.axis[0]);
  /* The second axis of a cross turns with the child. */
  item->axis[1] = km_project_direction(scene->view, def->type == KM_UNIVERSAL ? child.R.axis[1] : parent.R.axis[1]);
}

static void add_symbol(km_scene *scene, int joint) {
  km_item *item = add_item(scene, KM_ITEM_SYMBOL, LAYER_SYMBOLS, 1);
  if (!item)
    return;
  item->joint = joint;
  item->spots[0] = km_project(scene->view, km_joint_place(scene, joint));
  /* Depth of a symbol: in front of the links that it joins; a pin in front of its box or weld. */
  bool carries = scene->marks[joint].look == KM_LOOK_SLIDER || scene->marks[joint].look == KM_LOOK_WELD;
  item->spots[0].depth += (carries ? 1.6 : 2.0) * scene->radius;
  item->reach = km_symbol_reach(scene, joint);
  symbol_axes(scene, joint, item);
}

static void add_joint(km_scene *scene, int joint) {
  const km_mark *mark = &scene->marks[joint];
  if (scene->fade <= 0.0) /* a faint configuration uses the ground of the full one */
    add_ground(scene, joint);
  if (mark->look == KM_LOOK_SLEEVE || mark->look == KM_LOOK_SCREW)
    add_spindle(scene, joint);
  size_t before = scene->count;
  if (mark->look == KM_LOOK_ACTUATOR && !km_joint_is_solid(scene, joint))
    add_actuator(scene, joint);
  if (mark->look == KM_LOOK_SLIDER)
    add_guide(scene, joint);
  if (mark->look != KM_LOOK_ACTUATOR || scene->count == before)
    add_symbol(scene, joint);
}

static void find_depths(km_scene *scene) {
  for (size_t i = 0; i < scene->count; ++i) {
    km_item *item = &scene->items[i];
    for (int k = 0; k < item->count; ++k)
      item->depth += item->spots[k].depth / item->count;
    item->depth = round(item->depth * 1e4) * 1e-4; /* all items of a plane have equal depth */
    if (!scene->view->planar && item->layer != LAYER_BASE)
      item->layer = LAYER_LINKS;
  }
}

void km_scene_build(km_scene *scene) {
  const km_model *model = scene->mechanism->model;
  scene->capacity = (size_t)model->body_count + 4 * (size_t)model->joint_count + 1;
  scene->items = KM_ARENA_NEW(scene->arena, km_item, scene->capacity);
  if (!scene->items)
    return;
  add_base(scene);
  for (int b = 1; b < model->body_count; ++b)
    if (!has_mesh(scene, b))
      add_body(scene, b);
  for (int j = 0; j < model->joint_count; ++j)
    add_joint(scene, j);
  find_depths(scene);
  km_scene_add_faces(scene);
  if (!scene->arena->failed)
    km_scene_order(scene);
}
