/* Joints of an assembly that is drawn assembled: their points and axes in the drawing's coordinates. */
#include "exchange/json/read/reader.h"

#include "model/initial_poses.h"

#include <string.h>

void km_read_drawn(km_reader *reader, const km_value *assembly, const km_place *place, km_model_assembly *out) {
  const char *word = km_reader_string(assembly, "drawn");
  km_place at = {place, "drawn", 0};
  out->drawn = word != NULL;
  if (word)
    km_reader_needs(reader, "1.1");
  if (word && strcmp(word, "assembled") != 0)
    km_reader_error(reader, &at, "\"%.40s\" is not known; expected \"assembled\", or no such key", word);
}

static bool is_drawn(const km_model *model, int body) {
  int assembly = model->bodies[body].assembly;
  return body == 0 || (assembly != KM_NO_ASSEMBLY && model->assemblies[assembly].drawn);
}

bool km_joint_is_drawn(const km_value *joint) {
  return km_value_get(joint, "bodies") || km_value_get(joint, "at") || km_value_get(joint, "axis");
}

int km_drawn_axis(km_joint_type type) {
  const km_joint_kind *kind = km_joint_kind_of(type);
  return kind->freedom == 1 || kind->freedom == 2 ? kind->motions[0].axis : 2;
}

static bool drawn_axis(km_reader *reader, const km_value *value, const km_place *place, km_joint_type type,
                       km_rotation *R) {
  km_place at = {place, "axis", 0};
  *R = km_rotation_identity();
  if (!km_value_get(value, "axis")) {
    bool slide = strcmp(km_reader_string(value, "type"), "prismatic") == 0;
    if (slide)
      km_reader_error(reader, place, "\"axis\" is missing; expected the direction of the slide, as [1, 0]");
    return !slide;
  }
  km_vec3 axis = km_reader_vector(value, "axis");
  double length = km_vec3_norm(axis);
  if (!(length > 0.0)) {
    km_reader_error(reader, &at, "found no length; expected a direction");
    return false;
  }
  *R = km_rotation_onto(km_drawn_axis(type), km_vec3_scale(1.0 / length, axis));
  return true;
}

/* The body at one end; KM_NOT_FOUND (reported) or KM_LEFT_OUT. */
static int drawn_body(km_reader *reader, const km_value *path, int assembly, const km_place *place) {
  const km_model *model = reader->model;
  char text[KM_PLACE_TEXT];
  int frame = km_reader_frame(reader, path, assembly, place);
  if (frame < 0)
    return frame;
  int body = model->frames[frame].body;
  if (strcmp(model->frames[frame].name, "origin") != 0)
    km_reader_error(reader, place, "\"%s\" is a frame; expected a body", km_path_text(path, text));
  else if (!is_drawn(model, body))
    km_reader_error(reader, place, "body \"%.80s\" is of an assembly that isn't \"drawn\": \"assembled\"",
                    model->bodies[body].name);
  else
    return body;
  return KM_NOT_FOUND;
}

bool km_read_drawn_ends(km_reader *reader, const km_value *value, int assembly, const km_place *place,
                        km_model_joint *joint, int body[2]) {
  const km_value *bodies = km_value_get(value, "bodies");
  km_place at = {place, "bodies", 0};
  km_place item = {&at, NULL, 0}, second = {&at, NULL, 1};
  bool anywhere = joint->type == KM_RIGID || joint->type == KM_FLOAT;
  km_pose pose = {.p = km_reader_vector(value, "at")};
  if (!bodies || bodies->count != 2) {
    km_reader_error(reader, bodies ? &at : place,
                    "expected the two bodies of the joint, as \"bodies\": [\"fixed\", \"crank\"]");
    return false;
  }
  if (!km_value_get(value, "at") && !anywhere) {
    km_reader_error(reader, place, "\"at\" is missing; expected the joint's point in the drawing");
    return false;
  }
  body[0] = drawn_body(reader, bodies->first, assembly, &item);
  body[1] = drawn_body(reader, bodies->last, assembly, &second);
  if (body[0] < 0 || body[1] < 0 || !drawn_axis(reader, value, place, joint->type, &pose.R))
    return false;
  for (int end = 0; end < 2; ++end)
    joint->frame[end] = km_reader_make_frame(reader, body[end], joint->name, pose);
  km_reader_record_drawn(reader, value, joint->frame);
  return true;
}

void km_place_drawn_child(km_model *model, int joint) {
  const int *frame = model->joints[joint].frame;
  km_pose motion = km_model_start_motion(model, joint);
  model->frames[frame[1]].pose = km_pose_product(&model->frames[frame[0]].pose, &motion);
}

/* The diagonal of the box around all drawn joints. */
static double drawing_size(const km_model *model) {
  km_vec3 low = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_frame *f = &model->frames[model->joints[j].frame[0]];
    if (!is_drawn(model, f->body))
      continue;
    low = (km_vec3){fmin(low.x, f->pose.p.x), fmin(low.y, f->pose.p.y), fmin(low.z, f->pose.p.z)};
    high = (km_vec3){fmax(high.x, f->pose.p.x), fmax(high.y, f->pose.p.y), fmax(high.z, f->pose.p.z)};
  }
  return km_vec3_norm(km_vec3_sub(high, low));
}

/* The gap that the drawing leaves between a joint's frames. */
static void report_gap(km_reader *reader, int joint, double size) {
  const km_model *model = reader->model;
  const km_model_joint *def = &model->joints[joint];
  const km_model_frame *a = &model->frames[def->frame[0]], *b = &model->frames[def->frame[1]];
  km_pose motion = km_model_start_motion(model, joint);
  km_pose X = km_pose_product(&a->pose, &motion);
  double gap = km_vec3_norm(km_vec3_sub(X.p, b->pose.p));
  km_rotation back = km_rotation_inverse(&X.R), turn = km_rotation_product(&back, &b->pose.R);
  double angle = km_vec3_norm(km_quaternion_log(km_rotation_quaternion(&turn)));
  if (gap > 1e-6 * size || angle > 1e-6)
    km_messages_add(reader->messages, KM_NOTE,
                    "%s: the drawing leaves a gap of %.3g %s and %.3g deg in joint \"%.80s\"; the assembly closes it",
                    def->where, gap, model->units.length->suffix, angle * 180.0 / M_PI, def->name);
}

void km_report_drawing_gaps(km_reader *reader) {
  const km_model *model = reader->model;
  double size = drawing_size(model);
  for (int j = 0; j < model->joint_count; ++j) {
    const int *frame = model->joints[j].frame;
    if (is_drawn(model, model->frames[frame[0]].body) && is_drawn(model, model->frames[frame[1]].body))
      report_gap(reader, j, size);
  }
}
