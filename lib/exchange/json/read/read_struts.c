/* Struts: the length between two points as one coordinate. A slide lies along the line between the points, with a
 * massless body on either side of it and a joint at either end: in space a ball at `from` and a universal joint at
 * `to`, in a plane a hinge at each. All of them are at 0 where the assembly starts, the slide at the length. */
#include "exchange/json/read/reader.h"

#include "model/initial_poses.h"

#include <string.h>

typedef struct strut {
  const km_value *value;
  const km_place *place;
  const char *name;
  int assembly;
  bool planar;
  int body[2];      /* those that it joins */
  int half[2];      /* those that it is made of */
  km_pose stand[2]; /* pose of `body` in the inertial frame at the initial displacements */
  km_vec3 point[2]; /* its ends there */
  km_rotation axes; /* x along it; in a plane z is the normal, in space turned for the universal joint only at `to` */
  double length, offset; /* `to` from `from` along x, and in a plane along the normal */
} strut;

/* The name of a part: the strut's, a colon and what it is. */
static const char *part_name(km_reader *reader, const strut *s, const km_names *names, const char *part) {
  km_text text = {0};
  km_text_format(&text, "%s:%s", s->name, part);
  const char *name = km_reader_free_name(reader, names, s->assembly, text.data ? text.data : "", NULL);
  reader->model->arena.failed = reader->model->arena.failed || text.failed;
  km_text_free(&text);
  return name;
}

static int make_half(km_reader *reader, const strut *s, const char *part) {
  km_model *model = reader->model;
  const char *name = part_name(reader, s, &reader->bodies, part);
  int index = model->body_count++;
  model->bodies[index] = (km_model_body){.name = name,
                                         .assembly = s->assembly,
                                         .density = -1.0,
                                         .is_strut_part = true,
                                         .where = km_reader_where(reader, s->place)};
  if (!km_names_set(&reader->bodies, s->assembly, name, index))
    model->arena.failed = true;
  km_reader_add_frame(reader, "origin", index, km_pose_identity());
  return index;
}

/* A frame on a body that the strut joins, from its place in the inertial frame. */
static int make_end(km_reader *reader, const strut *s, int end, const km_rotation *R) {
  km_pose back = km_pose_inverse(&s->stand[end]), X = {*R, s->point[end]};
  return km_reader_make_frame(reader, s->body[end], s->name, km_pose_product(&back, &X));
}

static int origin_of(const km_reader *reader, int body) {
  return km_names_get(&reader->frames, body, "origin");
}

/* `value`: what has limits and damping; NULL: none. */
static int make_joint(km_reader *reader, const strut *s, const char *name, km_joint_type type, int parent, int child,
                      const km_value *value) {
  km_model *model = reader->model;
  int index = model->joint_count++;
  model->joints[index] = (km_model_joint){.name = name,
                                          .assembly = s->assembly,
                                          .type = type,
                                          .frame = {parent, child},
                                          .where = km_reader_where(reader, s->place)};
  reader->origin->joints[index] = NULL;
  km_read_coordinates(reader, value, s->place, index);
  if (!km_names_set(&reader->joints, s->assembly, name, index))
    model->arena.failed = true;
  return index;
}

/* The hinge of the body at `to` that is most across the strut: while the body turns about it the universal joint, whose
 * second axis it becomes, is far from its singular poses. Without one, any direction across. */
static km_vec3 across(const km_model *model, const strut *s, km_vec3 along) {
  km_vec3 best = {0, 0, 0};
  double most = 0.1;
  for (int j = 0; j < model->joint_count; ++j) {
    const km_joint_kind *kind = km_joint_kind_of(model->joints[j].type);
    for (int end = 0; end < 2; ++end) {
      const km_model_frame *frame = &model->frames[model->joints[j].frame[end]];
      for (int i = 0; i < kind->motion_count && frame->body == s->body[1]; ++i) {
        if (kind->motions[i].primitive != KM_REVOLUTE)
          continue;
        km_vec3 axis = km_rotate(&s->stand[1].R, frame->pose.R.axis[kind->motions[i].axis]);
        double sine = km_vec3_norm(km_vec3_cross(along, axis));
        if (sine > most + 1e-9) {
          most = sine;
          best = axis;
        }
      }
    }
  }
  return most > 0.1 ? best : km_rotation_onto(0, along).axis[1];
}

