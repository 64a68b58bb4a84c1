/* Paths of least motion of several drives in vectors: a part of lanes_body.h. What is computed for a lane is what least_path.c
 * and continuation.c compute for one drive. */

/* weigh_nodes of least_path.c. */
static inline void weigh_nodes(const vector *x, int nodes, vector *moment) {
  for (int k = 0; k < nodes - 1; ++k)
    for (int i = nodes - 1; i > k; --i)
      moment[i] -= x[k] * moment[i - 1];
  for (int k = nodes - 2; k >= 0; --k) {
    for (int i = k + 1; i < nodes; ++i)
      moment[i] /= x[i] - x[i - k - 1];
    for (int i = k; i < nodes - 1; ++i)
      moment[i] -= moment[i + 1];
  }
}

/* Of the tangents at all nodes, 0 of those that a lane doesn't know. */
typedef struct node_weights {
  vector whole[KM_PATH_NODES];                      /* for the way */
  vector change[KM_PATH_NODES];                     /* for what one tangent less makes of it */
  vector slope[KM_PATH_NODES], bend[KM_PATH_NODES]; /* for the derivatives at the pose, with balls */
} node_weights;

/* The weights of the first nodes, 0 for the others. */
static inline void weigh_first(const vector *x, int nodes, const double *moment, vector *weight) {
  for (int i = 0; i < KM_PATH_NODES; ++i)
    weight[i] = all(i < nodes ? moment[i] : 0.0);
  weigh_nodes(x, nodes, weight);
}

/* The weights of all nodes that a lane knows but the last `less`: all are known or, elsewhere, all but one. */
static inline void weigh_known(const vector *x, mask all_known, int less, const double *moment, vector *weight) {
  vector fewer[KM_PATH_NODES];
  weigh_first(x, KM_PATH_NODES - less, moment, weight);
  weigh_first(x, KM_PATH_NODES - less - 1, moment, fewer);
  for (int i = 0; i < KM_PATH_NODES; ++i)
    weight[i] = pick(all_known, weight[i], fewer[i]);
}

static inline node_weights weigh_tangents(const km_batch *l, vector h, int r, int first) {
  static const double integral[KM_PATH_NODES] = {1.0, 1.0 / 2, 1.0 / 3, 1.0 / 4, 1.0 / 5};
  static const double slope[KM_PATH_NODES] = {0.0, 1.0}, bend[KM_PATH_NODES] = {0.0, 0.0, 2.0};
  node_weights w = {.slope = {all(0.0)}, .bend = {all(0.0)}};
  mask all_known = equal(GET(l->here.older_count), all(KM_OLDER_STEPS));
  vector x[KM_PATH_NODES] = {all(0.0), -GET(l->here.last_h) / h}, less[KM_PATH_NODES];
  for (int i = 0; i < KM_OLDER_STEPS; ++i)
    x[2 + i] = x[1 + i] - GET(l->here.older_h[i]) / h;
  weigh_known(x, all_known, 0, integral, w.whole);
  weigh_known(x, all_known, 1, integral, less);
  for (int i = 0; i < KM_PATH_NODES; ++i)
    w.change[i] = w.whole[i] - less[i];
  if (l->m->ball_count > 0) {
    weigh_known(x, all_known, 0, slope, w.slope);
    weigh_known(x, all_known, 0, bend, w.bend);
  }
  return w;
}

/* weighted_turn of least_path.c. */
static inline lanes_vec weighted_turn(const km_batch_number *const *t, const vector *weight, int column, int lane) {
  lanes_vec sum = {all(0.0), all(0.0), all(0.0)};
  for (int i = 0; i < KM_PATH_NODES; ++i)
    sum = lanes_axpy(weight[i], get_columns(t[i] + column, lane), sum);
  return sum;
}

