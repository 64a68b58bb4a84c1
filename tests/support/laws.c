/* Laws that hold at every closed pose, each against equations of its own. */
#include "support/laws.h"
#include "linalg/factor_private.h"

#include "kinematics/body_poses.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "mobility/mobility_numbers.h"

#include <string.h>

/* Central differences with h = 1e-5 err by h²·|e'''|/6 ≈ 2e-11·(a few) and by 1e-16/h = 1e-11. */
void law_jacobian(fixture *f, randomness *r) {
  (void)r;
  const km_mechanism *m = f->mechanism;
  const double h = 1e-5;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    size_t rows = (size_t)sub->rows, columns = (size_t)sub->columns;
    km_loops_update(m, f->state, sub);
    double *J = KM_NEW(double, rows *columns), *saved = KM_NEW(double, 3 * columns), *step = KM_NEW(double, columns);
    double *plus = KM_NEW(double, rows);
    km_state_jacobian_dense(f->state, sub, J);
    km_state_save(f->state, sub, saved);
    for (size_t c = 0; c < columns; ++c) {
      memset(step, 0, columns * sizeof *step);
      step[c] = h;
      km_state_move(m, f->state, sub, step);
      km_loops_update(m, f->state, sub);
      memcpy(plus, km_state_error(f->state, sub), rows * sizeof *plus);
      km_state_restore(f->state, sub, saved);
      step[c] = -h;
      km_state_move(m, f->state, sub, step);
      km_loops_update(m, f->state, sub);
      for (size_t i = 0; i < rows; ++i)
        assert_near((plus[i] - km_state_error(f->state, sub)[i]) / (2 * h), J[c * rows + i], 1e-9);
      km_state_restore(f->state, sub, saved);
    }
    km_free(J);
    km_free(saved);
    km_free(step);
    km_free(plus);
  }
}

/* Γ(a) b, by the pattern of the Jacobian. */
static void apply_slopes(const km_substructure *sub, const double *slopes, const double *b, double *out) {
  memset(out, 0, (size_t)sub->rows * sizeof *out);
  for (int c = 0; c < sub->columns; ++c)
    for (int r = 0, i = c * sub->rows; !sub->pattern.start && r < sub->rows; ++r, ++i)
      out[r] += slopes[i] * b[c];
  for (int c = 0; c < sub->columns && sub->pattern.start; ++c)
    for (int i = sub->pattern.start[c]; i < sub->pattern.start[c + 1]; ++i)
      out[sub->pattern.row[i]] += slopes[i] * b[c];
}

/* γ is a square: Γ(a) b = γ(a + b) − γ(a) − γ(b), Γ = ∂γ/∂x by the scaled rates x. */
void law_slopes(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    size_t rows = (size_t)sub->rows, columns = (size_t)sub->columns;
    double *x = KM_NEW(double, 2 * columns), *rate = KM_NEW(double, (size_t)m->coordinate_count);
    double *gamma = KM_NEW(double, 3 * rows + 1), *slopes = KM_NEW(double, sub->pattern.size + 1);
    double *polar = KM_NEW(double, rows + 1), largest = 0.0;
    km_loops_update(m, f->state, sub);
    for (size_t c = 0; c < 2 * columns; ++c)
      x[c] = uniform(r, -1.0, 1.0);
    for (int n = 0; n < 3; ++n) {
      for (size_t c = 0; c < columns; ++c) {
        int k = m->column_coordinate[(size_t)sub->column_start + c];
        rate[k] = m->unit[k] * (n == 0 ? x[c] : n == 1 ? x[columns + c] : x[c] + x[columns + c]);
      }
      km_loops_velocity_products(m, f->state, sub, rate, gamma + (size_t)n * rows);
      if (n == 0)
        km_loops_velocity_slopes(m, f->state, sub, rate, slopes);
    }
    apply_slopes(sub, slopes, x + columns, polar);
    for (size_t i = 0; i < 3 * rows; ++i)
      largest = fmax(largest, fabs(gamma[i]));
    for (size_t i = 0; i < rows; ++i)
      assert_near(polar[i], gamma[2 * rows + i] - gamma[i] - gamma[rows + i], 1e-12 * (1.0 + largest));
    km_free(x);
    km_free(rate);
    km_free(gamma);
    km_free(slopes);
    km_free(polar);
  }
}

