/* Transmission wrench and indices of a single loop (theory 8.3, 8.4).
 *
 *   w = (f; τ) : w · h_j = 0 for all joints but input and output; scaled to a unit force or moment
 *   virtual coefficient ½ |w · s_o|;   Sutherland-Roth, Chen-Angeles : |w · s_o| / sqrt((h_w + h_o)² + d²)
 *   manipulability ∏ σ_i, condition number σ_1 / σ_r of J D⁻¹;   transmission angle of planar four-bars
 *
 * s_o the output's unit twist, h pitches, d the distance of the wrench's point P from the output axis. */
#include "transfer/transmission_metrics.h"
#include "base/arguments.h"
#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/full_jacobian.h"
#include "mobility/jacobian_singular_values.h"
#include "spatial/wrench.h"
#include "transfer/transfer.h"

#include <string.h>

struct km_transmission_workspace {
  km_arena arena;
  const km_mechanism *mechanism;
  km_port input, output;
  int substructure;    /* substructure of the input; -1: none */
  const char *no_loop; /* reason for no single loop with both ports; NULL: there is one */
  int *ring, joints;   /* the loop's joints in cyclic order, without rigid ones */
  int next;            /* step in the ring from the output away from the input; 0: they share no link */
  int at_output;       /* index of the output in the ring */
  km_pose *pose;
  km_twist *twist;
  double *T;         /* passive joints' columns and, in a plane, the excluded components of w, as rows */
  km_factor *factor; /* factor of T */
  km_singular_value_workspace *singular; /* NULL: the substructure is too large, or there is none */
};

/* Lists the loop's moving joints in cyclic order. */
static void list_ring(const km_mechanism *m, int loop, km_transmission_workspace *w) {
  const km_topology *t = &m->topology;
  int first = t->member_start[loop], end = t->member_start[loop + 1], split = first;
  while (split < end && t->member[split].side > 0)
    ++split;
  for (int i = 0; i < end - first; ++i) {
    int joint = t->member[first + i < split ? first + i : end - 1 - (first + i - split)].joint;
    const km_model_joint *def = &m->model->joints[joint];
    int freedom = km_model_freedom(m->model, joint);
    bool moves = false;
    for (int c = def->first_coordinate; c < def->first_coordinate + freedom; ++c)
      moves = moves || !m->held[c];
    if (moves)
      w->ring[w->joints++] = joint;
  }
}

/* Index of a joint in the loop's ring of joints; w->joints if absent. */
static int index_in_ring(const km_transmission_workspace *w, int joint) {
  int index = 0;
  while (index < w->joints && w->ring[index] != joint)
    ++index;
  return index;
}

static const char *find_loop(const km_mechanism *m, km_transmission_workspace *w) {
  if (w->input.kind != KM_PORT_JOINT || w->output.kind != KM_PORT_JOINT)
    return "input and output aren't both joints";
  int sub = m->substructure_of[w->input.coordinate];
  if (sub < 0 || m->substructures[sub].loop_count != 1 || m->substructures[sub].coupling_count > 0)
    return "the input isn't in a substructure of a single loop";
  list_ring(m, m->topology.loop[m->topology.loop_start[sub]], w);
  w->at_output = index_in_ring(w, m->model->coordinates[w->output.coordinate].joint);
  int input = index_in_ring(w, m->model->coordinates[w->input.coordinate].joint);
  if (w->at_output == w->joints)
    return "the output isn't in the input's loop";
  if (w->joints > 2 && (w->at_output + 1) % w->joints == input)
    w->next = -1;
  else if (w->joints > 2 && (input + 1) % w->joints == w->at_output)
    w->next = 1;
  return NULL;
}

static bool allocate(const km_mechanism *m, km_transmission_workspace *w) {
  km_arena *arena = &w->arena;
  size_t coordinates = (size_t)m->coordinate_count;
  int columns = w->substructure >= 0 ? m->substructures[w->substructure].columns : 0;
  w->ring = KM_ARENA_NEW(arena, int, (size_t)m->topology.joint_count);
  w->pose = KM_ARENA_NEW(arena, km_pose, (size_t)m->topology.body_count);
  w->twist = KM_ARENA_NEW(arena, km_twist, coordinates);
  w->T = KM_ARENA_NEW(arena, double, 6 * (size_t)(columns + 3));
  bool fits = w->substructure >= 0 && km_singular_values_fit(&m->substructures[w->substructure]);
  w->singular = fits ? km_singular_value_workspace_create(m) : NULL;
  if (fits && !w->singular)
    return false;
  w->factor = km_factor_create(columns + 3, 6, NULL, arena);
  return w->factor != NULL;
}

