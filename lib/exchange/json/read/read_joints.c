/* Joints, their coordinates and the couplings between them. */
#include "exchange/json/read/reader.h"

#include <math.h>
#include <string.h>

/* Fills `values` with one number a coordinate from a number or a list; reports a wrong count. */
static void read_coordinates(km_reader *reader, const km_value *joint, const char *key, int freedom,
                             const km_place *place, double otherwise, double values[KM_MAX_FREEDOM]) {
  const km_value *value = km_value_get(joint, key);
  for (int k = 0; k < freedom; ++k)
    values[k] = otherwise;
  if (!value)
    return;
  km_place at = {place, key, 0};
  size_t given = value->kind == KM_LIST ? value->count : 1;
  if (freedom == 0 && (given == 0 || (value->kind == KM_NUMBER && value->number == 0.0)))
    return;
  if (given != (size_t)freedom || (freedom > 1 && value->kind != KM_LIST)) {
    km_reader_error(reader, &at, "found %s%zu; expected %d (one a coordinate of this type)",
                    value->kind == KM_LIST ? "a list of " : "", given, freedom);
    return;
  }
  const km_value *item = value->kind == KM_LIST ? value->first : value;
  for (int k = 0; k < freedom; ++k, item = item->next)
    values[k] = item->number;
}

/* One range on a ball is that of the angle by which it turns. */
static void read_most_turn(km_reader *reader, const km_value *range, const km_place *at, km_model_joint *out) {
  if (range->first->number == 0.0 && /* NOLINT(*NullDereference): the format's check has seen to two numbers */
      range->last->number > 0.0)
    out->most_turn = range->last->number;
  else
    km_reader_error(reader, at, "found [%s, %s]; expected 0 and the largest angle of the ball's turn",
                    KM_SHOWN(range->first->number), KM_SHOWN(range->last->number));
}

static void read_limits(km_reader *reader, const km_value *joint, int freedom, const km_place *place,
                        km_model_joint *out, km_model_coordinate *coordinates) {
  const km_value *limits = km_value_get(joint, "limits");
  for (int k = 0; k < freedom; ++k) {
    coordinates[k].low = -HUGE_VAL;
    coordinates[k].high = HUGE_VAL;
  }
  if (!limits)
    return;
  km_place at = {place, "limits", 0};
  bool pairs = limits->first && limits->first->kind == KM_LIST;
  size_t given = pairs ? limits->count : 1;
  if (!pairs && out->type == KM_SPHERICAL) {
    read_most_turn(reader, limits, &at, out);
    return;
  }
  if (given != (size_t)freedom) {
    km_reader_error(reader, &at, "found %zu ranges; expected %d (one a coordinate of this type)", given, freedom);
    return;
  }
  const km_value *pair = pairs ? limits->first : limits;
  for (int k = 0; k < freedom; ++k, pair = pair->next) {
    coordinates[k].low = pair->first->number; /* NOLINT(*NullDereference): as above */
    coordinates[k].high = pair->last->number;
    if (coordinates[k].low > coordinates[k].high)
      km_reader_error(reader, &at, "found [%s, %s]; expected low ≤ high", KM_SHOWN(coordinates[k].low),
                      KM_SHOWN(coordinates[k].high));
  }
}

static void check_least(km_reader *reader, const km_place *place, const char *key, bool above, const double *values,
                        int count) {
  km_place at = {place, key, 0};
  for (int k = 0; k < count; ++k)
    if (above ? !(values[k] > 0.0) : values[k] < 0.0)
      km_reader_error(reader, &at, "found %s; expected a number %s 0", KM_SHOWN(values[k]),
                      above ? "greater than" : "of at least");
}

/* Limits of the joint's drive, and constant friction. */
static void read_drive(km_reader *reader, const km_value *joint, int freedom, const km_place *place,
                       km_model_coordinate *out) {
  double rate[KM_MAX_FREEDOM], force[KM_MAX_FREEDOM], armature[KM_MAX_FREEDOM], friction[KM_MAX_FREEDOM];
  km_place friction_place = {place, "friction", 0};
  read_coordinates(reader, joint, "max_rate", freedom, place, HUGE_VAL, rate);
  read_coordinates(reader, joint, "max_force", freedom, place, HUGE_VAL, force);
  read_coordinates(reader, joint, "armature", freedom, place, 0.0, armature);
  read_coordinates(reader, km_value_get(joint, "friction"), "torque", freedom, &friction_place, 0.0, friction);
  check_least(reader, place, "max_rate", true, rate, freedom);
  check_least(reader, place, "max_force", true, force, freedom);
  check_least(reader, place, "armature", false, armature, freedom);
  check_least(reader, &friction_place, "torque", false, friction, freedom);
  for (int k = 0; k < freedom; ++k) {
    out[k].max_rate = rate[k];
    out[k].max_force = force[k];
    out[k].armature = armature[k];
    out[k].friction = friction[k];
  }
}

