/* Mechanical advantage at a pose: the ratio of two rates in the one motion, or in the least one. */

#include "base/arguments.h"
#include "base/text.h"
#include "kinematics/body_poses.h"
#include "local/bifurcation.h"
#include "mobility/mobility_numbers.h"
#include "transfer/transfer.h"

#include <string.h>

/* Symbols: D the characteristic length's scale, Z the null space's basis, Y = D⁻¹ Z physical rates, a, b the rows of
 * input and output on the free motions. */

/* Rates below this fraction of the largest one count as zero. Where that end drives, its own digits don't tell such a pose
 * from its dead centre: they differ by the square. */
static const double zero_rate_tolerance = 3e-8;
/* Of two speeds that cancel, as those of a point on its own hinge, rounding is left. So much of them counts as speed that this is less
 * than the smallest part of a speed that anybody takes for a rate, 1e-12. */
static const double left_of_two = 1e-2;

/* The coordinates that an end's rate is made of: its own, or those on the way to the point's body. */
static void mark_direct(const km_mechanism *m, const km_port *h, bool *marks) {
  const km_topology *t = &m->topology;
  if (h->kind == KM_PORT_JOINT) {
    marks[h->coordinate] = true;
    return;
  }
  for (int body = m->model->frames[h->frame].body; body > 0; body = t->parent[body]) {
    int joint = t->arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c)
      marks[c] = !m->held[c];
  }
}

/* All free coordinates that move with an end: whole substructures. */
static void mark_moving(const km_mechanism *m, const km_port *h, bool *marks) {
  memset(marks, 0, (size_t)m->coordinate_count * sizeof *marks);
  mark_direct(m, h, marks);
  for (int i = 0; i < m->topology.substructure_count; ++i) {
    const km_substructure *sub = &m->substructures[i];
    const int *coordinate = m->column_coordinate + sub->column_start;
    bool any = false;
    for (int k = 0; k < sub->columns; ++k)
      any = any || marks[coordinate[k]];
    for (int k = 0; k < sub->columns; ++k)
      marks[coordinate[k]] = any;
  }
}

/* "joint \"A\"" or "point of body \"b\"". */
static void name_of(const km_mechanism *m, const km_port *h, km_text *out) {
  if (h->kind == KM_PORT_JOINT)
    km_text_format(out, "joint \"%s\"", m->model->coordinates[h->coordinate].label);
  else
    km_text_format(out, "the point of body \"%s\"", m->model->bodies[m->model->frames[h->frame].body].name);
}

static km_status check_end(const km_mechanism *m, const km_port *h, bool output, const bool *marks, km_error *error) {
  bool any = false;
  for (int c = 0; c < m->coordinate_count; ++c)
    any = any || marks[c];
  if (h->kind == KM_PORT_JOINT && m->held[h->coordinate])
    return km_fail(error, KM_USAGE, "%s \"%s\" is held; expected a joint that is free to move", km_end_word(output),
                   m->model->coordinates[h->coordinate].label);
  if (!any)
    return km_fail(error, KM_USAGE, "%s: nothing moves body \"%s\"; expected a point of a body that moves",
                   km_end_word(output), m->model->bodies[m->model->frames[h->frame].body].name);
  return KM_OK;
}

static bool same(const km_port *a, const km_port *b) {
  if (a->kind != b->kind)
    return false;
  if (a->kind == KM_PORT_JOINT)
    return a->coordinate == b->coordinate;
  km_vec3 difference = km_vec3_cross(km_vec3_from_array(a->direction), km_vec3_from_array(b->direction));
  return a->frame == b->frame && km_vec3_norm(difference) < 1e-12;
}

/* The labels of the free coordinates in `marks`, as a list of what would be right. */
static void list(const km_mechanism *m, const bool *marks, int but, km_text *out) {
  int shown = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (marks[c] && c != but && shown++ < 30)
      km_text_format(out, "%s%s", shown > 1 ? ", " : "", m->model->coordinates[c].label);
  if (shown > 30)
    km_text_add(out, ", …");
}

