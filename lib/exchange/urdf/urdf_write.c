/* Writes a model as URDF, a tree of links. Loops can't be represented. */
#include "exchange/robot/robot_write.h"

#include "model/validation.h"

#include <math.h>
#include <string.h>

/* Roll, pitch, yaw; near pitch ±90° the roll is what the yaw leaves. */
static void set_origin(km_written *w, const km_pose *X) {
  const double p[3] = {X->p.x, X->p.y, X->p.z};
  double r[9], rpy[3];
  km_rotation_rows(&X->R, r);
  rpy[1] = atan2(-r[6], hypot(r[0], r[3]));
  rpy[2] = hypot(r[0], r[3]) > 0.0 ? atan2(r[3], r[0]) : 0.0;
  km_rotation turn = km_rotation_identity();
  turn = km_rotation_about_axis(&turn, 2, cos(rpy[2]), sin(rpy[2]));
  turn = km_rotation_about_axis(&turn, 1, cos(rpy[1]), sin(rpy[1]));
  turn = km_rotation_inverse(&turn);
  km_rotation rest = km_rotation_product(&turn, &X->R);
  rpy[0] = atan2(rest.axis[1].z, rest.axis[1].y);
  km_xml_begin(&w->xml, "origin");
  km_xml_set_numbers(&w->xml, "xyz", p, 3, false);
  km_xml_set_numbers(&w->xml, "rpy", rpy, 3, true);
  km_xml_end(&w->xml, "origin");
}

static void add_massless(km_written *w, const char *name) {
  km_xml_begin(&w->xml, "link");
  km_xml_set(&w->xml, "name", name);
  km_xml_end(&w->xml, "link");
}

static void add_geometry(km_written *w, const km_model_shape *shape) {
  const char *element = km_shape_word(shape->kind);
  km_xml_begin(&w->xml, "geometry");
  km_xml_begin(&w->xml, element);
  if (shape->kind == KM_SHAPE_OF_MESH) {
    km_xml_set(&w->xml, "filename", shape->mesh);
    km_xml_set_numbers(&w->xml, "scale", shape->scale, 3, false);
  } else if (shape->kind == KM_SHAPE_BOX) {
    km_xml_set_numbers(&w->xml, "size", shape->size, 3, false);
  } else {
    km_xml_set_numbers(&w->xml, "radius", shape->size, 1, false);
    if (shape->kind != KM_SHAPE_SPHERE)
      km_xml_set_numbers(&w->xml, "length", shape->size + 1, 1, false);
  }
  km_xml_end(&w->xml, element);
  km_xml_end(&w->xml, "geometry");
  if (shape->kind == KM_SHAPE_CAPSULE)
    km_written_omit(w, "capsules, which not every reader of URDF knows", w->bodies[shape->body]);
}

static void add_visual(km_written *w, const km_model_shape *shape, int index) {
  km_xml_begin(&w->xml, "visual");
  set_origin(w, &shape->pose);
  add_geometry(w, shape);
  if (shape->color[3] >= 0.0) {
    km_xml_begin(&w->xml, "material"); /* a name means one colour in all of the file */
    km_xml_set(&w->xml, "name", km_written_text(w, "%s:%d", w->bodies[shape->body], index));
    km_xml_begin(&w->xml, "color");
    km_xml_set_numbers(&w->xml, "rgba", shape->color, 4, false);
    km_xml_end(&w->xml, "color");
    km_xml_end(&w->xml, "material");
  }
  km_xml_end(&w->xml, "visual");
}

