/* Relations between axes and lengths. */
#include "rounding/regular_shapes.h"

#include "base/number/tolerances.h"
#include "rounding/digits.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Distance of two joints, and of what rounding makes of it. */
typedef struct link {
  km_joint_end end[2];
  double length, noise;
} link;

static km_vec3 axis_of(const km_model *model, km_joint_end e) {
  return model->frames[e.frame].pose.R.axis[e.axis];
}

/* Distance of the axes of two joints, of a point and an axis, or of two points. */
static double distance_of(const km_model *model, km_joint_end a, km_joint_end b) {
  km_vec3 d = km_vec3_sub(model->frames[b.frame].pose.p, model->frames[a.frame].pose.p);
  if (a.axis < 0 && b.axis < 0)
    return km_vec3_norm(d);
  if (a.axis < 0)
    return km_vec3_norm(km_vec3_cross(d, axis_of(model, b)));
  if (b.axis < 0)
    return km_vec3_norm(km_vec3_cross(d, axis_of(model, a)));
  km_vec3 u = axis_of(model, a), n = km_vec3_cross(u, axis_of(model, b));
  double sine = km_vec3_norm(n);
  return sine < km_three_digits ? km_vec3_norm(km_vec3_cross(d, u)) : fabs(km_vec3_dot(d, n)) / sine;
}

static int rows_of(const km_relation *r) {
  return r->kind == KM_PARALLEL_AXES ? 3 : 1;
}

int km_relations_rows(const km_relations *relations) {
  int rows = 0;
  for (int i = 0; i < relations->count; ++i)
    rows += rows_of(&relations->relation[i]);
  return rows;
}

static void residual_of(const km_model *model, const km_relation *r, double size, double *out) {
  if (r->kind == KM_EQUAL_LENGTHS) {
    *out = (distance_of(model, r->end[0], r->end[1]) - distance_of(model, r->end[2], r->end[3])) / size;
    return;
  }
  km_vec3 u = axis_of(model, r->end[0]), v = axis_of(model, r->end[1]), n = km_vec3_cross(u, v);
  if (r->kind == KM_RIGHT_ANGLE) {
    *out = km_vec3_dot(u, v);
    return;
  }
  km_vec3_write(n, out);
}

/* Moves the frames that a number places by `by` of its units. */
static void displace(km_model *model, const km_written_number *number, double by, const km_pose *from) {
  km_rotation R = km_quaternion_rotation(km_quaternion_exp(km_vec3_scale(by, number->turn)));
  for (int end = 0; end < 2; ++end)
    if (number->frame[end] >= 0)
      model->frames[number->frame[end]].pose =
          (km_pose){km_rotation_product(&R, &from[end].R), km_vec3_axpy(by, number->move, from[end].p)};
}

bool km_relation_is_placed(const km_relation *r, const km_written_number *number) {
  for (int k = 0; k < (r->kind == KM_EQUAL_LENGTHS ? 4 : 2); ++k)
    if (r->end[k].frame == number->frame[0] || r->end[k].frame == number->frame[1])
      return true;
  return false;
}

void km_relations_compute(const km_relations *relations, km_model *model, const km_written_number *number,
                          const double *half, int count, double *c, double *A, size_t stride) {
  size_t row = 0;
  for (int i = 0; i < relations->count; row += (size_t)rows_of(&relations->relation[i++]))
    residual_of(model, &relations->relation[i], relations->size, c + row);
  for (int k = 0; k < count && A; ++k) {
    double reach = fmax(km_vec3_norm(number[k].move) / relations->size, km_vec3_norm(number[k].turn)),
           by = reach > 0.0 ? cbrt(DBL_EPSILON) / reach : 0.0; /* the best step of central differences */
    km_pose kept[2];
    for (int end = 0; end < 2; ++end)
      if (number[k].frame[end] >= 0)
        kept[end] = model->frames[number[k].frame[end]].pose;
    row = 0;
    for (int i = 0; i < relations->count; row += (size_t)rows_of(&relations->relation[i++])) {
      const km_relation *r = &relations->relation[i];
      double ahead[3] = {0}, back[3] = {0};
      if (by > 0.0 && km_relation_is_placed(r, &number[k])) {
        displace(model, &number[k], by, kept);
        residual_of(model, r, relations->size, ahead);
        displace(model, &number[k], -by, kept);
        residual_of(model, r, relations->size, back);
      }
      for (int j = 0; j < rows_of(r); ++j)
        A[(size_t)k * stride + row + (size_t)j] = by > 0.0 ? half[k] * (ahead[j] - back[j]) / (2.0 * by) : 0.0;
    }
    for (int end = 0; end < 2; ++end)
      if (number[k].frame[end] >= 0)
        model->frames[number[k].frame[end]].pose = kept[end];
  }
}