km_status km_transmission_create(const km_mechanism *m, const km_port *input, const km_port *output,
                                 km_transmission_workspace **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status fits = km_check_ports(m, input, output, error);
  if (fits)
    return fits;
  km_transmission_workspace *w = KM_NEW(km_transmission_workspace, 1);
  if (w) {
    w->mechanism = m;
    w->input = *input;
    w->output = *output;
    w->substructure = input->kind == KM_PORT_JOINT ? m->substructure_of[input->coordinate] : -1;
  }
  if (!w || !allocate(m, w)) {
    km_transmission_free(w);
    return km_fail(error, KM_MEMORY, "out of memory for the transmission");
  }
  w->no_loop = find_loop(m, w);
  *out = w;
  return KM_OK;
}

void km_transmission_free(km_transmission_workspace *w) {
  if (!w)
    return;
  km_singular_value_workspace_free(w->singular);
  km_arena_free(&w->arena);
  km_free(w);
}

static km_vec3 joint_centre(const km_mechanism *m, const km_transmission_workspace *w, int joint) {
  return km_frame_origin(m->model, w->pose, m->model->joints[joint].frame[0]);
}

/* Returns the hinge axis of a planar loop. */
static km_vec3 plane_normal(const km_mechanism *m, const km_transmission_workspace *w) {
  const km_substructure *sub = &m->substructures[w->substructure];
  for (int k = 0; k < sub->columns; ++k) {
    km_vec3 axis = w->twist[m->column_coordinate[sub->column_start + k]].w;
    if (km_vec3_norm(axis) > 0.5)
      return axis;
  }
  return (km_vec3){0, 0, 0};
}

static void add_row(const double row[6], int rows, int *count, double *T) {
  for (int k = 0; k < 6; ++k)
    T[(size_t)k * (size_t)rows + (size_t)*count] = row[k];
  ++*count;
}

/* Computes the wrench w reciprocal to the passive joints, w · h = 0; in a planar loop it is a force in the plane,
 * without normal force or moment about a direction of the plane. False if it is not unique. */
static bool find_wrench(const km_mechanism *m, km_transmission_workspace *w, km_vec3 about, km_wrench *out) {
  const km_substructure *sub = &m->substructures[w->substructure];
  bool planar = km_substructure_is_planar(m, w->substructure);
  int rows = sub->columns - 2 + (planar ? 3 : 0), count = 0;
  double row[6];
  for (int k = 0; k < sub->columns; ++k) {
    int c = m->column_coordinate[sub->column_start + k];
    if (c == w->input.coordinate || c == w->output.coordinate)
      continue;
    km_twist_entries(sub, w->twist[c], about, m->unit[c], row);
    add_row(row, rows, &count, w->T);
  }
  if (planar) {
    km_vec3 n = plane_normal(m, w), a = km_vec3_perpendicular(n), b = km_vec3_cross(n, a);
    const double keep[3][6] = {{n.x, n.y, n.z, 0, 0, 0}, {0, 0, 0, a.x, a.y, a.z}, {0, 0, 0, b.x, b.y, b.z}};
    for (int i = 0; i < 3; ++i)
      add_row(keep[i], rows, &count, w->T);
  }
  km_factor_compute(w->factor, w->T, rows, 6, &(km_factor_options){.tolerance = km_rank_tolerance(m, sub, 0.0)});
  if (km_factor_freedom(w->factor) != 1)
    return false;
  const double *x = km_factor_null_space(w->factor, 1);
  km_vec3 f = km_vec3_scale(1.0 / sub->size, km_vec3_from_array(x)), t = km_vec3_from_array(x + 3);
  double force = km_vec3_norm(f), moment = km_vec3_norm(t);
  bool is_pure_moment = force * sub->size <= 1e-9 * moment;
  double scale = 1.0 / (is_pure_moment ? moment : force);
  *out = (km_wrench){km_vec3_scale(is_pure_moment ? 0.0 : scale, f), km_vec3_scale(scale, t)};
  out->t = km_vec3_add(out->t, km_vec3_cross(about, out->f)); /* moment about the poses' origin */
  return true;
}

/* A line: a point and a unit direction. */
typedef struct line {
  km_vec3 point, along;
} line;

static km_vec3 nearest_on(const line *a, km_vec3 p) {
  return km_vec3_axpy(km_vec3_dot(a->along, km_vec3_sub(p, a->point)), a->along, a->point);
}