static void add_link(km_written *w, int body) {
  static const char *const keys[6] = {"ixx", "iyy", "izz", "ixy", "iyz", "ixz"};
  double center[3], I[6];
  double mass = km_written_mass(w, body, center, I);
  int shapes;
  const km_model_shape *shape = km_written_shapes(w, body, &shapes);
  km_pose at = {km_rotation_identity(), km_vec3_from_array(center)};
  km_xml_begin(&w->xml, "link");
  km_xml_set(&w->xml, "name", w->bodies[body]);
  km_xml_begin(&w->xml, "inertial");
  set_origin(w, &at);
  km_xml_begin(&w->xml, "mass");
  km_xml_set_numbers(&w->xml, "value", &mass, 1, false);
  km_xml_end(&w->xml, "mass");
  km_xml_begin(&w->xml, "inertia");
  for (int k = 0; k < 6; ++k)
    km_xml_set_numbers(&w->xml, keys[k], &I[k], 1, false);
  km_xml_end(&w->xml, "inertia");
  km_xml_end(&w->xml, "inertial");
  for (int i = 0; i < shapes; ++i)
    add_visual(w, &shape[i], i);
  km_xml_end(&w->xml, "link");
}

static void begin_joint(km_written *w, const char *name, const char *type, const km_pose *origin, const char *from,
                        const char *to) {
  km_xml_begin(&w->xml, "joint");
  km_xml_set(&w->xml, "name", name);
  km_xml_set(&w->xml, "type", type);
  set_origin(w, origin);
  km_xml_begin(&w->xml, "parent");
  km_xml_set(&w->xml, "link", from);
  km_xml_end(&w->xml, "parent");
  km_xml_begin(&w->xml, "child");
  km_xml_set(&w->xml, "link", to);
  km_xml_end(&w->xml, "child");
}

static void add_fixed(km_written *w, const char *name, const km_pose *origin, const char *from, const char *to) {
  begin_joint(w, name, "fixed", origin, from, to);
  km_xml_end(&w->xml, "joint");
}

/* Limits, drive and friction of a hinge or slide; URDF wants a rate and an effort beside limits. */
static void add_dynamics(km_written *w, int c, bool limited) {
  const km_model_coordinate *def = &w->model->coordinates[c];
  const double effort = fmin(def->max_force * km_written_force(w, c), 1e30),
               velocity = fmin(def->max_rate * km_written_rate(w, c), 1e30),
               damping = def->damping * km_written_damping(w, c), friction = def->friction * km_written_force(w, c);
  if (limited || isfinite(def->max_force) || isfinite(def->max_rate)) {
    double range[2];
    km_written_range(w, c, range);
    km_xml_begin(&w->xml, "limit");
    if (limited) {
      km_xml_set_numbers(&w->xml, "lower", &range[0], 1, false);
      km_xml_set_numbers(&w->xml, "upper", &range[1], 1, false);
    }
    km_xml_set_numbers(&w->xml, "effort", &effort, 1, false);
    km_xml_set_numbers(&w->xml, "velocity", &velocity, 1, false);
    km_xml_end(&w->xml, "limit");
  }
  if (damping != 0.0 || friction != 0.0) {
    km_xml_begin(&w->xml, "dynamics");
    km_xml_set_numbers(&w->xml, "damping", &damping, 1, false);
    km_xml_set_numbers(&w->xml, "friction", &friction, 1, false);
    km_xml_end(&w->xml, "dynamics");
  }
  km_written_hold(w, c, 1, KM_HELD_BY_AXIS);
}

static void set_mimic(km_written *w, const char *leader, double multiplier, double offset) {
  km_xml_begin(&w->xml, "mimic");
  km_xml_set(&w->xml, "joint", leader);
  km_xml_set_numbers(&w->xml, "multiplier", &multiplier, 1, false);
  km_xml_set_numbers(&w->xml, "offset", &offset, 1, false);
  km_xml_end(&w->xml, "mimic");
}

/* True if the coordinate has a joint of its own in the file. */
static bool has_joint(const km_written *w, int c) {
  int joint = w->model->coordinates[c].joint;
  km_joint_type type = w->model->joints[joint].type;
  return w->in_tree[joint] && type != KM_FLOAT && type != KM_PLANAR && type != KM_SPHERICAL;
}

/* The coupling by which a coordinate follows another one, if a line does it and the other one is written. */
static void add_mimic(km_written *w, int c) {
  int leader;
  double ratio, constant;
  if (km_written_mimic(w, c, &leader, &ratio, &constant) && has_joint(w, leader))
    set_mimic(w, w->model->coordinates[leader].label, ratio, constant);
}

