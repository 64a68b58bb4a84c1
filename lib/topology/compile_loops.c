/* Compiles loops into programs of steps (docs/theory.md 2.1-2.4).
 *
 *   side: constant displacement, motion, constant displacement, motion, …, closing frame       two sides per loop
 *   free motions become steps; held ones become part of the constant displacements
 *
 * Sides of loops with one base body share the steps of their common paths. */
#include "base/extrema.h"
#include "topology/compile.h"
#include "topology/motion_space.h"

#include <string.h>

/* Bounds of steps and entries: members of all loops times the most motions of a joint. */
void km_compile_bounds(const km_mechanism *m, size_t *steps, size_t *entries) {
  const km_topology *t = &m->topology;
  *entries = 0;
  for (int l = 0; l < t->loop_count; ++l)
    for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i)
      *entries += KM_MAX_MOTIONS;
  *steps = *entries;
}

bool km_compile_workspace_create(const km_mechanism *m, size_t steps, km_arena *arena, km_compile_workspace *w) {
  size_t bodies = (size_t)m->model->body_count;
  *w = (km_compile_workspace){.stamp = KM_ARENA_NEW(arena, int, bodies),
                              .entry_joint = KM_ARENA_NEW(arena, int, bodies),
                              .first_step = KM_ARENA_NEW(arena, int, bodies),
                              .step_count = KM_ARENA_NEW(arena, int, bodies),
                              .body_frame = KM_ARENA_NEW(arena, km_chain_frame, bodies),
                              .reference_pose = KM_ARENA_NEW(arena, km_pose, steps + 1),
                              .twist = KM_ARENA_NEW(arena, km_twist, 3 * steps),
                              .next_column = KM_ARENA_NEW(arena, int, (size_t)m->topology.substructure_count),
                              .parent = KM_ARENA_NEW(arena, int, bodies)};
  return !arena->failed;
}

/* True if R differs from the identity by more than rounding. The diagonal is insufficient: it is 1 up to angles of
 * 1e-8. */
static bool has_rotation_part(const km_rotation *R) {
  const km_vec3 *a = R->axis;
  double across = fmax(fmax(fabs(a[0].y), fabs(a[0].z)), fmax(fabs(a[1].z), fmax(fabs(a[1].x), fabs(a[2].x))));
  return a[0].x != 1.0 || a[1].y != 1.0 || a[2].z != 1.0 || fmax(across, fabs(a[2].y)) > 1e-15;
}

/* Moves the end of the chain to another frame of its body. The origin on the base body moves along: positions are
 * counted from the point where a branch leaves the base, so that a distant branch keeps its digits. */
static void advance_to_frame(const km_mechanism *m, int base_frame, int frame, double size, km_chain_frame *at) {
  const km_model_frame *frames = m->model->frames;
  km_pose link = km_frame_to_frame(m->model, at->frame, frame, size);
  if (frames[at->frame].body == frames[base_frame].body) {
    link.p = (km_vec3){0, 0, 0};
    at->origin = frames[frame].pose.p;
  }
  at->displacement = km_pose_product(&at->displacement, &link);
  at->frame = frame;
}

/* Appends a joint: free motions become steps, held ones constant displacements. */
static void append_joint(km_mechanism *m, km_program *program, int joint, bool is_reversed, double size,
                         km_chain_frame *at) {
  km_joint_traversal p;
  km_joint_traverse(m->model, joint, is_reversed, &p);
  double pitch = km_pitch_per_radian(m->model, joint, size);
  advance_to_frame(m, program->base_frame, p.entry, size, at);
  at->frame = p.exit;
  for (int i = 0; i < p.count; ++i) {
    int c = p.coordinate[i];
    if (m->held[c]) {
      double value[3];
      for (int k = 0; k < km_primitive_freedom(p.motion[i].primitive); ++k)
        value[k] = m->start[c + k] / m->unit[c + k];
      km_pose fixed = km_motion_traversed(p.motion[i], pitch, value, p.sign);
      at->displacement = km_pose_product(&at->displacement, &fixed);
      continue;
    }
    m->steps[program->step_start + program->step_count++] =
        (km_step){.primitive = p.motion[i].primitive,
                  .axis = p.motion[i].axis,
                  .coordinate = c,
                  .ball = m->ball_of[c],
                  .sign = p.sign,
                  .pitch = pitch,
                  .from = at->slot,
                  .to = program->slot_count,
                  .has_rotation = has_rotation_part(&at->displacement.R),
                  .before = at->displacement};
    at->slot = program->slot_count++;
    at->displacement = km_pose_identity();
  }
}

