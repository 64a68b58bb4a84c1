/* Random functions of the bodies' poses (complex_closure.h): fingerprints of solutions, and the trace's functional.
 *
 *   y = Σ_slots w · pose + Σ_ends w · position
 *
 * w = 0 for parts that aren't functions of the bodies' places (docs/theory.md 4.13). */
#include "space/complex/complex_closure.h"

#include "kinematics/modes/mode_identity.h"
#include "model/joint_type.h"
#include "space/complex/complex_loops.h"

#include <string.h>

/* Steps of all programs. */
static int count_steps(const km_complex_closure *c) {
  int steps = 0;
  for (int i = 0; i < c->sub->program_count; ++i)
    steps += c->m->programs[c->sub->program_start + i].step_count;
  return steps;
}

/* A step of a program, as the functionals need it. */
typedef struct slot_place {
  int joint, body, body_before, from, to;
  bool is_inner; /* the next step belongs to the same joint, or the joint closes a loop */
} slot_place;

static slot_place place_of_step(const km_mechanism *m, const km_program *program, int i) {
  int coordinate, from, to;
  double sign;
  if (program->planar) {
    const km_planar_step *step = &m->planar_steps[program->step_start + i];
    coordinate = step->coordinate, from = step->from, to = step->to, sign = step->sign;
  } else {
    const km_step *step = &m->steps[program->step_start + i];
    coordinate = step->coordinate, from = step->from, to = step->to, sign = step->sign;
  }
  int joint = m->model->coordinates[coordinate].joint;
  const km_model_joint *j = &m->model->joints[joint];
  bool is_chord = false;
  for (int l = 0; l < m->topology.loop_count; ++l)
    is_chord = is_chord || m->topology.chord[l] == joint;
  return (slot_place){
      joint,   m->model->frames[j->frame[sign > 0.0]].body, m->model->frames[j->frame[sign <= 0.0]].body, from, to,
      is_chord};
}

static bool has_slide(const km_model_joint *joint) {
  const km_joint_kind *kind = km_joint_kind_of(joint->type);
  bool found = false;
  for (int i = 0; i < kind->motion_count; ++i)
    found = found || kind->motions[i].primitive == KM_PRISMATIC;
  return found;
}

/* Part of a slot's pose that is a function of the bodies' places: of a half of a strut none, but the place of a joint
 * without a slide is one of the other body too. */
static km_body_identity identity_of_slot(const km_mechanism *m, const km_body_placement *placement,
                                         const slot_place *here) {
  if (here->is_inner)
    return KM_BODY_PASSIVE;
  km_body_identity own = placement[here->body].identity;
  bool is_shared = !has_slide(&m->model->joints[here->joint]) &&
                   (here->body_before == 0 || placement[here->body_before].identity != KM_BODY_PASSIVE);
  return own == KM_BODY_PASSIVE && is_shared ? KM_BODY_POINT : own;
}

/* Draws random coefficients of the parts of a slot's pose that count. */
static void random_weight(const km_program *program, km_body_identity identity, uint64_t *random, km_slot_weight *out) {
  *out = (km_slot_weight){0};
  if (identity == KM_BODY_PASSIVE)
    return;
  if (program->planar) {
    out->p[0] = identity == KM_BODY_POINT ? 0.0 : km_complex_random(random);
    out->p[1] = km_complex_random(random);
    out->p[2] = km_complex_random(random);
    return;
  }
  for (int k = 0; k < 3; ++k) {
    out->p[k] = km_complex_random(random);
    for (int j = 0; j < 3; ++j)
      out->R[k][j] = identity == KM_BODY_POSE ? km_complex_random(random) : 0.0;
  }
}

/* Two connected bodies whose joints lie at one point differ in their orientation (mode_identity.h). */
static void orient_connected_points(const km_mechanism *m, km_body_placement *placement, km_arena *arena) {
  bool *is_oriented = KM_ARENA_NEW(arena, bool, (size_t)m->model->body_count);
  if (!is_oriented)
    return;
  for (int j = 0; j < m->model->joint_count; ++j) {
    const int *frame = m->model->joints[j].frame;
    int a = m->model->frames[frame[0]].body, b = m->model->frames[frame[1]].body;
    if (placement[a].identity == KM_BODY_POINT && placement[b].identity == KM_BODY_POINT)
      is_oriented[a] = is_oriented[b] = true;
  }
  for (int b = 0; b < m->model->body_count; ++b)
    if (is_oriented[b])
      placement[b].identity = KM_BODY_POSE;
}