/* J N = 0 for the whole six-row Jacobian, which also shows that the dropped rows were dependent. */
void law_null_space(fixture *f, randomness *r) {
  (void)r;
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  km_mobility_compute(m, f->state, &mobility);
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    const km_factor *p = f->state->factor[s];
    const double *Z = km_state_basis(f->state, s), *weight = m->column_weight + sub->column_start;
    int rows;
    double *J = whole_jacobian(f, s, &rows);
    for (int k = 0; k < km_factor_freedom(p); ++k) {
      for (int i = 0; i < rows; ++i) {
        double sum = 0.0;
        for (int c = 0; c < sub->columns; ++c)
          sum += J[c * rows + i] * Z[k * sub->columns + c] / weight[c];
        assert_near(sum, 0.0, 1e-12 * fmax(1.0, 1.0 / weight[0]));
      }
    }
    km_free(J);
  }
}

void law_numbers(fixture *f, randomness *r) {
  (void)r;
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  km_mobility_compute(m, f->state, &mobility);
  double sum = 0.0;
  for (int c = 0; c < m->coordinate_count; ++c) {
    assert_true(f->state->mobility_number[c] >= 0.0 && f->state->mobility_number[c] <= 1.0 + 1e-12);
    sum += f->state->mobility_number[c];
  }
  assert_near(sum, mobility.mobility, 1e-12 * (1 + m->coordinate_count));
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    double *numbers = KM_NEW(double, (size_t)sub->columns);
    assert_near(km_factor_rank(f->state->factor[s]), numbers_by_svd(f, s, numbers), 0.0);
    for (int k = 0; k < sub->columns; ++k)
      assert_near(f->state->mobility_number[m->column_coordinate[sub->column_start + k]], numbers[k], 1e-10);
    km_free(numbers);
  }
}

/* Rates that the loops allow, of which the driver's is 1, at right angles to all motions that leave it alone. */
static void assert_least_rates(fixture *f, int s, int driver) {
  const km_mechanism *m = f->mechanism;
  const km_substructure *sub = &m->substructures[s];
  const double *weight = m->column_weight + sub->column_start;
  size_t n = (size_t)sub->columns, rows = (size_t)sub->rows;
  double *t = KM_NEW(double, n), *J = KM_NEW(double, n *rows);
  km_minimum_norm_rates(m, f->state, s, driver, t);
  assert_near(t[driver], 1.0, 1e-12);
  double length = km_step_length(m, sub, t);
  km_state_jacobian_dense(f->state, sub, J);
  for (size_t i = 0; i < rows; ++i) {
    double sum = 0.0;
    for (size_t k = 0; k < n; ++k)
      sum += J[k * rows + i] * t[k];
    assert_near(sum / length, 0.0, 1e-9);
  }
  const double *Z = km_factor_null_space(f->state->factor[s], km_factor_freedom(f->state->factor[s]) - 1);
  for (int i = 0; i < km_factor_freedom(f->state->factor[s]) - 1; ++i) {
    double dot = 0.0;
    for (size_t k = 0; k < n; ++k)
      dot += Z[(size_t)i * n + k] * weight[k] * t[k];
    assert_near(dot / length, 0.0, 1e-9);
  }
  km_free(t);
  km_free(J);
}

/* Mobility numbers don't depend on a driver's column forced independent: they belong to the null space. */
void law_forced(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  for (int s = 0; s < m->topology.substructure_count; ++s) {
    const km_substructure *sub = &m->substructures[s];
    km_mobility_compute(m, f->state, &mobility);
    int driver = below(r, sub->columns);
    double *free_numbers = KM_NEW(double, (size_t)sub->columns);
    for (int k = 0; k < sub->columns; ++k)
      free_numbers[k] = f->state->mobility_number[m->column_coordinate[sub->column_start + k]];
    km_search_pivots(m, f->state, s, driver, km_rank_tolerance(m, sub, 0.0));
    if (!km_factor_has_forced_pivot(f->state->factor[s]))
      assert_least_rates(f, s, driver);
    km_numbers_update(m, f->state, s);
    for (int k = 0; k < sub->columns; ++k)
      assert_near(f->state->mobility_number[m->column_coordinate[sub->column_start + k]], free_numbers[k], 1e-11);
    km_free(free_numbers);
  }
}

/* Moves every coordinate by h times its rate, whether the loops stay closed or not; a ball turns about its parent's
 * axes. */
