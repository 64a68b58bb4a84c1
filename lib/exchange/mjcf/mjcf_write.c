/* A model as MJCF: nested bodies, with loops closed by constraints. */
#include "exchange/mjcf/mjcf_write.h"

#include <math.h>
#include <string.h>

void km_mjcf_set_pose(km_written *w, const km_pose *X) {
  const double p[3] = {X->p.x, X->p.y, X->p.z};
  double q[4];
  km_written_quaternion(&X->R, q);
  km_xml_set_numbers(&w->xml, "pos", p, 3, false);
  if (q[0] != 1.0)
    km_xml_set_numbers(&w->xml, "quat", q, 4, true);
}

static void set_number(km_written *w, const char *name, double value) {
  if (value != 0.0)
    km_xml_set_numbers(&w->xml, name, &value, 1, false);
}

static void add_inertial(km_written *w, int body) {
  double center[3], I[6];
  double mass = km_written_mass(w, body, center, I);
  const double full[6] = {I[0], I[1], I[2], I[3], I[5], I[4]}; /* xx yy zz xy xz yz */
  bool some = mass != 0.0;
  for (int k = 0; k < 6; ++k)
    some = some || I[k] != 0.0;
  if (!some) {
    km_written_omit(w, "bodies without mass, which MuJoCo itself doesn't simulate", w->bodies[body]);
    return;
  }
  km_xml_begin(&w->xml, "inertial");
  km_xml_set_numbers(&w->xml, "pos", center, 3, false);
  km_xml_set_numbers(&w->xml, "mass", &mass, 1, false);
  km_xml_set_numbers(&w->xml, "fullinertia", full, 6, false);
  km_xml_end(&w->xml, "inertial");
}

/* The angle of a ball joint counts from the written configuration, which is the model's own where the joint is at 0. */
static void add_turn_limit(km_written *w, const km_written_motion *motion) {
  double most = w->model->joints[w->model->coordinates[motion->coordinate].joint].most_turn;
  const double range[2] = {0.0, most * w->model->units.angle->si}, *from = w->reference + motion->coordinate;
  if (most == 0.0)
    return;
  if (from[0] != 0.0 || from[1] != 0.0 || from[2] != 0.0) {
    km_written_omit(w, "limits of turned ball joints not written", motion->name);
    return;
  }
  km_xml_set(&w->xml, "limited", "true");
  km_xml_set_numbers(&w->xml, "range", range, 2, false);
}

/* A ball has one number for its three coordinates: these must be alike. */
static unsigned held_of_ball(const km_written *w, int first) {
  const km_model_coordinate *c = &w->model->coordinates[first];
  unsigned held = KM_HELD_DAMPING | KM_HELD_FRICTION | KM_HELD_ARMATURE | KM_HELD_TURN;
  for (int k = 1; k < 3; ++k)
    held &=
        ~((c[k].damping != c->damping ? KM_HELD_DAMPING : 0u) | (c[k].friction != c->friction ? KM_HELD_FRICTION : 0u) |
          (c[k].armature != c->armature ? KM_HELD_ARMATURE : 0u));
  return held;
}

/* Writes drive, friction and limits of a joint. */
static void set_dynamics(km_written *w, const km_written_motion *motion) {
  const km_model_coordinate *c = &w->model->coordinates[motion->coordinate];
  double stiffness, rest;
  bool ball = motion->primitive == KM_BALL;
  unsigned held = ball ? held_of_ball(w, motion->coordinate) : ~(unsigned)KM_HELD_RATE;
  if (held & KM_HELD_DAMPING)
    set_number(w, "damping", c->damping * km_written_damping(w, motion->coordinate));
  if (held & KM_HELD_ARMATURE)
    set_number(w, "armature", c->armature * km_written_inertia(w, motion->coordinate));
  if (held & KM_HELD_FRICTION)
    set_number(w, "frictionloss", c->friction * km_written_force(w, motion->coordinate));
  km_written_hold(w, motion->coordinate, ball ? 3 : 1, held);
  if (ball) {
    add_turn_limit(w, motion);
    if (km_written_ball_spring(w, motion->coordinate, &stiffness))
      km_xml_set_numbers(&w->xml, "stiffness", &stiffness, 1, false);
    return;
  }
  if (isfinite(c->max_force)) {
    double most = c->max_force * km_written_force(w, motion->coordinate);
    km_xml_set_numbers(&w->xml, "actuatorfrcrange", (const double[2]){-most, most}, 2, false);
  }
  if (km_written_spring(w, motion->coordinate, &stiffness, &rest)) {
    km_xml_set_numbers(&w->xml, "stiffness", &stiffness, 1, false);
    km_xml_set_numbers(&w->xml, "springref", &rest, 1, false);
  }
  if (km_written_is_limited(w->model, motion->coordinate) && !km_written_held_at(w->model, motion->coordinate)) {
    double range[2];
    km_written_range(w, motion->coordinate, range);
    km_xml_set(&w->xml, "limited", "true");
    km_xml_set_numbers(&w->xml, "range", range, 2, false);
  }
}