static void make_joints(km_reader *reader, strut *s) {
  km_model *model = reader->model;
  km_rotation last = km_rotation_identity(), world;
  if (!s->planar) {
    km_vec3 second = across(model, s, s->axes.axis[0]), first = km_vec3_cross(s->axes.axis[0], second);
    first = km_vec3_scale(1.0 / km_vec3_norm(first), first);
    world = (km_rotation){{first, second, km_vec3_cross(first, second)}};
    last = km_rotation_inverse(&s->axes);
    last = km_rotation_product(&last, &world);
  } else {
    world = s->axes;
  }
  int from = make_end(reader, s, 0, &s->axes), to = make_end(reader, s, 1, &world);
  int tip = km_reader_make_frame(reader, s->half[1], "end", (km_pose){last, {0.0, 0.0, s->offset}});
  int rod = origin_of(reader, s->half[0]), sleeve = origin_of(reader, s->half[1]);
  make_joint(reader, s, part_name(reader, s, &reader->joints, "from"), s->planar ? KM_RZ : KM_SPHERICAL, from, rod,
             NULL);
  int slide = make_joint(reader, s, s->name, KM_TX, rod, sleeve, s->value);
  km_model_coordinate *length = &model->coordinates[model->joints[slide].first_coordinate];
  length->position = s->length;
  length->is_strut = true;
  make_joint(reader, s, part_name(reader, s, &reader->joints, "to"), s->planar ? KM_RZ : KM_UNIVERSAL, tip, to, NULL);
  const km_value *cylinder = km_value_get(s->value, "cylinder");
  if (cylinder && cylinder->number != 0.0)
    reader->cylinders[reader->cylinder_count++] = model->joints[slide].first_coordinate;
}

/* The force constant + slope · length along the strut, positive pushing the points apart. */
static void make_force(km_reader *reader, const strut *s, const char *part, double constant, double slope) {
  km_model *model = reader->model;
  double *coefficients = KM_ARENA_NEW(&model->arena, double, 2);
  int *start = KM_ARENA_NEW(&model->arena, int, 2);
  int slide = km_names_get(&reader->joints, s->assembly, s->name);
  if (!coefficients || !start)
    return;
  coefficients[0] = constant;
  coefficients[1] = slope;
  start[1] = 2;
  km_module_port port = {model->joints[slide].first_coordinate, {0, 0}};
  const km_module_input *inputs = km_model_single_input(&model->arena, port, KM_DISTANCE_EUCLID);
  if (!inputs)
    return;
  reader->origin->modules[model->module_count] = NULL;
  model->modules[model->module_count++] = (km_model_module){.name = part_name(reader, s, &(km_names){0}, part),
                                                            .where = km_reader_where(reader, s->place),
                                                            .type = KM_MODULE_STIFFNESS,
                                                            .input = port,
                                                            .output = port,
                                                            .input_count = 1,
                                                            .inputs = inputs,
                                                            .law = {.start = start, .coefficients = coefficients}};
}

static void read_spring(km_reader *reader, const strut *s) {
  const km_value *spring = km_value_get(s->value, "spring");
  km_place at = {s->place, "spring", 0};
  double stiffness = km_reader_number(spring, "stiffness", 0.0), free = km_reader_number(spring, "free_length", 0.0);
  km_reader_not_negative(reader, spring, "stiffness", &at);
  km_reader_not_negative(reader, spring, "free_length", &at);
  if (spring)
    make_force(reader, s, "spring", stiffness * free, -stiffness);
}

static void read_gas_spring(km_reader *reader, const strut *s) {
  const km_value *spring = km_value_get(s->value, "gas_spring");
  km_place at = {s->place, "gas_spring", 0};
  double force = km_reader_number(spring, "force", 0.0), rate = km_reader_number(spring, "rate", 0.0);
  double length = km_reader_number(spring, "length", 0.0);
  km_reader_not_negative(reader, spring, "rate", &at);
  if (rate != 0.0 && !km_value_get(spring, "length"))
    km_reader_error(reader, &at, "\"length\" is missing; expected the length at which the force is as stated");
  if (spring)
    make_force(reader, s, "gas_spring", force + rate * length, -rate);
}

