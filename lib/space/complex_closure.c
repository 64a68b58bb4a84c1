/* Setup and configurations of the complex closure system (complex_closure.h). */
#include "space/complex_closure.h"

#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kinematics/mode_identity.h"
#include "model/joint_type.h"
#include "space/complex_loops.h"
#include "space/complex_solve.h"

#include <string.h>

/* Pivots relative to the first one that count as 0 at a generic configuration: rounding of the elimination. */
static const double generic_rank_tolerance = 1e-10;
static const double generic_distance = 0.5; /* radians, sizes: of a generic configuration from the reference */
/* Relative change of a functional along a null vector that counts as 0. */
static const double passive_tolerance = 1e-7;

static bool is_ball_column(const km_complex_closure *c, int column) {
  return c->m->ball_of[c->m->column_coordinate[c->sub->column_start + column]] >= 0;
}

/* True if `column` is the first one of a ball joint. */
static bool begins_ball(const km_complex_closure *c, int column) {
  int coordinate = c->m->column_coordinate[c->sub->column_start + column], ball = c->m->ball_of[coordinate];
  return ball >= 0 && c->m->ball_coordinate[ball] == coordinate;
}

/* ---- Configurations. */

void km_complex_from_state(const km_complex_closure *c, const km_state *s, km_complex *x) {
  for (int k = 0; k < c->sub->columns; ++k) {
    int coordinate = c->m->column_coordinate[c->sub->column_start + k];
    if (begins_ball(c, k)) {
      const km_quaternion *Q = &s->ball[c->m->ball_of[coordinate]];
      const km_complex numbers[4] = {Q->w, Q->x, Q->y, Q->z};
      memcpy(&x[c->start_of[k]], numbers, sizeof numbers);
    } else if (!is_ball_column(c, k)) {
      x[c->start_of[k]] = s->q[coordinate] / c->m->unit[coordinate];
    }
  }
}

/* Sets the joints that close loops. */
static void set_closing_joints(const km_complex_closure *c, km_complex *x) {
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      int place = program->loop_start + j, step = c->closing_step[place - c->sub->loop_start];
      const km_loop *loop = &c->m->loops[c->m->loop_order[place]];
      if (step >= 0)
        (program->planar ? km_complex_close_planar : km_complex_close_spatial)(c, program, loop, step, x);
    }
  }
}

void km_complex_to_state(const km_complex_closure *c, km_complex *x, km_state *s) {
  set_closing_joints(c, x);
  for (int k = 0; k < c->sub->columns; ++k) {
    int coordinate = c->m->column_coordinate[c->sub->column_start + k];
    const km_complex *number = &x[c->start_of[k]];
    if (s->locked[coordinate])
      continue;
    if (begins_ball(c, k))
      km_state_set_ball(c->m, s, c->m->ball_of[coordinate],
                        (km_quaternion){creal(number[0]), creal(number[1]), creal(number[2]), creal(number[3])});
    else if (!is_ball_column(c, k))
      s->q[coordinate] = c->m->unit[coordinate] * (km_coordinate_turns(c->m, coordinate)
                                                       ? remainder(creal(*number), 2.0 * M_PI)
                                                       : creal(*number));
  }
}

void km_complex_normalise(const km_complex_closure *c, km_complex *x) {
  for (int k = 0; k < c->sub->columns; ++k)
    if (begins_ball(c, k)) {
      km_complex *Q = &x[c->start_of[k]];
      km_complex share = 1.0 / csqrt(Q[0] * Q[0] + Q[1] * Q[1] + Q[2] * Q[2] + Q[3] * Q[3]);
      for (int i = 0; i < 4; ++i)
        Q[i] *= share;
    }
}

/* Q̇ = ½ ω Q of the ball at a configuration's numbers Q, ω along the parent frame's axes. */
static void quaternion_rate(const km_complex *Q, const km_complex *w, km_complex *out) {
  km_complex r[4] = {-w[0] * Q[1] - w[1] * Q[2] - w[2] * Q[3], w[0] * Q[0] + w[1] * Q[3] - w[2] * Q[2],
                     w[1] * Q[0] + w[2] * Q[1] - w[0] * Q[3], w[2] * Q[0] + w[0] * Q[2] - w[1] * Q[1]};
  for (int i = 0; i < 4; ++i)
    out[i] = 0.5 * r[i];
}