/* Both ends are one, or one doesn't move with the other: says which outputs would do. */
static km_status refuse(const km_mechanism *m, const km_transfer *l, km_error *error) {
  const km_port *in = &l->input.handle, *out = &l->output.handle;
  km_text names = {0}, choice = {0};
  list(m, l->moves, in->kind == KM_PORT_JOINT ? in->coordinate : -1, &choice);
  name_of(m, out, &names);
  const char *known = choice.size ? choice.data : "a point of a body that it moves";
  km_status status;
  if (names.failed || choice.failed)
    status = km_fail(error, KM_MEMORY, "out of memory for a message");
  else if (same(in, out))
    status = km_fail(error, KM_USAGE, "input and output are both %s; expected another output: %s", names.data, known);
  else
    status = km_fail(error, KM_USAGE,
                     "the output, %s, doesn't move with the input: they are in different substructures; expected an "
                     "output in the input's: %s",
                     names.data, known);
  km_text_free(&names);
  km_text_free(&choice);
  return status;
}

static km_status check(const km_mechanism *m, const km_transfer *l, bool *other, km_error *error) {
  const km_port *in = &l->input.handle, *out = &l->output.handle;
  mark_moving(m, out, other);
  km_status status = check_end(m, in, false, l->moves, error);
  if (!status)
    status = check_end(m, out, true, other, error);
  if (status)
    return status;
  bool meet = false;
  for (int c = 0; c < m->coordinate_count; ++c)
    meet = meet || (l->moves[c] && other[c]);
  return meet && !same(in, out) ? KM_OK : refuse(m, l, error);
}
static bool allocate(const km_mechanism *m, km_transfer *l) {
  size_t coordinates = (size_t)m->coordinate_count;
  km_transfer_end *ends[2] = {&l->input, &l->output};
  for (int i = 0; i < 2; ++i) {
    ends[i]->row = KM_ARENA_NEW(&l->arena, double, coordinates);
    ends[i]->speed = KM_ARENA_NEW(&l->arena, double, coordinates);
  }
  l->rates = KM_ARENA_NEW(&l->arena, double, coordinates);
  l->moves = KM_ARENA_NEW(&l->arena, bool, coordinates);
  l->pose = KM_ARENA_NEW(&l->arena, km_pose, (size_t)m->topology.body_count);
  l->steady = KM_ARENA_NEW(&l->arena, km_constant_rank, (size_t)m->topology.substructure_count + 1);
  l->is_steady = KM_ARENA_NEW(&l->arena, bool, (size_t)m->topology.substructure_count + 1);
  l->asked = KM_ARENA_NEW(&l->arena, bool, (size_t)m->topology.substructure_count + 1);
  return !l->arena.failed;
}

km_status km_transfer_create(const km_mechanism *m, const km_port *input, const km_port *output, km_transfer **out,
                             km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_ports(m, input, output, error);
  if (fits)
    return fits;
  km_transfer *l = KM_NEW(km_transfer, 1);
  bool *other = KM_NEW(bool, (size_t)m->coordinate_count);
  km_status status = KM_OK;
  if (!l || !other || !allocate(m, l)) {
    status = km_fail(error, KM_MEMORY, "out of memory for a mechanical advantage");
  } else {
    l->mechanism = m;
    l->input.handle = *input;
    l->output.handle = *output;
    mark_moving(m, input, l->moves);
    status = check(m, l, other, error);
  }
  km_free(other);
  if (status)
    km_transfer_free(l);
  else
    *out = l;
  return status;
}

void km_transfer_free(km_transfer *l) {
  if (!l)
    return;
  km_arena_free(&l->arena);
  km_free(l);
}

const double *km_transfer_rates(const km_transfer *l) {
  if (!l)
    return NULL;
  return l->rates;
}

static void point_row(const km_mechanism *m, const km_state *s, const km_transfer *l, km_transfer_end *end) {
  const km_topology *t = &m->topology;
  const km_model_frame *frame = &m->model->frames[end->handle.frame];
  km_vec3 p = km_pose_point(&l->pose[frame->body], frame->pose.p), along = km_vec3_from_array(end->handle.direction);
  for (int body = frame->body; body > 0; body = t->parent[body]) {
    int joint = t->arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
      km_twist h = km_coordinate_twist_about(m, s, l->pose, c);
      km_vec3 turned = km_vec3_cross(h.w, p), v = km_vec3_add(h.v, turned);
      end->row[c] = (t->is_reversed[joint] ? -1.0 : 1.0) * km_vec3_dot(along, v);
      end->speed[c] = km_vec3_norm(v) + left_of_two * (km_vec3_norm(h.v) + km_vec3_norm(turned));
    }
  }
}

