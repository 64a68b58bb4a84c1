/* A mechanism moved by hand: pulls keep the loops closed, their branch and the limits, and end where other ways
 * lead. */
#include "support/support.h"

#include "kinematics/loop_equations.h"
#include "kmech/continuation.h"
#include "kmech/mechanism.h"
#include "model/model.h"

#include <string.h>

static const char *const models[] = {"excavator", "fourbar",      "slider_crank", "klann",        "bricard",
                                     "bennett",   "stewart",      "panda",        "brake",        "sarrus3",
                                     "rssr",      "scissor_lift", "delta",        "toggle_press", NULL};

typedef struct held {
  fixture f;
  km_manipulation *hand;
} held;

static held take_hold(const char *name) {
  held h = {.f = fixture_open(name)};
  km_mobility mobility;
  km_error error;
  km_mobility_compute(h.f.mechanism, h.f.state, &mobility);
  km_poses_compute(h.f.mechanism, h.f.state);
  assert_int_equal(km_manipulation_create(h.f.mechanism, h.f.state, &h.hand, &error), KM_OK);
  return h;
}

static void let_go(held *h) {
  km_manipulation_free(h->hand);
  fixture_close(&h->f);
}

/* The worst loop error, by the Jacobians and errors made anew. */
static double opened(const fixture *f) {
  double worst = 0.0;
  for (int i = 0; i < f->mechanism->topology.substructure_count; ++i) {
    km_loops_update(f->mechanism, f->state, &f->mechanism->substructures[i]);
    worst = fmax(worst, km_loops_residual(f->mechanism, f->state, &f->mechanism->substructures[i]));
  }
  return worst;
}

static void is_within_limits(const fixture *f) {
  for (int c = 0; c < f->model->coordinate_count; ++c) {
    double low, high, q = km_state_coordinate(f->state, c);
    km_model_coordinate_limits(f->model, c, &low, &high);
    assert_true(q >= low - 1e-9 * (1.0 + fabs(low)) && q <= high + 1e-9 * (1.0 + fabs(high)));
  }
}

/* The way of the whole mechanism between two poses, √Σ (D δq)²; balls by their rotation vectors. */
static double way(const fixture *f, const double *from) {
  double square = 0.0;
  for (int c = 0; c < f->model->coordinate_count; ++c) {
    double step = (f->state->q[c] - from[c]) * f->mechanism->scale[c];
    if (f->mechanism->ball_of[c] < 0)
      square += step * step;
  }
  return sqrt(square);
}

static km_manipulation_point grip_of(const fixture *f, randomness *r) {
  km_manipulation_point grip = {.body = 1 + below(r, f->model->body_count - 1)};
  for (int k = 0; k < 3; ++k)
    grip.point[k] = uniform(r, -0.5, 0.5) * f->mechanism->length;
  return grip;
}

static void aim(const fixture *f, km_manipulation_point *grip, randomness *r, double far) {
  km_vec3 at = km_pose_point(&f->state->pose[grip->body], km_vec3_from_array(grip->point));
  const double p[3] = {at.x, at.y, at.z};
  for (int k = 0; k < 3; ++k)
    grip->target[k] = p[k] + uniform(r, -far, far) * f->mechanism->length;
}

/* Points pulled anywhere, mostly out of reach: loops stay closed, limits hold, no call goes further than it may, and
 * mobility numbers are those of a fresh search. */
