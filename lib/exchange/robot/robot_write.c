/* A model in SI units at a pose, and a tree of its joints. */
#include "exchange/robot/robot_write.h"

#include "base/name_map.h"
#include "base/number/union_find.h"
#include "exchange/mesh/mesh_folders.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

static const double largest_gap =
    1e-6; /* that a closed loop may have, over the model's largest distance from an origin */

const char *km_written_text(km_written *w, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const char *text = km_arena_format_list(&w->arena, format, arguments);
  va_end(arguments);
  return text ? text : "";
}

double km_written_unit(const km_written *w, int c) {
  return km_model_coordinate_is_length(w->model, c) ? w->length : 1.0;
}

/* The first coupling that lets the coordinate follow another one along a line; -1: none. */
static int line_of(const km_written *w, int c) {
  for (int i = 0; i < w->model->coupling_count; ++i) {
    const km_model_coupling *coupling = &w->model->couplings[i];
    if (coupling->coordinates[0] == c && coupling->count == 2 && coupling->ratios && coupling->ratios[0] != 0.0)
      return i;
  }
  return -1;
}

bool km_written_is_mimic(const km_written *w, int i) {
  return line_of(w, w->model->couplings[i].coordinates[0]) == i;
}

bool km_written_mimic(const km_written *w, int c, int *leader, double *ratio, double *constant) {
  int i = line_of(w, c);
  if (i < 0)
    return false;
  const km_model_coupling *coupling = &w->model->couplings[i];
  *leader = coupling->coordinates[1];
  *ratio = -coupling->ratios[1] / coupling->ratios[0] * km_written_unit(w, c) / km_written_unit(w, *leader);
  *constant = coupling->constant_given ? coupling->constant / coupling->ratios[0] * km_written_unit(w, c)
                                       : w->q[c] - *ratio * w->q[*leader];
  return true;
}

void km_written_omit(km_written *w, const char *kind, const char *name) {
  km_omissions_add(&w->omissions, kind, name);
}

void km_written_tell(const km_written *w) {
  km_omissions_report(&w->omissions, w->messages);
}

/* Frames by which no joint is held, such as a tool's: a name of their own, with the body's where others have it too. */
static void name_frames(km_written *w, km_names *taken) {
  const km_model *m = w->model;
  bool *used = KM_ARENA_NEW(&w->arena, bool, (size_t)m->frame_count);
  for (int j = 0; j < m->joint_count && used; ++j)
    used[m->joints[j].frame[0]] = used[m->joints[j].frame[1]] = true;
  for (int f = 0; f < m->frame_count && used; ++f) {
    const km_model_frame *frame = &m->frames[f];
    if (used[f] || strcmp(frame->name, "origin") == 0)
      continue;
    bool alone = km_names_get(taken, 0, frame->name) < 0;
    w->frames[f] = alone ? frame->name : km_written_text(w, "%s/%s", w->bodies[frame->body], frame->name);
    if (alone && !km_names_set(taken, 0, frame->name, f))
      w->arena.failed = true;
  }
}

/* Names that are unique in the file: with their assemblies where they aren't alone. */
static void name_all(km_written *w) {
  const km_model *m = w->model;
  km_names taken = {0};
  for (int b = 0; b < m->body_count; ++b) {
    const char *name = b == 0 ? "world" : m->bodies[b].name;
    for (int n = 2; km_names_get(&taken, 0, name) >= 0 && !w->arena.failed; ++n)
      name = n == 2 && m->bodies[b].assembly >= 0
                 ? km_written_text(w, "%s/%s", m->assemblies[m->bodies[b].assembly].name, m->bodies[b].name)
                 : km_written_text(w, "%s:%d", m->bodies[b].name, n);
    w->bodies[b] = name;
    if (!km_names_set(&taken, 0, name, b))
      w->arena.failed = true;
  }
  for (int j = 0; j < m->joint_count; ++j) {
    w->joints[j] = m->joints[j].label;
    if (!km_names_set(&taken, 0, w->joints[j], j))
      w->arena.failed = true;
  }
  name_frames(w, &taken);
  km_names_free(&taken);
}