/* Adds the steps `first` … first + count − 1 to the loop's entries. */
static void add_entries(km_mechanism *m, km_program *program, km_loop *loop, int first, int count, int side) {
  for (int i = first; i < first + count; ++i) {
    const km_step *step = &m->steps[program->step_start + i];
    m->entries[loop->entry_start + loop->entry_count++] =
        (km_entry){.step = i, .column = m->column_of[step->coordinate], .side = side};
  }
}

/* Records that a body was reached in the present program by a joint with `count` steps. */
static void record_body(km_compile_workspace *w, int body, int joint, const km_chain_frame *at, int first, int count) {
  w->stamp[body] = w->current_stamp;
  w->entry_joint[body] = joint;
  w->body_frame[body] = *at;
  w->first_step[body] = first;
  w->step_count[body] = count;
}

/* Compiles one side of the loop from the base outwards. Bodies that another loop of the program has reached by the same
 * joints share its steps. */
static km_chain_frame compile_side(km_mechanism *m, km_program *program, km_loop *loop, int l, int side,
                                   km_chain_frame from, km_compile_workspace *w) {
  const km_topology *t = &m->topology;
  double size = m->substructures[t->substructure_of_loop[l]].size;
  km_chain_frame at = from;
  bool is_common = true; /* every body so far was reached by the joint by which other loops of the program reach it */
  for (int i = t->member_start[l]; i < t->member_start[l + 1]; ++i) {
    const km_member *member = &t->member[i];
    if (member->side != side)
      continue;
    int first = program->step_count, body = km_joint_body(m->model, member->joint, !member->is_reversed);
    bool is_shared_path = is_common && w->stamp[body] == w->current_stamp && w->entry_joint[body] == member->joint;
    is_common = is_shared_path || (is_common && member->joint != t->chord[l] && w->stamp[body] != w->current_stamp);
    if (is_shared_path) {
      at = w->body_frame[body];
      add_entries(m, program, loop, w->first_step[body], w->step_count[body], side);
      continue;
    }
    append_joint(m, program, member->joint, member->is_reversed, size, &at);
    add_entries(m, program, loop, first, program->step_count - first, side);
    if (is_common)
      record_body(w, body, member->joint, &at, first, program->step_count - first);
  }
  return at;
}

/* Poses of the program's slots with every free coordinate 0, each about the origin of its branch. */
static void compute_reference_poses(const km_mechanism *m, const km_program *program, km_compile_workspace *w) {
  w->reference_pose[0] = km_pose_identity();
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *step = &m->steps[program->step_start + i];
    w->reference_pose[step->to] = km_pose_product(&w->reference_pose[step->from], &step->before);
  }
}

/* Unit twists of a loop's steps about its point with all coordinates 0, lengths over the loop's own radius: the motion
 * space depends neither on the position of the loop nor on the length of its chain. Returns their number. */
