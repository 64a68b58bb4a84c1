/* Hermite interpolation through four configurations q_i with tangents t_i at s_i = c + x_i h, x = -2, -1, 1, 2:
 *
 *   q(s) = sum_i H_i(u) q_i + h K_i(u) t_i,   u = (s - c) / h,   error q^(8) (4 h^4)^2 / 8!  at c
 *   H_i = (1 - 2 l_i'(x_i) (u - x_i)) l_i^2,  K_i = (u - x_i) l_i^2,   l_i Lagrange's polynomials */
#include "continuation/node_curve.h"

#include "base/number/vectors.h"
#include "kinematics/loop_equations.h"

#include <string.h>

/* Weights of the nodes' configurations and of their tangents times h. */
typedef struct hermite_weights {
  double value[KM_CURVE_NODES], tangent[KM_CURVE_NODES];
} hermite_weights;

bool km_node_curve_reserve(km_node_curve *curve, int columns, km_arena *arena) {
  curve->base = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *(size_t)columns);
  for (int i = 0; i < KM_CURVE_NODES; ++i) {
    curve->configuration[i] = KM_ARENA_NEW(arena, double, KM_SAVED_PER_COLUMN *(size_t)columns);
    curve->tangent[i] = KM_ARENA_NEW(arena, double, (size_t)columns);
  }
  return !arena->failed;
}

void km_node_curve_record(km_node_curve *curve, const km_continuation *c, int i, const double *t) {
  const km_substructure *sub = km_continuation_sub(c);
  km_state_save(c->state, sub, curve->configuration[i]);
  memcpy(curve->tangent[i], t, (size_t)sub->columns * sizeof *t);
}

/* l_i(u), its derivative, and l_i'(x_i). */
static void evaluate_lagrange(int i, double u, double *l, double *slope, double *slope_at_node) {
  *l = 1.0;
  *slope = *slope_at_node = 0.0;
  for (int j = 0; j < KM_CURVE_NODES; ++j)
    if (j != i) {
      double width = km_node_place[i] - km_node_place[j], factor = (u - km_node_place[j]) / width;
      *slope = *slope * factor + *l / width;
      *l *= factor;
      *slope_at_node += 1.0 / width;
    }
}

/* Computes the weights of q and of dq/du at u. */
static void compute_hermite_weights(double u, hermite_weights *value, hermite_weights *derivative) {
  for (int i = 0; i < KM_CURVE_NODES; ++i) {
    double l, slope, slope_at_node, distance = u - km_node_place[i];
    evaluate_lagrange(i, u, &l, &slope, &slope_at_node);
    value->value[i] = (1.0 - 2.0 * slope_at_node * distance) * l * l;
    value->tangent[i] = distance * l * l;
    derivative->value[i] = -2.0 * slope_at_node * l * l + 2.0 * (1.0 - 2.0 * slope_at_node * distance) * l * slope;
    derivative->tangent[i] = l * l + 2.0 * distance * l * slope;
  }
}

/* Computes sum_i of the weights times q_i - q and h t_i, q the saved configuration `base`. The state is overwritten. */
static void combine_nodes(const km_node_curve *curve, km_continuation *c, const hermite_weights *w, const double *base,
                          double *sum) {
  const km_substructure *sub = km_continuation_sub(c);
  const km_mechanism *m = c->mechanism;
  double *move = c->work;
  memset(sum, 0, (size_t)sub->columns * sizeof *sum);
  for (int i = 0; i < KM_CURVE_NODES; ++i) {
    km_state_restore(c->state, sub, curve->configuration[i]);
    km_state_difference(c->state, sub, base, move);
    for (int k = 0; k < sub->columns; ++k) {
      const double *t = curve->tangent[i] + k;
      int a = m->column_coordinate[sub->column_start + k];
      if (m->ball_of[a] < 0) {
        sum[k] += w->value[i] * move[k] + w->tangent[i] * curve->h * *t;
        continue;
      }
      km_vec3 rate = km_rotation_vector_rate(km_vec3_from_array(move + k), km_vec3_from_array(t));
      const double rates[3] = {rate.x, rate.y, rate.z};
      for (int axis = 0; axis < 3; ++axis)
        sum[k + axis] += w->value[i] * move[k + axis] + w->tangent[i] * curve->h * rates[axis];
      k += 2;
    }
  }
}

void km_node_curve_place(const km_node_curve *curve, km_continuation *c, double s) {
  const km_substructure *sub = km_continuation_sub(c);
  hermite_weights value, derivative;
  compute_hermite_weights((s - curve->c) / curve->h, &value, &derivative);
  combine_nodes(curve, c, &value, curve->configuration[0], c->move);
  km_state_restore(c->state, sub, curve->configuration[0]);
  km_state_move(c->mechanism, c->state, sub, c->move);
  km_loops_update(c->mechanism, c->state, sub);
}

void km_node_curve_tangent(const km_node_curve *curve, km_continuation *c, double s, double *t) {
  const km_substructure *sub = km_continuation_sub(c);
  hermite_weights value, derivative;
  compute_hermite_weights((s - curve->c) / curve->h, &value, &derivative);
  km_state_save(c->state, sub, curve->base);
  combine_nodes(curve, c, &derivative, curve->base, t);
  for (int k = 0; k < sub->columns; ++k)
    t[k] /= curve->h;
  km_state_restore(c->state, sub, curve->base);
  km_loops_update(c->mechanism, c->state, sub);
}

double km_node_curve_highest_coefficient(const km_node_curve *curve, km_continuation *c) {
  hermite_weights w;
  for (int i = 0; i < KM_CURVE_NODES; ++i) {
    double leading = 1.0, slope_at_node = 0.0;
    for (int j = 0; j < KM_CURVE_NODES; ++j)
      if (j != i) {
        leading /= km_node_place[i] - km_node_place[j];
        slope_at_node += 1.0 / (km_node_place[i] - km_node_place[j]);
      }
    w.value[i] = -2.0 * slope_at_node * leading * leading;
    w.tangent[i] = leading * leading;
  }
  combine_nodes(curve, c, &w, curve->configuration[0], c->move);
  return km_max_norm(c->move, km_continuation_sub(c)->columns);
}

double km_node_curve_root(const double value[KM_CURVE_NODES], double u) {
  enum { ITERATIONS = 20 };
  for (int pass = 0; pass < ITERATIONS; ++pass) {
    double sum = 0.0, slope = 0.0;
    for (int i = 0; i < KM_CURVE_NODES; ++i) {
      double l, l_slope, unused;
      evaluate_lagrange(i, u, &l, &l_slope, &unused);
      sum += value[i] * l;
      slope += value[i] * l_slope;
    }
    u -= sum / slope;
  }
  return u;
}