static void points_keep_the_loops(void **state) {
  (void)state;
  enum { PULLS = 150 };
  for (const char *const *name = models; *name; ++name) {
    held h = take_hold(*name);
    randomness r = {7};
    double *from = km_alloc((size_t)h.f.model->coordinate_count, sizeof *from);
    double *numbers = km_alloc((size_t)h.f.model->coordinate_count, sizeof *numbers);
    km_manipulation_point grip = {0};
    for (int i = 0; i < PULLS; ++i) {
      km_manipulation_step move;
      km_error error;
      km_mobility mobility;
      if (i % 10 == 0)
        grip = grip_of(&h.f, &r);
      if (i % 5 == 0)
        aim(&h.f, &grip, &r, i % 3 ? 0.2 : 3.0);
      memcpy(from, h.f.state->q, (size_t)h.f.model->coordinate_count * sizeof *from);
      assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.1, &move, &error), KM_OK);
      assert_true(opened(&h.f) <= 1e-11);
      assert_true(i == 0 || way(&h.f, from) <= 0.14); /* the first one may leave a branch point */
      is_within_limits(&h.f);
      for (int c = 0; c < h.f.model->coordinate_count; ++c)
        numbers[c] = km_mobility_number(h.f.state, c);
      km_mobility_compute(h.f.mechanism, h.f.state, &mobility);
      for (int c = 0; c < h.f.model->coordinate_count; ++c)
        assert_near(numbers[c], km_mobility_number(h.f.state, c), 1e-9);
    }
    km_free(from);
    km_free(numbers);
    let_go(&h);
  }
}

/* Where a pull says that no motion brings the point any nearer, pulling again doesn't bring it nearer by more than a
 * step that counts as none, but for slow convergence to the nearest point; and a pull that has used up its way
 * doesn't say so. */
static void nearest_points_are_nearest(void **state) {
  (void)state;
  int judged = 0;
  for (const char *const *name = models; *name; ++name) {
    held h = take_hold(*name);
    randomness r = {11};
    for (int i = 0; i < 25; ++i) {
      km_manipulation_step move = {0}, again;
      km_error error;
      km_manipulation_point grip = grip_of(&h.f, &r);
      aim(&h.f, &grip, &r, i % 3 ? 0.3 : 2.0);
      for (int k = 0; k < 400 && move.stop == KM_MANIPULATION_FREE && !move.is_reached; ++k)
        assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.35, &move, &error), KM_OK);
      if (move.stop != KM_MANIPULATION_NEAREST || move.is_reached)
        continue;
      assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.35, &again, &error), KM_OK);
      assert_true(again.remaining >= move.remaining - 1e-4 * h.f.mechanism->length);
      judged++;
    }
    let_go(&h);
  }
  assert_true(judged > 50);
}

/* A target that the mechanism has reached another way is reached, and the point is there. */
static void reachable_points_are_reached(void **state) {
  (void)state;
  static const char *const names[] = {"excavator", "panda", "fourbar", "klann", "stewart", NULL};
  for (const char *const *name = names; *name; ++name) {
    held h = take_hold(*name);
    fixture other = fixture_open(*name);
    randomness r = {3};
    for (int i = 0; i < 10; ++i) {
      km_manipulation *elsewhere;
      km_manipulation_step move = {0};
      km_error error;
      km_manipulation_point grip = grip_of(&h.f, &r);
      km_mobility mobility;
      memcpy(other.state->q, h.f.state->q, (size_t)h.f.model->coordinate_count * sizeof(double));
      km_state_set(other.mechanism, other.state, other.state->q);
      km_mobility_compute(other.mechanism, other.state, &mobility);
      km_poses_compute(other.mechanism, other.state);
      assert_int_equal(km_manipulation_create(other.mechanism, other.state, &elsewhere, &error), KM_OK);
      km_manipulation_point away = grip;
      aim(&other, &away, &r, 0.15);
      for (int k = 0; k < 5; ++k)
        assert_int_equal(km_manipulation_pull_point(elsewhere, &away, 0.05, &move, &error), KM_OK);
      km_manipulation_free(elsewhere);
      km_vec3 goal = km_pose_point(&other.state->pose[grip.body], km_vec3_from_array(grip.point));
      memcpy(grip.target, (const double[]){goal.x, goal.y, goal.z}, sizeof grip.target);
      move.is_reached = false;
      for (int k = 0; k < 60 && !move.is_reached; ++k)
        assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.2, &move, &error), KM_OK);
      km_vec3 at = km_pose_point(&h.f.state->pose[grip.body], km_vec3_from_array(grip.point));
      assert_true(km_vec3_norm(km_vec3_sub(at, goal)) <= 1e-6 * h.f.mechanism->length);
    }
    fixture_close(&other);
    let_go(&h);
  }
}