/* Positions of the ends, and direction of the strut; false if its length is 0. */
static bool lie(km_reader *reader, strut *s, const km_pose *poses, const int frame[2]) {
  const km_model *model = reader->model;
  for (int end = 0; end < 2; ++end) {
    s->body[end] = model->frames[frame[end]].body;
    s->stand[end] = poses[s->body[end]];
    s->point[end] = km_pose_point(&s->stand[end], model->frames[frame[end]].pose.p);
  }
  km_vec3 way = km_vec3_sub(s->point[1], s->point[0]);
  km_vec3 normal = km_rotate(&s->stand[0].R, model->frames[frame[0]].pose.R.axis[2]);
  s->offset = s->planar ? km_vec3_dot(normal, way) : 0.0;
  way = km_vec3_axpy(-s->offset, normal, way);
  s->length = km_vec3_norm(way);
  if (!(s->length > 1e-12 * (km_vec3_norm(s->point[0]) + km_vec3_norm(s->point[1])))) {
    km_reader_error(reader, s->place, "both ends are at one point%s; expected a length greater than 0",
                    s->planar ? " of the plane" : "");
    return false;
  }
  km_vec3 x = km_vec3_scale(1.0 / s->length, way);
  s->axes = s->planar ? (km_rotation){{x, km_vec3_cross(normal, x), normal}} : km_rotation_onto(0, x);
  return true;
}

/* The two frames; false if there are none, which is reported unless they are left out. */
static bool read_frames(km_reader *reader, const km_value *value, int assembly, const km_place *place, int frame[2]) {
  km_place from = {place, "from", 0}, to = {place, "to", 0};
  frame[0] = km_reader_frame(reader, km_value_get(value, "from"), assembly, &from);
  frame[1] = km_reader_frame(reader, km_value_get(value, "to"), assembly, &to);
  if (frame[0] == KM_LEFT_OUT || frame[1] == KM_LEFT_OUT)
    km_reader_note(reader, place, "strut \"%.80s\" is left out with the body or frame that it is on",
                   km_reader_string(value, "name"));
  if (frame[0] < 0 || frame[1] < 0)
    return false;
  int body[2] = {reader->model->frames[frame[0]].body, reader->model->frames[frame[1]].body};
  bool parts = body[0] >= reader->start_count || body[1] >= reader->start_count;
  if (parts)
    km_reader_error(reader, body[0] >= reader->start_count ? &from : &to,
                    "is a part of another strut; expected a body of the file");
  else if (body[0] == body[1])
    km_reader_error(reader, &to, "is on \"%.80s\", as \"from\" is; expected two different bodies",
                    reader->model->bodies[body[0]].name);
  return !parts && body[0] != body[1];
}

static void omit(km_reader *reader, const km_value *value, int assembly, int why) {
  const char *name = km_reader_string(value, "name");
  if (km_names_get(&reader->joints, assembly, name) == KM_NOT_FOUND &&
      !km_names_set(&reader->joints, assembly, name, why))
    reader->model->arena.failed = true;
}

static void read_strut(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  strut s = {.value = value, .place = place, .assembly = assembly};
  int frame[2];
  size_t errors = km_messages_errors(reader->messages);
  bool active = km_reader_active(value);
  if (active) {
    s.name = km_reader_name(reader, value, place, &reader->joints, assembly, NULL);
    active = read_frames(reader, value, assembly, place, frame) && km_messages_errors(reader->messages) == errors;
  }
  const km_value *planar = km_value_get(value, "planar");
  s.planar = planar && planar->number != 0.0;
  if (!active || !lie(reader, &s, reader->start, frame)) {
    omit(reader, value, assembly, km_messages_errors(reader->messages) == errors ? KM_LEFT_OUT : KM_FAULTY);
    return;
  }
  s.half[0] = make_half(reader, &s, "from");
  s.half[1] = make_half(reader, &s, "to");
  make_joints(reader, &s);
  read_spring(reader, &s);
  read_gas_spring(reader, &s);
}

static void struts_of(km_reader *reader, const km_value *assembly, int index, const km_place *place) {
  km_reader_each(reader, assembly, "struts", index, place, read_strut);
}

void km_read_struts(km_reader *reader, const km_value *root) {
  km_model *model = reader->model;
  km_pose *start = reader->strut_room ? KM_NEW(km_pose, (size_t)model->body_count) : NULL;
  reader->cylinders = KM_ARENA_NEW(&model->arena, int, reader->strut_room);
  if (reader->strut_room && (!start || !reader->cylinders || !km_model_start_poses(model, start)))
    model->arena.failed = true;
  reader->start = start;
  reader->start_count = model->body_count;
  if (!model->arena.failed && start)
    km_reader_visit(reader, root, struts_of);
  reader->start = NULL;
  km_free(start);
}