static void check_table(km_reader *reader, const km_value *table, const km_place *place) {
  km_check_rows(reader, table, "time", place);
  if (table->count < 2)
    km_reader_error(reader, place, "found %zu rows; expected at least 2", table->count);
}

/* Reads a law that is a curve: a table with a period, a cosine, or segments. */
static void read_prescribed_curve(km_reader *reader, const km_value *p, double start, const km_place *place,
                                  km_joint_prescribed *out) {
  out->law = KM_MOTION_CURVE;
  if (km_value_get(p, "segments"))
    km_read_segments(reader, p, km_reader_number(p, "start", start), place, &out->curve);
  else if (km_value_get(p, "expression"))
    km_read_curve(reader, p, 1.0, place, &out->curve);
  else if (km_value_get(p, "cosine"))
    km_read_cosine(reader, p, 1.0, place, &out->curve);
  else
    km_read_table(reader, p, true, 1.0, place, &out->curve);
}

static void read_prescribed(km_reader *reader, const km_value *p, km_joint_prescribed *out) {
  const km_value *table = km_value_get(p, "table"), *polynomial = km_value_get(p, "polynomial");
  const km_value *sine = km_value_get(p, "sine");
  out->law = table ? KM_MOTION_TABLE : polynomial ? KM_MOTION_POLYNOMIAL : KM_MOTION_SINE;
  out->count = (int)(table ? table->count : polynomial ? polynomial->count : 1);
  out->values = KM_ARENA_NEW(&reader->model->arena, double,
                             table        ? 2 * table->count
                             : polynomial ? polynomial->count
                                          : 4);
  double *value = out->values;
  if (!value)
    return;
  for (const km_value *row = table ? table->first : NULL; row; row = row->next, value += 2) {
    value[0] = row->first->number;
    value[1] = row->last->number;
  }
  for (const km_value *c = polynomial ? polynomial->first : NULL; c; c = c->next)
    *value++ = c->number;
  static const char *const keys[4] = {"offset", "amplitude", "frequency", "phase"};
  for (int k = 0; k < 4 && out->law == KM_MOTION_SINE; ++k)
    out->values[k] = km_reader_number(sine, keys[k], 0.0);
}

/* Numbers of an object of a joint, none of them negative; 0 without it. */
static void read_parts(km_reader *reader, const km_value *joint, const km_place *place, const char *key,
                       const char *const *names, double *const *out) {
  const km_value *object = km_value_get(joint, key);
  km_place at = {place, key, 0};
  for (int i = 0; names[i]; ++i) {
    *out[i] = km_reader_number(object, names[i], 0.0);
    km_reader_not_negative(reader, object, names[i], &at);
  }
}

/* Tolerance, clearance and stiffness, for the allowance of redundant constraints. */
static void read_fit(km_reader *reader, const km_value *joint, const km_place *place, km_joint_fit *out) {
  out->has_tolerance = km_value_get(joint, "tolerance") != NULL;
  out->has_clearance = km_value_get(joint, "clearance") != NULL;
  read_parts(reader, joint, place, "tolerance", (const char *const[]){"position", "direction", NULL},
             (double *const[]){&out->position, &out->direction});
  read_parts(reader, joint, place, "clearance", (const char *const[]){"radial", "axial", "angular", NULL},
             (double *const[]){&out->radial, &out->axial, &out->angular});
  read_parts(reader, joint, place, "stiffness", (const char *const[]){"force", "moment", NULL},
             (double *const[]){&out->force_stiffness, &out->moment_stiffness});
}

