/* Bodies and joints of a drawing: what their frames held, in the inertial frame. */
#include "exchange/json/write/drawing_tree.h"

#include <string.h>

static const double unit_grain = 1e-15;    /* rounding of the entries of axes and rotations */
static const double inertia_grain = 1e-15; /* relative to the largest entry: residue of a rotation by a multiple of
                                            * 90° */

bool km_sketch_has_body(const km_sketch *s, int body) {
  return body == 0 || (s->model->bodies[body].assembly != KM_NO_ASSEMBLY && s->drawn[s->model->bodies[body].assembly]);
}

km_pose km_sketch_joint_pose(const km_sketch *s, int joint) {
  const km_model_frame *frame = &s->model->frames[s->model->joints[joint].frame[0]];
  return km_pose_product(&s->stand[frame->body], &frame->pose);
}

static bool same_rotation(const km_rotation *a, const km_rotation *b) {
  double most = 0.0;
  for (int k = 0; k < 3; ++k)
    most = fmax(most, km_vec3_norm(km_vec3_sub(a->axis[k], b->axis[k])));
  return most < 1e-12;
}

bool km_sketch_can_point(const km_sketch *s, int joint) {
  km_pose X = km_sketch_joint_pose(s, joint);
  km_joint_type type = s->model->joints[joint].type;
  if (km_model_freedom(s->model, joint) <= 1 || type == KM_CYLINDRICAL)
    return true;
  int axis = km_drawn_axis(type);
  km_rotation R = km_rotation_onto(axis, X.R.axis[axis]);
  return same_rotation(&R, &X.R);
}

/* The nearest multiple of a power of ten, as a decimal would have it. No zero has a sign. */
static double rounded(double value, double grain) {
  double steps = nearbyint(value / grain);
  return fabs(steps) < 0x1p53 ? (grain < 1.0 ? steps / nearbyint(1.0 / grain) : steps * grain) + 0.0 : value;
}

/* [x, y], or [x, y, z] out of the plane z = 0. */
static void write_point(const km_sketch *s, km_value *parent, const char *key, km_vec3 p, double grain) {
  const double x[3] = {rounded(p.x, grain), rounded(p.y, grain), rounded(p.z, grain)};
  km_value_numbers(s->arena, parent, key, x, x[2] == 0.0 ? 2 : 3);
}

/* `R`, unless it is none. */
static void write_rotation(const km_sketch *s, km_value *parent, const km_rotation *rotation) {
  double rows[9];
  bool turned = false;
  km_rotation_rows(rotation, rows);
  for (int i = 0; i < 9; ++i) {
    rows[i] = rounded(rows[i], unit_grain);
    turned = turned || rows[i] != (i % 4 == 0);
  }
  km_value *R = turned ? km_value_add(s->arena, parent, "R", KM_LIST) : NULL;
  for (int i = 0; i < 3 && turned; ++i)
    km_value_numbers(s->arena, R, NULL, &rows[3 * i], 3);
}

static void write_frame(const km_sketch *s, const km_value *object, const char *name, const km_pose *pose,
                        km_value *frames) {
  km_value *out = km_value_add(s->arena, frames, NULL, KM_OBJECT);
  km_value_string(s->arena, out, "name", name);
  write_point(s, out, "T", pose->p, s->grain);
  write_rotation(s, out, &pose->R);
  for (const km_value *v = object ? object->first : NULL; v; v = v->next)
    if (strcmp(v->key, "name") != 0 && strcmp(v->key, "T") != 0 && !km_is_orientation(v->key))
      km_sketch_copy(s, v, out, v->key);
}

/* The body's frame of that name; -1: it is left out. */
static int frame_of(const km_sketch *s, int body, const km_value *object) {
  const km_value *name = km_value_get(object, "name");
  for (int f = 0; f < s->model->frame_count && km_reader_active(object); ++f)
    if (s->model->frames[f].body == body && strcmp(s->model->frames[f].name, name->string) == 0)
      return f;
  return -1;
}

static bool joins_by_point(const km_sketch *s, int frame) {
  bool joins = false;
  for (int j = 0; j < s->model->joint_count; ++j)
    joins =
        joins || (s->pointed[j] && (s->model->joints[j].frame[0] == frame || s->model->joints[j].frame[1] == frame));
  return joins;
}

