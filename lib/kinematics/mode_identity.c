/* Compares configurations as assembly modes: by the places of bodies, without passive turns. */
#include "kinematics/mode_identity.h"

static const double collinear = 1e-9; /* of the largest distance between joints */

/* Adds a joint's frame to what is known of its body's joints: the first one's origin is the point, the farthest other
 * one, or the axis of a slide, gives the direction. */
static void add_frame(km_body_placement *place, bool *is_known, double *farthest, const km_pose *frame,
                      int slide_axis) {
  if (!*is_known) {
    place->point = frame->p;
    *is_known = true;
  }
  km_vec3 way = km_vec3_sub(frame->p, place->point);
  double length = km_vec3_norm(way);
  if (length > *farthest) {
    *farthest = length;
    place->direction = km_vec3_scale(1.0 / length, way);
  } else if (slide_axis >= 0 && *farthest == 0.0) {
    place->direction = frame->R.axis[slide_axis];
  }
}

/* The axis of a joint's slide; -1: it has none; -2: several, or a screw, so that its body has no passive turn. */
static int slide_of(km_joint_type type) {
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

static bool lies_along(km_vec3 way, km_vec3 direction, double size) {
  return km_vec3_norm(km_vec3_cross(way, direction)) <= collinear * size;
}

/* One end of a joint: its body, the axis of its slide (slide_of), and its frame there. */
typedef struct joint_end {
  int body, slide;
  const km_pose *frame;
} joint_end;

static joint_end end_of(const km_mechanism *m, int joint, int end) {
  const km_model_joint *j = &m->model->joints[joint];
  const km_model_frame *frame = &m->model->frames[j->frame[end]];
  return (joint_end){frame->body, slide_of(j->type), &frame->pose};
}

static bool find_lines(const km_mechanism *m, km_body_placement *places) {
  const km_model *model = m->model;
  size_t bodies = (size_t)model->body_count;
  km_arena scratch = {0};
  bool *is_known = KM_ARENA_NEW(&scratch, bool, bodies);
  double *farthest = KM_ARENA_NEW(&scratch, double, bodies);
  bool made = !scratch.failed;
  for (int i = 0; made && i < 2 * model->joint_count; ++i) {
    joint_end e = end_of(m, i / 2, i % 2);
    add_frame(&places[e.body], &is_known[e.body], &farthest[e.body], e.frame, e.slide);
  }
  for (int b = 1; made && b < model->body_count; ++b)
    if (places[b].identity != KM_BODY_PASSIVE && is_known[b])
      places[b].identity = km_vec3_norm(places[b].direction) > 0.0 ? KM_BODY_LINE : KM_BODY_POINT;
  for (int i = 0; made && i < 2 * model->joint_count; ++i) {
    joint_end e = end_of(m, i / 2, i % 2);
    km_body_placement *place = &places[e.body];
    bool fits = e.slide != -2 && (e.slide < 0 || lies_along(e.frame->R.axis[e.slide], place->direction, 1.0)) &&
                lies_along(km_vec3_sub(e.frame->p, place->point), place->direction, fmax(farthest[e.body], 1e-300));
    if (!fits && place->identity != KM_BODY_PASSIVE)
      place->identity = KM_BODY_POSE;
  }
  km_arena_free(&scratch);
  return made;
}

bool km_body_placements(const km_mechanism *m, km_body_placement *places) {
  for (int b = 0; b < m->model->body_count; ++b)
    places[b] = (km_body_placement){.identity = m->model->bodies[b].is_strut_part ? KM_BODY_PASSIVE : KM_BODY_POSE};
  return find_lines(m, places);
}

static bool same_vectors(km_vec3 a, km_vec3 b, double tolerance) {
  return km_vec3_norm(km_vec3_sub(a, b)) <= tolerance;
}

/* How much of a body's place is the same in two configurations. */
typedef enum agreement { DIFFERS, SAME_POINT, SAME_LINE, SAME_PLACE } agreement;

static agreement compare(const km_body_placement *p, const km_pose *a, const km_pose *b, double size,
                         double tolerance) {
  bool is_turned = false;
  if (p->identity == KM_BODY_PASSIVE)
    return SAME_PLACE;
  if (!same_vectors(km_pose_point(a, p->point), km_pose_point(b, p->point), tolerance * size))
    return DIFFERS;
  for (int k = 0; k < 3; ++k)
    is_turned = is_turned || !same_vectors(a->R.axis[k], b->R.axis[k], tolerance);
  if (!is_turned)
    return SAME_PLACE;
  if (p->identity == KM_BODY_POINT)
    return SAME_POINT;
  bool on_line = p->identity == KM_BODY_LINE &&
                 same_vectors(km_rotate(&a->R, p->direction), km_rotate(&b->R, p->direction), tolerance);
  return on_line ? SAME_LINE : DIFFERS;
}

bool km_is_same_mode(const km_mechanism *m, const km_body_placement *places, const km_pose *a, const km_pose *b,
                     double size, double tolerance) {
  const km_model *model = m->model;
  for (int i = 1; i < model->body_count; ++i)
    if (compare(&places[i], &a[i], &b[i], size, tolerance) == DIFFERS)
      return false;
  /* A crosspiece may be turned between bodies that aren't. The links of a spherical linkage turn together: that is
   * another mode. */
  for (int j = 0; j < model->joint_count; ++j) {
    int one = model->frames[model->joints[j].frame[0]].body, other = model->frames[model->joints[j].frame[1]].body;
    if (compare(&places[one], &a[one], &b[one], size, tolerance) == SAME_POINT &&
        compare(&places[other], &a[other], &b[other], size, tolerance) == SAME_POINT)
      return false;
  }
  return true;
}