static void read_options(km_reader *reader, const km_value *joint, const km_place *place, km_model_joint *out) {
  km_place friction = {place, "friction", 0}, stop = {place, "stop", 0}, prescribed = {place, "prescribed", 0};
  const km_value *f = km_value_get(joint, "friction"), *s = km_value_get(joint, "stop");
  size_t errors = km_messages_errors(reader->messages);
  out->friction = (km_joint_friction){km_reader_number(f, "coefficient", 0.0), km_reader_number(f, "radius", 0.0),
                                      km_reader_number(f, "stiction_velocity", 0.0)};
  out->stop = (km_joint_stop){km_reader_number(s, "stiffness", 0.0), km_reader_number(s, "damping", 0.0)};
  km_reader_not_negative(reader, f, "coefficient", &friction);
  km_reader_not_negative(reader, f, "radius", &friction);
  km_reader_not_negative(reader, f, "stiction_velocity", &friction);
  km_reader_not_negative(reader, s, "stiffness", &stop);
  km_reader_not_negative(reader, s, "damping", &stop);
  read_fit(reader, joint, place, &out->fit);
  const km_value *p = km_value_get(joint, "prescribed");
  if (!p)
    return;
  if (km_joint_kind_of(out->type)->freedom != 1)
    km_reader_error(reader, &prescribed, "a joint of %d coordinates; expected one with a single coordinate",
                    km_joint_kind_of(out->type)->freedom);
  const km_value *table = km_value_get(p, "table");
  const km_value *polynomial = km_value_get(p, "polynomial"), *sine = km_value_get(p, "sine");
  const km_value *cosine = km_value_get(p, "cosine"), *segments = km_value_get(p, "segments"),
                 *expression = km_value_get(p, "expression");
  const km_value *period = km_value_get(p, "period"), *start = km_value_get(p, "start");
  int laws = (table != NULL) + (polynomial != NULL) + (sine != NULL) + (cosine != NULL) + (segments != NULL) +
             (expression != NULL);
  km_place at = {&prescribed, "table", 0}, polynomial_at = {&prescribed, "polynomial", 0};
  km_place period_at = {&prescribed, "period", 0}, start_at = {&prescribed, "start", 0};
  if (laws != 1)
    km_reader_error(
        reader, &prescribed,
        "found %d laws; expected one of \"table\", \"polynomial\", \"sine\", \"cosine\", \"segments\", \"expression\"",
        laws);
  if (period && (polynomial || sine))
    km_reader_error(reader, &period_at, "this law has no period; expected a table, a cosine or segments");
  if (start && !segments)
    km_reader_error(reader, &start_at, "found it without segments; expected it beside \"segments\"");
  if (table)
    check_table(reader, table, &at);
  if (polynomial && polynomial->count == 0)
    km_reader_error(reader, &polynomial_at, "found a list of 0; expected at least one coefficient");
  if (km_messages_errors(reader->messages) > errors)
    return;
  if (cosine || segments || expression || period)
    read_prescribed_curve(reader, p, reader->model->coordinates[out->first_coordinate].position, &prescribed,
                          &out->prescribed);
  else
    read_prescribed(reader, p, &out->prescribed);
}

static bool read_type(km_reader *reader, const km_value *value, const km_place *place, km_model_joint *joint) {
  const char *word = km_reader_string(value, "type");
  int type = km_joint_type_find(word);
  km_place at = {place, "type", 0}, pitch_at = {place, "pitch", 0};
  if (type < 0) {
    km_text known = {0};
    for (int t = 0; t < KM_JOINT_TYPES; ++t)
      km_text_format(&known, "%s%s", t ? ", " : "", km_joint_kind_of((km_joint_type)t)->word);
    km_reader_error(reader, &at, "\"%.40s\" is not a joint type; expected %s, revolute or prismatic", word,
                    known.data ? known.data : "");
    km_text_free(&known);
    return false;
  }
  const km_value *pitch = km_value_get(value, "pitch");
  joint->type = (km_joint_type)type;
  joint->pitch = pitch ? pitch->number : 0.0;
  if (type == KM_SCREW && !pitch)
    km_reader_error(reader, place, "\"pitch\" is missing; expected the travel of a screw in one turn");
  if (type != KM_SCREW && pitch)
    km_reader_error(reader, &pitch_at, "found a pitch on a joint of type %s; expected it only on a screw", word);
  return true;
}

/* Frames of body_frame_pairs and their bodies. */
static bool read_pair(km_reader *reader, const km_value *pair, int assembly, const km_place *place,
                      km_model_joint *joint, int body[2]) {
  km_place at = {place, "body_frame_pairs", 0};
  km_place first = {&at, NULL, 0}, second = {&at, NULL, 1};
  joint->frame[0] = km_reader_frame(reader, pair->first, assembly, &first);
  joint->frame[1] = km_reader_frame(reader, pair->last, assembly, &second);
  for (int end = 0; end < 2; ++end)
    body[end] = joint->frame[end] < 0 ? joint->frame[end] : reader->model->frames[joint->frame[end]].body;
  return body[0] >= 0 && body[1] >= 0;
}