/* Joints pulled step by step end at the pose that a drive reaches in one go. */
static void joints_end_where_drives_do(void **state) {
  (void)state;
  static const struct {
    const char *model, *joint;
    double to;
  } cases[] = {{"excavator", "L", 2.0},
               {"excavator", "O", 2.4},
               {"fourbar", "A", 5.0},
               {"klann", "A", 7.0},
               {"brake", "K", 27.0}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    held h = take_hold(cases[i].model);
    km_error error;
    km_hold goal = {.value = cases[i].to};
    assert_int_equal(km_model_find_coordinate(h.f.model, cases[i].joint, &goal.coordinate, &error), KM_OK);
    km_manipulation_step move = {0};
    double *from = km_alloc((size_t)h.f.model->coordinate_count, sizeof *from);
    int calls = 0;
    for (; calls < 2000 && !move.is_reached; ++calls) {
      memcpy(from, h.f.state->q, (size_t)h.f.model->coordinate_count * sizeof *from);
      assert_int_equal(km_manipulation_pull_joint(h.hand, goal.coordinate, goal.value, 0.1, &move, &error), KM_OK);
      assert_true(way(&h.f, from) <= 0.2);
      assert_true(opened(&h.f) <= 1e-11);
    }
    assert_true(calls > 3 && move.is_reached);
    fixture other = fixture_open(cases[i].model);
    assert_int_equal(km_state_move_to(other.mechanism, other.state, &goal, 1, &error), KM_OK);
    for (int c = 0; c < h.f.model->coordinate_count; ++c)
      assert_near(h.f.state->q[c], other.state->q[c], 1e-8 * (1.0 + fabs(other.state->q[c])));
    km_free(from);
    fixture_close(&other);
    let_go(&h);
  }
}

static int coordinate_of(const fixture *f, const char *label) {
  int coordinate = -1;
  km_error error;
  assert_int_equal(km_model_find_coordinate(f->model, label, &coordinate, &error), KM_OK);
  return coordinate;
}

static km_manipulation_step pull_on(held *h, int coordinate, double target, int calls) {
  km_manipulation_step move = {0};
  km_error error;
  for (int i = 0; i < calls; ++i)
    assert_int_equal(km_manipulation_pull_joint(h->hand, coordinate, target, 0.1, &move, &error), KM_OK);
  return move;
}

/* The slider of a slider-crank (crank ½, rod 1) ends at 1.5, where its number is 0; the crank then carries it on,
 * and the slider leads back. */
static void toggles_stop_softly(void **state) {
  (void)state;
  held h = take_hold("slider_crank");
  int slider = coordinate_of(&h.f, "B"), crank = coordinate_of(&h.f, "A");
  double end = 0.0, before;
  km_manipulation_step move = pull_on(&h, slider, 100.0, 200);
  assert_int_equal(move.stop, KM_MANIPULATION_TOGGLE);
  assert_int_equal(move.coordinate, slider);
  end = km_state_coordinate(h.f.state, slider);
  assert_near(km_mobility_number(h.f.state, slider), 0.0, 1e-9);
  before = km_state_coordinate(h.f.state, crank);
  move = pull_on(&h, crank, before + 1.0, 100);
  assert_true(move.is_reached && km_state_coordinate(h.f.state, slider) < end);
  move = pull_on(&h, slider, end - 0.3, 200);
  assert_true(move.is_reached);
  assert_near(km_state_coordinate(h.f.state, slider), end - 0.3, 1e-12);
  let_go(&h);
}