/* Joints that a loop may be cut at, the dearest first into the tree: balls are cut before hinges, those before
 * others. */
static int worth(const km_model *m, int joint) {
  const km_model_joint *def = &m->joints[joint];
  if (def->type == KM_SPHERICAL)
    return 0;
  bool hinge = def->type == KM_RX || def->type == KM_RY || def->type == KM_RZ;
  if (!hinge)
    return 3;
  for (int i = 0; i < m->actuator_count; ++i)
    if (m->actuators[i] == def->first_coordinate)
      return 2;
  for (int i = 0; i < m->coupling_count; ++i)
    for (int k = 0; k < m->couplings[i].count; ++k)
      if (m->couplings[i].coordinates[k] == def->first_coordinate)
        return 2;
  return km_written_is_limited(m, def->first_coordinate) ? 2 : 1;
}

static void choose_tree(km_written *w, int *leader) {
  const km_model *m = w->model;
  km_sets_reset(leader, m->body_count);
  for (int class = 3; class >= 0; --class)
    for (int j = 0; j < m->joint_count; ++j) {
      int a = km_set_root(leader, km_joint_body(m, j, 0)), b = km_set_root(leader, km_joint_body(m, j, 1));
      if (worth(m, j) != class || a == b)
        continue;
      leader[a] = b;
      w->in_tree[j] = true;
    }
}

/* Bodies in the order in which the tree grows from the inertial frame. */
static void orient(km_written *w, bool *reached) {
  const km_model *m = w->model;
  reached[0] = true;
  w->arc[0] = -1;
  for (bool more = true; more;) {
    more = false;
    for (int j = 0; j < m->joint_count; ++j) {
      int a = km_joint_body(m, j, 0), b = km_joint_body(m, j, 1);
      if (!w->in_tree[j] || reached[a] == reached[b])
        continue;
      int body = reached[a] ? b : a;
      reached[body] = more = true;
      w->arc[body] = j;
      w->order[w->ordered++] = body;
    }
  }
}

km_pose km_written_motion_at(const km_written_motion *motion, const double *q) {
  km_pose X = km_pose_identity();
  const double *value = q + motion->coordinate;
  if (motion->primitive == KM_BALL) {
    X.R = km_quaternion_rotation(km_quaternion_exp(km_vec3_from_array(value)));
    if (motion->sign < 0.0)
      X.R = km_rotation_inverse(&X.R);
  } else if (motion->primitive == KM_PRISMATIC) {
    X.p = km_vec3_scale(value[0], motion->axis);
  } else {
    X.R = km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(value[0], motion->axis)));
    if (motion->primitive == KM_HELICAL)
      X.p = km_vec3_scale(value[0] * motion->pitch, motion->axis);
  }
  return X;
}

static km_pose metres(const km_written *w, const km_pose *pose) {
  return (km_pose){pose->R, km_vec3_scale(w->length, pose->p)};
}

static km_vec3 unit(int axis) {
  return (km_vec3){axis == 0, axis == 1, axis == 2};
}

