/* Writes a model as SDFormat: links at their poses, and all joints. */
#include "exchange/robot/robot_write.h"

#include "model/validation.h"

#include <math.h>
#include <string.h>

static void add_pose(km_written *w, const km_pose *X, const char *relative_to) {
  double wxyz[4];
  km_written_quaternion(&X->R, wxyz);
  const double v[7] = {X->p.x, X->p.y, X->p.z, wxyz[1], wxyz[2], wxyz[3], wxyz[0]};
  km_xml_begin(&w->xml, "pose");
  if (relative_to)
    km_xml_set(&w->xml, "relative_to", relative_to);
  km_xml_set(&w->xml, "rotation_format", "quat_xyzw");
  km_text_add(w->xml.out, ">");
  km_xml_add_numbers(w->xml.out, v, 7, true);
  km_text_add(w->xml.out, "</pose>\n");
  w->xml.open = false;
  w->xml.depth--;
}

static void add_number(km_written *w, const char *name, double value) {
  km_xml_numbers(&w->xml, name, &value, 1, false);
}

/* A link without a statement would weigh 1 kg. */
static void add_inertial(km_written *w, const double center[3], double mass, const double I[6]) {
  static const char *const keys[6] = {"ixx", "iyy", "izz", "ixy", "iyz", "ixz"};
  km_pose at = {km_rotation_identity(), km_vec3_from_array(center)};
  km_xml_begin(&w->xml, "inertial");
  add_pose(w, &at, NULL);
  add_number(w, "mass", mass);
  km_xml_begin(&w->xml, "inertia");
  for (int k = 0; k < 6; ++k)
    add_number(w, keys[k], I[k]);
  km_xml_end(&w->xml, "inertia");
  km_xml_end(&w->xml, "inertial");
}

static void add_geometry(km_written *w, const km_model_shape *shape) {
  const char *element = km_shape_word(shape->kind);
  km_xml_begin(&w->xml, "geometry");
  km_xml_begin(&w->xml, element);
  if (shape->kind == KM_SHAPE_OF_MESH) {
    km_xml_text(&w->xml, "uri", shape->mesh);
    km_xml_numbers(&w->xml, "scale", shape->scale, 3, false);
  } else if (shape->kind == KM_SHAPE_BOX) {
    km_xml_numbers(&w->xml, "size", shape->size, 3, false);
  } else {
    add_number(w, "radius", shape->size[0]);
    if (shape->kind != KM_SHAPE_SPHERE)
      add_number(w, "length", shape->size[1]);
  }
  km_xml_end(&w->xml, element);
  km_xml_end(&w->xml, "geometry");
}

static void add_visual(km_written *w, const km_model_shape *shape, int index) {
  km_xml_begin(&w->xml, "visual");
  km_xml_set(&w->xml, "name", km_written_text(w, "visual%d", index));
  add_pose(w, &shape->pose, NULL);
  add_geometry(w, shape);
  if (shape->color[3] >= 0.0) {
    km_xml_begin(&w->xml, "material");
    km_xml_numbers(&w->xml, "ambient", shape->color, 4, false);
    km_xml_numbers(&w->xml, "diffuse", shape->color, 4, false);
    km_xml_end(&w->xml, "material");
  }
  km_xml_end(&w->xml, "visual");
}

static void add_link(km_written *w, int body) {
  double center[3], I[6];
  double mass = km_written_mass(w, body, center, I);
  int shapes;
  const km_model_shape *shape = km_written_shapes(w, body, &shapes);
  km_xml_begin(&w->xml, "link");
  km_xml_set(&w->xml, "name", w->bodies[body]);
  add_pose(w, &w->world[body], NULL);
  add_inertial(w, center, mass, I);
  for (int i = 0; i < shapes; ++i)
    add_visual(w, &shape[i], i);
  km_xml_end(&w->xml, "link");
}

static void add_massless(km_written *w, const char *name, const km_pose *X) {
  static const double none[6];
  km_xml_begin(&w->xml, "link");
  km_xml_set(&w->xml, "name", name);
  add_pose(w, X, NULL);
  add_inertial(w, none, 0.0, none);
  km_xml_end(&w->xml, "link");
}

static void add_range(km_written *w, int c) {
  static const char *const ends[2] = {"lower", "upper"};
  double range[2];
  km_written_range(w, c, range);
  for (int k = 0; k < 2; ++k)
    add_number(w, ends[k], fabs(range[k]) < 1e30 ? range[k] - w->reference[c] : range[k]);
}