static void add_single(km_written *w, const km_written_motion *motion, const char *name, bool slides,
                       const km_pose *in_body, double reference) {
  km_vec3 u = km_rotate(&in_body->R, motion->axis);
  const double axis[3] = {u.x, u.y, u.z}, p[3] = {in_body->p.x, in_body->p.y, in_body->p.z};
  km_xml_begin(&w->xml, "joint");
  km_xml_set(&w->xml, "name", name);
  km_xml_set(&w->xml, "type", slides ? "slide" : "hinge");
  km_xml_set_numbers(&w->xml, "pos", p, 3, false);
  km_xml_set_numbers(&w->xml, "axis", axis, 3, true);
  set_number(w, "ref", reference);
}

/* One motion as a joint of the body, where the motion's frame at the file's pose is `in_body`. */
static void add_motion(km_written *w, km_mjcf_order *order, const km_written_motion *motion, const km_pose *in_body) {
  double reference = w->reference[motion->coordinate];
  int joint = w->model->coordinates[motion->coordinate].joint;
  if (motion->primitive == KM_BALL) {
    km_mjcf_remember(w, order, KM_MJCF_BALL, joint, motion);
    const double p[3] = {in_body->p.x, in_body->p.y, in_body->p.z};
    km_xml_begin(&w->xml, "joint");
    km_xml_set(&w->xml, "name", motion->name);
    km_xml_set(&w->xml, "type", "ball");
    km_xml_set_numbers(&w->xml, "pos", p, 3, false);
    set_dynamics(w, motion);
    km_xml_end(&w->xml, "joint");
    km_written_omit(w, "ball joints whose coordinates count from the file's pose", motion->name);
    return;
  }
  if (motion->primitive == KM_HELICAL) { /* a slide that follows the hinge */
    km_mjcf_remember(w, order, KM_MJCF_SLIDE_OF_SCREW, joint, motion);
    add_single(w, motion, km_mjcf_slide_of(w, motion->name), true, in_body, reference * motion->pitch);
    km_xml_end(&w->xml, "joint");
  }
  km_mjcf_remember(w, order, KM_MJCF_SINGLE, joint, motion);
  add_single(w, motion, motion->name, motion->primitive == KM_PRISMATIC, in_body, reference);
  set_dynamics(w, motion);
  km_xml_end(&w->xml, "joint");
}

/* The joints of a body, whose pose in its parent is `X`. */
static void add_joints(km_written *w, km_mjcf_order *order, const km_written_joint *way, const km_pose *X) {
  km_pose back = km_pose_inverse(X), at = km_pose_identity();
  if (w->model->joints[way->joint].type == KM_FLOAT && way->from == 0) {
    km_mjcf_remember(w, order, KM_MJCF_FREE, way->joint, NULL);
    km_xml_begin(&w->xml, "freejoint");
    km_xml_set(&w->xml, "name", w->joints[way->joint]);
    km_xml_end(&w->xml, "freejoint");
    km_written_hold_none(w, way->joint);
    return;
  }
  for (int i = 0; i < way->count; ++i) {
    at = km_pose_product(&at, &way->motion[i].before);
    km_pose in_body = km_pose_product(&back, &at);
    add_motion(w, order, &way->motion[i], &in_body);
    km_pose step = km_written_motion_at(&way->motion[i], w->reference);
    at = km_pose_product(&at, &step);
  }
}

