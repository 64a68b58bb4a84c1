/* Reading robot descriptions in tests. */
#include "support/robots.h"

#include "kmech/mobility.h"

#include <math.h>
#include <string.h>

km_model *read_as(const char *text, bool floating, km_messages *messages) {
  km_model *model = NULL;
  km_error error = {0};
  if (km_model_read_as(text, strlen(text), &(km_read_def){.floating = floating}, messages, &model, &error))
    fail_msg("%s", error.text);
  return model;
}

fixture open_text(const char *text) {
  return fixture_of(read_as(text, false, NULL));
}

int coordinate_of(const km_model *model, const char *label) {
  for (int c = 0; c < km_model_coordinate_count(model); ++c)
    if (strcmp(km_model_coordinate_label(model, c), label) == 0)
      return c;
  fail_msg("no coordinate %s", label);
  return -1;
}

int body_of(const km_model *model, const char *name) {
  for (int b = 1; b < model->body_count; ++b)
    if (strcmp(model->bodies[b].name, name) == 0)
      return b;
  fail_msg("no body %s", name);
  return -1;
}

void go_to(fixture *f, const char *label, double value) {
  assert_int_equal(km_state_set_coordinate(f->mechanism, f->state, coordinate_of(f->model, label), value, NULL), KM_OK);
}

km_frame_pose pose_of(const fixture *f, const char *body) {
  int b = body_of(f->model, body), frame = 0;
  km_frame_pose pose;
  while (km_model_frame_body(f->model, frame) != b || strcmp(km_model_frame_name(f->model, frame), "origin") != 0)
    frame++;
  km_poses_compute(f->mechanism, f->state);
  assert_int_equal(km_frame_place(f->mechanism, f->state, frame, &pose, NULL), KM_OK);
  return pose;
}

void assert_planar(const fixture *f, const char *body, double x, double y, double angle) {
  km_frame_pose pose = pose_of(f, body);
  assert_near(pose.p[0], x, 1e-14);
  assert_near(pose.p[1], y, 1e-14);
  assert_near(pose.p[2], 0.0, 1e-14);
  assert_near(pose.R[0], cos(angle), 1e-14);
  assert_near(pose.R[3], sin(angle), 1e-14);
  assert_near(pose.R[8], 1.0, 1e-14);
}

int mobility_of(fixture *f) {
  km_mobility mobility;
  km_error error;
  if (km_assemble(f->mechanism, f->state, NULL, &error))
    fail_msg("%s", error.text);
  km_mobility_compute(f->mechanism, f->state, &mobility);
  return mobility.mobility;
}