static int compute_loop_twists(const km_mechanism *m, const km_program *program, const km_loop *loop,
                               km_compile_workspace *w, const km_rotation *plane) {
  double square = 1.0;
  int count = 0;
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    const km_step *step = &m->steps[program->step_start + entry->step];
    const km_pose *frame = &w->reference_pose[step->to];
    const km_vec3 at = km_vec3_sub(frame->p, loop->point[entry->side < 0.0]);
    square = km_larger(km_vec3_dot(at, at), square);
    for (int k = 0; k < km_primitive_freedom(step->primitive); ++k) {
      const km_vec3 axis = frame->R.axis[step->primitive == KM_BALL ? k : step->axis];
      km_twist twist = km_axis_twist(step->primitive, step->pitch, axis, at);
      km_vec3 v = km_rotate_back(plane, twist.v), turn = km_rotate_back(plane, twist.w);
      /* Nearly parallel axes count as parallel, as in the planar steps: relative to a short link their rounding would
       * be a motion out of the plane. */
      w->twist[count++] = program->planar ? (km_twist){{v.x, v.y, 0.0}, {0.0, 0.0, turn.z}} : (km_twist){v, turn};
    }
  }
  const double scale = 1.0 / sqrt(square);
  for (int i = 0; i < count; ++i)
    w->twist[i].v = km_vec3_scale(scale, w->twist[i].v);
  return count;
}

/* Dimension λ and independent rows of the loop's motion space. */
static void find_motion_space(km_mechanism *m, const km_program *program, km_loop *loop, km_compile_workspace *w,
                              const km_rotation *plane) {
  int count = compute_loop_twists(m, program, loop, w, plane);
  /* Directions must differ by more than the rounding of brackets, or than 30 times the stated closure tolerance. */
  double tolerance = m->closure_tolerance_given ? fmax(3e-8, 30.0 * m->closure_tolerance) : 3e-8;
  const int max_dimension = program->planar ? 3 : 6;
  km_motion_space space;
  km_motion_space_close(w->twist, count, max_dimension, tolerance, &space);
  loop->lambda = space.dimension;
  loop->has_moving_point = loop->lambda == max_dimension;
  enum { TURN_IN_SPACE = 5, TURN_IN_PLANE = 2 };
  for (int i = 0; i < space.dimension; ++i)
    loop->rows[i] = program->planar && space.rows[i] == TURN_IN_SPACE ? TURN_IN_PLANE : space.rows[i];
}

/* Compiles both sides of a loop and its closing frames. */
static void compile_loop(km_mechanism *m, km_program *program, int l, km_chain_frame base, km_compile_workspace *w,
                         int *entries) {
  km_loop *loop = &m->loops[l];
  const km_edge ends = {m->model->joints[m->topology.chord[l]].frame[0],
                        m->model->joints[m->topology.chord[l]].frame[1]};
  double size = m->substructures[m->topology.substructure_of_loop[l]].size;
  loop->entry_start = *entries;
  km_chain_frame outward = compile_side(m, program, loop, l, +1, base, w);
  km_chain_frame inward = compile_side(m, program, loop, l, -1, base, w);
  advance_to_frame(m, program->base_frame, ends.head, size, &inward);
  loop->slot[0] = outward.slot;
  loop->closing_frame[0] = outward.displacement;
  loop->slot[1] = inward.slot;
  loop->closing_frame[1] = inward.displacement;
  loop->origin_offset = km_vec3_scale(1.0 / size, km_rotate_back(&m->model->frames[program->base_frame].pose.R,
                                                                 km_vec3_sub(inward.origin, outward.origin)));
  *entries += loop->entry_count;
}

/* Sets the point of the loop's rows: where its frames meet with every coordinate 0. */
static void set_point(const km_compile_workspace *w, km_loop *loop) {
  loop->point[0] = km_pose_point(&w->reference_pose[loop->slot[0]], loop->closing_frame[0].p);
  loop->point[1] = km_vec3_sub(loop->point[0], loop->origin_offset);
}