km_written_joint km_written_pass(km_written *w, int joint, int from) {
  const km_model *m = w->model;
  const km_model_joint *def = &m->joints[joint];
  const km_joint_kind *kind = km_joint_kind_of(def->type);
  const km_model_frame *ends[2] = {&m->frames[def->frame[0]], &m->frames[def->frame[1]]};
  bool against = ends[0]->body != from;
  km_pose last = metres(w, &ends[against]->pose), end = metres(w, &ends[!against]->pose);
  km_written_joint out = {.joint = joint, .from = from, .to = ends[!against]->body, .count = kind->motion_count};
  int coordinate = def->first_coordinate + (against ? kind->freedom : 0);
  for (int i = 0; i < out.count; ++i) {
    km_motion motion = kind->motions[against ? out.count - 1 - i : i];
    int freedom = km_primitive_freedom(motion.primitive);
    coordinate -= against ? freedom : 0;
    out.motion[i] = (km_written_motion){.primitive = motion.primitive,
                                        .coordinate = coordinate,
                                        .name = out.count == 1 ? w->joints[joint] : m->coordinates[coordinate].label,
                                        .axis = km_vec3_scale(against ? -1.0 : 1.0, unit(motion.axis)),
                                        .pitch = def->pitch * w->length / (2.0 * M_PI),
                                        .sign = against ? -1.0 : 1.0,
                                        .before = i ? km_pose_identity() : last};
    if (i + 1 < out.count)
      out.motion[i].beyond = km_written_text(w, "%s:%d", w->joints[joint], i + 1);
    coordinate += against ? 0 : freedom;
  }
  out.after = km_pose_inverse(&end);
  if (out.count == 0)
    out.after = km_pose_product(&last, &out.after);
  return out;
}

bool km_written_fold(km_written_joint *joint) {
  km_written_motion *last = joint->count ? &joint->motion[joint->count - 1] : NULL;
  if (!last || joint->count > 1 || last->primitive == KM_BALL || last->primitive == KM_HELICAL)
    return joint->count == 0;
  /* M(q) · after = after · M'(q), M' about or along the axis as the body sees it, where the axis goes through its
   * origin, or the motion is a slide. */
  km_vec3 p = joint->after.p, off = km_vec3_axpy(-km_vec3_dot(p, last->axis), last->axis, p);
  if (last->primitive != KM_PRISMATIC && (off.x != 0.0 || off.y != 0.0 || off.z != 0.0))
    return false;
  last->axis = km_rotate_back(&joint->after.R, last->axis);
  last->before = km_pose_product(&last->before, &joint->after);
  joint->after = km_pose_identity();
  return true;
}

km_pose km_written_through(const km_written_joint *way, const double *q) {
  km_pose X = km_pose_identity();
  for (int i = 0; i < way->count; ++i) {
    km_pose step = km_written_motion_at(&way->motion[i], q);
    X = km_pose_product(&X, &way->motion[i].before);
    X = km_pose_product(&X, &step);
  }
  return km_pose_product(&X, &way->after);
}

static int parent_of(const km_written *w, int body) {
  const km_model_joint *def = &w->model->joints[w->arc[body]];
  int a = w->model->frames[def->frame[0]].body;
  return a == body ? w->model->frames[def->frame[1]].body : a;
}

/* True if the joint is in a loop: its ends are connected without it. */
static bool in_loop(const km_written *w, int joint, int *leader) {
  const km_model *m = w->model;
  km_sets_reset(leader, m->body_count);
  for (int j = 0; j < m->joint_count; ++j)
    if (j != joint)
      leader[km_set_root(leader, km_joint_body(m, j, 0))] = km_set_root(leader, km_joint_body(m, j, 1));
  return km_set_root(leader, km_joint_body(m, joint, 0)) == km_set_root(leader, km_joint_body(m, joint, 1));
}

static void place(km_written *w, const double *q) {
  w->world[0] = km_pose_identity();
  for (int i = 0; i < w->ordered; ++i) {
    int body = w->order[i];
    km_written_joint way = km_written_pass(w, w->arc[body], parent_of(w, body));
    km_pose X = km_written_through(&way, q);
    w->world[body] = km_pose_product(&w->world[way.from], &X);
  }
}

bool km_written_refer(km_written *w, bool zero_where_free) {
  const km_model *m = w->model;
  int *leader = KM_ARENA_NEW(&w->arena, int, (size_t)m->body_count);
  if (!leader)
    return false;
  bool loops = w->ordered < m->joint_count;
  for (int j = 0; j < m->joint_count; ++j) {
    bool bound = !zero_where_free || (loops && in_loop(w, j, leader)) || km_joint_is_coupled(m, j);
    int first = m->joints[j].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m, j); ++c)
      w->reference[c] = bound ? w->q[c] : 0.0;
  }
  place(w, w->reference);
  return !w->arena.failed;
}

