/* Clearances of pairs of bodies and their gradients.
 *
 *   d = min over parts a of A, b of B of d(a, b);  d(a, b) ≥ |c_b − c_a| − r_a − r_b by their bounding balls
 *   ∂d/∂q_k = n · (∂p_B/∂q_k − ∂p_A/∂q_k)  at the closest points, as the points' own displacements on the surfaces are
 *             normal to n (J. M. Danskin, The theory of max-min, 1967)
 *
 * Parts whose balls are farther apart than the least distance so far are skipped. */
#include "kmech/clearance.h"

#include "base/arguments.h"
#include "base/text.h"
#include "clearance/body_parts.h"
#include "kinematics/body_poses.h"

#include <string.h>

/* Bodies touch at the reference configuration if their distance is below this part of their sizes: rounding of the
 * configuration, and of hulls. */
static const double touching = 1e-8;

struct km_clearance {
  const km_mechanism *m;
  km_arena arena;
  km_body_parts bodies;
  km_body_pair *pairs, *left_out;
  const char **names; /* [pair_count] "arm/frame" */
  int pair_count, left_out_count;
};

const char *km_left_out_word(km_left_out reason) {
  static const char *const words[KM_LEFT_OUT_REASONS] = {"rigid", "joined", "overlap"};
  return (unsigned)reason < KM_LEFT_OUT_REASONS ? words[reason] : "";
}

/* ---- Distances */

static void write_vector(km_vec3 v, double *out) {
  out[0] = v.x + 0.0; /* no −0 */
  out[1] = v.y + 0.0;
  out[2] = v.z + 0.0;
}

/* Distance of the bounding balls of two parts, of which the second has a pose in the frame of the first. */
static double ball_distance(const km_convex *a, const km_convex *b, const km_pose *pose) {
  return km_vec3_norm(km_vec3_sub(km_pose_point(pose, b->center), a->center)) - a->reach - b->reach;
}

/* Distance of two bodies, in the frame of the first. */
static km_convex_distance body_distance(const km_clearance *w, const int body[2], const km_pose *pose) {
  const km_body_parts *all = &w->bodies;
  km_convex_distance least = {.distance = HUGE_VAL};
  for (int i = all->start[body[0]]; i < all->start[body[0] + 1]; ++i)
    for (int j = all->start[body[1]]; j < all->start[body[1] + 1]; ++j) {
      const km_convex_pair pair = {{&all->parts[i], &all->parts[j]}, *pose};
      if (!(ball_distance(pair.part[0], pair.part[1], pose) < least.distance))
        continue;
      km_convex_distance d = km_convex_distance_compute(&pair);
      if (d.distance < least.distance)
        least = d;
    }
  return least;
}

static km_pair_clearance pair_distance(const km_clearance *w, const km_state *s, const int body[2]) {
  const km_pose *first = &s->pose[body[0]], back = km_pose_inverse(first);
  const km_pose pose = km_pose_product(&back, &s->pose[body[1]]);
  km_convex_distance d = body_distance(w, body, &pose);
  km_pair_clearance out = {.distance = d.distance, .error = d.error};
  write_vector(km_pose_point(first, d.a), out.point[0]);
  write_vector(km_pose_point(first, d.b), out.point[1]);
  write_vector(km_rotate(&first->R, d.normal), out.normal);
  return out;
}

static km_status check_clearance(const km_clearance *w, const km_state *s, km_error *error) {
  km_status status = km_check_given(w != NULL, "clearance", error);
  return status ? status : km_check_state(w->m, s, error);
}

km_status km_clearance_compute(const km_clearance *w, const km_state *s, km_pair_clearance *out, int *nearest,
                               km_error *error) {
  km_status status = check_clearance(w, s, error);
  if (!status)
    status = km_check_given(out != NULL, "place for the result", error);
  if (status)
    return status;
  int least = 0;
  for (int i = 0; i < w->pair_count; ++i) {
    out[i] = pair_distance(w, s, w->pairs[i].body);
    least = out[i].distance < out[least].distance ? i : least;
  }
  if (nearest)
    *nearest = least;
  return KM_OK;
}

/* Adds sign · n · v, v the velocity of the point p of a body per unit rate of each coordinate between it and the
 * inertial frame. */
