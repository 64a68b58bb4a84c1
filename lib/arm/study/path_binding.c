/* Path of a path study, bound to the arm: units, start pose, and the place of errors in the text. */
#include "arm/arm_arguments.h"
#include "arm/study/study_binding.h"

#include <stdio.h>
#include <string.h>

/* Poses with orientations from rotation vectors. */
static const km_frame_pose *poses_from_rotation_vectors(km_arena *arena, const km_path_segment *g, const double *turns,
                                                        double angle) {
  km_frame_pose *poses = KM_ARENA_NEW(arena, km_frame_pose, (size_t)g->point_count);
  for (int k = 0; k < g->point_count && poses; ++k) {
    const double *turn = &turns[3 * k];
    km_vec3 v = {turn[0] * angle, turn[1] * angle, turn[2] * angle};
    km_rotation R = km_quaternion_rotation(km_quaternion_exp(v));
    poses[k] = g->points[k];
    km_rotation_rows(&R, poses[k].R);
  }
  return poses;
}

/* Converts a plan to radians. */
static bool convert(km_arena *arena, const km_study_path *path, double angle, km_path_plan *out) {
  km_path_segment *segments = KM_ARENA_NEW(arena, km_path_segment, (size_t)path->plan.segment_count);
  *out = path->plan;
  out->segments = segments;
  out->turn_speed *= angle;
  for (int i = 0; i < out->segment_count && segments; ++i) {
    segments[i] = path->plan.segments[i];
    segments[i].angle *= angle;
  }
  if (segments && path->turns)
    segments[0].points = poses_from_rotation_vectors(arena, &segments[0], path->turns, angle);
  return !arena->failed;
}

/* First pose of the path, in the arm's units: the effector's pose at q, with position or orientation replaced by
 * stated ones. */
static bool find_first_pose(km_binder *b, const double *q, km_pose *out) {
  const km_arm *a = b->study->arm;
  const km_study_path *path = &b->def->path;
  km_arm_space space;
  if (!km_arm_space_create(a, &space))
    return km_binder_memory(b);
  km_arm_update(a, &space, q);
  *out = space.pose;
  km_arm_space_free(&space);
  km_pose given = km_arm_pose_of(a, &path->plan.start);
  if (path->start_p)
    out->p = given.p;
  if (path->start_R)
    out->R = given.R;
  return true;
}

/* Reports a fault with its place: the line of a file of poses, else the part of the segment. */
static void report_fault(km_binder *b, const km_path_fault *fault, const km_error *found) {
  const km_study_path *path = &b->def->path;
  char segment[KM_PATH_FAULT_TEXT], where[KM_ERROR_TEXT];
  km_study_place at = {where, path->place.option};
  if (path->file && fault->item >= 0)
    snprintf(where, sizeof where, "%s.csv: %s, line %d", path->place.text, path->file, path->lines[fault->item]);
  else if (path->file)
    snprintf(where, sizeof where, "%s.csv", path->place.text);
  else
    snprintf(where, sizeof where, "%s.%s", path->place.text, km_path_fault_text(fault, segment));
  km_binder_fault(b, &at, "%s", found->text);
}

bool km_bind_path(km_binder *b, const double *q) {
  const km_study_path *path = &b->def->path;
  km_path_fault fault = KM_PATH_NO_FAULT;
  km_path_plan plan;
  km_pose start;
  km_error error;
  if (!path->plan.segments)
    return b->def->path_optional || km_binder_fault(b, &path->place, "found none; expected the path to follow");
  if (!km_binder_pass(b, &path->place, km_check_pose(&path->plan.start, &error), &error))
    return false;
  if (!find_first_pose(b, q, &start))
    return false;
  km_status status = km_path_plan_check(&path->plan, &fault, &error);
  if (!status && !convert(&b->study->arena, path, b->mechanism->model->units.angle->si, &plan))
    return km_binder_memory(b);
  if (!status)
    status = km_path_build(b->study->arm, &plan, &start, &b->study->path, &fault, &error);
  if (status == KM_MEMORY)
    return km_binder_pass(b, &path->place, status, &error);
  if (status)
    report_fault(b, &fault, &error);
  return !status;
}