/* Frames that no joint is held by, as sites. */
static void add_sites(km_written *w, int body) {
  for (int f = 0; f < w->model->frame_count; ++f) {
    if (!w->frames[f] || w->model->frames[f].body != body)
      continue;
    km_pose X = km_written_frame(w, f);
    km_xml_begin(&w->xml, "site");
    km_xml_set(&w->xml, "name", w->frames[f]);
    km_mjcf_set_pose(w, &X);
    km_xml_end(&w->xml, "site");
  }
}

static km_pose between(const km_written *w, int from, int to) {
  km_pose back = km_pose_inverse(&w->world[from]);
  return km_pose_product(&back, &w->world[to]);
}

/* Writes a loop joint as the joint of a massless body that is welded to the body that it represents. */
static bool is_welded(const km_written *w, int joint) {
  const km_model_joint *def = &w->model->joints[joint];
  bool hinge = def->type == KM_RX || def->type == KM_RY || def->type == KM_RZ;
  const km_model_coordinate *c = &w->model->coordinates[def->first_coordinate];
  if (def->type == KM_RIGID || def->type == KM_SPHERICAL)
    return false;
  if (!hinge)
    return true;
  bool told = km_written_is_limited(w->model, def->first_coordinate) || c->damping != 0.0 || c->armature != 0.0 ||
              c->friction != 0.0 || isfinite(c->max_force);
  double stiffness, rest;
  told = told || km_written_spring(w, def->first_coordinate, &stiffness, &rest);
  for (int i = 0; i < w->model->actuator_count; ++i)
    told = told || w->model->actuators[i] == def->first_coordinate;
  for (int i = 0; i < w->model->coupling_count; ++i)
    for (int k = 0; k < w->model->couplings[i].count; ++k)
      told = told || w->model->couplings[i].coordinates[k] == def->first_coordinate;
  return told;
}

static const char *twin_of(km_written *w, int joint) {
  return km_written_text(w, "%s:end", w->joints[joint]);
}

static void add_body(km_written *w, km_mjcf_order *order, int body);

/* Writes the children of a body: bodies of the tree, and massless ends of loops. */
static void add_children(km_written *w, km_mjcf_order *order, int body) {
  for (int i = 0; i < w->ordered; ++i) {
    const km_model_joint *def = &w->model->joints[w->arc[w->order[i]]];
    int a = w->model->frames[def->frame[0]].body, b = w->model->frames[def->frame[1]].body;
    if ((a == w->order[i] ? b : a) == body)
      add_body(w, order, w->order[i]);
  }
  for (int j = 0; j < w->model->joint_count; ++j) {
    if (w->in_tree[j] || km_joint_body(w->model, j, 0) != body || !is_welded(w, j))
      continue;
    km_written_joint way = km_written_pass(w, j, body);
    km_pose X = between(w, body, way.to);
    km_xml_begin(&w->xml, "body");
    km_xml_set(&w->xml, "name", twin_of(w, j));
    km_mjcf_set_pose(w, &X);
    add_joints(w, order, &way, &X);
    km_xml_end(&w->xml, "body");
  }
}

static void add_body(km_written *w, km_mjcf_order *order, int body) {
  const km_model_joint *def = &w->model->joints[w->arc[body]];
  int a = w->model->frames[def->frame[0]].body;
  km_written_joint way = km_written_pass(w, w->arc[body], a == body ? w->model->frames[def->frame[1]].body : a);
  km_pose X = between(w, way.from, body);
  km_xml_begin(&w->xml, "body");
  km_xml_set(&w->xml, "name", w->bodies[body]);
  km_mjcf_set_pose(w, &X);
  add_inertial(w, body);
  add_joints(w, order, &way, &X);
  add_sites(w, body);
  km_mjcf_write_geoms(w, body);
  add_children(w, order, body);
  km_xml_end(&w->xml, "body");
}

/* A body that the constraint names first has the anchor, and isn't the world. */
static void add_connect(km_written *w, const char *name, int one, int two, km_vec3 point) {
  km_pose back = km_pose_inverse(&w->world[one ? one : two]);
  km_vec3 p = km_pose_point(&back, point);
  const double anchor[3] = {p.x, p.y, p.z};
  km_xml_begin(&w->xml, "connect");
  km_xml_set(&w->xml, "name", name);
  km_xml_set(&w->xml, "body1", w->bodies[one ? one : two]);
  if (one && two)
    km_xml_set(&w->xml, "body2", w->bodies[two]);
  km_xml_set_numbers(&w->xml, "anchor", anchor, 3, false);
  km_xml_end(&w->xml, "connect");
}