/* wind_balls of least_path.c. */
static inline void wind_balls(km_batch *l, const km_batch_number *const *t, const node_weights *w, const vector *h,
                              int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k) {
    if (!l->is_ball[k])
      continue;
    const km_batch_number *now = t[0] + k;
    km_batch_number *turn = l->move + k;
    EACH(r) {
      lanes_vec bend = weighted_turn(t, w[r].bend, k, AT(r)), slope = weighted_turn(t, w[r].slope, k, AT(r));
      lanes_vec change = lanes_axpy(all(0.5), bend, slope);
      lanes_vec lag = lanes_scaled(-h[r] * h[r] / 12.0, lanes_cross(get_columns(now, AT(r)), change));
      PUT(turn[0], GET(turn[0]) + lag.x);
      PUT(turn[1], GET(turn[1]) + lag.y);
      PUT(turn[2], GET(turn[2]) + lag.z);
    }
    k += 2;
  }
}

/* The strain of a step into `move`, whose error is the other number: see km_driver_motion. */
static inline void find_strain(const km_batch *l, const km_batch_number *move, const vector *error, vector *strain,
                               int first, int count) {
  vector largest[TOGETHER];
  EACH(r)
  largest[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  largest[r] = larger(size_of(GET(move[k])), largest[r]);
  EACH(r)
  strain[r] = error[r] / (km_path_allowed * largest[r] + km_path_grain);
}

/* km_minimum_norm_path_continue. `able`: lanes that know enough tangents, and whose step isn't too long for them. */
static inline void continue_path(km_batch *l, const vector *h, vector *strain, mask *able, int first, int count) {
  const km_batch_number *t[KM_PATH_NODES] = {l->t, l->last_t};
  node_weights weights[TOGETHER];
  vector error[TOGETHER];
  for (int i = 0; i < KM_OLDER_STEPS; ++i)
    t[2 + i] = l->past[i];
  EACH(r) {
    weights[r] = weigh_tangents(l, h[r], r, first);
    error[r] = all(0.0);
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector sum = all(0.0), apart = all(0.0);
      for (int i = 0; i < KM_PATH_NODES; ++i) {
        vector tangent = GET(t[i][k]);
        sum += weights[r].whole[i] * tangent;
        apart += weights[r].change[i] * tangent;
      }
      vector off = size_of(h[r] * apart);
      error[r] = pick(at_most(off, error[r]), error[r], off);
      PUT(l->move[k], h[r] * sum);
    }
  wind_balls(l, t, weights, h, first, count);
  find_strain(l, l->move, error, strain, first, count);
  EACH(r)
  able[r] = at_most(all(KM_PATH_LEAST_NODES - 2), GET(l->here.older_count)) & at_most(strain[r], all(1.0));
}

/* h Σ share_i rate_i, of column k. */
static inline vector combined(const km_batch *l, const double *share, int stages, int k, vector h, int r, int first) {
  vector sum = all(0.0);
  for (int i = 0; i < stages; ++i)
    if (share[i] != 0.0)
      sum += h * share[i] * GET(l->stage[i][k]);
  return sum;
}

/* vector_rate of least_path.c. */
static inline lanes_vec vector_rate(lanes_vec u, lanes_vec w) {
  vector angle = root(lanes_dot(u, u)), square = angle * angle, sine, cosine;
  lanes_sincos(angle, &sine, &cosine);
  vector near = 1.0 / 12 + square / 720, far = 1.0 / square - (1.0 + cosine) / (2.0 * angle * sine);
  lanes_vec once = lanes_cross(u, w), twice = lanes_cross(u, once);
  return lanes_axpy(pick(below(angle, all(KM_PATH_NEAR)), near, far), twice, lanes_axpy(all(-0.5), once, w));
}

/* unwind_balls of least_path.c: the rates of a stage take the place of the move that led there. */
static inline void set_stage(const km_batch *l, km_batch_number *stage, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k) {
    bool is_ball = l->is_ball[k];
    EACH(r) {
      if (is_ball) {
        lanes_vec v = vector_rate(get_columns(stage + k, AT(r)), get_columns(l->next_t + k, AT(r)));
        PUT(stage[k], v.x);
        PUT(stage[k + 1], v.y);
        PUT(stage[k + 2], v.z);
      } else {
        PUT(stage[k], GET(l->next_t[k]));
      }
    }
    k += is_ball ? 2 : 0;
  }
}

