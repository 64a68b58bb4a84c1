/* Lie algebras of rigid motions, of known dimension, in random frames. */
#include "support/support.h"

#include "topology/motion_space.h"

static km_pose random_pose(randomness *r) {
  km_vec3 v = {uniform(r, -2, 2), uniform(r, -2, 2), uniform(r, -2, 2)};
  return (km_pose){km_quaternion_rotation(km_quaternion_exp(v)),
                   {uniform(r, -2, 2), uniform(r, -2, 2), uniform(r, -2, 2)}};
}

static km_vec3 unit(randomness *r) {
  km_vec3 v = {uniform(r, -1, 1), uniform(r, -1, 1), uniform(r, -1, 1)};
  return km_vec3_scale(1.0 / km_vec3_norm(v), v);
}

static void check(const km_twist *twists, int count, int dimension, randomness *r) {
  for (int trial = 0; trial < 20; ++trial) {
    km_pose X = trial ? random_pose(r) : km_pose_identity();
    km_twist moved[8];
    for (int i = 0; i < count; ++i)
      moved[i] = km_twist_transform(&X, twists[i]);
    km_motion_space space;
    km_motion_space_close(moved, count, 6, 3e-8, &space);
    assert_int_equal(space.dimension, dimension);
  }
}

static void known_dimensions(void **state) {
  (void)state;
  randomness r = {3};
  const km_vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1}, o = {0, 0, 0}, a = {1, 2, 0}, b = {-1, 0.5, 0};
  km_twist hinge = km_twist_revolute(z, o), slide = km_twist_prismatic(z);
  check((km_twist[]){hinge}, 1, 1, &r);
  check((km_twist[]){hinge, hinge}, 2, 1, &r);
  check((km_twist[]){hinge, slide}, 2, 2, &r); /* cylindrical */
  km_twist screw = {{0, 0, 0.1}, z};
  check((km_twist[]){hinge, screw}, 2, 2, &r); /* a screw press */
  check((km_twist[]){km_twist_prismatic(x), km_twist_prismatic(y)}, 2, 2, &r);
  check((km_twist[]){hinge, km_twist_revolute(z, a), km_twist_revolute(z, b)}, 3, 3, &r); /* planar */
  check((km_twist[]){hinge, km_twist_prismatic(x)}, 2, 3, &r);
  check((km_twist[]){hinge, km_twist_revolute(x, o)}, 2, 3, &r); /* spherical */
  check((km_twist[]){slide, km_twist_prismatic(x), km_twist_prismatic(y)}, 3, 3, &r);
  check((km_twist[]){hinge, km_twist_revolute(z, a), slide}, 3, 4, &r); /* Schönflies */
  check((km_twist[]){screw, km_twist_revolute(z, a)}, 2, 4, &r);
  check((km_twist[]){hinge, km_twist_revolute(z, a), km_twist_revolute(x, o), km_twist_revolute(x, a)}, 4, 6, &r);
  for (int i = 0; i < 100; ++i)
    check((km_twist[]){km_twist_revolute(unit(&r), unit(&r)), km_twist_revolute(unit(&r), unit(&r))}, 2, 6, &r);
}

/* The chosen rows determine the motion: no twist of the space vanishes on them. */
static void rows_are_independent(void **state) {
  (void)state;
  randomness r = {5};
  for (int i = 0; i < 200; ++i) {
    km_pose X = random_pose(&r);
    km_twist twists[2] = {km_twist_revolute((km_vec3){0, 0, 1}, (km_vec3){0, 0, 0}),
                          i % 2 ? km_twist_prismatic((km_vec3){1, 0, 0})
                                : km_twist_revolute((km_vec3){1, 0, 0}, (km_vec3){0, 0, 0})};
    for (int k = 0; k < 2; ++k)
      twists[k] = km_twist_transform(&X, twists[k]);
    km_motion_space space;
    km_motion_space_close(twists, 2, 6, 3e-8, &space);
    assert_int_equal(space.dimension, 3);
    double m[3][3];
    for (int k = 0; k < 3; ++k) {
      const km_twist *t = &space.basis[k];
      const double rows[6] = {t->v.x, t->v.y, t->v.z, t->w.x, t->w.y, t->w.z};
      for (int j = 0; j < 3; ++j)
        m[j][k] = rows[space.rows[j]];
    }
    double det = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                 m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
    assert_true(fabs(det) > 0.02);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(known_dimensions), cmocka_unit_test(rows_are_independent)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
