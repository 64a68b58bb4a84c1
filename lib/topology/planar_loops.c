/* Recognition of planar loops, and their conversion to planar steps (docs/theory.md 2.5).
 *
 *   plane: all hinge axes parallel to the normal, all slides normal to it, to 1e-12
 *   steps are counted from the configuration with all coordinates 0, so that no constant rotation remains */
#include "base/number/tolerances.h"
#include "topology/compile.h"

/* Axis of a step in the base frame, with all coordinates 0. */
static km_vec3 step_axis(const km_step *step, const km_compile_workspace *w) {
  return w->reference_pose[step->to].R.axis[step->axis];
}

/* Finds the normal of the plane: the axis of a hinge, else the normal of two slides, else any direction normal to a
 * slide. False without steps. */
static bool find_normal(const km_mechanism *m, const km_program *program, const km_compile_workspace *w,
                        km_vec3 *normal) {
  const km_step *steps = &m->steps[program->step_start];
  for (int i = 0; i < program->step_count; ++i) {
    if (steps[i].primitive == KM_REVOLUTE) {
      *normal = step_axis(&steps[i], w);
      return true;
    }
  }
  for (int i = 0; i < program->step_count; ++i) {
    km_vec3 n = km_vec3_cross(step_axis(&steps[0], w), step_axis(&steps[i], w));
    double size = km_vec3_norm(n);
    if (size > 1e-3) {
      *normal = km_vec3_scale(1.0 / size, n);
      return true;
    }
  }
  *normal = program->step_count ? km_vec3_perpendicular(step_axis(&steps[0], w)) : (km_vec3){0, 0, 1};
  return program->step_count > 0;
}

/* Hinge axis parallel to the normal, or slide normal to it, to 1e-13. */
bool km_moves_in_plane(km_primitive primitive, km_vec3 axis, km_vec3 normal) {
  km_vec3 across = km_vec3_cross(axis, normal);
  double along = km_vec3_dot(axis, normal);
  if (primitive != KM_REVOLUTE && primitive != KM_PRISMATIC)
    return false;
  return (primitive == KM_REVOLUTE ? km_vec3_dot(across, across) : along * along) <=
         km_solved_rounding * km_solved_rounding;
}

/* True if every step of the program moves in planes normal to `normal`. */
static bool are_steps_in_plane(const km_mechanism *m, const km_program *program, const km_compile_workspace *w,
                               km_vec3 normal) {
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &m->steps[program->step_start + i];
    if (!km_moves_in_plane(step->primitive, step_axis(step, w), normal))
      return false;
  }
  return true;
}

/* Base frame rotated so that its z axis is the normal; an axis of the base frame is kept exactly. */
static km_rotation create_plane_frame(km_vec3 normal) {
  const double n[3] = {normal.x, normal.y, normal.z};
  for (int k = 0; k < 3; ++k) {
    if (fabs(fabs(n[k]) - 1.0) > km_solved_rounding)
      continue;
    km_rotation unit = km_rotation_identity();
    km_vec3 z = unit.axis[k], x = unit.axis[(k + 1) % 3];
    if (n[k] < 0.0)
      z = km_vec3_scale(-1.0, z);
    return (km_rotation){{x, km_vec3_cross(z, x), z}};
  }
  km_vec3 x = km_vec3_perpendicular(normal);
  return (km_rotation){{x, km_vec3_cross(normal, x), normal}};
}

/* Converts a spatial step to a planar one. */
static void convert_step(const km_step *step, const km_compile_workspace *w, const km_rotation *plane,
                         km_planar_step *out) {
  km_vec3 shift = km_rotate_back(plane, km_vec3_sub(w->reference_pose[step->to].p, w->reference_pose[step->from].p));
  km_vec3 axis = km_rotate_back(plane, step_axis(step, w));
  bool is_slide = step->primitive == KM_PRISMATIC;
  *out = (km_planar_step){.is_slide = is_slide,
                          .coordinate = step->coordinate,
                          .sign = is_slide || axis.z > 0.0 ? step->sign : -step->sign,
                          .from = step->from,
                          .to = step->to,
                          .x = shift.x,
                          .y = shift.y,
                          .ux = is_slide ? axis.x : 0.0,
                          .uy = is_slide ? axis.y : 0.0};
}

