/* Closure errors and Jacobians of spatial loops in a batch; part of step_body.h. Per lane the operations are those of
 * loop_equations.c, primitive_motion.h and spatial/, with their names. */

#include "spatial/vec3_body.h"

#define ALL                   all
#define ROOT                  root
#define SINCOS                lanes_sincos
#define BELOW(a, limit, x, y) pick(below((a), all(limit)), (x), (y))
#include "spatial/rotation_body.h"

typedef struct lanes_twist {
  lanes_vec3 v, w;
} lanes_twist;

static inline lanes_vec3 get_vec(const km_lane_vec3 *n, int lane) {
  return (lanes_vec3){get(n->x.of + lane), get(n->y.of + lane), get(n->z.of + lane)};
}
static inline void put_vec(km_lane_vec3 *n, int lane, lanes_vec3 a) {
  put(n->x.of + lane, a.x);
  put(n->y.of + lane, a.y);
  put(n->z.of + lane, a.z);
}
static inline lanes_rotation get_rotation(const km_lane_pose *n, int lane) {
  return (lanes_rotation){{get_vec(&n->axis[0], lane), get_vec(&n->axis[1], lane), get_vec(&n->axis[2], lane)}};
}
static inline lanes_pose get_pose(const km_lane_pose *n, int lane) {
  return (lanes_pose){get_rotation(n, lane), get_vec(&n->p, lane)};
}
static inline void put_pose(km_lane_pose *n, int lane, const lanes_pose *X) {
  for (int k = 0; k < 3; ++k)
    put_vec(&n->axis[k], lane, X->R.axis[k]);
  put_vec(&n->p, lane, X->p);
}

#include "continuation/batch/ball_joints_body.h"

/* Moves the pose X by a joint other than a ball joint, as km_motion_step. Clears lanes whose angle exceeds the sine's
 * range. */
static inline lanes_pose motion_step(const km_step *step, vector pitch, vector value, lanes_pose X, km_lane_twist *h,
                                     mask *valid, int lane) {
  lanes_vec3 axis = lanes_vec3_axis(X.R.axis, step->axis), w = lanes_vec3_scale(all(step->sign), axis), v = w;
  if (step->primitive == KM_PRISMATIC) {
    w = (lanes_vec3){all(0.0), all(0.0), all(0.0)};
    X.p = lanes_vec3_axpy(value, axis, X.p);
  } else {
    vector sine, cosine;
    v = lanes_vec3_cross(X.p, w);
    if (step->primitive == KM_HELICAL) {
      v = lanes_vec3_axpy(all(step->sign) * pitch, axis, v);
      X.p = lanes_vec3_axpy(value * pitch, axis, X.p);
    }
    lanes_sincos(value, &sine, &cosine);
    *valid &= at_most(size_of(value), all(KM_SINCOS_MAX_ANGLE));
    lanes_vec3_turn_about(X.R.axis, step->axis, cosine, sine);
  }
  put_vec(&h->v, lane, v);
  put_vec(&h->w, lane, w);
  return X;
}

/* Forward kinematics of a spatial program. */
static inline void spatial_steps(km_batch *l, const km_program *program, mask *valid, int first, int count) {
  for (int i = program->step_start; i < program->step_start + program->step_count; ++i) {
    const km_step *step = &l->m->steps[i];
    const km_lane_spatial_step *n = &l->spatial_steps[i];
    EACH(r) {
      lanes_pose X = get_pose(&l->poses[step->from], AT(r));
      vector value = all(step->sign) * GET(l->q[step->coordinate]);
      if (step->primitive == KM_PRISMATIC)
        value /= GET(l->size);
      X.p = lanes_pose_point(&X, get_vec(&n->before.p, AT(r)));
      if (step->has_rotation) {
        lanes_rotation before = get_rotation(&n->before, AT(r));
        X.R = lanes_rotation_product(&X.R, &before);
      }
      if (step->primitive == KM_BALL) {
        lanes_quaternion ball = get_quaternion(&l->ball[step->ball], AT(r));
        X = ball_step(step->sign, &ball, X, &l->twists[3 * i], AT(r));
      } else {
        X = motion_step(step, GET(n->pitch), value, X, &l->twists[3 * i], &valid[r], AT(r));
      }
      put_pose(&l->poses[step->to], AT(r), &X);
    }
  }
}