/* The coupling by which a coordinate follows another one, if a line does it; counted from the file's pose. */
static void add_mimic(km_written *w, int c) {
  int leader;
  double ratio, constant;
  if (!km_written_mimic(w, c, &leader, &ratio, &constant))
    return;
  km_xml_begin(&w->xml, "mimic");
  km_xml_set(&w->xml, "joint", w->model->coordinates[leader].label);
  add_number(w, "multiplier", ratio);
  add_number(w, "offset", constant + ratio * w->reference[leader] - w->reference[c]);
  add_number(w, "reference", 0.0);
  km_xml_end(&w->xml, "mimic");
}

static void add_axis(km_written *w, const char *element, km_vec3 u, int c) {
  const km_model_coordinate *def = &w->model->coordinates[c];
  const double axis[3] = {u.x, u.y, u.z};
  double stiffness, rest;
  km_xml_begin(&w->xml, element);
  km_xml_numbers(&w->xml, "xyz", axis, 3, true);
  km_xml_begin(&w->xml, "limit");
  add_range(w, c);
  if (isfinite(def->max_force))
    add_number(w, "effort", def->max_force * km_written_force(w, c));
  if (isfinite(def->max_rate))
    add_number(w, "velocity", def->max_rate * km_written_rate(w, c));
  km_xml_end(&w->xml, "limit");
  km_xml_begin(&w->xml, "dynamics");
  add_number(w, "damping", def->damping * km_written_damping(w, c));
  add_number(w, "friction", def->friction * km_written_force(w, c));
  if (km_written_spring(w, c, &stiffness, &rest)) {
    add_number(w, "spring_reference", rest - w->reference[c]);
    add_number(w, "spring_stiffness", stiffness);
  }
  km_xml_end(&w->xml, "dynamics");
  add_mimic(w, c);
  km_xml_end(&w->xml, element);
  km_written_hold(w, c, 1, KM_HELD_BY_AXIS);
}

/* `at`: the joint's frame in the world. */
static void begin_joint(km_written *w, const char *name, const char *type, const char *from, const char *to,
                        const km_pose *child, const km_pose *at) {
  km_pose back = km_pose_inverse(child), X = km_pose_product(&back, at);
  km_xml_begin(&w->xml, "joint");
  km_xml_set(&w->xml, "name", name);
  km_xml_set(&w->xml, "type", type);
  add_pose(w, &X, to);
  km_xml_text(&w->xml, "parent", from);
  km_xml_text(&w->xml, "child", to);
}

/* A joint without axis in the format has no element for further data. */
static void omit_axes(km_written *w, int first, int count) {
  double stiffness, rest;
  for (int c = first; c < first + count; ++c)
    if (km_written_spring(w, c, &stiffness, &rest))
      km_written_omit(w, "springs not written", w->model->coordinates[c].label);
  km_written_hold(w, first, count, 0);
}

static void add_motion(km_written *w, const km_written_motion *motion, const char *from, const char *to,
                       const km_pose *child, const km_pose *at) {
  static const char *const types[] = {
      [KM_REVOLUTE] = "revolute", [KM_PRISMATIC] = "prismatic", [KM_HELICAL] = "screw", [KM_BALL] = "ball"};
  begin_joint(w, motion->name, types[motion->primitive], from, to, child, at);
  if (motion->primitive == KM_HELICAL)
    add_number(w, "screw_thread_pitch", motion->pitch * 2.0 * M_PI);
  if (motion->primitive == KM_BALL)
    omit_axes(w, motion->coordinate, 3);
  else
    add_axis(w, "axis", motion->axis, motion->coordinate);
  km_xml_end(&w->xml, "joint");
}

static void add_universal(km_written *w, const km_written_joint *way) {
  const char *from = w->bodies[way->from], *to = w->bodies[way->to];
  km_pose at = km_pose_product(&w->world[way->from], &way->motion[0].before);
  begin_joint(w, w->joints[way->joint], "universal", from, to, &w->world[way->to], &at);
  add_axis(w, "axis", way->motion[0].axis, way->motion[0].coordinate);
  add_axis(w, "axis2", way->motion[1].axis, way->motion[1].coordinate);
  km_xml_end(&w->xml, "joint");
}