/* The excavator's cylinders end at their stated limits, by whichever joint or point they are driven. */
static void limits_are_named(void **state) {
  (void)state;
  held h = take_hold("excavator");
  int boom = coordinate_of(&h.f, "C"), left = coordinate_of(&h.f, "L"), right = coordinate_of(&h.f, "M");
  double low, high;
  km_model_coordinate_limits(h.f.model, left, &low, &high);
  km_manipulation_step move = pull_on(&h, boom, 3.0, 400);
  assert_int_equal(move.stop, KM_MANIPULATION_LIMIT);
  assert_true(move.coordinate == left || move.coordinate == right);
  assert_near(km_state_coordinate(h.f.state, left), high, 1e-9);
  km_manipulation_point grip = {.body = 3, .point = {5.7, 0, 0}, .target = {3, 0, -20}};
  km_error error;
  for (int i = 0; i < 400; ++i)
    assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.1, &move, &error), KM_OK);
  assert_int_equal(move.stop, KM_MANIPULATION_LIMIT);
  assert_true(move.coordinate == left || move.coordinate == right);
  assert_near(km_state_coordinate(h.f.state, left), low, 1e-6);
  let_go(&h);
}

/* A ball whose angle is limited as a whole is turned and pulled up to its limit, and no further. */
static void balls_keep_their_limit(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}], "
      "\"joints\": [{\"name\": \"S\", \"type\": \"spherical\", \"limits\": [0, 0.5], \"body_frame_pairs\": "
      "[[\"fixed\", \"origin\"], [\"b\", \"origin\"]]}]}]}");
  km_manipulation *hand;
  km_mobility mobility;
  km_error error;
  km_manipulation_step move = {0};
  km_mobility_compute(f.mechanism, f.state, &mobility);
  km_poses_compute(f.mechanism, f.state);
  assert_int_equal(km_manipulation_create(f.mechanism, f.state, &hand, &error), KM_OK);
  for (int i = 0; i < 40; ++i)
    assert_int_equal(km_manipulation_pull_joint(hand, 2, 2.0, 0.1, &move, &error), KM_OK);
  assert_int_equal(move.stop, KM_MANIPULATION_LIMIT);
  assert_near(km_state_coordinate(f.state, 2), 0.5, 1e-12);
  km_manipulation_point grip = {.body = 1, .point = {1, 0, 0}, .target = {0, 0, 5}};
  for (int i = 0; i < 60; ++i) {
    assert_int_equal(km_manipulation_pull_point(hand, &grip, 0.1, &move, &error), KM_OK);
    km_vec3 q = km_vec3_from_array(f.state->q);
    assert_true(km_vec3_norm(q) <= 0.5 + 1e-9);
  }
  assert_int_equal(move.stop, KM_MANIPULATION_LIMIT);
  km_manipulation_free(hand);
  fixture_close(&f);
}

static void misuse_is_refused(void **state) {
  (void)state;
  held h = take_hold("excavator");
  km_manipulation_step move;
  km_error error;
  km_manipulation_point grip = {.body = 1};
  assert_int_equal(km_manipulation_pull_joint(h.hand, 0, (double)NAN, 0.1, &move, &error), KM_USAGE);
  assert_int_equal(km_manipulation_pull_joint(h.hand, 0, 0.0, 0.0, &move, &error), KM_USAGE);
  assert_int_equal(km_manipulation_pull_joint(h.hand, 999, 0.0, 0.1, &move, &error), KM_USAGE);
  assert_int_equal(km_manipulation_pull_point(h.hand, &grip, (double)NAN, &move, &error), KM_USAGE);
  grip.target[1] = HUGE_VAL;
  assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.1, &move, &error), KM_USAGE);
  grip = (km_manipulation_point){.body = 99};
  assert_int_equal(km_manipulation_pull_point(h.hand, &grip, 0.1, &move, &error), KM_USAGE);
  assert_string_equal(km_manipulation_stop_name(KM_MANIPULATION_TOGGLE), "toggle");
  assert_string_equal(km_manipulation_stop_name((km_manipulation_stop)99), "");
  let_go(&h);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nearest_points_are_nearest),
      cmocka_unit_test(points_keep_the_loops),
      cmocka_unit_test(reachable_points_are_reached),
      cmocka_unit_test(joints_end_where_drives_do),
      cmocka_unit_test(toggles_stop_softly),
      cmocka_unit_test(limits_are_named),
      cmocka_unit_test(misuse_is_refused),
      cmocka_unit_test(balls_keep_their_limit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