static void add_velocities(const km_mechanism *m, const km_state *s, int body, double sign, km_vec3 n, km_vec3 p,
                           double *gradient) {
  for (; body > 0; body = m->topology.parent[body]) {
    int joint = m->topology.arc[body], first = m->model->joints[joint].first_coordinate;
    double sense = m->topology.is_reversed[joint] ? -sign : sign;
    for (int c = first; c < first + km_model_freedom(m->model, joint); ++c)
      if (!m->held[c])
        gradient[c] += sense * km_vec3_dot(n, km_point_velocity(km_coordinate_twist(m, s, c), p));
  }
}

km_status km_clearance_gradient(const km_clearance *w, const km_state *s, int pair, const km_pair_clearance *of,
                                double *gradient, km_error *error) {
  km_status status = check_clearance(w, s, error);
  if (!status)
    status = km_check_index(pair, w->pair_count, "pair", error);
  if (!status)
    status = km_check_given(of && gradient, "distance or place for the result", error);
  if (status)
    return status;
  km_vec3 n = km_vec3_from_array(of->normal);
  memset(gradient, 0, (size_t)w->m->coordinate_count * sizeof *gradient);
  for (int k = 0; k < 2; ++k)
    add_velocities(w->m, s, w->pairs[pair].body[k], k ? 1.0 : -1.0, n, km_vec3_from_array(of->point[k]), gradient);
  return KM_OK;
}

/* ---- The choice of pairs */

/* Group of each body: bodies that rigid or held joints connect. */
static void group_bodies(const km_mechanism *m, int *group) {
  const km_model *model = m->model;
  for (int b = 0; b < model->body_count; ++b)
    group[b] = b;
  for (int j = 0; j < model->joint_count; ++j) {
    const km_model_joint *joint = &model->joints[j];
    bool is_rigid = true;
    for (int c = 0; c < km_model_freedom(model, j); ++c)
      is_rigid = is_rigid && m->held[joint->first_coordinate + c];
    int a = group[model->frames[joint->frame[0]].body], b = group[model->frames[joint->frame[1]].body];
    for (int k = 0; k < model->body_count && is_rigid; ++k)
      group[k] = group[k] == b ? a : group[k];
  }
}

static bool are_joined(const km_model *model, int a, int b) {
  for (int j = 0; j < model->joint_count; ++j) {
    int one = km_joint_body(model, j, 0), two = km_joint_body(model, j, 1);
    if ((one == a && two == b) || (one == b && two == a))
      return true;
  }
  return false;
}

static double size_of(const km_clearance *w, int body) {
  double size = 0.0;
  for (int i = w->bodies.start[body]; i < w->bodies.start[body + 1]; ++i)
    size = fmax(size, w->bodies.parts[i].reach);
  return size;
}

static void sort_pair(km_clearance *w, const km_state *s, const int *group, int a, int b) {
  km_body_pair pair = {.body = {a, b}};
  bool left_out = true;
  if (group[a] == group[b])
    pair.reason = KM_LEFT_OUT_RIGID;
  else if (are_joined(w->m->model, a, b))
    pair.reason = KM_LEFT_OUT_JOINED;
  else if (pair_distance(w, s, pair.body).distance <= touching * (size_of(w, a) + size_of(w, b)))
    pair.reason = KM_LEFT_OUT_OVERLAP;
  else
    left_out = false;
  if (left_out)
    w->left_out[w->left_out_count++] = pair;
  else
    w->pairs[w->pair_count++] = pair;
}

static km_status choose_pairs(km_clearance *w, const km_state *s, const bool *wanted, km_error *error) {
  const km_model *model = w->m->model;
  int *group = KM_ARENA_NEW(&w->arena, int, (size_t)model->body_count);
  int bodies = 0;
  for (int b = 0; b < model->body_count; ++b)
    bodies += wanted[b];
  w->pairs = KM_ARENA_NEW(&w->arena, km_body_pair, (size_t)bodies * (size_t)bodies + 1);
  w->left_out = KM_ARENA_NEW(&w->arena, km_body_pair, (size_t)bodies * (size_t)bodies + 1);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for pairs of bodies");
  group_bodies(w->m, group);
  for (int a = 0; a < model->body_count; ++a)
    for (int b = a + 1; b < model->body_count; ++b)
      if (wanted[a] && wanted[b])
        sort_pair(w, s, group, a, b);
  if (w->pair_count > 0)
    return KM_OK;
  return km_fail(error, KM_USAGE,
                 "no clearance to compute: %d bod%s shapes or meshes, and no two of them are apart without a joint "
                 "between them; expected shapes of bodies that aren't adjacent, or chosen pairs",
                 bodies, bodies == 1 ? "y has" : "ies have");
}

/* ---- Creation */