static void update_row(const km_mechanism *m, const km_state *s, const km_transfer *l, km_transfer_end *end) {
  memset(end->row, 0, (size_t)m->coordinate_count * sizeof *end->row);
  if (end->handle.kind == KM_PORT_JOINT)
    end->row[end->handle.coordinate] = 1.0;
  else
    point_row(m, s, l, end);
}

/* Adds the free motion Y_k of a substructure, or of a joint in no loop, to the rates: once, or as often as it moves the
 * input. */
static void add_motion(const km_mechanism *m, km_transfer *l, const double *z, const int *coordinate, int count,
                       bool alone) {
  double a = 0.0;
  for (int j = 0; j < count; ++j)
    a += l->input.row[coordinate[j]] * z[j] / m->scale[coordinate[j]];
  for (int j = 0; j < count; ++j)
    l->rates[coordinate[j]] += (alone ? 1.0 : a) * z[j] / m->scale[coordinate[j]];
}

/* Does the substructure shake all along its motion? Whether it does is found at the first pose that leaves several freedoms. */
static bool is_steady(const km_mechanism *m, km_state *s, int index, km_transfer *l) {
  km_constant_rank *steady = &l->steady[index];
  if (km_partition_freedom(&s->partition[index]) < 2)
    return false;
  if (!l->asked[index])
    l->asked[index] = km_constant_rank_begin(steady, m, s, index, KM_NO_DRIVER, &l->arena);
  return steady->is_active && km_constant_rank_update(steady, m, s, index);
}

static int find_freedom(const km_mechanism *m, km_state *s, int index, km_transfer *l) {
  l->is_steady[index] = is_steady(m, s, index, l);
  return l->is_steady[index] ? l->steady[index].count : km_partition_freedom(&s->partition[index]);
}

/* The same of all free motions of a substructure. */
static void add_motions(const km_mechanism *m, km_state *s, int index, km_transfer *l, bool alone) {
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  if (l->is_steady[index]) {
    for (int k = 0; k < l->steady[index].count; ++k)
      add_motion(m, l, l->steady[index].Z + (size_t)k * (size_t)sub->columns, coordinate, sub->columns, alone);
    return;
  }
  if (km_state_project_onto_motions(m, s, index, l->input.row, s->work)) {
    for (int j = 0; j < sub->columns; ++j)
      l->rates[coordinate[j]] += s->work[j] / m->scale[coordinate[j]];
    return;
  }
  const double *Z = km_state_basis(s, index);
  for (int k = 0; k < km_partition_freedom(&s->partition[index]); ++k)
    add_motion(m, l, Z + (size_t)k * (size_t)sub->columns, coordinate, sub->columns, alone);
}

/* The motion that the advantage is about; returns the freedoms that it was chosen from. */
static int choose_motion(const km_mechanism *m, km_state *s, km_transfer *l) {
  static const double one = 1.0;
  int freedom = 0;
  memset(l->rates, 0, (size_t)m->coordinate_count * sizeof *l->rates);
  for (int pass = 0; pass < 2; ++pass) { /* first to count, then to add */
    bool alone = freedom == 1;
    for (int c = 0; c < m->coordinate_count; ++c) {
      if (!l->moves[c] || m->substructure_of[c] >= 0)
        continue;
      freedom += pass == 0;
      if (pass)
        add_motion(m, l, &one, &c, 1, alone);
    }
    for (int i = 0; i < m->topology.substructure_count; ++i) {
      if (!l->moves[m->column_coordinate[m->substructures[i].column_start]])
        continue;
      freedom += pass == 0 ? find_freedom(m, s, i, l) : 0;
      if (pass)
        add_motions(m, s, i, l, alone);
    }
  }
  return freedom;
}

static double largest_rate(const km_mechanism *m, const double *rates) {
  double largest = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c)
    largest = fmax(largest, fabs(rates[c] / m->unit[c]));
  return largest;
}

static void find_rate(const km_mechanism *m, const double *rates, double largest, km_transfer_end *end) {
  if (end->handle.kind == KM_PORT_JOINT) {
    int own = end->handle.coordinate;
    end->size = m->unit[own] * largest;
    end->rate = rates[own];
    return;
  }
  /* A coordinate that stands has a rate of rounding: of the largest one, not of its own. */
  end->size = end->rate = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    end->rate += end->row[c] * rates[c];
    end->size += end->speed[c] * m->unit[c] * largest;
  }
}

static double clear_rate(const km_transfer_end *end) {
  return fabs(end->rate) > zero_rate_tolerance * end->size ? end->rate : 0.0;
}