static bool stands_straight(const km_written *w, const km_written_joint *way) {
  return w->reference[way->motion[0].coordinate] == 0.0 && w->reference[way->motion[1].coordinate] == 0.0;
}

static void add_joint(km_written *w, int joint) {
  const km_model_joint *def = &w->model->joints[joint];
  km_written_joint way = km_written_pass(w, joint, w->model->frames[def->frame[0]].body);
  km_pose at = w->world[way.from];
  const char *from = w->bodies[way.from];
  if (way.count == 0) {
    begin_joint(w, w->joints[joint], "fixed", from, w->bodies[way.to], &w->world[way.to], &w->world[way.to]);
    km_xml_end(&w->xml, "joint");
    return;
  }
  if (def->type == KM_FLOAT && way.from == 0) {
    km_written_omit(w, "free bodies, which --float reads as such", w->bodies[way.to]);
    omit_axes(w, def->first_coordinate, km_model_freedom(w->model, joint));
    return;
  }
  if (def->type == KM_UNIVERSAL && stands_straight(w, &way)) {
    add_universal(w, &way);
    return;
  }
  for (int i = 0; i < way.count; ++i) {
    at = km_pose_product(&at, &way.motion[i].before);
    km_pose step = km_written_motion_at(&way.motion[i], w->reference), after = km_pose_product(&at, &step);
    bool last = i + 1 == way.count;
    const char *to = last ? w->bodies[way.to] : way.motion[i].beyond;
    if (!last)
      add_massless(w, to, &after);
    add_motion(w, &way.motion[i], from, to, last ? &w->world[way.to] : &after, &after);
    at = after;
    from = to;
  }
}

/* Frames that no joint is held by. */
static void add_frames(km_written *w) {
  for (int f = 0; f < w->model->frame_count; ++f) {
    if (!w->frames[f])
      continue;
    km_pose X = km_written_frame(w, f);
    km_xml_begin(&w->xml, "frame");
    km_xml_set(&w->xml, "name", w->frames[f]);
    km_xml_set(&w->xml, "attached_to", w->bodies[w->model->frames[f].body]);
    add_pose(w, &X, NULL);
    km_xml_end(&w->xml, "frame");
  }
}

static void report_rest(km_written *w) {
  const km_model *m = w->model;
  for (int i = 0; i < m->coupling_count; ++i)
    if (!km_written_is_mimic(w, i))
      km_written_omit(w, "couplings not written, as SDF has lines between two joints only", m->couplings[i].name);
  for (int c = 0; c < m->coordinate_count; ++c)
    if (w->reference[c] != 0.0)
      km_written_omit(w, "joints that count from the pose that is written", m->coordinates[c].label);
    else if (w->q[c] != 0.0)
      km_written_omit(w, "joints whose value isn't written: in the file they stand at 0", m->coordinates[c].label);
  for (int i = 0; i < m->pose_count; ++i)
    km_written_omit(w, "named poses not written", m->poses[i].name);
}

km_status km_sdf_write(km_written *w, km_error *error) {
  const km_model *m = w->model;
  km_vec3 g = km_vec3_scale(w->length / (w->time * w->time), m->gravity);
  if (!km_written_refer(w, true))
    return km_fail(error, KM_MEMORY, "out of memory while writing the model");
  km_xml_begin(&w->xml, "sdf");
  km_xml_set(&w->xml, "version", "1.11");
  if (km_written_tolerance(w) > 0.0)
    km_xml_set(&w->xml, "xmlns:kmech", "urn:kmech");
  km_xml_begin(&w->xml, "world");
  km_xml_set(&w->xml, "name", "world");
  km_xml_numbers(&w->xml, "gravity", (const double[3]){g.x, g.y, g.z}, 3, false);
  km_xml_begin(&w->xml, "model");
  km_xml_set(&w->xml, "name", m->assembly_count ? m->assemblies[0].name : "model");
  if (km_written_tolerance(w) > 0.0)
    add_number(w, KM_SDF_TOLERANCE, km_written_tolerance(w));
  for (int i = 0; i < w->ordered; ++i)
    add_link(w, w->order[i]);
  for (int j = 0; j < m->joint_count; ++j)
    add_joint(w, j);
  add_frames(w);
  km_xml_end(&w->xml, "model");
  km_xml_end(&w->xml, "world");
  km_xml_end(&w->xml, "sdf");
  km_written_omit_forces(w);
  report_rest(w);
  return KM_OK;
}