static double distance(const line *a, km_vec3 p) {
  return km_vec3_norm(km_vec3_sub(p, nearest_on(a, p)));
}

/* Returns the point of line a nearest to line b; for parallel lines, to b's point. */
static km_vec3 nearest_to_line(const line *a, const line *b) {
  km_vec3 n = km_vec3_cross(a->along, b->along), difference = km_vec3_sub(b->point, a->point);
  double square = km_vec3_dot(n, n);
  if (square < 1e-18)
    return nearest_on(a, b->point);
  return km_vec3_axpy(km_vec3_dot(km_vec3_cross(difference, b->along), n) / square, a->along, a->point);
}

/* Returns |w · s_o| over its largest value for a wrench of this pitch through P. */
static double index_at(km_wrench w, km_twist s, km_vec3 P) {
  double force = km_vec3_norm(w.f), rotation = km_vec3_norm(s.w), power = fabs(km_wrench_power(w, s));
  if (rotation < 0.5) /* slide: the largest value is a force along it */
    return force > 0.0 ? power / km_vec3_norm(s.v) : 0.0;
  if (force == 0.0) /* moment: the largest value is a moment along the axis */
    return power;
  line axis = {km_vec3_cross(s.w, s.v), s.w};
  double pitch = km_vec3_dot(w.f, w.t) + km_vec3_dot(s.w, s.v), d = distance(&axis, P);
  double largest = sqrt(pitch * pitch + d * d);
  return largest > 0.0 ? power / largest : 0.0;
}

static bool is_point(const km_mechanism *m, const km_transmission_workspace *w, int joint) {
  km_joint_type type = m->model->joints[joint].type;
  return type == KM_SPHERICAL ||
         (km_substructure_is_planar(m, w->substructure) && (type == KM_RX || type == KM_RY || type == KM_RZ));
}

/* Virtual coefficient, and the indices of Sutherland-Roth (point: centre of the joint next to the output, if it is a
 * ball or planar revolute joint) and Chen-Angeles (point of the wrench's line nearest to that joint's axis). */
static void find_indices(const km_mechanism *m, const km_transmission_workspace *w, km_wrench wrench,
                         km_transmission *out) {
  km_twist s = w->twist[w->output.coordinate];
  out->virtual_coefficient = (km_metric){fabs(0.5 * km_wrench_power(wrench, s)), NULL};
  if (w->next == 0) {
    out->sutherland_roth.why = out->chen_angeles.why = "input and output share no link of the loop";
    return;
  }
  int joint = w->ring[(w->at_output + w->next + w->joints) % w->joints];
  int c = m->model->joints[joint].first_coordinate;
  km_vec3 centre = joint_centre(m, w, joint);
  if (is_point(m, w, joint))
    out->sutherland_roth = (km_metric){index_at(wrench, s, centre), NULL};
  else
    out->sutherland_roth.why = "the wrench has no fixed point on the output link";
  bool is_rotational = km_vec3_norm(w->twist[c].w) > 0.5;
  line axis = {centre, w->twist[c].w}, force = {km_vec3_cross(wrench.f, wrench.t), wrench.f};
  bool moment = km_vec3_norm(wrench.f) == 0.0;
  if (is_point(m, w, joint) || moment)
    out->chen_angeles = (km_metric){index_at(wrench, s, centre), NULL};
  else if (is_rotational)
    out->chen_angeles = (km_metric){index_at(wrench, s, nearest_to_line(&force, &axis)), NULL};
  else
    out->chen_angeles.why = "the joint that drives the output link has no axis that turns";
}

/* Computes the transmission angle: between the lines from the near to the far joint of the coupler and to the
 * output's axis. */
static void find_angle(const km_mechanism *m, const km_transmission_workspace *w, km_transmission *out) {
  bool is_rotational = w->joints == 4 && km_substructure_is_planar(m, w->substructure);
  for (int i = 0; i < w->joints && is_rotational; ++i) {
    km_joint_type type = m->model->joints[w->ring[i]].type;
    is_rotational = type == KM_RX || type == KM_RY || type == KM_RZ;
  }
  if (!is_rotational || w->next == 0) {
    out->angle.why = is_rotational ? "input and output share no link of the loop" : "the loop isn't a planar four-bar";
    return;
  }
  km_vec3 n = plane_normal(m, w), p[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = joint_centre(m, w, w->ring[(w->at_output + i * w->next + w->joints) % w->joints]);
    p[i] = km_vec3_axpy(-km_vec3_dot(n, p[i]), n, p[i]);
  }
  km_vec3 a = km_vec3_sub(p[0], p[1]), b = km_vec3_sub(p[2], p[1]);
  double angle = atan2(km_vec3_norm(km_vec3_cross(a, b)), km_vec3_dot(a, b));
  out->angle = (km_metric){angle / m->model->units.angle->si, NULL};
}