void km_complex_rate(const km_complex_closure *c, const km_complex *x, const km_complex *rates, km_complex *out) {
  for (int k = 0; k < c->sub->columns; ++k) {
    km_complex w[3] = {0.0, 0.0, 0.0};
    int count = begins_ball(c, k) ? 3 : 1;
    for (int i = 0; i < count; ++i)
      w[i] = c->unknown_of[k + i] >= 0 ? rates[c->unknown_of[k + i]] : 0.0;
    if (count == 3)
      quaternion_rate(&x[c->start_of[k]], w, &out[c->start_of[k]]);
    else if (!is_ball_column(c, k))
      out[c->start_of[k]] = w[0];
  }
}

void km_complex_move(const km_complex_closure *c, const km_complex *step, km_complex *x) {
  for (int k = 0; k < c->sub->columns; ++k) {
    km_complex w[3] = {0.0, 0.0, 0.0}, rate[4];
    int count = begins_ball(c, k) ? 3 : 1;
    for (int i = 0; i < count; ++i)
      w[i] = c->unknown_of[k + i] >= 0 ? step[c->unknown_of[k + i]] : 0.0;
    if (count == 3) {
      quaternion_rate(&x[c->start_of[k]], w, rate);
      for (int i = 0; i < 4; ++i)
        x[c->start_of[k] + i] += rate[i];
    } else if (!is_ball_column(c, k)) {
      x[c->start_of[k]] += w[0];
    }
  }
  km_complex_normalise(c, x);
}

void km_complex_randomise(const km_complex_closure *c, const km_complex *centre, double distance, uint64_t *random,
                          km_complex *x) {
  memcpy(x, centre, (size_t)c->length * sizeof *x);
  for (int k = 0; k < c->sub->columns; ++k) {
    km_complex w[3], rate[4];
    int count = begins_ball(c, k) ? 3 : 1;
    for (int i = 0; i < count; ++i)
      w[i] = c->unknown_of[k + i] >= 0 ? distance * km_complex_random(random) : 0.0;
    if (count == 3) {
      quaternion_rate(&x[c->start_of[k]], w, rate);
      for (int i = 0; i < 4; ++i)
        x[c->start_of[k] + i] += rate[i];
    } else if (!is_ball_column(c, k)) {
      x[c->start_of[k]] += w[0];
    }
  }
  km_complex_normalise(c, x);
}

/* ---- Evaluation. */

/* Coefficients of one program, whose first step is the `step`-th one of all. */
static km_program_weight weight_of_program(const km_complex_closure *c, int functional, const km_program *program,
                                           int step) {
  const km_slot_weight *all = c->weight[functional];
  return (km_program_weight){all + step, all + c->end_start + 2 * (program->loop_start - c->sub->loop_start)};
}

void km_complex_evaluate(const km_complex_closure *c, const km_complex *x, km_complex_values *out) {
  bool has_functional = out->functional >= 0;
  int rows = 0, columns = 0;
  for (int k = 0; k < c->sub->columns; ++k)
    columns += c->unknown_of[k] >= 0;
  for (int r = 0; r < c->sub->rows; ++r)
    rows += c->equation_of[r] >= 0;
  for (int r = 0; out->J && r < rows; ++r)
    memset(out->J + r * out->stride, 0, (size_t)columns * sizeof *out->J);
  out->value = 0.0;
  if (has_functional && out->gradient)
    memset(out->gradient, 0, (size_t)columns * sizeof *out->gradient);
  for (int i = 0, step = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    km_program_weight weight = has_functional ? weight_of_program(c, out->functional, program, step)
                                              : (km_program_weight){NULL, NULL};
    if (program->planar)
      km_complex_planar(c, program, x, weight, out);
    else
      km_complex_spatial(c, program, x, weight, out);
    step += program->step_count;
  }
}

void km_complex_fingerprint(const km_complex_closure *c, const km_complex *x, km_complex *y) {
  for (int k = 0; k < KM_FINGERPRINT; ++k) {
    km_complex_values values = {.functional = k};
    km_complex_evaluate(c, x, &values);
    y[k] = values.value;
  }
}

km_complex_extent km_complex_pose_extent(const km_complex_closure *c, const km_complex *x) {
  km_complex_extent extent = {0.0, 0.0};
  for (int i = 0, step = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    (program->planar ? km_complex_planar_extent : km_complex_spatial_extent)(
        c, program, x, weight_of_program(c, 0, program, step), &extent);
    step += program->step_count;
  }
  return extent;
}