static void add_single(km_written *w, const km_written_motion *motion, const char *from, const char *to) {
  const double axis[3] = {motion->axis.x, motion->axis.y, motion->axis.z};
  bool slides = motion->primitive == KM_PRISMATIC, limited = km_written_is_limited(w->model, motion->coordinate);
  begin_joint(w, motion->name, slides ? "prismatic" : limited ? "revolute" : "continuous", &motion->before, from, to);
  km_xml_begin(&w->xml, "axis");
  km_xml_set_numbers(&w->xml, "xyz", axis, 3, true);
  km_xml_end(&w->xml, "axis");
  add_dynamics(w, motion->coordinate, limited || slides);
  add_mimic(w, motion->coordinate);
  km_xml_end(&w->xml, "joint");
}

/* A slide that follows its hinge. */
static void add_screw(km_written *w, const km_written_motion *motion, const char *from, const char *to) {
  const double axis[3] = {motion->axis.x, motion->axis.y, motion->axis.z};
  const char *between = km_written_text(w, "%s:slide", motion->name);
  const double wide[2] = {-1e30, 1e30};
  add_massless(w, between);
  begin_joint(w, between, "prismatic", &motion->before, from, between);
  km_xml_begin(&w->xml, "axis");
  km_xml_set_numbers(&w->xml, "xyz", axis, 3, true);
  km_xml_end(&w->xml, "axis");
  km_xml_begin(&w->xml, "limit");
  km_xml_set_numbers(&w->xml, "lower", &wide[0], 1, false);
  km_xml_set_numbers(&w->xml, "upper", &wide[1], 1, false);
  km_xml_set_numbers(&w->xml, "effort", &wide[1], 1, false);
  km_xml_set_numbers(&w->xml, "velocity", &wide[1], 1, false);
  km_xml_end(&w->xml, "limit");
  set_mimic(w, motion->name, motion->pitch, 0.0);
  km_xml_end(&w->xml, "joint");
  km_written_motion hinge = *motion;
  hinge.before = km_pose_identity();
  hinge.primitive = KM_REVOLUTE;
  add_single(w, &hinge, between, to);
}

/* The type by which URDF has the whole joint; NULL: it has none, or the joint is passed against its sense. */
static const char *complete_type(const km_written *w, const km_written_joint *way) {
  bool forward = way->count > 0 && way->motion[0].sign > 0.0;
  km_joint_type type = w->model->joints[way->joint].type;
  if (!forward)
    return NULL;
  return type == KM_FLOAT ? "floating" : type == KM_PLANAR ? "planar" : type == KM_SPHERICAL ? "spherical" : NULL;
}

static void add_whole(km_written *w, const km_written_joint *way, const char *type, const char *from, const char *to) {
  const double z[3] = {0, 0, 1};
  bool direct = km_vec3_norm(way->after.p) == 0.0 && way->after.R.axis[0].x == 1.0 && way->after.R.axis[1].y == 1.0;
  const char *next = direct ? to : km_written_text(w, "%s:end", w->joints[way->joint]);
  if (!direct)
    add_massless(w, next);
  begin_joint(w, w->joints[way->joint], type, &way->motion[0].before, from, next);
  if (strcmp(type, "planar") == 0) {
    km_xml_begin(&w->xml, "axis");
    km_xml_set_numbers(&w->xml, "xyz", z, 3, true);
    km_xml_end(&w->xml, "axis");
  }
  km_xml_end(&w->xml, "joint");
  if (!direct)
    add_fixed(w, next, &way->after, next, to);
  km_written_hold_none(w, way->joint);
  if (strcmp(type, "spherical") == 0)
    km_written_omit(w, "ball joints, whose type \"spherical\" not every reader of URDF knows", w->joints[way->joint]);
}

/* The chain of a joint's motions, with links of no mass between them, and behind them where the link itself isn't
 * there. */
