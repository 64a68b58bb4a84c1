/* Mechanical advantage at a configuration (theory 8.1, 8.2): MA = q̇_in / q̇_out in a motion Y x, Y = D⁻¹ Z.
 *
 *   one freedom      : the single motion
 *   several freedoms : the shortest motion that moves the input, Y Yᵀ a, a the input's row on the free motions
 *   point along u    : row_j = uᵀ(v_j + ω_j × p), joints from the inertial frame to the body */

#include "base/arguments.h"
#include "base/number/tolerances.h"
#include "base/text.h"
#include "kinematics/body_poses.h"
#include "local/bifurcation.h"
#include "mobility/mobility_numbers.h"
#include "transfer/transfer.h"

#include <float.h>
#include <string.h>

/* True if a rate is above 2 √ε of the largest scaled rate. A rate nearer to its dead point is not determined by the
 * digits of its own angle, since they differ by the square. */
static bool is_above_rounding(double rate, double largest) {
  return fabs(rate) > 2.0 * sqrt(DBL_EPSILON) * largest;
}

/* Marks the coordinates on which a port's rate depends: its own, or those on the path to the point's body. */
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

/* Marks all free coordinates of the substructures that a port depends on. */
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
static void add_port_name(const km_mechanism *m, const km_port *h, km_text *out) {
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

static bool is_same_port(const km_port *a, const km_port *b) {
  if (a->kind != b->kind)
    return false;
  if (a->kind == KM_PORT_JOINT)
    return a->coordinate == b->coordinate;
  km_vec3 difference = km_vec3_cross(km_vec3_from_array(a->direction), km_vec3_from_array(b->direction));
  return a->frame == b->frame && km_vec3_norm(difference) < 1e-12;
}

/* Appends the labels of the marked coordinates, at most 30. */
static void list_labels(const km_mechanism *m, const bool *marks, int excluded, km_text *out) {
  int shown = 0;
  for (int c = 0; c < m->coordinate_count; ++c)
    if (marks[c] && c != excluded && shown++ < 30)
      km_text_format(out, "%s%s", shown > 1 ? ", " : "", m->model->coordinates[c].label);
  if (shown > 30)
    km_text_add(out, ", …");
}

/* Fails with the possible outputs: both ports are equal, or the output does not move with the input. */
static km_status fail_unconnected(const km_mechanism *m, const km_transfer *l, km_error *error) {
  const km_port *in = &l->input.port, *out = &l->output.port;
  km_text names = {0}, choice = {0};
  list_labels(m, l->moves, in->kind == KM_PORT_JOINT ? in->coordinate : -1, &choice);
  add_port_name(m, out, &names);
  const char *known = choice.size ? choice.data : "a point of a body that it moves";
  km_status status;
  if (names.failed || choice.failed)
    status = km_fail(error, KM_MEMORY, "out of memory for a message");
  else if (is_same_port(in, out))
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

static km_status check_connection(const km_mechanism *m, const km_transfer *l, bool *output_marks, km_error *error) {
  const km_port *in = &l->input.port, *out = &l->output.port;
  mark_moving(m, out, output_marks);
  km_status status = check_end(m, in, false, l->moves, error);
  if (!status)
    status = check_end(m, out, true, output_marks, error);
  if (status)
    return status;
  bool are_connected = false;
  for (int c = 0; c < m->coordinate_count; ++c)
    are_connected = are_connected || (l->moves[c] && output_marks[c]);
  return are_connected && !is_same_port(in, out) ? KM_OK : fail_unconnected(m, l, error);
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
  l->constant_rank = KM_ARENA_NEW(&l->arena, km_constant_rank, (size_t)m->topology.substructure_count + 1);
  l->uses_constant_rank = KM_ARENA_NEW(&l->arena, bool, (size_t)m->topology.substructure_count + 1);
  l->is_tested = KM_ARENA_NEW(&l->arena, bool, (size_t)m->topology.substructure_count + 1);
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
  bool *output_marks = KM_NEW(bool, (size_t)m->coordinate_count);
  km_status status = KM_OK;
  if (!l || !output_marks || !allocate(m, l)) {
    status = km_fail(error, KM_MEMORY, "out of memory for a mechanical advantage");
  } else {
    l->mechanism = m;
    l->input.port = *input;
    l->output.port = *output;
    mark_moving(m, input, l->moves);
    status = check_connection(m, l, output_marks, error);
  }
  km_free(output_marks);
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
  km_vec3 p = km_frame_origin(m->model, l->pose, end->port.frame), direction = km_vec3_from_array(end->port.direction);
  for (int body = m->model->frames[end->port.frame].body; body > 0; body = t->parent[body]) {
    int joint = t->arc[body], first = m->model->joints[joint].first_coordinate;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c) {
      km_twist h = km_coordinate_twist_about(m, s, l->pose, c);
      km_vec3 rotational = km_vec3_cross(h.w, p), v = km_vec3_add(h.v, rotational);
      end->row[c] = (t->is_reversed[joint] ? -1.0 : 1.0) * km_vec3_dot(direction, v);
      /* a part of two velocities that cancel, so that their rounding stays below km_solved_rounding of the scale */
      end->speed[c] =
          km_vec3_norm(v) + km_sum_rounding / km_solved_rounding * (km_vec3_norm(h.v) + km_vec3_norm(rotational));
    }
  }
}

static void update_row(const km_mechanism *m, const km_state *s, const km_transfer *l, km_transfer_end *end) {
  memset(end->row, 0, (size_t)m->coordinate_count * sizeof *end->row);
  if (end->port.kind == KM_PORT_JOINT)
    end->row[end->port.coordinate] = 1.0;
  else
    point_row(m, s, l, end);
}

/* Adds the free motion Y_k of a substructure or tree joint to the rates: with coefficient 1 for a single freedom,
 * else with the input's rate in it. */
static void add_motion(const km_mechanism *m, km_transfer *l, const double *z, const int *coordinate, int count,
                       bool single_freedom) {
  double a = 0.0;
  for (int j = 0; j < count; ++j)
    a += l->input.row[coordinate[j]] * z[j] / m->scale[coordinate[j]];
  for (int j = 0; j < count; ++j)
    l->rates[coordinate[j]] += (single_freedom ? 1.0 : a) * z[j] / m->scale[coordinate[j]];
}

/* True if the substructure is permanently shaky; tested at the first configuration with several freedoms. */
static bool is_permanently_shaky(const km_mechanism *m, km_state *s, int index, km_transfer *l) {
  km_constant_rank *constant_rank = &l->constant_rank[index];
  if (km_factor_freedom(s->factor[index]) < 2)
    return false;
  if (!l->is_tested[index])
    l->is_tested[index] = km_constant_rank_begin(constant_rank, m, s, index, KM_NO_DRIVER, &l->arena);
  return constant_rank->is_active && km_constant_rank_update(constant_rank, m, s, index);
}

static int find_freedom(const km_mechanism *m, km_state *s, int index, km_transfer *l) {
  l->uses_constant_rank[index] = is_permanently_shaky(m, s, index, l);
  return l->uses_constant_rank[index] ? l->constant_rank[index].count : km_factor_freedom(s->factor[index]);
}

/* Adds all free motions of a substructure to the rates. */
static void add_motions(const km_mechanism *m, km_state *s, int index, km_transfer *l, bool single_freedom) {
  const km_substructure *sub = &m->substructures[index];
  const int *coordinate = m->column_coordinate + sub->column_start;
  if (l->uses_constant_rank[index]) {
    for (int k = 0; k < l->constant_rank[index].count; ++k)
      add_motion(m, l, l->constant_rank[index].Z + (size_t)k * (size_t)sub->columns, coordinate, sub->columns,
                 single_freedom);
    return;
  }
  if (km_state_project_onto_motions(m, s, index, l->input.row, s->work)) {
    for (int j = 0; j < sub->columns; ++j)
      l->rates[coordinate[j]] += s->work[j] / m->scale[coordinate[j]];
    return;
  }
  const double *Z = km_state_basis(s, index);
  for (int k = 0; k < km_factor_freedom(s->factor[index]); ++k)
    add_motion(m, l, Z + (size_t)k * (size_t)sub->columns, coordinate, sub->columns, single_freedom);
}

/* Computes the motion of the advantage into the rates; returns the number of freedoms it was chosen from. */
static int choose_motion(const km_mechanism *m, km_state *s, km_transfer *l) {
  int freedom = 0;
  memset(l->rates, 0, (size_t)m->coordinate_count * sizeof *l->rates);
  for (int pass = 0; pass < 2; ++pass) { /* first pass counts the freedoms, second adds the motions */
    bool single_freedom = freedom == 1;
    for (int c = 0; c < m->coordinate_count; ++c) {
      if (!l->moves[c] || m->substructure_of[c] >= 0)
        continue;
      freedom += pass == 0;
      if (pass)
        add_motion(m, l, &(double){1.0}, &c, 1, single_freedom);
    }
    for (int i = 0; i < m->topology.substructure_count; ++i) {
      if (!l->moves[m->column_coordinate[m->substructures[i].column_start]])
        continue;
      freedom += pass == 0 ? find_freedom(m, s, i, l) : 0;
      if (pass)
        add_motions(m, s, i, l, single_freedom);
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
  if (end->port.kind == KM_PORT_JOINT) {
    int coordinate = end->port.coordinate;
    end->size = m->unit[coordinate] * largest;
    end->rate = rates[coordinate];
    return;
  }
  /* the rate of a coordinate at rest is rounding of the largest one, not of its own */
  end->size = end->rate = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    end->rate += end->row[c] * rates[c];
    end->size += end->speed[c] * m->unit[c] * largest;
  }
}

static double rate_above_rounding(const km_transfer_end *end) {
  return is_above_rounding(end->rate, end->size) ? end->rate : 0.0;
}

/* Returns a/b: 0, infinity or NaN if one or both are 0. */
static double ratio(double a, double b) {
  return a == 0.0 ? (b == 0.0 ? nan("") : 0.0) : b == 0.0 ? HUGE_VAL : a / b;
}

static void update_rows(const km_mechanism *m, const km_state *s, km_transfer *l) {
  if (l->input.port.kind == KM_PORT_POINT || l->output.port.kind == KM_PORT_POINT) /* joints need no poses */
    km_poses_about_mechanism(m, s, l->pose);
  update_row(m, s, l, &l->input);
  update_row(m, s, l, &l->output);
}

/* Computes the advantage in the motion l->rates, chosen from `freedom` freedoms. */
static void evaluate_advantage(const km_mechanism *m, km_transfer *l, int freedom, km_advantage *out) {
  double largest = largest_rate(m, l->rates);
  for (int c = 0; c < m->coordinate_count && largest > 0.0; ++c)
    l->rates[c] /= largest;
  *out = (km_advantage){.method = freedom == 1 ? KM_ADVANTAGE_SINGLE_FREEDOM : KM_ADVANTAGE_LEAST_MOTION};
  /* an input without part in the free motions has no motion of its own */
  bool moves = freedom == 1 ? largest > 0.0 : is_above_rounding(largest, 1.0);
  double scaled = largest > 0.0 ? 1.0 : 0.0;
  find_rate(m, l->rates, scaled, &l->input);
  find_rate(m, l->rates, scaled, &l->output);
  out->input_rate = moves ? rate_above_rounding(&l->input) : 0.0;
  out->output_rate = moves ? rate_above_rounding(&l->output) : 0.0;
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
  evaluate_advantage(m, l, choose_motion(m, s, l), out);
  km_status status = km_mobility_check_memory(m, s);
  if (status)
    *out = unknown;
  return status;
}

void km_transfer_along(const km_mechanism *m, const km_state *s, km_transfer *l, const double *rates,
                       km_advantage *out) {
  update_rows(m, s, l);
  memcpy(l->rates, rates, (size_t)m->coordinate_count * sizeof *rates);
  evaluate_advantage(m, l, 1, out);
}

int km_transfer_branches(const km_mechanism *m, km_state *s, km_transfer *l, km_advantage *out, int most) {
  if (!l || !out || l->mechanism != m || !km_state_mobility_is_known(m, s))
    return 0;
  int index = -1, count = 0;
  for (int c = 0; c < m->coordinate_count && index < 0; ++c)
    index = l->moves[c] ? m->substructure_of[c] : -1;
  if (index < 0 || km_factor_freedom(s->factor[index]) < 2)
    return 0;
  if (is_permanently_shaky(m, s, index, l))
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