static bool read_ends(km_reader *reader, const km_value *value, int assembly, const km_place *place,
                      km_model_joint *joint) {
  const km_value *pair = km_value_get(value, "body_frame_pairs");
  bool drawn = reader->model->assemblies[assembly].drawn, pointed = km_joint_is_drawn(value);
  km_place at = {place, pair ? "body_frame_pairs" : "bodies", 0};
  int body[2] = {KM_NOT_FOUND, KM_NOT_FOUND};
  bool found = false;
  if (pair && pointed)
    km_reader_error(reader, place,
                    "found \"body_frame_pairs\" beside \"bodies\", \"at\" or \"axis\"; expected one way");
  else if (pointed && !drawn)
    km_reader_error(reader, place,
                    "found \"bodies\", \"at\" or \"axis\"; expected \"body_frame_pairs\", or \"drawn\": "
                    "\"assembled\" in the assembly");
  else if (pair)
    found = read_pair(reader, pair, assembly, place, joint, body);
  else
    found = km_read_drawn_ends(reader, value, assembly, place, joint, body);
  if (body[0] == KM_LEFT_OUT || body[1] == KM_LEFT_OUT)
    km_reader_note(reader, place, "joint \"%.80s\" is left out with the body or frame that it is on", joint->name);
  else if (found && body[0] == body[1])
    km_reader_error(reader, &at, "both ends are on \"%.80s\"; expected two different bodies",
                    reader->model->bodies[body[0]].name);
  return found && body[0] != body[1];
}

/* Past a million radians an angle's rounding is larger than what loops are closed to. */
static void check_turns(km_reader *reader, km_joint_type type, const double *position, int freedom,
                        const km_place *place) {
  static const double most = 1e6;
  km_place at = {place, "initial_displacement", 0};
  for (int k = 0; k < freedom; ++k)
    if (!km_joint_is_length(type, k) && fabs(position[k]) * reader->model->units.angle->si > most)
      km_reader_error(reader, &at, "found an angle of %.6g; expected less than a million radians", position[k]);
}

void km_read_coordinates(km_reader *reader, const km_value *value, const km_place *place, int index) {
  km_model *model = reader->model;
  km_model_joint *joint = &model->joints[index];
  int freedom = km_model_freedom(model, index);
  double position[KM_MAX_FREEDOM], rate[KM_MAX_FREEDOM], damping[KM_MAX_FREEDOM];
  read_coordinates(reader, value, "initial_displacement", freedom, place, 0.0, position);
  check_turns(reader, joint->type, position, freedom, place);
  read_coordinates(reader, value, "initial_velocity", freedom, place, 0.0, rate);
  read_coordinates(reader, value, "damping", freedom, place, 0.0, damping);
  joint->first_coordinate = model->coordinate_count;
  model->coordinate_count += freedom;
  for (int k = 0; k < freedom; ++k)
    model->coordinates[joint->first_coordinate + k] =
        (km_model_coordinate){.joint = index,
                              .index = k,
                              .position = position[k],
                              .rate = rate[k],
                              .rate_stated = km_value_get(value, "initial_velocity") != NULL,
                              .damping = damping[k]};
  read_limits(reader, value, freedom, place, joint, &model->coordinates[joint->first_coordinate]);
  read_drive(reader, value, freedom, place, &model->coordinates[joint->first_coordinate]);
}

static void read_joint(km_reader *reader, const km_value *value, int assembly, const km_place *place) {
  km_model *model = reader->model;
  km_model_joint joint = {.assembly = assembly, .where = km_reader_where(reader, place)};
  bool active = km_reader_active(value);
  size_t errors = km_messages_errors(reader->messages);
  if (active) {
    joint.name = km_reader_name(reader, value, place, &reader->joints, assembly, NULL);
    active = read_type(reader, value, place, &joint);
    active = read_ends(reader, value, assembly, place, &joint) && active;
  }
  const char *name = km_reader_string(value, "name");
  bool faulty = km_messages_errors(reader->messages) > errors;
  if (faulty && !km_names_set(&reader->labels, KM_LABEL_FAULTY, name, 1))
    model->arena.failed = true;
  if (!active) {
    if (!faulty && !km_names_set(&reader->labels, KM_LABEL_LEFT_OUT, name, 1))
      model->arena.failed = true;
    if (km_names_get(&reader->joints, assembly, name) == KM_NOT_FOUND &&
        !km_names_set(&reader->joints, assembly, name, faulty ? KM_FAULTY : KM_LEFT_OUT))
      model->arena.failed = true;
    return;
  }
  int index = model->joint_count++;
  model->joints[index] = joint;
  reader->origin->joints[index] = value;
  km_read_coordinates(reader, value, place, index);
  if (km_joint_is_drawn(value))
    km_place_drawn_child(model, index);
  read_options(reader, value, place, &model->joints[index]);
  if (!km_names_set(&reader->joints, assembly, joint.name, index))
    model->arena.failed = true;
}

static void joints_of(km_reader *reader, const km_value *assembly, int index, const km_place *place) {
  km_reader_each(reader, assembly, "joints", index, place, read_joint);
}

void km_read_joints(km_reader *reader, const km_value *root) {
  km_reader_visit(reader, root, joints_of);
  km_report_drawing_gaps(reader);
  km_read_struts(reader, root);
  if (km_messages_errors(reader->messages) == 0)
    km_model_check_ties(reader->model, reader->messages);
  km_model_assign_labels(reader->model, &reader->labels, reader->messages);
}
