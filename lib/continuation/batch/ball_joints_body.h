/* Ball joints in a batch; part of step_body.h. Per lane the operations are those of rotation.h, state.c and
 * minimum_norm_path.c. Rotation vectors are computed at the end of a step only, by km_batch_finish_ball_joints;
 * before, their coordinates are undefined. */

typedef struct quaternion {
  vector w, x, y, z;
} quaternion;

static inline quaternion get_quaternion(const km_lane_quaternion *n, int lane) {
  return (quaternion){get(n->w.of + lane), get(n->x.of + lane), get(n->y.of + lane), get(n->z.of + lane)};
}
static inline void put_quaternion(km_lane_quaternion *n, int lane, const quaternion *a) {
  put(n->w.of + lane, a->w);
  put(n->x.of + lane, a->x);
  put(n->y.of + lane, a->y);
  put(n->z.of + lane, a->z);
}
static inline quaternion pick_quaternion(mask m, const quaternion *a, const quaternion *b) {
  return (quaternion){pick(m, a->w, b->w), pick(m, a->x, b->x), pick(m, a->y, b->y), pick(m, a->z, b->z)};
}

static inline quaternion quaternion_product(const quaternion *a, const quaternion *b) {
  return (quaternion){
      a->w * b->w - a->x * b->x - a->y * b->y - a->z * b->z, a->w * b->x + a->x * b->w + a->y * b->z - a->z * b->y,
      a->w * b->y - a->x * b->z + a->y * b->w + a->z * b->x, a->w * b->z + a->x * b->y - a->y * b->x + a->z * b->w};
}
static inline quaternion quaternion_conjugate(const quaternion *a) {
  return (quaternion){a->w, -a->x, -a->y, -a->z};
}
static inline quaternion quaternion_normalised(const quaternion *a) {
  vector s = 1.0 / root(a->w * a->w + a->x * a->x + a->y * a->y + a->z * a->z);
  return (quaternion){s * a->w, s * a->x, s * a->y, s * a->z};
}
/* Exponential of a rotation vector not longer than KM_SINCOS_MAX_ANGLE. */
static inline quaternion quaternion_exp(lanes_vec v) {
  vector angle = root(lanes_dot(v, v)), sine, cosine;
  lanes_sincos(0.5 * angle, &sine, &cosine);
  vector s = pick(below(angle, all(KM_EXP_SERIES)), 0.5 - angle * angle / 48.0, sine / angle);
  return (quaternion){cosine, s * v.x, s * v.y, s * v.z};
}
static inline rotation quaternion_rotation(const quaternion *q) {
  vector xx = q->x * q->x, yy = q->y * q->y, zz = q->z * q->z;
  vector xy = q->x * q->y, yz = q->y * q->z, zx = q->z * q->x;
  vector wx = q->w * q->x, wy = q->w * q->y, wz = q->w * q->z;
  return (rotation){{{1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (zx - wy)},
                     {2 * (xy - wz), 1 - 2 * (zz + xx), 2 * (yz + wx)},
                     {2 * (zx + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)}}};
}

/* Moves the pose X by a ball joint, as km_motion_step; h: its three unit twists. */
static NOT_INLINED pose ball_step(double sign, const quaternion *ball, pose X, km_lane_twist *h, int lane) {
  quaternion back = quaternion_conjugate(ball);
  rotation turn = quaternion_rotation(sign > 0.0 ? ball : &back), before = X.R;
  X.R = rotation_product(&X.R, &turn);
  const rotation *axes = sign > 0.0 ? &before : &X.R;
  for (int k = 0; k < 3; ++k) {
    lanes_vec w = lanes_scaled(all(sign), axes->axis[k]);
    put_vec(&h[k].v, lane, lanes_cross(X.p, w));
    put_vec(&h[k].w, lane, w);
  }
  return X;
}

/* Reads the three columns of a ball joint as a vector. */
static inline lanes_vec get_columns(const km_batch_number *x, int lane) {
  return (lanes_vec){get(x[0].of + lane), get(x[1].of + lane), get(x[2].of + lane)};
}

/* Rotates all ball joints by the step where the mask is set, as km_state_turn_ball. */
static NOT_INLINED void rotate_ball_joints(km_batch *l, const km_batch_number *step, const mask *where, int first,
                                           int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k) {
    if (!l->is_ball[k])
      continue;
    const km_batch_number *turn = step + k;
    km_lane_quaternion *at = &l->ball[l->m->ball_of[coordinate[k]]];
    EACH(r) {
      quaternion old = get_quaternion(at, AT(r));
      quaternion by = quaternion_exp(get_columns(turn, AT(r)));
      quaternion turned = quaternion_product(&by, &old);
      turned = quaternion_normalised(&turned);
      turned = pick_quaternion(where[r], &turned, &old);
      put_quaternion(at, AT(r), &turned);
    }
    k += 2;
  }
}

static NOT_INLINED void save_ball_joints(km_batch *l, int first, int count) {
  for (int b = 0; b < l->m->ball_count; ++b)
    EACH(r) {
      quaternion q = get_quaternion(&l->ball[b], AT(r));
      put_quaternion(&l->from_ball[b], AT(r), &q);
    }
}

/* Ends the step of the ball joints: kept where `took` is set, restored elsewhere. */
static NOT_INLINED void end_ball_joints(km_batch *l, const mask *took, int first, int count) {
  unsigned ended = 0;
  EACH(r)
  ended |= bits_of(took[r]) << AT(r);
  km_batch_finish_ball_joints(l, ended);
  for (int b = 0; b < l->m->ball_count; ++b)
    EACH(r) {
      quaternion q = get_quaternion(&l->ball[b], AT(r)), from = get_quaternion(&l->from_ball[b], AT(r));
      q = pick_quaternion(took[r], &q, &from);
      put_quaternion(&l->ball[b], AT(r), &q);
    }
}