/* Loops must be closed where they are written. */
static km_status check_loops(km_written *w, km_error *error) {
  const km_model *m = w->model;
  double size = 0.0, most = fmax(largest_gap, 10.0 * m->closure_tolerance);
  for (int b = 0; b < m->body_count; ++b)
    size = fmax(size, km_vec3_norm(w->world[b].p));
  for (int k = 0; k < m->frame_count; ++k)
    size = fmax(size, w->length * km_vec3_norm(m->frames[k].pose.p));
  for (int j = 0; j < m->joint_count; ++j) {
    if (w->in_tree[j])
      continue;
    int from = km_joint_body(m, j, 0);
    km_written_joint way = km_written_pass(w, j, from);
    km_pose X = km_written_through(&way, w->q);
    km_pose Y = km_pose_product(&w->world[from], &X);
    if (km_vec3_norm(km_vec3_sub(Y.p, w->world[way.to].p)) > most * size)
      return km_fail(error, KM_MODEL, "the loop of joint %s is open at this pose; expected the pose of a closed one",
                     m->joints[j].label);
  }
  return KM_OK;
}

km_status km_written_make(const km_model *m, const double *q, const char *file, km_messages *messages, km_text *out,
                          km_written *w, km_error *error) {
  size_t bodies = (size_t)m->body_count, coordinates = (size_t)m->coordinate_count, joints = (size_t)m->joint_count;
  *w = (km_written){.model = m,
                    .messages = messages,
                    .xml = {.out = out},
                    .length = m->units.length->si,
                    .mass = m->units.mass->si,
                    .force = m->units.force->si,
                    .time = m->units.time->si};
  w->q = KM_ARENA_NEW(&w->arena, double, coordinates);
  w->reference = KM_ARENA_NEW(&w->arena, double, coordinates);
  w->world = KM_ARENA_NEW(&w->arena, km_pose, bodies);
  w->bodies = KM_ARENA_NEW(&w->arena, const char *, bodies);
  w->joints = KM_ARENA_NEW(&w->arena, const char *, joints);
  w->frames = KM_ARENA_NEW(&w->arena, const char *, (size_t)m->frame_count);
  w->arc = KM_ARENA_NEW(&w->arena, int, bodies);
  w->in_tree = KM_ARENA_NEW(&w->arena, bool, joints);
  w->order = KM_ARENA_NEW(&w->arena, int, bodies);
  int *leader = KM_ARENA_NEW(&w->arena, int, bodies);
  bool *reached = KM_ARENA_NEW(&w->arena, bool, bodies);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory while writing the model");
  for (int c = 0; c < m->coordinate_count; ++c) {
    double value = q ? q[c] : m->coordinates[c].position;
    w->q[c] = value * km_model_coordinate_factor(m, c) * km_written_unit(w, c);
  }
  name_all(w);
  choose_tree(w, leader);
  orient(w, reached);
  place(w, w->q);
  km_status status = km_find_destination(&m->folders, file, &w->arena, &w->destination, error);
  if (status)
    return status;
  return w->arena.failed ? km_fail(error, KM_MEMORY, "out of memory while writing the model") : check_loops(w, error);
}

void km_written_free(km_written *w) {
  km_arena_free(&w->arena);
}

km_pose km_written_frame(const km_written *w, int frame) {
  return metres(w, &w->model->frames[frame].pose);
}

double km_written_mass(const km_written *w, int body, double center[3], double inertia[6]) {
  const km_model_body *b = &w->model->bodies[body];
  km_vec3 c = km_vec3_scale(w->length, b->center_of_mass);
  memcpy(center, &c, sizeof c);
  for (int k = 0; k < 6; ++k)
    inertia[k] = b->inertia[k] * w->mass * w->length * w->length;
  return b->mass * w->mass;
}

void km_written_quaternion(const km_rotation *R, double out[4]) {
  km_quaternion q = km_quaternion_normalised(km_rotation_quaternion(R));
  memcpy(out, &q, sizeof q);
}
