/* kmob frame: where a frame is and how it moves. */
#include "kmob/kmob.h"

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"
#include "kmech/model.h"
#include "kmech/report.h"

#include <string.h>

typedef struct options {
  kt_request request;
  const char *frame;
} options;

/* Results about a frame. */
typedef struct told {
  km_frame_pose pose;
  double *J;      /* [6 × coordinates] by the spanning tree */
  double *moving; /* [6 × freedom] the twists that the loops allow */
  int coordinates, freedom;
  bool weighs;        /* every free motion moves some mass */
  double inverse[36]; /* the inverse of the inertia that the frame shows */
} told;

static const char *const pushes[6] = {"fx", "fy", "fz", "tx", "ty", "tz"};
static const char *const rows[6] = {"vx", "vy", "vz", "wx", "wy", "wz"};

/* The twists of the mechanism's own motions: J N. */
static void multiply(const double *J, const double *N, int coordinates, int freedom, double *out) {
  for (int f = 0; f < freedom; ++f)
    for (int r = 0; r < 6; ++r) {
      double sum = 0.0;
      for (int c = 0; c < coordinates; ++c)
        sum += J[6 * c + r] * N[f * coordinates + c];
      out[6 * f + r] = sum;
    }
}

static km_status inspect(const kt_pose *pose, int frame, km_arena *arena, told *out, km_error *error) {
  km_mobility mobility;
  out->coordinates = km_model_coordinate_count(pose->model);
  if (km_mobility_compute(pose->mechanism, pose->state, &mobility))
    return km_fail(error, KM_MEMORY, "out of memory");
  km_poses_compute(pose->mechanism, pose->state);
  size_t n = (size_t)out->coordinates;
  double *N = KM_ARENA_NEW(arena, double, n *n);
  out->J = KM_ARENA_NEW(arena, double, 6 * n);
  out->moving = KM_ARENA_NEW(arena, double, 6 * n);
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory");
  km_status status = km_frame_place(pose->mechanism, pose->state, frame, &out->pose, error);
  if (!status)
    status = km_frame_jacobian(pose->mechanism, pose->state, frame, out->J, error);
  if (!status)
    status = km_motions_basis(pose->mechanism, pose->state, N, &out->freedom, error);
  if (!status)
    multiply(out->J, N, out->coordinates, out->freedom, out->moving);
  if (status)
    return status;
  status = km_frame_inverse_inertia(pose->mechanism, pose->state, frame, out->inverse, error);
  out->weighs = status == KM_OK;
  return status == KM_MODEL ? KM_OK : status;
}

static void print_matrix(const double *M, int columns, km_text *out) {
  for (int r = 0; r < 6; ++r) {
    km_text_format(out, "  %s", rows[r]);
    for (int c = 0; c < columns; ++c)
      km_text_format(out, " %12.6g", M[6 * c + r] + 0.0);
    km_text_add(out, "\n");
  }
}

/* Rounding of 1/mass at a point on the axis of rotation: its velocity is rounding of the angular velocity times its
 * position. */
static double left_of(const told *t) {
  static const double rounding = 1e-13;
  const double *p = t->pose.p, turning = t->inverse[21] + t->inverse[28] + t->inverse[35];
  return rounding * rounding * turning * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
}

/* Effective inertia for a force or torque along an axis of the inertial frame. */
static void print_masses(const km_model *model, const told *t, km_text *out) {
  km_units units = km_model_units(model);
  const char *mass = units.mass->suffix, *length = units.length->suffix;
  km_text_format(out, "\nmass that a push along each axis feels, from rest (forces %s, torques %s*%s²)\n", mass, mass,
                 length);
  for (int r = 0; r < 6; ++r) {
    const double *block = t->inverse + (r < 3 ? 0 : 21), easy = t->inverse[7 * r];
    if (easy > 1e-12 * (block[0] + block[7] + block[14]) + (r < 3 ? left_of(t) : 0.0))
      km_text_format(out, "  %s %12.6g\n", pushes[r], 1.0 / easy);
    else
      km_text_format(out, "  %s    it can't move\n", pushes[r]);
  }
}

