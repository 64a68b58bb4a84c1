/* Predictors along the path of least motion (theory 4.7) in a batch; part of step_body.h. Per lane the operations are
 * those of minimum_norm_path.c and predictor_corrector.c. */

#include "continuation/multistep_body.h"

/* Computes the weights of all nodes: a lane has all tangents or all but one. */
static inline lanes_multistep compute_node_weights(const km_batch *l, vector h, int r, int first) {
  vector x[KM_PATH_NODES] = {all(0.0), -GET(l->current.last_h) / h};
  for (int i = 0; i < KM_OLDER_STEPS; ++i)
    x[2 + i] = x[1 + i] - GET(l->current.older_h[i]) / h;
  const bool has_balls = l->m->ball_count > 0;
  const mask all_known = equal(GET(l->current.older_count), all(KM_OLDER_STEPS));
  lanes_multistep w = lanes_multistep_weights(x, KM_PATH_NODES, has_balls),
                  fewer = lanes_multistep_weights(x, KM_PATH_NODES - 1, has_balls);
  for (int i = 0; i < KM_PATH_NODES; ++i) {
    w.weight[i] = pick(all_known, w.weight[i], fewer.weight[i]);
    w.error_weight[i] = pick(all_known, w.error_weight[i], fewer.error_weight[i]);
    w.slope[i] = pick(all_known, w.slope[i], fewer.slope[i]);
    w.curvature[i] = pick(all_known, w.curvature[i], fewer.curvature[i]);
  }
  return w;
}

/* Returns the weighted sum of a ball joint's angular velocities at the nodes. */
static inline lanes_vec3 weighted_angular_velocity(const km_batch_number *const *t, const vector *weight, int column,
                                                   int lane) {
  lanes_vec3 sum = {all(0.0), all(0.0), all(0.0)};
  for (int i = 0; i < KM_PATH_NODES; ++i)
    sum = lanes_vec3_axpy(weight[i], get_columns(t[i] + column, lane), sum);
  return sum;
}

/* Adds the Magnus terms to the rotation vectors of ball joints: −h³/12 ω × ω̇ − h⁴/24 ω × ω̈. */
static inline void add_magnus_terms(km_batch *l, const km_batch_number *const *t, const lanes_multistep *w,
                                    const vector *h, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k) {
    if (!l->is_ball[k])
      continue;
    const km_batch_number *now = t[0] + k;
    km_batch_number *turn = l->move + k;
    EACH(r) {
      lanes_vec3 curvature = weighted_angular_velocity(t, w[r].curvature, k, AT(r)),
                 slope = weighted_angular_velocity(t, w[r].slope, k, AT(r));
      lanes_vec3 error_weight = lanes_vec3_axpy(all(0.5), curvature, slope);
      lanes_vec3 correction =
          lanes_vec3_scale(-h[r] * h[r] / 12.0, lanes_vec3_cross(get_columns(now, AT(r)), error_weight));
      PUT(turn[0], GET(turn[0]) + correction.x);
      PUT(turn[1], GET(turn[1]) + correction.y);
      PUT(turn[2], GET(turn[2]) + correction.z);
    }
    k += 2;
  }
}

/* Computes the ratio of a step's error to the allowed one: see minimum_norm_path.h. */
static inline void compute_error_ratio(const km_batch *l, const km_batch_number *move, const vector *error,
                                       vector *error_ratio, int first, int count) {
  vector largest[REGISTERS];
  EACH(r)
  largest[r] = all(0.0);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  largest[r] = larger(size_of(GET(move[k])), largest[r]);
  EACH(r)
  error_ratio[r] = error[r] / (km_path_allowed * largest[r] + km_path_rounding);
}

/* Variable-step Adams-Bashforth, as km_minimum_norm_path_predict_multistep. `has_tangents`: lanes with enough
 * tangents whose step is not too long. */
static inline void predict_multistep(km_batch *l, const vector *h, vector *error_ratio, mask *applicable, int first,
                                     int count) {
  const km_batch_number *t[KM_PATH_NODES] = {l->t, l->last_t};
  lanes_multistep weights[REGISTERS];
  vector error[REGISTERS];
  for (int i = 0; i < KM_OLDER_STEPS; ++i)
    t[2 + i] = l->past[i];
  EACH(r) {
    weights[r] = compute_node_weights(l, h[r], r, first);
    error[r] = all(0.0);
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector sum = all(0.0), difference = all(0.0);
      for (int i = 0; i < KM_PATH_NODES; ++i) {
        vector tangent = GET(t[i][k]);
        sum += weights[r].weight[i] * tangent;
        difference += weights[r].error_weight[i] * tangent;
      }
      vector off = size_of(h[r] * difference);
      error[r] = pick(at_most(off, error[r]), error[r], off);
      PUT(l->move[k], h[r] * sum);
    }
  add_magnus_terms(l, t, weights, h, first, count);
  compute_error_ratio(l, l->move, error, error_ratio, first, count);
  EACH(r)
  applicable[r] =
      at_most(all(KM_PATH_LEAST_NODES - 2), GET(l->current.older_count)) & at_most(error_ratio[r], all(1.0));
}

/* Returns h Σ weight_i rate_i of column k over the stages. */
static inline vector combine_stages(const km_batch *l, const double *weight, int stages, int k, vector h, int r,
                                    int first) {
  vector sum = all(0.0);
  for (int i = 0; i < stages; ++i)
    if (weight[i] != 0.0)
      sum += h * weight[i] * GET(l->stage[i][k]);
  return sum;
}