/* True if the loop has a hinge, whose frames may lie anywhere along its axis. */
static bool has_hinge(const km_mechanism *m, const km_program *program, const km_loop *loop) {
  for (int i = 0; i < loop->entry_count; ++i) {
    int step = m->entries[loop->entry_start + i].step;
    if (m->steps[program->step_start + step].primitive == KM_REVOLUTE)
      return true;
  }
  return false;
}

/* Closing points, closing angle and constant misfit of a planar loop. */
static void convert_loop(km_loop *loop, const km_compile_workspace *w, const km_rotation *plane,
                         const km_rotation *base, bool has_hinge) {
  km_pose end[2];
  for (int side = 0; side < 2; ++side) {
    const km_pose *slot = &w->reference_pose[loop->slot[side]];
    end[side] = km_pose_product(slot, &loop->closing_frame[side]);
    km_vec3 shift = km_rotate_back(plane, km_vec3_sub(end[side].p, slot->p));
    loop->planar_closing_point[side][0] = shift.x;
    loop->planar_closing_point[side][1] = shift.y;
  }
  km_vec3 offset = km_rotate_back(plane, loop->origin_offset), point = km_rotate_back(plane, loop->point[0]);
  loop->planar_origin_offset[0] = offset.x;
  loop->planar_origin_offset[1] = offset.y;
  loop->planar_point[0] = point.x;
  loop->planar_point[1] = point.y;
  end[1].p = km_vec3_add(end[1].p, loop->origin_offset);
  km_pose inverse = km_pose_inverse(&end[1]);
  km_rotation relative_rotation = km_rotation_product(&end[0].R, &inverse.R);
  km_vec3 x = km_rotate_back(plane, km_rotate(&relative_rotation, plane->axis[0]));
  km_vec3 z = km_rotate_back(plane, km_rotate(&relative_rotation, plane->axis[2]));
  loop->planar_closing_angle = atan2(x.y, x.x);
  /* Components out of the plane are constant: the offset between the frames along the normal, and the rotation of the
   * normals onto each other, z × z′ with the length of their angle, so that a frame upside down counts as π. The offset
   * has no effect in loops with hinges, whose frames may lie anywhere along their axes. */
  double sine = hypot(z.x, z.y), s = sine > 0.0 ? atan2(sine, z.z) / sine : 0.0;
  double height = km_vec3_dot(plane->axis[2], km_vec3_sub(end[0].p, end[1].p));
  loop->plane_normal = km_rotate(base, plane->axis[2]);
  loop->pin_offset = has_hinge ? height : 0.0;
  loop->fixed_misfit[2] = has_hinge ? 0.0 : height;
  loop->fixed_misfit[3] = z.z < 0.0 && sine == 0.0 ? M_PI : -s * z.y;
  loop->fixed_misfit[4] = s * z.x;
}

/* Finds the plane of all steps of a program. */
bool km_find_plane(const km_mechanism *m, const km_program *program, const km_compile_workspace *w,
                   km_rotation *plane) {
  km_vec3 normal;
  *plane = km_rotation_identity();
  if (!find_normal(m, program, w, &normal) || !are_steps_in_plane(m, program, w, normal))
    return false;
  *plane = create_plane_frame(normal);
  return true;
}

void km_compile_planar(km_mechanism *m, km_program *program, const km_compile_workspace *w, const km_rotation *plane) {
  int start = m->planar_step_count;
  for (int i = 0; i < program->step_count; ++i)
    convert_step(&m->steps[program->step_start + i], w, plane, &m->planar_steps[start + i]);
  for (int i = 0; i < program->loop_count; ++i) {
    km_loop *loop = &m->loops[m->loop_order[program->loop_start + i]];
    convert_loop(loop, w, plane, &m->model->frames[program->base_frame].pose.R, has_hinge(m, program, loop));
  }
  program->step_start = start;
  m->planar_step_count += program->step_count;
}