/* ---- Search */

/* The ends of the substructure's joints on one body. */
typedef struct body_ends {
  int count;
  km_joint_end *end;
} body_ends;

/* Change of a frame's place (relative to size) and of its axes that half a digit of all its numbers can make. */
typedef struct frame_noise {
  double move, turn;
} frame_noise;

static void list_ends(const km_mechanism *m, int substructure, int body, body_ends *out) {
  const km_topology *t = &m->topology;
  out->count = 0;
  for (int i = t->joint_start[substructure]; i < t->joint_start[substructure + 1]; ++i)
    for (int end = 0; end < 2; ++end) {
      const km_model_joint *joint = &m->model->joints[t->joint[i]];
      if (m->model->frames[joint->frame[end]].body == body)
        out->end[out->count++] = (km_joint_end){joint->frame[end], km_joint_axis(joint->type)};
    }
}

static void add(km_relations *out, km_relation relation) {
  if (out->count < KM_MAX_RELATIONS)
    out->relation[out->count++] = relation;
}

static void find_angles(const km_model *model, const body_ends *ends, const frame_noise *noise, km_relations *out) {
  for (int i = 0; i < ends->count; ++i)
    for (int k = i + 1; k < ends->count; ++k) {
      km_joint_end a = ends->end[i], b = ends->end[k];
      if (a.axis < 0 || b.axis < 0)
        continue;
      km_vec3 u = axis_of(model, a), v = axis_of(model, b);
      double most = noise[a.frame].turn + noise[b.frame].turn + km_solved_rounding;
      if (km_vec3_norm(km_vec3_cross(u, v)) <= most)
        add(out, (km_relation){KM_PARALLEL_AXES, {a, b}});
      else if (fabs(km_vec3_dot(u, v)) <= most)
        add(out, (km_relation){KM_RIGHT_ANGLE, {a, b}});
    }
}

static int compare_lengths(const void *a, const void *b) {
  double x = ((const link *)a)->length, y = ((const link *)b)->length;
  return (x > y) - (x < y);
}

static void find_equal_lengths(link *links, int count, km_relations *out) {
  qsort(links, (size_t)count, sizeof *links, compare_lengths);
  for (int i = 1; i < count; ++i)
    if (links[i].length - links[i - 1].length <= links[i].noise + links[i - 1].noise + km_solved_rounding)
      add(out, (km_relation){KM_EQUAL_LENGTHS,
                             {links[i - 1].end[0], links[i - 1].end[1], links[i].end[0], links[i].end[1]}});
}

static int list_links(const km_model *model, const body_ends *ends, const frame_noise *noise, double size, link *out) {
  int count = 0;
  for (int i = 0; i < ends->count; ++i)
    for (int k = i + 1; k < ends->count; ++k) {
      km_joint_end a = ends->end[i], b = ends->end[k];
      double apart = km_vec3_norm(km_vec3_sub(model->frames[b.frame].pose.p, model->frames[a.frame].pose.p)) / size;
      double error = noise[a.frame].move + noise[b.frame].move + apart * (noise[a.frame].turn + noise[b.frame].turn);
      link l = {{a, b}, distance_of(model, a, b) / size, error};
      if (l.length > km_root_rounding && l.length > 10.0 * error)
        out[count++] = l;
    }
  return count;
}

bool km_relations_find(const km_mechanism *m, int substructure, const km_written_number *number, const double *half,
                       int count, km_arena *arena, km_relations *out) {
  const km_topology *t = &m->topology;
  const km_model *model = m->model;
  size_t ends = 2 * (size_t)(t->joint_start[substructure + 1] - t->joint_start[substructure]);
  body_ends own = {.end = KM_ARENA_NEW(arena, km_joint_end, ends + 1)};
  frame_noise *noise = KM_ARENA_NEW(arena, frame_noise, (size_t)model->frame_count);
  link *links = KM_ARENA_NEW(arena, link, ends * ends + 1);
  *out = (km_relations){.relation = KM_ARENA_NEW(arena, km_relation, KM_MAX_RELATIONS),
                        .size = m->substructures[substructure].size};
  if (arena->failed)
    return false;
  for (int k = 0; k < count; ++k)
    for (int end = 0; end < 2; ++end)
      if (number[k].frame[end] >= 0) {
        noise[number[k].frame[end]].move += half[k] * km_vec3_norm(number[k].move) / out->size;
        noise[number[k].frame[end]].turn += half[k] * km_vec3_norm(number[k].turn);
      }
  int link_count = 0;
  for (int b = 0; b < model->body_count; ++b) {
    list_ends(m, substructure, b, &own);
    find_angles(model, &own, noise, out);
    link_count += list_links(model, &own, noise, out->size, links + link_count);
  }
  find_equal_lengths(links, link_count, out);
  return true;
}