/* Stores the rates of a stage in place of the move that led to it; angular velocities become rates of rotation
 * vectors. */
static inline void store_stage_rates(const km_batch *l, km_batch_number *stage, int first, int count) {
  for (int k = 0; k < l->sub->columns; ++k) {
    bool is_ball = l->is_ball[k];
    EACH(r) {
      if (is_ball) {
        lanes_vec3 v = lanes_rotation_vector_rate(get_columns(stage + k, AT(r)), get_columns(l->next_t + k, AT(r)));
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

static inline void restore_start(km_batch *l, int first, int count) {
  const int *coordinate = l->m->column_coordinate + l->sub->column_start;
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->q[coordinate[k]], GET(l->from[k]));
  for (int b = 0; b < l->m->ball_count; ++b)
    EACH(r) {
      lanes_quaternion q = get_quaternion(&l->from_ball[b], AT(r));
      put_quaternion(&l->ball[b], AT(r), &q);
    }
}

/* Computes the rates of one Runge-Kutta stage; clears lanes whose stage is displaced by more than 1. */
static inline void runge_kutta_stage(km_batch *l, int index, const vector *h, mask *valid, int first, int count) {
  km_batch_number *stage = l->stage[index];
  vector square[REGISTERS], largest_b[REGISTERS];
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      vector by = combine_stages(l, km_path_stage_weights[index], index, k, h[r], r, first);
      valid[r] &= at_most(size_of(by), all(1.0));
      PUT(stage[k], by);
    }
  apply_step(l, stage, valid, first, count);
  update(l, false, square, valid, first, count);
  refactor(l, largest_b, valid, first, count);
  compute_null_vectors(l, 0, l->extra_freedoms, first, count);
  compute_next_tangent(l, first, count);
  store_stage_rates(l, stage, first, count);
  restore_start(l, first, count);
}

/* Runge-Kutta 5(4) step into `move` where `valid` is set, as km_minimum_norm_path_predict_runge_kutta; other lanes
 * keep theirs. */
static NOT_INLINED void predict_runge_kutta(km_batch *l, const vector *h, vector *error_ratio, mask *valid, int first,
                                            int count) {
  double difference[KM_PATH_STAGES];
  vector error[REGISTERS], new_ratio[REGISTERS];
  mask wanted[REGISTERS];
  for (int i = 0; i < KM_PATH_STAGES; ++i)
    difference[i] = km_path_fifth[i] - km_path_fourth[i];
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r)
  PUT(l->stage[0][k], GET(l->t[k]));
  EACH(r) {
    wanted[r] = valid[r];
    error[r] = all(0.0);
  }
  for (int i = 1; i < KM_PATH_STAGES && any(valid, count); ++i)
    runge_kutta_stage(l, i, h, valid, first, count);
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      error[r] = larger(size_of(combine_stages(l, difference, KM_PATH_STAGES, k, h[r], r, first)), error[r]);
      PUT(l->x[k], combine_stages(l, km_path_fifth, KM_PATH_STAGES, k, h[r], r, first));
      PUT(l->move[k], pick(wanted[r], GET(l->x[k]), GET(l->move[k])));
    }
  compute_error_ratio(l, l->x, error, new_ratio, first, count);
  EACH(r) {
    error_ratio[r] = pick(wanted[r], new_ratio[r], error_ratio[r]);
    valid[r] &= at_most(new_ratio[r], all(1.0));
  }
}

/* Predicts along the path of least motion, not stiff: multistep, else Runge-Kutta. Clears lanes whose step is too
 * long. */
static NOT_INLINED void predict_minimum_norm_path(km_batch *l, const vector *h, vector *error_ratio, mask *valid,
                                                  int first, int count) {
  mask applicable[REGISTERS], others[REGISTERS];
  predict_multistep(l, h, error_ratio, applicable, first, count);
  EACH(r)
  others[r] = valid[r] & ~applicable[r];
  if (any(others, count))
    predict_runge_kutta(l, h, error_ratio, others, first, count);
  EACH(r)
  valid[r] &= applicable[r] | others[r];
}

/* Shifts the tangents of earlier steps where `took` is set, before a step h is accepted; a reversal clears them. */
static NOT_INLINED void push_older_tangents(km_batch *l, const vector *h, const mask *took, int first, int count) {
  EACH(r) {
    vector last = GET(l->current.last_h), known = GET(l->current.older_count), most = all(KM_OLDER_STEPS);
    mask is_reversed = below(h[r] * last, all(0.0));
    vector grown = pick(is_reversed, all(0.0), pick(below(known, most), known + 1.0, most));
    PUT(l->current.older_count, pick(took[r], grown, known));
    for (int i = KM_OLDER_STEPS - 1; i > 0; --i)
      PUT(l->current.older_h[i], pick(took[r], GET(l->current.older_h[i - 1]), GET(l->current.older_h[i])));
    PUT(l->current.older_h[0], pick(took[r], last, GET(l->current.older_h[0])));
  }
  for (int k = 0; k < l->sub->columns; ++k)
    EACH(r) {
      for (int i = KM_OLDER_STEPS - 1; i > 0; --i)
        PUT(l->past[i][k], pick(took[r], GET(l->past[i - 1][k]), GET(l->past[i][k])));
      PUT(l->past[0][k], pick(took[r], GET(l->last_t[k]), GET(l->past[0][k])));
    }
}