km_complex km_complex_trace(const km_complex_closure *c, const km_complex *x) {
  km_complex_values values = {.functional = KM_TRACE};
  km_complex_evaluate(c, x, &values);
  return values.value;
}

bool km_complex_is_same_mode(const km_complex_closure *c, const km_complex *x, const km_complex *other) {
  km_complex y[2][KM_FINGERPRINT];
  km_complex_fingerprint(c, x, y[0]);
  km_complex_fingerprint(c, other, y[1]);
  for (int k = 0; k < KM_FINGERPRINT; ++k)
    if (!(cabs(y[0][k] - y[1][k]) <= passive_tolerance * (1.0 + cabs(y[0][k]))))
      return false;
  return true;
}

/* Difference of the trace's functional at two configurations, relative to 1 + |y|, above which they are separate. */
static const double separate = 1e-6;
enum { LEAST_SEPARATED = 8 }; /* fewer configurations don't show that a slot's pose tells all of them apart */

/* True if the trace's functional differs at all configurations. */
static bool is_separating(const km_complex_closure *c, const km_complex *points, int count) {
  for (int i = 0; i < count; ++i) {
    km_complex y = km_complex_trace(c, points + (size_t)i * (size_t)c->length);
    for (int j = 0; j < i; ++j)
      if (!(cabs(y - km_complex_trace(c, points + (size_t)j * (size_t)c->length)) > separate * (1.0 + cabs(y))))
        return false;
  }
  return true;
}

/* Steps of all programs. */
static int count_steps(const km_complex_closure *c) {
  int steps = 0;
  for (int i = 0; i < c->sub->program_count; ++i)
    steps += c->m->programs[c->sub->program_start + i].step_count;
  return steps;
}

void km_complex_choose_trace(km_complex_closure *c, const km_complex *points, int count, uint64_t *random) {
  int steps = c->end_start + 2 * c->sub->loop_count;
  km_slot_weight *trace = c->weight[KM_TRACE];
  const km_slot_weight *all = c->weight[0];
  for (int i = 0; i < 2 * steps && count >= LEAST_SEPARATED; ++i) {
    km_slot_weight *one = &trace[i % steps];
    memset(trace, 0, (size_t)steps * sizeof *trace);
    for (int k = 0; k < 3; ++k) {
      one->p[k] = all[i % steps].p[k] == 0.0 ? 0.0 : km_complex_random(random);
      for (int j = 0; j < 3 && i >= steps; ++j)
        one->R[k][j] = all[i % steps].R[k][j] == 0.0 ? 0.0 : km_complex_random(random);
    }
    if (is_separating(c, points, count))
      return;
  }
  memcpy(trace, all, (size_t)steps * sizeof *trace);
}

bool km_complex_has_all_rows(const km_complex_closure *c) {
  int count = 0, closing = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    count += c->equation_of[r] >= 0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j)
      if (c->closing_step[program->loop_start + j - c->sub->loop_start] >= 0)
        closing += program->planar ? 1 : 3;
  }
  return count + closing == c->sub->rows;
}

/* ---- Functionals. */

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
  return (slot_place){joint, m->model->frames[j->frame[sign > 0.0]].body, m->model->frames[j->frame[sign <= 0.0]].body, from,
                      to, is_chord};
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

/* Parts of a slot's pose that are a function of the bodies' places. */
static void random_weight(const km_program *program, km_body_identity identity, uint64_t *random,
                          km_slot_weight *out) {
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
static void draw_weights(km_complex_closure *c, uint64_t *random, km_arena *arena) {
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
        random_weight(program, identity_of_slot(m, placement, &here), random,
                      &c->weight[k][first + j]);
    }
    first += program->step_count;
  }
  for (int l = 0; l < c->sub->loop_count; ++l)
    for (int i = 0; i < 2 * KM_FINGERPRINT; ++i)
      if (end_counts(m, placement, m->loop_order[c->sub->loop_start + l]))
        for (int k = 0; k < 3; ++k)
          c->weight[i / 2][c->end_start + 2 * l + i % 2].p[k] = km_complex_random(random);
}

/* ---- Choice of equations and unknowns. */

static int count_loops(const km_complex_closure *c, int column);