/* The only ball joint of the loop, on side *side; NULL if there is none or several. */
static km_step *find_only_ball(km_mechanism *m, const km_program *program, const km_loop *loop, int *side) {
  km_step *ball = NULL;
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_entry *entry = &m->entries[loop->entry_start + i];
    km_step *step = &m->steps[program->step_start + entry->step];
    if (step->primitive != KM_BALL)
      continue;
    if (ball)
      return NULL;
    ball = step;
    *side = entry->side < 0.0;
  }
  return ball;
}

/* True if another loop of the program contains the step. */
static bool is_shared(const km_mechanism *m, const km_program *program, const km_loop *loop, const km_step *step) {
  for (int i = 0; i < program->loop_count; ++i) {
    const km_loop *other = &m->loops[m->loop_order[program->loop_start + i]];
    for (int e = 0; e < other->entry_count && other != loop; ++e)
      if (&m->steps[program->step_start + m->entries[other->entry_start + e].step] == step)
        return true;
  }
  return false;
}

/* A loop with one ball joint that is cut there: frames of all other joints with all coordinates 0, in the base frame.
 * The part beyond the ball joint then belongs to the other side. */
typedef struct cut_loop {
  const km_step *ball;
  int side; /* side of the ball joint */
  km_pose
      beyond_ball; /* frame beyond the ball joint, about the origin of the other side's branch, with its origin at the
               * joint's centre */
} cut_loop;

/* Frame beyond the ball joint, seen from the other side of the loop. */
static cut_loop cut_loop_at_ball(const km_loop *loop, const km_step *ball, int side, const km_compile_workspace *w) {
  km_pose at_ball = km_pose_inverse(&w->reference_pose[ball->to]);
  at_ball = km_pose_product(&at_ball, &w->reference_pose[loop->slot[side]]);
  at_ball = km_pose_product(&at_ball, &loop->closing_frame[side]);
  km_pose end = km_pose_product(&w->reference_pose[loop->slot[!side]], &loop->closing_frame[!side]),
          inward = km_pose_inverse(&at_ball);
  return (cut_loop){ball, side, km_pose_product(&end, &inward)};
}

/* Axis of a step of the cut loop, in the base frame. Slots are numbered along the branches. */
static km_vec3 axis_of_cut_loop(const cut_loop *cut, const km_step *step, const km_entry *entry,
                                const km_compile_workspace *w) {
  km_vec3 axis = w->reference_pose[step->to].R.axis[step->axis];
  if ((entry->side < 0.0) != cut->side || step->to < cut->ball->to)
    return axis;
  return km_rotate(&cut->beyond_ball.R, km_rotate_back(&w->reference_pose[cut->ball->to].R, axis));
}

/* True if all joints of the loop except the ball joint move in planes normal to `normal`, and one of them is a
 * hinge. */
static bool is_cut_loop_planar(const km_mechanism *m, const km_program *program, const km_loop *loop,
                               const cut_loop *cut, const km_compile_workspace *w, km_vec3 *normal) {
  bool has_normal = false;
  for (int append_joint = 0; append_joint < 2; ++append_joint)
    for (int i = 0; i < loop->entry_count; ++i) {
      const km_entry *entry = &m->entries[loop->entry_start + i];
      const km_step *step = &m->steps[program->step_start + entry->step];
      if (step == cut->ball)
        continue;
      km_vec3 axis = axis_of_cut_loop(cut, step, entry, w);
      if (append_joint == 0 && !has_normal && step->primitive == KM_REVOLUTE) {
        *normal = axis;
        has_normal = true;
      }
      if (append_joint == 1 && !km_moves_in_plane(step->primitive, axis, *normal))
        return false;
    }
  return has_normal;
}

/* In a loop of parallel hinges with one ball joint, the offset along the axes at which the sides of the ball joint meet
 * is constant. Hinge frames may lie anywhere along their axes, so the ball joint is moved along them by this offset. */