static void move_all(fixture *f, const double *q, const km_quaternion *balls, const double *rates, double h) {
  const km_mechanism *m = f->mechanism;
  for (int c = 0; c < m->coordinate_count; ++c) {
    int ball = m->ball_of[c];
    bool first = ball >= 0 && (c == 0 || m->ball_of[c - 1] != ball);
    if (ball < 0)
      f->state->q[c] = q[c] + h * rates[c];
    else if (first)
      f->state->ball[ball] = km_quaternion_product(
          km_quaternion_exp((km_vec3){h * rates[c], h * rates[c + 1], h * rates[c + 2]}), balls[ball]);
  }
  km_poses_compute(m, f->state);
}

typedef struct pose_rate {
  km_vec3 p, axis[3];
} pose_rate;

/* Poses of all bodies h ahead less those h behind, over 2 h: of the origin and of the three axes. */
static void differences(fixture *f, const double *q, const km_quaternion *balls, const double *rates, double h,
                        pose_rate *out) {
  size_t bodies = (size_t)f->mechanism->topology.body_count;
  km_pose *ahead = KM_NEW(km_pose, bodies);
  move_all(f, q, balls, rates, h);
  memcpy(ahead, f->state->pose, bodies * sizeof *ahead);
  move_all(f, q, balls, rates, -h);
  for (size_t b = 0; b < bodies; ++b) {
    const km_pose *behind = &f->state->pose[b];
    out[b].p = km_vec3_scale(0.5 / h, km_vec3_sub(ahead[b].p, behind->p));
    for (int k = 0; k < 3; ++k)
      out[b].axis[k] = km_vec3_scale(0.5 / h, km_vec3_sub(ahead[b].R.axis[k], behind->R.axis[k]));
  }
  km_free(ahead);
}

static void check_rate(km_vec3 near, km_vec3 far, km_vec3 want, double rounding) {
  km_vec3 change = km_vec3_sub(far, near), off = km_vec3_sub(near, want);
  assert_at_most(km_vec3_norm(off), km_vec3_norm(change) + rounding);
}

/* Body twists from the joints' rates against finite differences of the poses along the tree, at any rates. The error of
 * a central difference is a third of its change when h doubles; rounding of places is divided by h. */
int judge_twists(fixture *f, randomness *r) {
  const km_mechanism *m = f->mechanism;
  const double h = 1e-5;
  size_t coordinates = (size_t)m->coordinate_count, bodies = (size_t)m->topology.body_count;
  double *rates = KM_NEW(double, coordinates), *q = KM_NEW(double, coordinates);
  km_quaternion *balls = KM_NEW(km_quaternion, coordinates);
  km_pose *poses = KM_NEW(km_pose, bodies);
  pose_rate *near = KM_NEW(pose_rate, bodies), *far = KM_NEW(pose_rate, bodies);
  int moving = 0;
  for (size_t c = 0; c < coordinates; ++c) {
    rates[c] = uniform(r, -1.0, 1.0) * m->unit[c];
    q[c] = f->state->q[c];
    if (m->ball_of[c] >= 0)
      balls[m->ball_of[c]] = f->state->ball[m->ball_of[c]];
  }
  km_poses_compute(m, f->state);
  memcpy(poses, f->state->pose, bodies * sizeof *poses);
  differences(f, q, balls, rates, h, near);
  differences(f, q, balls, rates, 2.0 * h, far);
  move_all(f, q, balls, rates, 0.0);
  for (size_t b = 1; b < bodies; ++b) {
    km_twist t = km_body_twist(m, f->state, (int)b, rates);
    double size = km_vec3_norm(poses[b].p) + km_vec3_norm(t.v) + m->length;
    check_rate(near[b].p, far[b].p, km_vec3_add(t.v, km_vec3_cross(t.w, poses[b].p)), 1e-9 * size);
    for (int k = 0; k < 3; ++k)
      check_rate(near[b].axis[k], far[b].axis[k], km_vec3_cross(t.w, poses[b].R.axis[k]), 1e-9);
    moving += km_vec3_norm(t.v) > 0.0 || km_vec3_norm(t.w) > 0.0;
  }
  km_free(rates);
  km_free(q);
  km_free(balls);
  km_free(poses);
  km_free(near);
  km_free(far);
  return moving;
}

void law_twists(fixture *f, randomness *r) {
  judge_twists(f, r);
}