/* Step of the ball joint, or planar hinge, that closes a loop and belongs to no other one; −1: none. The loop's rows are
 * taken where its frames meet, so that the joint turns no position. */
static int find_closing_step(const km_complex_closure *c, const km_state *s, const km_program *program,
                             const km_loop *loop) {
  const km_mechanism *m = c->m;
  int chord = m->topology.chord[loop - m->loops];
  if (!loop->has_moving_point || loop->lambda != (program->planar ? 3 : 6))
    return -1;
  for (int i = 0; i < program->step_count; ++i) {
    const km_step *spatial = program->planar ? NULL : &m->steps[program->step_start + i];
    const km_planar_step *planar = program->planar ? &m->planar_steps[program->step_start + i] : NULL;
    bool turns_freely = planar ? !planar->is_slide && planar->to == loop->slot[0] &&
                                     loop->planar_closing_point[0][0] == 0.0 && loop->planar_closing_point[0][1] == 0.0
                               : spatial->primitive == KM_BALL && spatial->to == loop->slot[0] &&
                                     km_vec3_norm(loop->closing_frame[0].p) == 0.0;
    int coordinate = planar ? planar->coordinate : spatial->coordinate;
    if (turns_freely && !s->locked[coordinate] && m->model->coordinates[coordinate].joint == chord &&
        count_loops(c, km_complex_column(c, coordinate)) == 1)
      return i;
  }
  return -1;
}

/* Finds the candidates for unknowns and equations. Returns the number of unknowns. */
static int number_candidates(km_complex_closure *c, const km_state *s, int *rows) {
  const km_mechanism *m = c->m;
  for (int k = 0; k < c->sub->columns; ++k)
    c->unknown_of[k] = s->locked[m->column_coordinate[c->sub->column_start + k]] ? -1 : 0;
  for (int r = 0; r < c->sub->rows; ++r)
    c->equation_of[r] = 0;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      int place = program->loop_start + j;
      const km_loop *loop = &m->loops[m->loop_order[place]];
      int step = c->closing_step[place - c->sub->loop_start] = find_closing_step(c, s, program, loop);
      if (step < 0)
        continue;
      int first = program->planar ? m->planar_steps[program->step_start + step].coordinate
                                  : m->steps[program->step_start + step].coordinate;
      for (int k = 0; k < (program->planar ? 1 : 3); ++k) {
        c->unknown_of[km_complex_column(c, first) + k] = -1;
        c->equation_of[loop->row_start + (program->planar ? 2 : 3) + k] = -1;
      }
    }
  }
  int columns = 0;
  *rows = 0;
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->unknown_of[k] == 0)
      c->unknown_of[k] = columns++;
  for (int r = 0; r < c->sub->rows; ++r)
    if (c->equation_of[r] == 0)
      c->equation_of[r] = (*rows)++;
  return columns;
}

/* Work arrays of the choice. */
typedef struct choice {
  km_complex *J, *gradient, *reference, *generic;
  int *row, *column;
  int rows, unlocked; /* candidates for equations and unknowns */
} choice;

static void evaluate_all(const km_complex_closure *c, const choice *w, const km_complex *x) {
  km_complex_values values = {.J = w->J, .stride = w->unlocked, .functional = -1};
  km_complex_evaluate(c, x, &values);
}

/* True if no functional changes along the null vectors of the eliminated J at the generic configuration. */
static bool is_passive(const km_complex_closure *c, const choice *w, int rank) {
  for (int k = 0; k < KM_FINGERPRINT; ++k) {
    km_complex_values values = {.functional = k, .gradient = w->gradient};
    km_complex_evaluate(c, w->generic, &values);
    double scale = 0.0;
    for (int j = 0; j < w->unlocked; ++j)
      scale += cabs(w->gradient[j]);
    for (int d = rank; d < w->unlocked; ++d) {
      km_complex slope = w->gradient[w->column[d]];
      for (int i = 0; i < rank; ++i)
        slope -= w->gradient[w->column[i]] * w->J[w->row[i] * w->unlocked + w->column[d]];
      if (!(cabs(slope) <= passive_tolerance * scale))
        return false;
    }
  }
  return true;
}

