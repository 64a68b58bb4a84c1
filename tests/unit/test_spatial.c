/* Rotations, poses and twists: exponentials, logarithms, adjoints. */
#include "support/support.h"

#include "spatial/twist.h"

static km_vec3 random_vector(randomness *r, double size) {
  return (km_vec3){uniform(r, -size, size), uniform(r, -size, size), uniform(r, -size, size)};
}

static void assert_vectors(km_vec3 a, km_vec3 b, double tolerance) {
  assert_near(a.x, b.x, tolerance);
  assert_near(a.y, b.y, tolerance);
  assert_near(a.z, b.z, tolerance);
}

static void quaternions_and_logarithms(void **state) {
  (void)state;
  randomness r = {11};
  for (int i = 0; i < 5000; ++i) {
    km_vec3 v = random_vector(&r, i % 3 ? 1.8 : 1e-6);
    km_quaternion q = km_quaternion_exp(v);
    assert_vectors(km_quaternion_log(q), v, 1e-14 + 1e-15 / fmax(M_PI - km_vec3_norm(v), 1e-2));
    km_rotation R = km_quaternion_rotation(q);
    assert_vectors(km_quaternion_log(km_rotation_quaternion(&R)), v, 1e-13);
    km_vec3 axis = km_vec3_scale(1.0 / km_vec3_norm(v), v);
    km_vec3 wound = km_vec3_scale(km_vec3_norm(v) + 4.0 * M_PI, axis);
    assert_vectors(km_quaternion_log_near(km_quaternion_exp(wound), km_vec3_scale(0.99, wound)), wound, 1e-8);
  }
}

/* Turned step by step, a rotation vector grows past π and past full turns without a jump. */
static void rotation_vectors_are_continuous(void **state) {
  (void)state;
  km_vec3 axis = {0.6, 0.0, 0.8}, last = {0, 0, 0};
  for (int i = 1; i <= 1000; ++i) {
    km_vec3 v = km_quaternion_log_near(km_quaternion_exp(km_vec3_scale(0.02 * i, axis)), last);
    assert_vectors(v, km_vec3_scale(0.02 * i, axis), 1e-9);
    last = v;
  }
}

/* exp of a twist by composing many small displacements, as an independent check of log. */
static void twist_logarithm_is_the_constant_twist(void **state) {
  (void)state;
  randomness r = {13};
  for (int i = 0; i < 50; ++i) {
    km_twist t = {random_vector(&r, 1.0), random_vector(&r, 1.5)};
    enum { PIECES = 1 << 14 };
    km_vec3 dv = km_vec3_scale(1.0 / PIECES, t.v), dw = km_vec3_scale(1.0 / PIECES, t.w);
    /* second order: p = dv + dw × dv / 2 */
    km_pose step = {km_quaternion_rotation(km_quaternion_exp(dw)), km_vec3_axpy(0.5, km_vec3_cross(dw, dv), dv)};
    for (int k = 1; k < PIECES; k *= 2)
      step = km_pose_product(&step, &step);
    km_twist log = km_twist_log(&step);
    assert_vectors(log.v, t.v, 1e-8);
    assert_vectors(log.w, t.w, 1e-9);
  }
}

/* Angles around the limit below which the logarithm is a series: exp by its own series, p = Σ ad(ω)ⁿ v / (n + 1)!,
 * whose seventh term is 1e-22 of the first. */
static void small_turns_have_the_same_logarithm(void **state) {
  (void)state;
  randomness r = {29};
  static const double sizes[] = {1e-9, 1e-5, 0.5e-3, 0.999e-3, 1.001e-3, 2e-3};
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; ++k)
    for (int i = 0; i < 50; ++i) {
      km_vec3 w = random_vector(&r, 1.0), v = random_vector(&r, 1.0), term = v;
      w = km_vec3_scale(sizes[k] / km_vec3_norm(w), w);
      km_pose x = {km_quaternion_rotation(km_quaternion_exp(w)), v};
      double factorial = 1.0;
      for (int n = 1; n < 7; ++n) {
        term = km_vec3_cross(w, term);
        factorial *= n + 1;
        x.p = km_vec3_axpy(1.0 / factorial, term, x.p);
      }
      km_twist log = km_twist_log(&x);
      assert_vectors(log.w, w, 4e-16); /* an entry of R has an error of 2⁻⁵³ */
      assert_vectors(log.v, v, 4e-15); /* |v| is less than 2, and ω × p is of rounding's size */
    }
}

static void adjoint_respects_composition_and_bracket(void **state) {
  (void)state;
  randomness r = {17};
  for (int i = 0; i < 200; ++i) {
    km_pose a = {km_quaternion_rotation(km_quaternion_exp(random_vector(&r, 1))), random_vector(&r, 2)};
    km_pose b = {km_quaternion_rotation(km_quaternion_exp(random_vector(&r, 1))), random_vector(&r, 2)};
    km_twist t = {random_vector(&r, 1), random_vector(&r, 1)}, u = {random_vector(&r, 1), random_vector(&r, 1)};
    km_pose ab = km_pose_product(&a, &b), back = km_pose_inverse(&ab), one = km_pose_product(&ab, &back);
    assert_vectors(one.p, (km_vec3){0, 0, 0}, 1e-14);
    km_twist inner = km_twist_transform(&b, t), twice = km_twist_transform(&a, inner),
             once = km_twist_transform(&ab, t);
    assert_vectors(once.v, twice.v, 1e-13);
    km_twist moved = km_twist_transform(&a, km_twist_bracket(t, u));
    km_twist bracket = km_twist_bracket(km_twist_transform(&a, t), km_twist_transform(&a, u));
    assert_vectors(moved.v, bracket.v, 1e-13);
    assert_vectors(moved.w, bracket.w, 1e-13);
  }
}

/* M = R S with S symmetric and positive has R as its nearest rotation. */
static void the_nearest_rotation_is_the_polar_factor(void **state) {
  (void)state;
  randomness r = {23};
  for (int i = 0; i < 500; ++i) {
    const double size = i % 2 ? 0.3 : 1e-6;
    km_rotation R = km_quaternion_rotation(km_quaternion_exp(random_vector(&r, 2))), M;
    km_vec3 d = random_vector(&r, size), e = random_vector(&r, 0.3 * size);
    const km_vec3 S[3] = {{1.0 + d.x, e.x, e.y}, {e.x, 1.0 + d.y, e.z}, {e.y, e.z, 1.0 + d.z}};
    for (int k = 0; k < 3; ++k)
      M.axis[k] = km_rotate(&R, S[k]);
    km_rotation nearest = km_rotation_nearest(&M);
    assert_true(km_rotation_distance(&nearest, &R) < 4e-15);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(quaternions_and_logarithms),
      cmocka_unit_test(small_turns_have_the_same_logarithm),
      cmocka_unit_test(rotation_vectors_are_continuous),
      cmocka_unit_test(twist_logarithm_is_the_constant_twist),
      cmocka_unit_test(the_nearest_rotation_is_the_polar_factor),
      cmocka_unit_test(adjoint_respects_composition_and_bracket),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