static void absorb_pin_offset(km_mechanism *m, km_program *program, km_loop *loop, km_compile_workspace *w) {
  int side = 0;
  km_step *ball = find_only_ball(m, program, loop, &side);
  if (!ball || is_shared(m, program, loop, ball))
    return;
  cut_loop cut = cut_loop_at_ball(loop, ball, side, w);
  km_vec3 normal;
  if (!is_cut_loop_planar(m, program, loop, &cut, w, &normal))
    return;
  km_vec3 offset = km_vec3_scale(side ? -1.0 : 1.0, loop->origin_offset);
  km_vec3 gap = km_vec3_sub(w->reference_pose[ball->to].p, km_vec3_add(cut.beyond_ball.p, offset));
  double height = km_vec3_dot(normal, gap);
  loop->pin_offset = side ? -height : height;
  loop->plane_normal = km_rotate(&m->model->frames[program->base_frame].pose.R, normal);
  km_vec3 correction = km_rotate_back(&w->reference_pose[ball->from].R, km_vec3_scale(-height, normal));
  ball->before.p = km_vec3_add(ball->before.p, correction);
  compute_reference_poses(m, program, w);
}

/* Compiles all loops with one base body, planar if they move in one plane. */
static void compile_program(km_mechanism *m, km_program *program, km_compile_workspace *w) {
  const km_topology *t = &m->topology;
  int first = m->loop_order[program->loop_start];
  const km_member *member = &t->member[t->member_start[first]];
  int base_frame = m->model->joints[member->joint].frame[member->is_reversed];
  km_chain_frame base = {0, km_pose_identity(), base_frame, m->model->frames[base_frame].pose.p};
  program->base_frame = base_frame;
  program->step_start = m->step_count;
  program->slot_count = 1;
  w->current_stamp++;
  for (int i = 0; i < program->loop_count; ++i)
    compile_loop(m, program, m->loop_order[program->loop_start + i], base, w, &m->entry_count);
  compute_reference_poses(m, program, w);
  km_rotation plane;
  program->planar = km_find_plane(m, program, w, &plane);
  for (int i = 0; i < program->loop_count; ++i) {
    km_loop *loop = &m->loops[m->loop_order[program->loop_start + i]];
    if (!program->planar)
      absorb_pin_offset(m, program, loop, w);
    set_point(w, loop);
    find_motion_space(m, program, loop, w, &plane);
  }
  program->twist_start = m->twist_count;
  m->twist_count += (program->planar ? 1 : 3) * program->step_count;
  if (program->planar)
    km_compile_planar(m, program, w, &plane);
  else
    m->step_count += program->step_count;
  if (program->slot_count > m->largest_slots)
    m->largest_slots = program->slot_count;
}

/* Groups the substructure's loops by base body, one program each. */
static void group_by_base(km_mechanism *m, km_substructure *sub) {
  int *order = m->loop_order + sub->loop_start;
  sub->program_start = m->program_count;
  for (int i = 0; i < sub->loop_count;) {
    km_program *program = &m->programs[m->program_count++];
    int base = m->topology.base[order[i]], end = i;
    for (int k = i; k < sub->loop_count; ++k) {
      if (m->topology.base[order[k]] != base)
        continue;
      int loop = order[k];
      memmove(order + end + 1, order + end, (size_t)(k - end) * sizeof *order);
      order[end++] = loop;
    }
    *program = (km_program){.loop_start = sub->loop_start + i, .loop_count = end - i};
    i = end;
  }
  sub->program_count = m->program_count - sub->program_start;
}

/* Compiles the programs of a substructure and numbers the rows of its loops. */
void km_compile_loops(km_mechanism *m, int s, km_compile_workspace *workspace) {
  km_substructure *sub = &m->substructures[s];
  group_by_base(m, sub);
  for (int i = 0; i < sub->program_count; ++i)
    compile_program(m, &m->programs[sub->program_start + i], workspace);
  for (int i = 0; i < sub->loop_count; ++i) {
    km_loop *loop = &m->loops[m->loop_order[sub->loop_start + i]];
    loop->row_start = sub->rows;
    sub->rows += loop->lambda;
  }
}