static void find_condition(const km_mechanism *m, km_state *s, km_transmission_workspace *w, km_transmission *out) {
  int rank = w->substructure >= 0 ? km_factor_rank(s->factor[w->substructure]) : 0, count;
  out->manipulability.why = out->condition.why = w->substructure < 0 ? "the input is in no loop"
                                                 : rank == 0         ? "the loops constrain nothing"
                                                 : !w->singular ? "the substructure is too large for singular values"
                                                                : NULL;
  if (out->condition.why)
    return;
  const km_substructure *sub = &m->substructures[w->substructure];
  km_loops_update(m, s, sub);
  const double *sigma = km_singular_values(w->singular, m, s, sub, &count);
  double product = 1.0;
  for (int i = 0; i < rank; ++i)
    product *= sigma[i];
  out->manipulability = (km_metric){product, NULL};
  out->condition = (km_metric){sigma[0] / sigma[rank - 1], NULL};
}

static const char *no_wrench(const km_mechanism *m, const km_state *s, const km_transmission_workspace *w) {
  if (w->no_loop)
    return w->no_loop;
  if (!km_substructure_is_planar(m, w->substructure) && km_factor_rank(s->factor[w->substructure]) < 6)
    return "the loop is overconstrained: the wrench isn't unique";
  return NULL;
}

static void set_undefined(km_metric *metric, const char *why) {
  *metric = (km_metric){nan(""), why};
}

void km_transmission_compute(const km_mechanism *m, km_state *s, km_transmission_workspace *w, km_transmission *out) {
  if (!out)
    return;
  if (!w || w->mechanism != m || !km_state_mobility_is_known(m, s)) {
    const km_metric unknown = {nan(""), "the mobility isn't known"};
    *out = (km_transmission){{0}, unknown.why, unknown, unknown, unknown, unknown, unknown, unknown};
    return;
  }
  *out = (km_transmission){.no_wrench = no_wrench(m, s, w)};
  km_metric *const all[] = {&out->virtual_coefficient, &out->sutherland_roth, &out->chen_angeles, &out->angle,
                            &out->manipulability,      &out->condition};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    set_undefined(all[i], out->no_wrench);
  km_vec3 origin = km_poses_about_mechanism(m, s, w->pose);
  km_twists_about(m, s, w->pose, w->twist);
  km_wrench wrench;
  if (!out->no_wrench) {
    km_vec3 about = joint_centre(m, w, w->ring[w->at_output]);
    if (find_wrench(m, w, about, &wrench)) {
      find_indices(m, w, wrench, out);
      km_vec3 t = km_wrench_about(wrench, km_vec3_scale(-1.0, origin)).t;
      const double values[6] = {wrench.f.x, wrench.f.y, wrench.f.z, t.x, t.y, t.z};
      memcpy(out->wrench, values, sizeof values);
    } else {
      out->no_wrench = km_factor_freedom(s->factor[w->substructure]) == 1
                           ? "the passive joints are dependent here: the wrench isn't unique"
                           : "the loop has not just one freedom";
      for (int i = 0; i < 3; ++i)
        set_undefined(all[i], out->no_wrench);
    }
    find_angle(m, w, out);
  }
  find_condition(m, s, w, out);
}

const char *km_transmission_name(int metric) {
  static const char *const names[KM_METRIC_COLUMNS] = {"transmission_angle", "virtual_coefficient", "sutherland_roth",
                                                       "chen_angeles",       "manipulability",      "condition_number"};
  return names[metric];
}

const char *km_transmission_unit(const km_model *model, const km_port *output, int metric) {
  if (metric == 0)
    return model->units.angle->suffix;
  if (metric != 1 || output->kind != KM_PORT_JOINT)
    return "";
  return km_model_coordinate_is_length(model, output->coordinate) ? "" : model->units.length->suffix;
}

void km_transmission_values(const km_transmission *t, double out[KM_METRIC_COLUMNS]) {
  const double values[KM_METRIC_COLUMNS] = {t->angle.value,           t->virtual_coefficient.value,
                                            t->sutherland_roth.value, t->chen_angeles.value,
                                            t->manipulability.value,  t->condition.value};
  memcpy(out, values, sizeof values);
}