static inline void return_to_start(km_batch *l, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->q[coordinate[k]], GET(l->from[k]));
  for (int b = 0; b < l->m->ball_count; ++b)
    EACH(r) {
      quaternion q = get_quaternion(&l->from_ball[b], AT(r));
      put_quaternion(&l->ball[b], AT(r), &q);
    }
}

/* One stage of Runge and Kutta's method; clears the lanes that it leads too far. */
static inline void run_stage(km_batch *l, int index, const vector *h, mask *fit, int first, int count) {
  km_batch_number *stage = l->stage[index];
  vector square[TOGETHER], largest_b[TOGETHER];
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector by = combined(l, km_path_stage_shares[index], index, k, h[r], r, first);
      fit[r] &= at_most(size_of(by), all(1.0));
      PUT(stage[k], by);
    }
  move(l, stage, fit, first, count);
  update(l, false, square, fit, first, count);
  factor(l, largest_b, fit, first, count);
  find_null_vectors(l, 0, l->beside, first, count);
  set_next_tangent(l, first, count);
  set_stage(l, stage, first, count);
  return_to_start(l, first, count);
}

/* km_minimum_norm_path_predict, where `fit` is set, into `move`; the other lanes keep theirs. */
static APART void run_stages(km_batch *l, const vector *h, vector *strain, mask *fit, int first, int count) {
  double difference[KM_PATH_STAGES];
  vector error[TOGETHER], own[TOGETHER];
  mask wanted[TOGETHER];
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    difference[i] = km_path_fifth[i] - km_path_fourth[i];
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->stage[0][k], GET(l->t[k]));
  EACH(r) {
    wanted[r] = fit[r];
    error[r] = all(0.0);
  }
  for (int i = 1; i < KM_PATH_STAGES && any(fit, count); ++i)
    run_stage(l, i, h, fit, first, count);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      error[r] = larger(size_of(combined(l, difference, KM_PATH_STAGES, k, h[r], r, first)), error[r]);
      PUT(l->x[k], combined(l, km_path_fifth, KM_PATH_STAGES, k, h[r], r, first));
      PUT(l->move[k], pick(wanted[r], GET(l->x[k]), GET(l->move[k])));
    }
  find_strain(l, l->x, error, own, first, count);
  EACH(r) {
    strain[r] = pick(wanted[r], own[r], strain[r]);
    fit[r] &= at_most(own[r], all(1.0));
  }
}

/* follow_path of drive.c, where the path isn't stiff. Clears the lanes whose step is too long. */
static APART void follow_path(km_batch *l, const vector *h, vector *strain, mask *fit, int first, int count) {
  mask able[TOGETHER], others[TOGETHER];
  continue_path(l, h, strain, able, first, count);
  EACH(r)
  others[r] = fit[r] & ~able[r];
  if (any(others, count))
    run_stages(l, h, strain, others, first, count);
  EACH(r)
  fit[r] &= able[r] | others[r];
}

/* grow_older of continuation.c, before a step of h is accepted where `took` is set. */
static APART void grow_older(km_batch *l, const vector *h, const mask *took, int first, int count) {
  EACH(r) {
    vector last = GET(l->here.last_h), known = GET(l->here.older_count), most = all(KM_OLDER_STEPS);
    mask back = below(h[r] * last, all(0.0));
    vector grown = pick(back, all(0.0), pick(below(known, most), known + 1.0, most));
    PUT(l->here.older_count, pick(took[r], grown, known));
    for (int i = KM_OLDER_STEPS - 1; i > 0; --i)
      PUT(l->here.older_h[i], pick(took[r], GET(l->here.older_h[i - 1]), GET(l->here.older_h[i])));
    PUT(l->here.older_h[0], pick(took[r], last, GET(l->here.older_h[0])));
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      for (int i = KM_OLDER_STEPS - 1; i > 0; --i)
        PUT(l->past[i][k], pick(took[r], GET(l->past[i - 1][k]), GET(l->past[i][k])));
      PUT(l->past[0][k], pick(took[r], GET(l->last_t[k]), GET(l->past[0][k])));
    }
}
