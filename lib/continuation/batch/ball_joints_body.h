/* Ball joints in a batch; part of step_body.h. Per lane the operations are those of rotation.h, state.c and
 * minimum_norm_path.c. Rotation vectors are computed at the end of a step only, by km_batch_finish_ball_joints;
 * before, their coordinates are undefined. */

static inline lanes_quaternion get_quaternion(const km_lane_quaternion *n, int lane) {
  return (lanes_quaternion){get(n->w.of + lane), get(n->x.of + lane), get(n->y.of + lane), get(n->z.of + lane)};
}
static inline void put_quaternion(km_lane_quaternion *n, int lane, const lanes_quaternion *a) {
  put(n->w.of + lane, a->w);
  put(n->x.of + lane, a->x);
  put(n->y.of + lane, a->y);
  put(n->z.of + lane, a->z);
}
static inline lanes_quaternion pick_quaternion(mask m, const lanes_quaternion *a, const lanes_quaternion *b) {
  return (lanes_quaternion){pick(m, a->w, b->w), pick(m, a->x, b->x), pick(m, a->y, b->y), pick(m, a->z, b->z)};
}

/* Moves the pose X by a ball joint, as km_motion_step; h: its three unit twists. */
static NOT_INLINED lanes_pose ball_step(double sign, const lanes_quaternion *ball, lanes_pose X, km_lane_twist *h,
                                        int lane) {
  lanes_rotation turn = lanes_quaternion_rotation(sign > 0.0 ? *ball : lanes_quaternion_conjugate(*ball)), before = X.R;
  X.R = lanes_rotation_product(&X.R, &turn);
  const lanes_rotation *axes = sign > 0.0 ? &before : &X.R;
  for (int k = 0; k < 3; ++k) {
    lanes_vec3 w = lanes_vec3_scale(all(sign), axes->axis[k]);
    put_vec(&h[k].v, lane, lanes_vec3_cross(X.p, w));
    put_vec(&h[k].w, lane, w);
  }
  return X;
}

/* Reads the three columns of a ball joint as a vector. */
static inline lanes_vec3 get_columns(const km_batch_number *x, int lane) {
  return (lanes_vec3){get(x[0].of + lane), get(x[1].of + lane), get(x[2].of + lane)};
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
      lanes_quaternion old = get_quaternion(at, AT(r));
      lanes_quaternion turned =
          lanes_quaternion_normalised(lanes_quaternion_product(lanes_quaternion_exp(get_columns(turn, AT(r))), old));
      turned = pick_quaternion(where[r], &turned, &old);
      put_quaternion(at, AT(r), &turned);
    }
    k += 2;
  }
}

static NOT_INLINED void save_ball_joints(km_batch *l, int first, int count) {
  for (int b = 0; b < l->m->ball_count; ++b)
    EACH(r) {
      lanes_quaternion q = get_quaternion(&l->ball[b], AT(r));
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
      lanes_quaternion q = get_quaternion(&l->ball[b], AT(r)), from = get_quaternion(&l->from_ball[b], AT(r));
      q = pick_quaternion(took[r], &q, &from);
      put_quaternion(&l->ball[b], AT(r), &q);
    }
}