static void write_frames(const km_sketch *s, int body, const km_value *list, km_value *parent) {
  km_value *frames = NULL;
  if (s->own[body] || (list && list->first))
    frames = km_value_add(s->arena, NULL, "frames", KM_LIST);
  if (s->own[body])
    write_frame(s, NULL, s->own[body], &s->stand[body], frames);
  for (const km_value *v = list ? list->first : NULL; v && frames; v = v->next) {
    int frame = frame_of(s, body, v);
    if (frame < 0) {
      km_sketch_copy(s, v, frames, NULL);
    } else if (s->needed[frame] || !joins_by_point(s, frame)) {
      km_pose X = km_pose_product(&s->stand[body], &s->model->frames[frame].pose);
      write_frame(s, v, s->model->frames[frame].name, &X, frames);
    }
  }
  if (frames && frames->first)
    km_sketch_copy(s, frames, parent, "frames");
}

/* R I Rᵀ. */
static void write_inertia(const km_sketch *s, int body, km_value *parent) {
  static const char *const keys[6] = {"Ixx", "Iyy", "Izz", "Ixy", "Iyz", "Izx"};
  static const int entry[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
  const double *I = s->model->bodies[body].inertia;
  const km_vec3 columns[3] = {{I[0], I[3], I[5]}, {I[3], I[1], I[4]}, {I[5], I[4], I[2]}};
  const km_rotation back = km_rotation_inverse(&s->stand[body].R);
  km_vec3 turned[3];
  double value[6], largest = 0.0;
  for (int k = 0; k < 3; ++k) {
    km_vec3 row = back.axis[k]; /* row k of R */
    km_vec3 product = km_vec3_scale(row.x, columns[0]);
    product = km_vec3_axpy(row.y, columns[1], product);
    turned[k] = km_vec3_axpy(row.z, columns[2], product);
  }
  for (int k = 0; k < 6; ++k) {
    value[k] = km_vec3_dot(back.axis[entry[k][0]], turned[entry[k][1]]);
    largest = fmax(largest, fabs(value[k]));
  }
  km_value *out = largest > 0.0 ? km_value_add(s->arena, parent, "moment_of_inertia", KM_OBJECT) : NULL;
  for (int k = 0; k < 6 && out; ++k)
    if (fabs(value[k]) > inertia_grain * largest)
      km_value_number(s->arena, out, keys[k], value[k]);
}

bool km_sketch_stays(const km_sketch *s, int body) {
  const km_rotation identity = km_rotation_identity();
  return same_rotation(&s->stand[body].R, &identity) && km_vec3_norm(s->stand[body].p) <= s->grain;
}

/* Where a body's shape of that place in its list is, in the body's frame. */
static km_pose shape_pose(const km_sketch *s, int body, int place) {
  int count = 0;
  for (int i = 0; i < s->model->shape_count; ++i)
    if (s->model->shapes[i].body == body && count++ == place)
      return s->model->shapes[i].pose;
  return km_pose_identity();
}

/* A shape of a body, or the mesh of its definition, where the inertial frame sees it. */
static void write_shape(const km_sketch *s, int body, const km_value *shape, km_pose own, km_value *list) {
  km_value *out = km_value_add(s->arena, list, NULL, KM_OBJECT);
  km_pose X = km_pose_product(&s->stand[body], &own);
  for (const km_value *v = shape->first; v; v = v->next)
    if (strcmp(v->key, "T") != 0 && !km_is_orientation(v->key))
      km_sketch_copy(s, v, out, v->key);
  write_point(s, out, "T", X.p, s->grain);
  write_rotation(s, out, &X.R);
}

static void write_shapes(const km_sketch *s, int body, const km_value *object, km_value *parent) {
  const km_value *shapes = km_value_get(object, "shapes"), *density = km_value_get(object, "density");
  const char *mesh = km_sketch_stays(s, body) ? NULL : s->model->bodies[body].mesh;
  if (!shapes && !mesh)
    return;
  km_value *list = km_value_add(s->arena, parent, "shapes", KM_LIST);
  if (mesh) {
    km_value *shape = km_value_add(s->arena, NULL, NULL, KM_OBJECT);
    km_value_string(s->arena, shape, "mesh", mesh);
    if (shape && density)
      km_value_number(s->arena, shape, "density", density->number);
    if (shape)
      write_shape(s, body, shape, km_pose_identity(), list);
  }
  int place = 0;
  for (const km_value *v = shapes ? shapes->first : NULL; v && list; v = v->next)
    write_shape(s, body, v, shape_pose(s, body, place++), list);
}

/* A mesh that moves becomes a shape, with its density. */
static bool is_shape_now(const km_sketch *s, int body, const char *key) {
  bool moved = s->model->bodies[body].mesh && !km_sketch_stays(s, body);
  return strcmp(key, "shapes") == 0 || (moved && (strcmp(key, "definition") == 0 || strcmp(key, "density") == 0));
}

/* Default position: the origin of the body's frame. */
static void write_center(const km_sketch *s, int body, km_value *parent) {
  write_point(s, parent, "center_of_mass", km_pose_point(&s->stand[body], s->model->bodies[body].center_of_mass),
              s->grain);
}

void km_sketch_body(const km_sketch *s, int body, const km_value *object, km_value *parent, const char *key) {
  km_value *twin = km_value_add(s->arena, NULL, NULL, KM_OBJECT);
  bool stated = km_value_get(object, "center_of_mass") != NULL;
  for (const km_value *v = object->first; v && twin; v = v->next) {
    if (strcmp(v->key, "center_of_mass") == 0)
      write_center(s, body, twin);
    else if (strcmp(v->key, "moment_of_inertia") == 0)
      write_inertia(s, body, twin);
    else if (strcmp(v->key, "frames") != 0 && !is_shape_now(s, body, v->key))
      km_sketch_copy(s, v, twin, v->key);
    if (strcmp(v->key, "mass") == 0 && v->number != 0.0 && !stated)
      write_center(s, body, twin);
  }
  write_shapes(s, body, object, twin);
  write_frames(s, body, km_value_get(object, "frames"), twin);
  if (twin && twin->first) /* the inertial frame may have lost all that it had */
    km_sketch_copy(s, twin, parent, key);
}

static void write_body_path(const km_sketch *s, int body, int assembly, km_value *list) {
  int own = s->model->bodies[body].assembly;
  if (body == 0 || own == assembly) {
    km_value_string(s->arena, list, NULL, s->model->bodies[body].name);
    return;
  }
  km_value *path = km_value_add(s->arena, list, NULL, KM_LIST);
  km_sketch_write_assemblies(s, own, path);
  km_value_string(s->arena, path, NULL, s->model->bodies[body].name);
}

static const char *word_of(km_joint_type type) {
  bool hinge = type == KM_RX || type == KM_RY || type == KM_RZ, slide = type == KM_TX || type == KM_TY || type == KM_TZ;
  return hinge ? "revolute" : slide ? "prismatic" : km_joint_kind_of(type)->word;
}

/* The axis, but where the file means it anyway. */
static void write_axis(const km_sketch *s, km_joint_type type, km_vec3 u, km_value *twin) {
  const double c[3] = {rounded(u.x, unit_grain), rounded(u.y, unit_grain), rounded(u.z, unit_grain)};
  const km_joint_type written = (km_joint_type)km_joint_type_find(word_of(type));
  const km_vec3 usual = km_rotation_identity().axis[km_drawn_axis(written)];
  bool told = strcmp(word_of(type), "prismatic") != 0 && c[0] == usual.x && c[1] == usual.y && c[2] == usual.z;
  if (!told && type != KM_RIGID)
    km_value_numbers(s->arena, twin, "axis", c, c[2] == 0.0 ? 2 : 3);
}

/* Members that are written in another way. */
static bool is_replaced(const km_sketch *s, int joint, const km_value *member) {
  static const char *const keys[] = {"name", "type", "body_frame_pairs"};
  bool found = false;
  for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i)
    found = found || strcmp(member->key, keys[i]) == 0;
  const km_model_joint *def = &s->model->joints[joint];
  bool nothing = strcmp(member->key, "initial_displacement") == 0;
  for (int k = 0; k < km_model_freedom(s->model, joint); ++k)
    nothing = nothing && s->model->coordinates[def->first_coordinate + k].position == 0.0;
  return found || nothing;
}

void km_sketch_joint(const km_sketch *s, int joint, const km_value *object, km_value *parent) {
  const km_model_joint *def = &s->model->joints[joint];
  km_pose X = km_sketch_joint_pose(s, joint);
  km_value *twin = km_value_add(s->arena, parent, NULL, KM_OBJECT);
  km_value_string(s->arena, twin, "name", def->name);
  km_value_string(s->arena, twin, "type", word_of(def->type));
  km_value *bodies = km_value_add(s->arena, twin, "bodies", KM_LIST);
  for (int end = 0; end < 2; ++end)
    write_body_path(s, s->model->frames[def->frame[end]].body, def->assembly, bodies);
  write_point(s, twin, "at", X.p, s->grain);
  write_axis(s, def->type, X.R.axis[km_drawn_axis(def->type)], twin);
  for (const km_value *v = object->first; v && twin; v = v->next)
    if (!is_replaced(s, joint, v))
      km_sketch_copy(s, v, twin, v->key);
}