static km_status check_pair(const km_model *model, const km_body_pair *pair, bool *wanted, km_error *error) {
  for (int k = 0; k < 2; ++k) {
    km_status status = km_check_index(pair->body[k], model->body_count, "body", error);
    if (status)
      return status;
    if (!km_body_has_geometry(model, pair->body[k]))
      return km_fail(error, KM_USAGE, "body \"%.200s\" has no shape and no mesh; expected one for its clearance",
                     model->bodies[pair->body[k]].name);
    wanted[pair->body[k]] = true;
  }
  if (pair->body[0] == pair->body[1])
    return km_fail(error, KM_USAGE, "a clearance of body \"%.200s\" with itself; expected two bodies",
                   model->bodies[pair->body[0]].name);
  return KM_OK;
}

static km_status fill(km_clearance *w, const km_state *s, const km_body_pair *pairs, int pair_count, km_error *error) {
  const km_model *model = w->m->model;
  bool *wanted = KM_ARENA_NEW(&w->arena, bool, (size_t)model->body_count);
  w->pairs = KM_ARENA_NEW(&w->arena, km_body_pair, (size_t)pair_count + 1);
  if (w->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for pairs of bodies");
  km_status status = KM_OK;
  for (int i = 0; i < pair_count && !status; ++i) {
    status = check_pair(model, &pairs[i], wanted, error);
    w->pairs[w->pair_count++] = pairs[i];
  }
  for (int b = 0; b < model->body_count && pair_count == 0; ++b)
    wanted[b] = km_body_has_geometry(model, b);
  if (!status)
    status = km_body_parts_create(model, wanted, &w->arena, &w->bodies, error);
  return status || pair_count > 0 ? status : choose_pairs(w, s, wanted, error);
}

static km_status name_pairs(km_clearance *w, km_error *error) {
  w->names = KM_ARENA_NEW(&w->arena, const char *, (size_t)w->pair_count);
  for (int i = 0; i < w->pair_count && w->names; ++i) {
    km_text name = {0};
    km_text_format(&name, "%s/%s", w->m->model->bodies[w->pairs[i].body[0]].name,
                   w->m->model->bodies[w->pairs[i].body[1]].name);
    w->names[i] = km_text_move_to_arena(&name, &w->arena);
  }
  return w->arena.failed ? km_fail(error, KM_MEMORY, "out of memory for pairs of bodies") : KM_OK;
}

km_status km_clearance_create(const km_mechanism *m, const km_state *s, const km_body_pair *pairs, int pair_count,
                              km_clearance **out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = NULL;
  km_status status = km_check_state(m, s, error);
  if (!status)
    status = km_check_list(pairs, pair_count, "pairs of bodies", error);
  if (status)
    return status;
  km_clearance *w = KM_NEW(km_clearance, 1);
  if (!w)
    return km_fail(error, KM_MEMORY, "out of memory for a clearance");
  w->m = m;
  status = fill(w, s, pairs, pair_count, error);
  if (!status)
    status = name_pairs(w, error);
  if (status)
    km_clearance_free(w);
  else
    *out = w;
  return status;
}

void km_clearance_free(km_clearance *w) {
  if (!w)
    return;
  km_arena_free(&w->arena);
  km_free(w);
}

/* ---- Access */

static const km_body_pair no_pair = {.body = {-1, -1}};

int km_clearance_pair_count(const km_clearance *w) {
  return w ? w->pair_count : 0;
}

km_body_pair km_clearance_pair(const km_clearance *w, int index) {
  return index >= 0 && index < km_clearance_pair_count(w) ? w->pairs[index] : no_pair;
}

const char *km_clearance_pair_name(const km_clearance *w, int index) {
  return index >= 0 && index < km_clearance_pair_count(w) ? w->names[index] : "";
}

int km_clearance_left_out_count(const km_clearance *w) {
  return w ? w->left_out_count : 0;
}

km_body_pair km_clearance_left_out(const km_clearance *w, int index) {
  return index >= 0 && index < km_clearance_left_out_count(w) ? w->left_out[index] : no_pair;
}

static bool has_body(const km_clearance *w, int body) {
  return w && body >= 0 && body < w->m->model->body_count;
}

int km_clearance_part_count(const km_clearance *w, int body) {
  return has_body(w, body) ? w->bodies.start[body + 1] - w->bodies.start[body] : 0;
}

double km_clearance_hull_error(const km_clearance *w, int body) {
  return has_body(w, body) ? w->bodies.error[body] : nan("");
}