/* Of two rates that are 0 where they count as 0. */
static double ratio(double a, double b) {
  return a == 0.0 ? (b == 0.0 ? nan("") : 0.0) : b == 0.0 ? HUGE_VAL : a / b;
}

static void update_rows(const km_mechanism *m, const km_state *s, km_transfer *l) {
  if (l->input.handle.kind == KM_PORT_POINT || l->output.handle.kind == KM_PORT_POINT) /* joints need no poses */
    km_poses_about_mechanism(m, s, l->pose);
  update_row(m, s, l, &l->input);
  update_row(m, s, l, &l->output);
}

/* The advantage in the motion l->rates, which was chosen from so many freedoms. */
static void measure(const km_mechanism *m, km_transfer *l, int freedom, km_advantage *out) {
  double largest = largest_rate(m, l->rates);
  for (int c = 0; c < m->coordinate_count && largest > 0.0; ++c)
    l->rates[c] /= largest;
  *out = (km_advantage){.method = freedom == 1 ? KM_ADVANTAGE_SINGLE_FREEDOM : KM_ADVANTAGE_LEAST_MOTION};
  /* Where the input has no part in several freedoms there is no motion of its own. */
  bool moves = largest > (freedom == 1 ? 0.0 : zero_rate_tolerance);
  double scaled = largest > 0.0 ? 1.0 : 0.0;
  find_rate(m, l->rates, scaled, &l->input);
  find_rate(m, l->rates, scaled, &l->output);
  out->input_rate = moves ? clear_rate(&l->input) : 0.0;
  out->output_rate = moves ? clear_rate(&l->output) : 0.0;
  bool in = out->input_rate != 0.0, outwards = out->output_rate != 0.0;
  out->state = in && outwards ? KM_ADVANTAGE_FINITE
               : in           ? KM_ADVANTAGE_INFINITE
               : outwards     ? KM_ADVANTAGE_ZERO
                              : KM_ADVANTAGE_UNDEFINED;
  out->value = ratio(out->input_rate, out->output_rate);
  out->velocity_ratio = ratio(out->output_rate, out->input_rate);
}

km_status km_transfer_compute(const km_mechanism *m, km_state *s, km_transfer *l, km_advantage *out) {
  static const km_advantage unknown = {
      .state = KM_ADVANTAGE_UNDEFINED, .value = (double)NAN, .velocity_ratio = (double)NAN};
  if (!out)
    return KM_USAGE;
  *out = unknown;
  if (!l || l->mechanism != m || !km_state_mobility_is_known(m, s))
    return KM_USAGE;
  update_rows(m, s, l);
  measure(m, l, choose_motion(m, s, l), out);
  km_status status = km_mobility_check_memory(m, s);
  if (status)
    *out = unknown;
  return status;
}

void km_transfer_along(const km_mechanism *m, const km_state *s, km_transfer *l, const double *rates,
                       km_advantage *out) {
  update_rows(m, s, l);
  memcpy(l->rates, rates, (size_t)m->coordinate_count * sizeof *rates);
  measure(m, l, 1, out);
}

int km_transfer_branches(const km_mechanism *m, km_state *s, km_transfer *l, km_advantage *out, int most) {
  if (!l || !out || l->mechanism != m || !km_state_mobility_is_known(m, s))
    return 0;
  int index = -1, count = 0;
  for (int c = 0; c < m->coordinate_count && index < 0; ++c)
    index = l->moves[c] ? m->substructure_of[c] : -1;
  if (index < 0 || km_partition_freedom(&s->partition[index]) < 2)
    return 0;
  if (is_steady(m, s, index, l))
    return 0;
  const km_substructure *sub = &m->substructures[index];
  double *directions = KM_NEW(double, KM_MAX_BRANCHES *(size_t)sub->columns);
  double *rates = KM_NEW(double, (size_t)m->coordinate_count);
  count = directions && rates ? km_branch_directions(m, s, index, directions) : -1;
  for (int i = 0; i < count && i < most; ++i) {
    for (int k = 0; k < sub->columns; ++k) {
      int c = m->column_coordinate[sub->column_start + k];
      rates[c] = directions[(size_t)i * (size_t)sub->columns + (size_t)k] * m->unit[c];
    }
    km_transfer_along(m, s, l, rates, &out[i]);
  }
  km_free(directions);
  km_free(rates);
  return most < 0 ? 0 : count < most ? count : most;
}
