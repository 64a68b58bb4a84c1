/* Polygon inequality of a loop whose joints only turn.
 *
 *   sum_i R_i v_i = 0,  |v_i| = l_i constant   =>   max l_i <= sum of the other l_j
 *
 * v_i leads from one joint of the loop to the next, in the axes of the link between them; in a plane, its part in the
 * plane. */
#include "kinematics/polygon_inequality.h"

/* Sum and maximum of the link lengths of a loop. */
typedef struct link_lengths {
  double sum;     /* sum of all lengths */
  double longest; /* greatest length */
  int ends[2];    /* coordinates at the ends of the longest link */
} link_lengths;

/* Adds a link between two joints. */
static void add_link(link_lengths *p, double length, int from, int to) {
  p->sum += length;
  if (length > p->longest) {
    p->longest = length;
    p->ends[0] = from;
    p->ends[1] = to;
  }
}

/* Program that contains a loop. */
static const km_program *find_program(const km_mechanism *m, int loop) {
  const km_substructure *sub = &m->substructures[m->topology.substructure_of_loop[loop]];
  for (int i = 0; i < sub->program_count; ++i) {
    const km_program *p = &m->programs[sub->program_start + i];
    for (int k = 0; k < p->loop_count; ++k)
      if (m->loop_order[p->loop_start + k] == loop)
        return p;
  }
  return NULL;
}

/* One step of a program: its start slot, its coordinate, and the distance from the previous joint. */
typedef struct step_length {
  int from, coordinate;
  bool is_rotation;
  double length;
} step_length;

static step_length read_step(const km_mechanism *m, const km_program *program, int step) {
  if (program->planar) {
    const km_planar_step *s = &m->planar_steps[program->step_start + step];
    return (step_length){s->from, s->coordinate, !s->is_slide, hypot(s->x, s->y)};
  }
  const km_step *s = &m->steps[program->step_start + step];
  return (step_length){s->from, s->coordinate, s->primitive == KM_REVOLUTE || s->primitive == KM_BALL,
                       km_vec3_norm(s->before.p)};
}

/* Step that ends in a slot; -1: the slot is the base. */
static int find_step_to(const km_mechanism *m, const km_program *program, int slot) {
  for (int i = 0; i < program->step_count; ++i) {
    int index = program->step_start + i;
    if ((program->planar ? m->planar_steps[index].to : m->steps[index].to) == slot)
      return i;
  }
  return -1;
}

/* Adds the links of a branch from its end to the base; *first and *last become the coordinates of its first and last
 * joint. False if a joint slides. */
static bool add_branch(const km_mechanism *m, const km_program *program, int slot, link_lengths *p, int *first,
                       int *last) {
  for (int step = find_step_to(m, program, slot); step >= 0;) {
    step_length link = read_step(m, program, step);
    if (!link.is_rotation)
      return false;
    if (*last < 0)
      *last = link.coordinate;
    int inner = find_step_to(m, program, link.from);
    *first = link.coordinate;
    if (inner >= 0)
      add_link(p, link.length, read_step(m, program, inner).coordinate, link.coordinate);
    step = inner;
  }
  return true;
}

/* Vector from the last joint of branch `side` to that of the other branch, fixed in the closing body. */
static km_vec3 closing_link(const km_program *program, const km_loop *loop, int side) {
  if (!program->planar) {
    km_pose back = km_pose_inverse(&loop->closing_frame[!side]);
    return km_pose_product(&loop->closing_frame[side], &back).p;
  }
  /* The closed loop has angle_0 − angle_1 = −planar_closing_angle: the other end's shift is rotated by it. */
  const double *this_end = loop->planar_closing_point[side], *other_end = loop->planar_closing_point[!side];
  double c = cos(loop->planar_closing_angle),
         s = side ? -sin(loop->planar_closing_angle) : sin(loop->planar_closing_angle);
  return (km_vec3){this_end[0] - (c * other_end[0] - s * other_end[1]),
                   this_end[1] - (s * other_end[0] + c * other_end[1]), 0.0};
}

/* Position of a branch's first joint on the base body, from the branch's origin; the origin if the branch has no
 * joint. */
static km_vec3 first_joint_position(const km_mechanism *m, const km_program *program, int slot) {
  int step = find_step_to(m, program, slot), first = -1;
  for (; step >= 0; step = find_step_to(m, program, read_step(m, program, step).from))
    first = step;
  if (first < 0)
    return (km_vec3){0.0, 0.0, 0.0};
  if (!program->planar)
    return m->steps[program->step_start + first].before.p;
  const km_planar_step *p = &m->planar_steps[program->step_start + first];
  return (km_vec3){p->x, p->y, 0.0};
}

/* Vector from the first joint of branch 0 to that of branch 1, fixed in the base body. */
static km_vec3 base_link(const km_mechanism *m, const km_program *program, const km_loop *loop) {
  km_vec3 offset = program->planar ? (km_vec3){loop->planar_origin_offset[0], loop->planar_origin_offset[1], 0.0}
                                   : loop->origin_offset;
  km_vec3 from = first_joint_position(m, program, loop->slot[0]), to = first_joint_position(m, program, loop->slot[1]);
  return km_vec3_add(offset, km_vec3_sub(to, from));
}

/* Adds the link on the base body and the link on the closing body; one link if a branch has no joint. */
static void add_ends(const km_mechanism *m, const km_program *program, const km_loop *loop, const int *first,
                     const int *last, link_lengths *p) {
  km_vec3 offset = base_link(m, program, loop);
  if (first[0] >= 0 && first[1] >= 0) {
    add_link(p, km_vec3_norm(offset), first[0], first[1]);
    add_link(p, km_vec3_norm(closing_link(program, loop, 0)), last[0], last[1]);
    return;
  }
  int empty = first[0] < 0 ? 0 : 1;
  km_vec3 link = km_vec3_axpy(empty ? 1.0 : -1.0, offset, closing_link(program, loop, empty));
  add_link(p, km_vec3_norm(link), first[!empty], last[!empty]);
}

/* Sums the link lengths of a loop and compares the longest with the rest. */
bool km_loop_violates_polygon(const km_mechanism *m, int index, km_long_link *out) {
  const double rounding = fmax(1e-9, m->closure_tolerance); /* relative to the longest link: gap that the closure
                                                             * tolerance allows */
  const km_loop *loop = &m->loops[index];
  const km_program *program = find_program(m, index);
  link_lengths p = {.longest = -1.0};
  int first[2] = {-1, -1}, last[2] = {-1, -1};
  for (int side = 0; side < 2; ++side)
    if (!program || !add_branch(m, program, loop->slot[side], &p, &first[side], &last[side]))
      return false;
  if (first[0] < 0 && first[1] < 0)
    return false;
  add_ends(m, program, loop, first, last, &p);
  *out = (km_long_link){2.0 * p.longest - p.sum, {p.ends[0], p.ends[1]}};
  return out->excess > rounding * p.longest;
}