static void print(const options *o, const km_model *model, const told *t, km_text *out) {
  const double *R = t->pose.R, *p = t->pose.p;
  km_text_format(out, "%s: frame %s at %.9g, %.9g, %.9g %s\n\naxes, as columns\n", o->request.model, o->frame, p[0],
                 p[1], p[2], km_model_units(model).length->suffix);
  for (int r = 0; r < 3; ++r)
    km_text_format(out, "  %12.9f %12.9f %12.9f\n", R[3 * r], R[3 * r + 1], R[3 * r + 2]);
  km_text_format(out, "\ntwists of its %d motion%s, each of unit size (lengths in %s, angles in rad)\n", t->freedom,
                 t->freedom == 1 ? "" : "s", km_model_units(model).length->suffix);
  print_matrix(t->moving, t->freedom, out);
  km_text_add(out, "\nJacobian along the spanning tree, of");
  for (int c = 0; c < t->coordinates; ++c)
    km_text_format(out, "%s %s", c ? "," : "", km_model_coordinate_label(model, c));
  km_text_add(out, "\n");
  print_matrix(t->J, t->coordinates, out);
  if (t->weighs)
    print_masses(model, t, out);
  else
    km_text_add(out, "\nno masses that pushes feel: a free motion moves no mass\n");
}

static void add_matrix(km_value *record, const char *key, const double *M, int columns, km_arena *arena) {
  km_value *list = km_value_add(arena, record, key, KM_LIST);
  for (int r = 0; r < 6; ++r) {
    km_value *line = km_value_add(arena, list, NULL, KM_LIST);
    for (int c = 0; c < columns; ++c)
      km_value_number(arena, line, NULL, M[6 * c + r]);
  }
}

static const km_value *record_of(const options *o, const kt_pose *pose, const told *t, km_arena *arena) {
  km_value *record = km_record_head(pose->mechanism, "kmob", o->request.model, arena);
  km_value_string(arena, record, "frame", o->frame);
  km_value_numbers(arena, record, "position", t->pose.p, 3);
  km_value *R = km_value_add(arena, record, "rotation", KM_LIST);
  for (int r = 0; r < 3; ++r)
    km_value_numbers(arena, R, NULL, t->pose.R + 3 * r, 3);
  km_value *labels = km_value_add(arena, record, "coordinates", KM_LIST);
  for (int c = 0; c < t->coordinates; ++c)
    km_value_string(arena, labels, NULL, km_model_coordinate_label(pose->model, c));
  add_matrix(record, "jacobian", t->J, t->coordinates, arena);
  add_matrix(record, "motions", t->moving, t->freedom, arena);
  if (t->weighs)
    add_matrix(record, "inverse_inertia", t->inverse, 6, arena);
  else
    km_value_add(arena, record, "inverse_inertia", KM_NULL);
  if (!t->weighs)
    km_value_string(arena, record, "inverse_inertia_state", "a free motion moves no mass");
  return record;
}

static kt_exit describe(const options *o, const kt_pose *pose, int frame) {
  km_arena arena = {0};
  km_text out = {0};
  km_error error;
  told t;
  km_status status = inspect(pose, frame, &arena, &t, &error);
  if (status)
    kt_print_message(&o->request.common, KM_ERROR, "%s: %s", o->request.model, error.text);
  else if (o->request.json)
    km_json_write(record_of(o, pose, &t, &arena), &out);
  else
    print(o, pose->model, &t, &out);
  kt_exit result = status ? kt_exit_of(status) : kt_answer(&o->request, "frame", &out);
  km_text_free(&out);
  km_arena_free(&arena);
  return result;
}

kt_exit kmob_frame(int argc, char **argv) {
  options o = {.request = {.common = KT_COMMON("kmob")}};
  kt_options all = {0};
  const kt_option own[] = {{"frame", 0, "BODY/FRAME", "The frame", KT_TEXT, &o.frame, KT_ABOUT_MODEL}};
  KT_OPTIONS_ADD(&all, own);
  kt_request_options(&all, &o.request, true, KT_REQUEST_BASE("frame"));
  kt_common_options(&all, &o.request.common, KT_USES_FLOAT);
  kt_options_read(
      &all,
      "Where a frame is in the inertial frame, how it moves with each coordinate along the spanning tree, "
      "which twists the loops leave it, and the inertia that it shows."
      "\vJSON keys beside those of every record: frame, position, rotation (rows), coordinates (labels of the "
      "Jacobian's columns), jacobian and motions (six rows vx vy vz wx wy wz, inertial axes, at the frame's "
      "origin; radians and the model's length unit), inverse_inertia (six rows: the twist per time that a unit force or "
      "torque gives the frame from rest, in one over the model's mass unit; null where a free motion moves no mass).",
      argc, argv);
  if (!o.frame)
    return kt_usage(&o.request.common, "--frame", "is missing", "the frame, as crank/tip");
  kt_pose pose;
  int frame;
  kt_exit result = kt_request_open(&o.request, &pose);
  if (result == KT_DONE)
    result = kt_frame(&o.request.common, pose.model, "--frame", o.frame, &frame);
  if (result == KT_DONE)
    result = describe(&o, &pose, frame);
  kt_close(&pose);
  return result;
}