/* Logarithm of a small displacement E as a twist, by series. Clears lanes whose rotation is not small. */
static inline lanes_twist twist_log(const lanes_pose *E, mask *valid) {
  const lanes_vec3 *a = E->R.axis;
  lanes_vec3 w = {0.5 * (a[1].z - a[2].y), 0.5 * (a[2].x - a[0].z), 0.5 * (a[0].y - a[1].x)};
  vector sine2 = lanes_vec3_dot(w, w);
  *valid &= below(sine2, all(KM_SERIES_ANGLE * KM_SERIES_ANGLE)) & below(all(2.0), a[0].x + a[1].y + a[2].z);
  w = lanes_vec3_scale(1.0 + sine2 * (1.0 / 6.0) + sine2 * sine2 * (3.0 / 40.0), w);
  vector c = 1.0 / 12.0 + lanes_vec3_dot(w, w) * (1.0 / 720.0);
  lanes_vec3 wp = lanes_vec3_cross(w, E->p);
  return (lanes_twist){lanes_vec3_axpy(c, lanes_vec3_cross(w, wp), lanes_vec3_axpy(all(-0.5), wp, E->p)), w};
}

/* Closure error of a spatial loop, its square and its rows. */
static inline void compute_spatial_error(km_batch *l, int index, mask *valid, int r, int first) {
  const km_loop *loop = &l->m->loops[index];
  km_lane_spatial_loop *n = &l->spatial_loops[index];
  km_lane_loop *out = &l->loops[index];
  lanes_pose close[2] = {get_pose(&n->closing_frame[0], AT(r)), get_pose(&n->closing_frame[1], AT(r))};
  lanes_pose a = get_pose(&l->poses[loop->slot[0]], AT(r)), b = get_pose(&l->poses[loop->slot[1]], AT(r));
  lanes_vec3 difference = get_vec(&n->origin_offset, AT(r));
  a = lanes_pose_product(&a, &close[0]);
  b = lanes_pose_product(&b, &close[1]);
  lanes_vec3 point = loop->has_moving_point ? a.p : get_vec(&n->point, AT(r));
  put_vec(&n->origin[0], AT(r), point);
  put_vec(&n->origin[1], AT(r), lanes_vec3_sub(point, difference));
  b.p = lanes_vec3_add(lanes_vec3_sub(b.p, a.p), difference);
  lanes_rotation back = lanes_rotation_inverse(&b.R);
  lanes_pose E = {lanes_rotation_product(&a.R, &back),
                  lanes_rotate(&a.R, lanes_vec3_scale(all(-1.0), lanes_rotate(&back, b.p)))};
  lanes_twist misfit = twist_log(&E, &valid[r]);
  PUT(out->square, lanes_vec3_dot(misfit.v, misfit.v) + lanes_vec3_dot(misfit.w, misfit.w));
  lanes_vec3 v = lanes_vec3_add(misfit.v, lanes_vec3_cross(misfit.w, lanes_vec3_sub(point, a.p)));
  const vector values[6] = {v.x, v.y, v.z, misfit.w.x, misfit.w.y, misfit.w.z};
  for (int k = 0; k < 6; ++k)
    put(l->error->of + out->row[k] + AT(r), values[k]);
}

/* Writes a spatial loop's entries of J. */
static inline void set_spatial_entries(km_batch *l, int index, const km_lane_twist *h, int first, int count) {
  const km_loop *loop = &l->m->loops[index];
  const km_lane_spatial_loop *n = &l->spatial_loops[index];
  for (int i = 0; i < loop->entry_count; ++i) {
    const km_lane_entry *entry = &l->entries[loop->entry_start + i];
    const km_lane_twist *of = &h[3 * entry->step];
    double *J = l->J->of;
    for (int k = 0; k < entry->columns; ++k, ++of, J += entry->column_stride)
      EACH(r) {
        lanes_vec3 w = get_vec(&of->w, AT(r)), o = get_vec(&n->origin[entry->side < 0.0], AT(r));
        lanes_vec3 v = lanes_vec3_add(get_vec(&of->v, AT(r)), lanes_vec3_cross(w, o));
        const vector column[6] = {v.x, v.y, v.z, w.x, w.y, w.z};
        for (int a = 0; a < 6; ++a)
          put(J + entry->position[a] + AT(r), entry->side * column[a]);
      }
  }
}

/* Errors and entries of all loops of a spatial program. */
static inline void update_spatial(km_batch *l, const km_program *program, mask *valid, int first, int count) {
  spatial_steps(l, program, valid, first, count);
  for (int i = 0; i < program->loop_count; ++i) {
    int index = l->m->loop_order[program->loop_start + i];
    EACH(r)
    compute_spatial_error(l, index, valid, r, first);
    set_spatial_entries(l, index, l->twists + 3 * (size_t)program->step_start, first, count);
  }
}
