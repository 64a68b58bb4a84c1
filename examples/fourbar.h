/* Builds a four-bar by calls: crank 1, rocker 3, ground 3.5, and a coupler of given length. */
#ifndef FOURBAR_H
#define FOURBAR_H

#include <kmech/kmech.h>
#include <stdio.h>

/* A joint about z between two frames, which starts at an angle. */
static inline km_status fourbar_hinge(km_builder *builder, const char *name, km_frame_id parent, km_frame_id child,
                                      double angle, km_error *error) {
  km_joint_def def = km_joint_default();
  def.name = name;
  def.type = KM_RZ;
  def.parent = parent;
  def.child = child;
  def.position[0] = angle;
  return km_model_add_joint(builder, &def, NULL, error);
}

static inline km_status fourbar_open(double coupler, km_model **model, km_error *error) {
  static const char *const names[3] = {"crank", "coupler", "rocker"};
  const double lengths[4] = {1.0, coupler, 3.0, 3.5}; /* the last link is the ground */
  km_frame_id root[4], tip[4];
  km_builder *builder = NULL;
  km_status status = km_builder_create(&builder, error);
  for (int i = 0; i < 4 && !status; ++i) {
    km_body_def body = km_body_default();
    km_frame_def frame = km_frame_default();
    km_body_id id = km_builder_fixed(builder);
    if (i < 3) {
      body.name = names[i];
      status = km_model_add_body(builder, &body, &id, error);
    }
    root[i] = km_builder_origin(builder, id);
    frame.name = "tip";
    frame.T[0] = lengths[i];
    if (!status)
      status = km_model_add_frame(builder, id, &frame, &tip[i], error);
  }
  if (!status)
    status = fourbar_hinge(builder, "A", root[3], root[0], 1.0, error);
  if (!status)
    status = fourbar_hinge(builder, "B", tip[0], root[1], -0.4, error);
  if (!status)
    status = fourbar_hinge(builder, "C", tip[1], tip[2], 1.2, error);
  if (!status)
    status = fourbar_hinge(builder, "D", tip[3], root[2], 1.8, error);
  if (!status)
    status = km_builder_finish(builder, model, error);
  km_builder_free(builder);
  return status;
}

#endif
