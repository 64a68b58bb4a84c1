/* Polygon inequality of a loop whose joints only turn.
 *
 *   sum_i R_i v_i = 0,  |v_i| = l_i constant   =>   max l_i <= sum of the other l_j
 *
 * v_i leads from one joint of the loop to the next, in the axes of the link between them; in a plane, its part in the
 * plane. */
#include "kinematics/polygon_inequality.h"

/* The links of a loop, while they are listed. */
typedef struct polygon {
  double sum;     /* of all lengths */
  double longest; /* of one link */
  int ends[2];    /* coordinates at its ends */
} polygon;

static void add_link(polygon *p, double length, int from, int to) {
  p->sum += length;
  if (length > p->longest) {
    p->longest = length;
    p->ends[0] = from;
    p->ends[1] = to;
  }
}

static const km_program *program_of(const km_mechanism *m, int loop) {
  const km_substructure *sub = &m->substructures[m->topology.substructure_of_loop[loop]];
  for (int i = 0; i < sub->program_count; ++i) {
    const km_program *p = &m->programs[sub->program_start + i];
    for (int k = 0; k < p->loop_count; ++k)
      if (m->loop_order[p->loop_start + k] == loop)
        return p;
  }
  return NULL;
}

/* One step of a program: the slot it starts from, its coordinate, and the distance to it from that slot's joint. */
typedef struct step_length {
  int from, coordinate;
  bool turns_only;
  double length;
} step_length;

static step_length length_of(const km_mechanism *m, const km_program *program, int step) {
  if (program->planar) {
    const km_planar_step *s = &m->planar_steps[program->step_start + step];
    return (step_length){s->from, s->coordinate, !s->is_slide, hypot(s->x, s->y)};
  }
  const km_step *s = &m->steps[program->step_start + step];
  return (step_length){s->from, s->coordinate, s->primitive == KM_REVOLUTE || s->primitive == KM_BALL,
                       km_vec3_norm(s->before.p)};
}

/* The step that leads to a slot; -1: the base. */
static int step_to(const km_mechanism *m, const km_program *program, int slot) {
  for (int i = 0; i < program->step_count; ++i) {
    int index = program->step_start + i;
    if ((program->planar ? m->planar_steps[index].to : m->steps[index].to) == slot)
      return i;
  }
  return -1;
}

/* Lists the links from a branch's end to the base; the first joint's coordinate into *first, the last one's into
 * *last. False if a joint slides. */
static bool add_branch(const km_mechanism *m, const km_program *program, int slot, polygon *p, int *first, int *last) {
  for (int step = step_to(m, program, slot); step >= 0;) {
    step_length link = length_of(m, program, step);
    if (!link.turns_only)
      return false;
    if (*last < 0)
      *last = link.coordinate;
    int inner = step_to(m, program, link.from);
    *first = link.coordinate;
    if (inner >= 0)
      add_link(p, link.length, length_of(m, program, inner).coordinate, link.coordinate);
    step = inner;
  }
  return true;
}

/* Vector from the last joint of branch `side` to that of the other one, fixed in the body that closes the loop. */
static km_vec3 closing_link(const km_program *program, const km_loop *loop, int side) {
  if (!program->planar) {
    km_pose back = km_pose_inverse(&loop->closing_frame[!side]);
    return km_pose_product(&loop->closing_frame[side], &back).p;
  }
  /* The closed loop has angle_0 - angle_1 = -planar_turn: seen from the one end, the other end's shift is turned by
   * that. */
  const double *own = loop->planar_closing_point[side], *other = loop->planar_closing_point[!side];
  double c = cos(loop->planar_closing_angle),
         s = side ? -sin(loop->planar_closing_angle) : sin(loop->planar_closing_angle);
  return (km_vec3){own[0] - (c * other[0] - s * other[1]), own[1] - (s * other[0] + c * other[1]), 0.0};
}

/* Place of a branch's first joint on the base body, from the branch's origin; that origin if it has no joint. */
static km_vec3 first_place(const km_mechanism *m, const km_program *program, int slot) {
  int step = step_to(m, program, slot), first = -1;
  for (; step >= 0; step = step_to(m, program, length_of(m, program, step).from))
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
  km_vec3 apart = program->planar ? (km_vec3){loop->planar_origin_offset[0], loop->planar_origin_offset[1], 0.0}
                                  : loop->origin_offset;
  km_vec3 from = first_place(m, program, loop->slot[0]), to = first_place(m, program, loop->slot[1]);
  return km_vec3_add(apart, km_vec3_sub(to, from));
}

/* The links along the base body and along the body that closes the loop; one link where a branch has no joint. */
static void add_ends(const km_mechanism *m, const km_program *program, const km_loop *loop, const int *first,
                     const int *last, polygon *p) {
  km_vec3 apart = base_link(m, program, loop);
  if (first[0] >= 0 && first[1] >= 0) {
    add_link(p, km_vec3_norm(apart), first[0], first[1]);
    add_link(p, km_vec3_norm(closing_link(program, loop, 0)), last[0], last[1]);
    return;
  }
  int empty = first[0] < 0 ? 0 : 1;
  km_vec3 link = km_vec3_axpy(empty ? 1.0 : -1.0, apart, closing_link(program, loop, empty));
  add_link(p, km_vec3_norm(link), first[!empty], last[!empty]);
}

bool km_loop_violates_polygon(const km_mechanism *m, int index, km_long_link *out) {
  const double rounding = fmax(1e-9, m->closure_tolerance); /* of the longest link: what the loop may be left open by */
  const km_loop *loop = &m->loops[index];
  const km_program *program = program_of(m, index);
  polygon p = {.longest = -1.0};
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