/* True if the position of a loop's chord is a function of the bodies' places: one of its bodies is no half of a strut,
 * and no slide lies between. */
static bool end_counts(const km_mechanism *m, const km_body_placement *placement, int loop) {
  const km_model_joint *chord = &m->model->joints[m->topology.chord[loop]];
  return placement[m->model->frames[chord->frame[1]].body].identity != KM_BODY_PASSIVE ||
         (!has_slide(chord) && placement[m->model->frames[chord->frame[0]].body].identity != KM_BODY_PASSIVE);
}

/* Draws the coefficients of all functionals. */
void km_complex_draw_weights(km_complex_closure *c, uint64_t *random, km_arena *arena) {
  const km_mechanism *m = c->m;
  c->end_start = count_steps(c);
  size_t steps = (size_t)(c->end_start + 2 * c->sub->loop_count);
  km_body_placement *placement = KM_ARENA_NEW(arena, km_body_placement, (size_t)m->model->body_count);
  for (int k = 0; k < KM_FUNCTIONALS; ++k)
    c->weight[k] = KM_ARENA_NEW(arena, km_slot_weight, steps);
  if (arena->failed || !km_body_placements(m, placement)) {
    arena->failed = true;
    return;
  }
  orient_connected_points(m, placement, arena);
  for (int i = 0, first = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->step_count; ++j) {
      slot_place here = place_of_step(m, program, j);
      for (int n = 0; n < program->step_count; ++n) {
        slot_place next = place_of_step(m, program, n);
        here.is_inner = here.is_inner || (next.from == here.to && next.joint == here.joint);
      }
      for (int k = 0; k < KM_FINGERPRINT; ++k)
        random_weight(program, identity_of_slot(m, placement, &here), random, &c->weight[k][first + j]);
    }
    first += program->step_count;
  }
  for (int l = 0; l < c->sub->loop_count; ++l)
    for (int i = 0; i < 2 * KM_FINGERPRINT; ++i)
      if (end_counts(m, placement, m->loop_order[c->sub->loop_start + l]))
        for (int k = 0; k < 3; ++k)
          c->weight[i / 2][c->end_start + 2 * l + i % 2].p[k] = km_complex_random(random);
}

/* Difference of the trace's functional at two configurations, relative to 1 + |y|, above which they are separate. */
static const double separate = 1e-6;
enum { LEAST_SEPARATED = 8 }; /* Fewer configurations don't show that a slot's pose separates all. */

/* True if the trace's functional differs at all configurations. */
static bool is_separating(const km_complex_closure *c, const km_wide *points, int count) {
  for (int i = 0; i < count; ++i) {
    km_complex y = km_complex_trace(c, points + (size_t)i * (size_t)c->length);
    for (int j = 0; j < i; ++j)
      if (!(cabs(y - km_complex_trace(c, points + (size_t)j * (size_t)c->length)) > separate * (1.0 + cabs(y))))
        return false;
  }
  return true;
}

/* Draws random coefficients where those of another functional aren't 0: of positions, and of rotations. */
static void draw_like(const km_slot_weight *other, bool has_rotation, uint64_t *random, km_slot_weight *out) {
  for (int k = 0; k < 3; ++k) {
    out->p[k] = other->p[k] == 0.0 ? 0.0 : km_complex_random(random);
    for (int j = 0; j < 3; ++j)
      out->R[k][j] = other->R[k][j] == 0.0 || !has_rotation ? 0.0 : km_complex_random(random);
  }
}

void km_complex_redraw_trace(km_complex_closure *c, uint64_t *random) {
  for (int i = 0; i < c->end_start + 2 * c->sub->loop_count; ++i)
    draw_like(&c->weight[0][i], true, random, &c->weight[KM_TRACE][i]);
}

void km_complex_choose_trace(km_complex_closure *c, const km_wide *points, int count, uint64_t *random) {
  int steps = c->end_start + 2 * c->sub->loop_count;
  km_slot_weight *trace = c->weight[KM_TRACE];
  for (int i = 0; i < 2 * steps && count >= LEAST_SEPARATED; ++i) {
    memset(trace, 0, (size_t)steps * sizeof *trace);
    draw_like(&c->weight[0][i % steps], i >= steps, random, &trace[i % steps]);
    if (is_separating(c, points, count))
      return;
  }
  km_complex_redraw_trace(c, random);
}