static void add_joint(km_written *w, int body) {
  const km_model_joint *def = &w->model->joints[w->arc[body]];
  int a = w->model->frames[def->frame[0]].body;
  km_written_joint way = km_written_pass(w, w->arc[body], a == body ? w->model->frames[def->frame[1]].body : a);
  const char *from = w->bodies[way.from], *to = w->bodies[body];
  const char *type = complete_type(w, &way);
  if (type) {
    add_whole(w, &way, type, from, to);
    return;
  }
  bool folded = km_written_fold(&way);
  if (way.count == 0) {
    add_fixed(w, w->joints[way.joint], &way.after, from, to);
    return;
  }
  for (int i = 0; i < way.count; ++i) {
    const km_written_motion *motion = &way.motion[i];
    const char *next = i + 1 < way.count ? motion->beyond
                       : folded          ? to
                                         : km_written_text(w, "%s:end", w->joints[way.joint]);
    if (next != to)
      add_massless(w, next);
    if (motion->primitive == KM_BALL) {
      begin_joint(w, motion->name, "spherical", &motion->before, from, next);
      km_xml_end(&w->xml, "joint");
      km_written_hold(w, motion->coordinate, 3, 0);
      km_written_omit(w, "ball joints, whose type \"spherical\" not every reader of URDF knows", motion->name);
    } else if (motion->primitive == KM_HELICAL) {
      add_screw(w, motion, from, next);
    } else {
      add_single(w, motion, from, next);
    }
    from = next;
  }
  if (!folded)
    add_fixed(w, from, &way.after, from, to);
}

/* A tool's frame is a link of its own, without mass. */
static void add_frames(km_written *w) {
  for (int f = 0; f < w->model->frame_count; ++f) {
    if (!w->frames[f])
      continue;
    km_pose X = km_written_frame(w, f);
    add_massless(w, w->frames[f]);
    add_fixed(w, km_written_text(w, "%s:frame", w->frames[f]), &X, w->bodies[w->model->frames[f].body], w->frames[f]);
  }
}

static void report_rest(km_written *w) {
  const km_model *m = w->model;
  double stiffness, rest;
  for (int j = 0; j < m->joint_count; ++j)
    if (!w->in_tree[j])
      km_written_omit(w, "joints that close loops not written, as URDF describes trees", w->joints[j]);
  for (int i = 0; i < m->coupling_count; ++i)
    if (!km_written_is_mimic(w, i))
      km_written_omit(w, "couplings not written, as URDF has lines between two joints only", m->couplings[i].name);
    else if (!has_joint(w, m->couplings[i].coordinates[0]) || !has_joint(w, m->couplings[i].coordinates[1]))
      km_written_omit(w, "couplings not written, as the file doesn't have all of their joints", m->couplings[i].name);
  for (int c = 0; c < m->coordinate_count; ++c) {
    if (km_written_spring(w, c, &stiffness, &rest))
      km_written_omit(w, "springs not written", m->coordinates[c].label);
    if (w->q[c] != 0.0)
      km_written_omit(w, "joints whose value isn't written: a URDF file stands at 0", m->coordinates[c].label);
  }
  for (int i = 0; i < m->pose_count; ++i)
    km_written_omit(w, "named poses not written", m->poses[i].name);
  km_vec3 g = km_vec3_scale(w->length / (w->time * w->time), m->gravity);
  if (fabs(g.x) + fabs(g.y) + fabs(g.z + 9.81) > 1e-9)
    km_written_omit(w, "gravity not written: of URDF it is 9.81 m/s² against z", w->bodies[0]);
}

km_status km_urdf_write(km_written *w, km_error *error) {
  const km_model *m = w->model;
  (void)error;
  km_xml_begin(&w->xml, "robot");
  km_xml_set(&w->xml, "name", m->assembly_count ? m->assemblies[0].name : "robot");
  add_massless(w, w->bodies[0]);
  for (int i = 0; i < w->ordered; ++i)
    add_link(w, w->order[i]);
  for (int i = 0; i < w->ordered; ++i)
    add_joint(w, w->order[i]);
  add_frames(w);
  km_xml_end(&w->xml, "robot");
  km_written_omit_forces(w);
  report_rest(w);
  return KM_OK;
}