/* Number of loops with a column. */
static int count_loops(const km_complex_closure *c, int column) {
  int count = 0;
  for (int i = 0; i < c->sub->loop_count; ++i) {
    const km_loop *loop = &c->m->loops[c->m->loop_order[c->sub->loop_start + i]];
    for (int e = 0; e < loop->entry_count; ++e) {
      int first = c->m->entries[loop->entry_start + e].column;
      count += first == column || (is_ball_column(c, column) && first <= column && column < first + 3 &&
                                   is_ball_column(c, first));
    }
  }
  return count;
}

/* Numbers the chosen rows and columns; sparse columns come first. */
static void number_system(km_complex_closure *c, const choice *w, int size, const bool *is_row, const bool *is_column) {
  int n = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    c->equation_of[r] = is_row[r] ? n++ : -1;
  n = 0;
  for (int loops = 1; loops <= c->sub->loop_count; ++loops)
    for (int k = 0; k < c->sub->columns; ++k)
      if (is_column[k] && count_loops(c, k) == loops) {
        c->column_of[n] = k;
        w->column[k] = n++;
      }
  for (int k = 0; k < c->sub->columns; ++k)
    c->unknown_of[k] = is_column[k] ? w->column[k] : -1;
  c->size = size;
}

/* Marks the equations of rotations. */
static void mark_turns(km_complex_closure *c) {
  for (int i = 0; i < c->size; ++i)
    c->turn_of[i] = -1;
  for (int i = 0; i < c->sub->program_count; ++i) {
    const km_program *program = &c->m->programs[c->sub->program_start + i];
    for (int j = 0; j < program->loop_count; ++j) {
      const km_loop *loop = &c->m->loops[c->m->loop_order[program->loop_start + j]];
      bool is_whole = true; /* a rotation of which some components are free has no quaternion */
      for (int r = 0; r < loop->lambda; ++r)
        is_whole = is_whole && (loop->rows[r] < (program->planar ? 2 : 3) || c->equation_of[loop->row_start + r] >= 0);
      for (int r = 0; r < loop->lambda && is_whole; ++r) {
        int equation = c->equation_of[loop->row_start + r];
        int component = loop->rows[r] - (program->planar ? 2 : 3);
        if (component < 0)
          continue;
        int turn = 4 * (program->loop_start + j - c->sub->loop_start);
        c->has_turn[turn] = c->has_turn[turn + 1 + (program->planar ? 2 : component)] = true;
        if (equation >= 0)
          c->turn_of[equation] = turn + 1 + (program->planar ? 2 : component);
      }
    }
  }
}

/* Chooses equations at the reference and unknowns at a generic configuration. Returns the number of freedoms of the
 * bodies that remain; 0 if the system is square. */
static int choose_system(km_complex_closure *c, const choice *w, double tolerance, km_arena *arena) {
  int rows = w->rows, unlocked = w->unlocked;
  int *column_of = KM_ARENA_NEW(arena, int, (size_t)c->sub->columns);
  int *row_of = KM_ARENA_NEW(arena, int, (size_t)c->sub->rows);
  bool *is_row = KM_ARENA_NEW(arena, bool, (size_t)c->sub->rows), *is_column = KM_ARENA_NEW(arena, bool, (size_t)c->sub->columns);
  if (arena->failed)
    return 0;
  for (int k = 0; k < c->sub->columns; ++k)
    if (c->unknown_of[k] >= 0)
      column_of[c->unknown_of[k]] = k;
  for (int r = 0; r < c->sub->rows; ++r)
    if (c->equation_of[r] >= 0)
      row_of[c->equation_of[r]] = r;
  evaluate_all(c, w, w->generic);
  int rank = km_complex_eliminate(w->J, rows, unlocked, generic_rank_tolerance, w->row, w->column);
  if (!is_passive(c, w, rank))
    return unlocked - rank;
  evaluate_all(c, w, w->reference);
  int closed_rank = km_complex_eliminate(w->J, rows, unlocked, tolerance, w->row, w->column);
  if (closed_rank < rank && rank < rows)
    return rank - closed_rank;
  /* At a singular configuration of independent loops all equations count. */
  for (int i = 0; i < rank; ++i)
    is_row[row_of[closed_rank < rank ? i : w->row[i]]] = true;
  int n = 0;
  for (int r = 0; r < c->sub->rows; ++r)
    c->equation_of[r] = is_row[r] ? n++ : -1;
  evaluate_all(c, w, w->generic);
  km_complex_eliminate(w->J, rank, unlocked, generic_rank_tolerance, w->row, w->column);
  for (int i = 0; i < rank; ++i)
    is_column[column_of[w->column[i]]] = true;
  number_system(c, w, rank, is_row, is_column);
  mark_turns(c);
  return 0;
}

