/* Comparison of configurations as assembly modes (docs/theory.md 4.13): poses of bodies, without passive rotations.
 *
 * A body with all joints on one line (a rod) counts by that line, a body with all joints at one point (a crosspiece) by
 * that point, the halves of a strut not at all. */
#include "kinematics/modes/mode_identity.h"
#include "base/number/tolerances.h"

/* Adds a joint's frame to the line of its body: the first joint gives the point; the farthest other joint, or the axis
 * of a slide, gives the direction. */
static void add_joint_frame(km_body_placement *placement, bool *is_known, double *farthest, const km_pose *frame,
                            int slide_axis) {
  if (!*is_known) {
    placement->point = frame->p;
    *is_known = true;
  }
  km_vec3 offset = km_vec3_sub(frame->p, placement->point);
  double length = km_vec3_norm(offset);
  if (length > *farthest) {
    *farthest = length;
    placement->direction = km_vec3_scale(1.0 / length, offset);
  } else if (slide_axis >= 0 && *farthest == 0.0) {
    placement->direction = frame->R.axis[slide_axis];
  }
}

/* Axis of a joint's slide; -1: no slide; -2: several slides, or a screw, so that the body has no passive rotation. */
static int find_slide_axis(km_joint_type type) {
  const km_joint_kind *kind = km_joint_kind_of(type);
  int axis = -1;
  for (int i = 0; i < kind->motion_count; ++i) {
    if (kind->motions[i].primitive == KM_HELICAL)
      return -2;
    if (kind->motions[i].primitive == KM_PRISMATIC)
      axis = axis == -1 ? kind->motions[i].axis : -2;
  }
  return axis;
}

/* True if a vector is parallel to `direction`, to a part of `size`. */
static bool is_parallel(km_vec3 offset, km_vec3 direction, double size) {
  return km_vec3_norm(km_vec3_cross(offset, direction)) <= km_relative_zero * size;
}

/* One end of a joint: its body, slide axis (find_slide_axis), and frame on the body. */
typedef struct joint_end {
  int body, slide_axis;
  const km_pose *frame;
} joint_end;

static joint_end joint_end_of(const km_mechanism *m, int joint, int end) {
  const km_model_joint *j = &m->model->joints[joint];
  const km_model_frame *frame = &m->model->frames[j->frame[end]];
  return (joint_end){frame->body, find_slide_axis(j->type), &frame->pose};
}

/* Classifies each body as pose, line or point by its joints' frames. */
static bool classify_placements(const km_mechanism *m, km_body_placement *placements) {
  const km_model *model = m->model;
  size_t bodies = (size_t)model->body_count;
  km_arena scratch = {0};
  bool *is_known = KM_ARENA_NEW(&scratch, bool, bodies);
  double *farthest = KM_ARENA_NEW(&scratch, double, bodies);
  bool is_ok = !scratch.failed;
  for (int i = 0; is_ok && i < 2 * model->joint_count; ++i) {
    joint_end e = joint_end_of(m, i / 2, i % 2);
    add_joint_frame(&placements[e.body], &is_known[e.body], &farthest[e.body], e.frame, e.slide_axis);
  }
  for (int b = 1; is_ok && b < model->body_count; ++b)
    if (placements[b].identity != KM_BODY_PASSIVE && is_known[b])
      placements[b].identity = km_vec3_norm(placements[b].direction) > 0.0 ? KM_BODY_LINE : KM_BODY_POINT;
  for (int i = 0; is_ok && i < 2 * model->joint_count; ++i) {
    joint_end e = joint_end_of(m, i / 2, i % 2);
    km_body_placement *placement = &placements[e.body];
    bool fits =
        e.slide_axis != -2 &&
        (e.slide_axis < 0 || is_parallel(e.frame->R.axis[e.slide_axis], placement->direction, 1.0)) &&
        is_parallel(km_vec3_sub(e.frame->p, placement->point), placement->direction, fmax(farthest[e.body], 1e-300));
    if (!fits && placement->identity != KM_BODY_PASSIVE)
      placement->identity = KM_BODY_POSE;
  }
  km_arena_free(&scratch);
  return is_ok;
}

bool km_body_placements(const km_mechanism *m, km_body_placement *placements) {
  for (int b = 0; b < m->model->body_count; ++b)
    placements[b] = (km_body_placement){.identity = m->model->bodies[b].is_strut_part ? KM_BODY_PASSIVE : KM_BODY_POSE};
  return classify_placements(m, placements);
}

static bool are_vectors_equal(km_vec3 a, km_vec3 b, double tolerance) {
  return km_vec3_norm(km_vec3_sub(a, b)) <= tolerance;
}

/* Part of a body's pose that agrees in two configurations. */
typedef enum pose_agreement { DIFFERS, SAME_POINT, SAME_LINE, SAME_PLACE } pose_agreement;

/* Compares the distinguishing part of one body's pose in two configurations. */
static pose_agreement compare(const km_body_placement *p, const km_pose *a, const km_pose *b, double size,
                              double tolerance) {
  bool is_rotated = false;
  if (p->identity == KM_BODY_PASSIVE)
    return SAME_PLACE;
  if (!are_vectors_equal(km_pose_point(a, p->point), km_pose_point(b, p->point), tolerance * size))
    return DIFFERS;
  for (int k = 0; k < 3; ++k)
    is_rotated = is_rotated || !are_vectors_equal(a->R.axis[k], b->R.axis[k], tolerance);
  if (!is_rotated)
    return SAME_PLACE;
  if (p->identity == KM_BODY_POINT)
    return SAME_POINT;
  bool is_line_equal = p->identity == KM_BODY_LINE &&
                       are_vectors_equal(km_rotate(&a->R, p->direction), km_rotate(&b->R, p->direction), tolerance);
  return is_line_equal ? SAME_LINE : DIFFERS;
}

/* Compares all bodies of two configurations. */
bool km_is_same_mode(const km_mechanism *m, const km_body_placement *placements, const km_pose *a, const km_pose *b,
                     double size, double tolerance) {
  const km_model *model = m->model;
  for (int i = 1; i < model->body_count; ++i)
    if (compare(&placements[i], &a[i], &b[i], size, tolerance) == DIFFERS)
      return false;
  /* A crosspiece may rotate between fixed bodies. If two connected bodies keep only their point (the links of a
   * spherical linkage), the configurations are different modes. */
  for (int j = 0; j < model->joint_count; ++j) {
    int first_body = km_joint_body(model, j, 0), second_body = km_joint_body(model, j, 1);
    if (compare(&placements[first_body], &a[first_body], &b[first_body], size, tolerance) == SAME_POINT &&
        compare(&placements[second_body], &a[second_body], &b[second_body], size, tolerance) == SAME_POINT)
      return false;
  }
  return true;
}