/* A ball meets in a point, a hinge in two points of its axis; the rest is welded. */
static void close_loop(km_written *w, int joint) {
  const km_model *m = w->model;
  const km_model_joint *def = &m->joints[joint];
  int from = m->frames[def->frame[0]].body;
  km_written_joint way = km_written_pass(w, joint, from);
  bool welded = is_welded(w, joint);
  if (!welded)
    km_written_hold_none(w, joint);
  if (welded || way.count == 0) {
    km_xml_begin(&w->xml, "weld");
    km_xml_set(&w->xml, "name", welded ? twin_of(w, joint) : w->joints[joint]);
    km_xml_set(&w->xml, "body1", welded ? twin_of(w, joint) : w->bodies[from ? from : way.to]);
    if (welded ? way.to != 0 : from && way.to)
      km_xml_set(&w->xml, "body2", w->bodies[way.to]);
    km_xml_end(&w->xml, "weld");
    return;
  }
  km_pose X = km_pose_product(&w->world[from], &way.motion[0].before);
  add_connect(w, w->joints[joint], from, way.to, X.p);
  if (way.motion[0].primitive == KM_BALL)
    return;
  double size = fmax(km_vec3_norm(way.motion[0].before.p), km_vec3_norm(way.after.p));
  km_vec3 along = km_vec3_scale(size > 0.0 ? size : 1.0, km_rotate(&X.R, way.motion[0].axis));
  add_connect(w, km_written_text(w, "%s:axis", w->joints[joint]), from, way.to, km_vec3_add(X.p, along));
}

static void add_constraints(km_written *w) {
  const km_model *m = w->model;
  km_xml_begin(&w->xml, "equality");
  for (int j = 0; j < m->joint_count; ++j)
    if (!w->in_tree[j])
      close_loop(w, j);
  km_mjcf_write_couplings(w);
  km_xml_end(&w->xml, "equality");
  km_mjcf_write_tendons(w);
}

static void add_tolerance(km_written *w) {
  double tolerance = km_written_tolerance(w);
  if (!(tolerance > 0.0))
    return;
  km_xml_begin(&w->xml, "custom");
  km_xml_begin(&w->xml, "numeric");
  km_xml_set(&w->xml, "name", KM_MJCF_TOLERANCE);
  km_xml_set_numbers(&w->xml, "data", &tolerance, 1, false);
  km_xml_end(&w->xml, "numeric");
  km_xml_end(&w->xml, "custom");
}

static void add_actuators(km_written *w) {
  const km_model *m = w->model;
  km_xml_begin(&w->xml, "actuator");
  for (int i = 0; i < m->actuator_count; ++i) {
    km_xml_begin(&w->xml, "motor");
    km_xml_set(&w->xml, "name", m->coordinates[m->actuators[i]].label);
    km_xml_set(&w->xml, "joint", m->coordinates[m->actuators[i]].label);
    km_xml_end(&w->xml, "motor");
  }
  km_xml_end(&w->xml, "actuator");
}

km_status km_mjcf_write(km_written *w, km_error *error) {
  km_mjcf_order order = {0};
  const km_model *m = w->model;
  km_vec3 g = km_vec3_scale(w->length / (w->time * w->time), m->gravity);
  if (!km_written_refer(w, false))
    return km_fail(error, KM_MEMORY, "out of memory while writing the model");
  km_xml_begin(&w->xml, "mujoco");
  km_xml_set(&w->xml, "model", m->assembly_count ? m->assemblies[0].name : "model");
  km_xml_begin(&w->xml, "compiler");
  km_xml_set(&w->xml, "angle", "radian");
  km_xml_end(&w->xml, "compiler");
  km_xml_begin(&w->xml, "option");
  km_xml_set_numbers(&w->xml, "gravity", (const double[3]){g.x, g.y, g.z}, 3, false);
  km_xml_end(&w->xml, "option");
  add_tolerance(w);
  km_mjcf_write_assets(w);
  km_xml_begin(&w->xml, "worldbody");
  add_sites(w, 0);
  add_children(w, &order, 0);
  km_xml_end(&w->xml, "worldbody");
  add_constraints(w);
  add_actuators(w);
  km_mjcf_write_keyframes(w, &order);
  km_xml_end(&w->xml, "mujoco");
  km_written_omit_forces(w);
  return KM_OK;
}