/* Refuses joints that are not algebraic. */
static km_status check_joints(const km_mechanism *m, const km_substructure *sub, km_error *error) {
  if (sub->coupling_count > 0)
    return km_fail(error, KM_USAGE,
                   "couplings between joints have no finite number of assembly modes over the complex numbers; random "
                   "starts find some: kmob info --modes");
  for (int i = 0; i < sub->program_count; ++i) {
    const km_program *program = &m->programs[sub->program_start + i];
    for (int j = 0; j < program->step_count && !program->planar; ++j) {
      const km_step *step = &m->steps[program->step_start + j];
      if (step->primitive == KM_HELICAL)
        return km_fail(error, KM_USAGE,
                       "joint \"%s\" is a screw, which has no finite number of assembly modes over the complex numbers; "
                       "hold it, or let random starts find some: kmob info --modes",
                       m->model->coordinates[step->coordinate].label);
    }
  }
  return KM_OK;
}

static void allocate(km_complex_closure *c, choice *w, km_arena *arena) {
  size_t rows = (size_t)c->sub->rows, columns = (size_t)c->sub->columns, most = rows > columns ? rows : columns;
  int steps = 0;
  c->start_of = KM_ARENA_NEW(arena, int, columns);
  c->unknown_of = KM_ARENA_NEW(arena, int, columns);
  c->equation_of = KM_ARENA_NEW(arena, int, rows);
  c->column_of = KM_ARENA_NEW(arena, int, most);
  c->closing_step = KM_ARENA_NEW(arena, int, (size_t)c->sub->loop_count);
  c->turn_of = KM_ARENA_NEW(arena, int, rows);
  c->has_turn = KM_ARENA_NEW(arena, bool, (size_t)(4 * c->sub->loop_count));
  for (int i = 0; i < c->sub->program_count; ++i)
    if (c->m->programs[c->sub->program_start + i].step_count > steps)
      steps = c->m->programs[c->sub->program_start + i].step_count;
  c->slot = KM_ARENA_NEW(arena, km_complex_pose, (size_t)c->m->largest_slots);
  c->isotropic = KM_ARENA_NEW(arena, km_isotropic_pose, (size_t)c->m->largest_slots);
  c->wrench = km_arena_alloc(arena, (size_t)c->m->largest_slots, sizeof *c->wrench);
  c->twist = km_arena_alloc(arena, (size_t)(3 * steps), sizeof *c->twist);
  w->J = KM_ARENA_NEW(arena, km_complex, rows *columns);
  w->gradient = KM_ARENA_NEW(arena, km_complex, columns);
  w->reference = KM_ARENA_NEW(arena, km_complex, 4 * columns);
  w->generic = KM_ARENA_NEW(arena, km_complex, 4 * columns);
  w->row = KM_ARENA_NEW(arena, int, most);
  w->column = KM_ARENA_NEW(arena, int, most);
}

km_status km_complex_closure_create(const km_mechanism *m, km_state *s, int substructure, uint64_t *random,
                                    km_arena *arena, km_complex_closure *out, int *freedom, km_error *error) {
  const km_substructure *sub = &m->substructures[substructure];
  choice w = {0};
  *out = (km_complex_closure){.m = m, .sub = sub};
  *freedom = 0;
  km_status status = check_joints(m, sub, error);
  if (status)
    return status;
  allocate(out, &w, arena);
  if (!arena->failed)
    draw_weights(out, random, arena);
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  for (int k = 0; k < sub->columns; ++k) {
    out->start_of[k] = out->length;
    out->length += begins_ball(out, k) ? 4 : !is_ball_column(out, k);
  }
  w.unlocked = number_candidates(out, s, &w.rows);
  km_complex_from_state(out, s, w.reference);
  km_complex_randomise(out, w.reference, generic_distance, random, w.generic);
  int worst;
  double tolerance = km_rank_tolerance(m, sub, km_loops_residual(m, s, sub, &worst));
  *freedom = choose_system(out, &w, tolerance, arena);
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  return *freedom == 0 ? KM_OK : km_fail(error, KM_USAGE, "bodies can move in %d way%s", *freedom, *freedom == 1 ? "" : "s");
}
