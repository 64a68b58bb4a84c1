/* A model that is written as a drawing is the same mechanism: bodies, masses, mobility and its motion. */
#include "support/support.h"

#include "support/random_mechanism.h"

#include "base/text.h"
#include "exchange/json/json.h"
#include "kmech/exchange.h"
#include "kmech/mechanism.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The fixture's present pose, drawn and read; an empty one where nothing can be drawn. */
static fixture redrawn(const fixture *a) {
  km_arena arena = {0};
  km_text text = {0};
  const km_value *tree = NULL;
  fixture b = {0};
  double *q = KM_NEW(double, (size_t)a->model->coordinate_count + 1);
  for (int c = 0; c < a->model->coordinate_count; ++c)
    q[c] = km_state_coordinate(a->state, c);
  km_status status = km_model_draw(a->model, &a->model->units, q, NULL, &arena, &tree, NULL);
  assert_true(status == KM_OK || status == KM_NO_RESULT);
  if (status == KM_OK) {
    km_json_write(tree, &text);
    b = fixture_read(text.data);
  }
  km_text_free(&text);
  km_arena_free(&arena);
  km_free(q);
  return b;
}

/* Rounding of a length: that of the farthest point. */
static double size_of(const fixture *f) {
  double size = km_mechanism_characteristic_length(f->mechanism, NULL);
  for (int i = 0; i < f->model->frame_count; ++i) {
    km_frame_pose X;
    assert_int_equal(km_frame_place(f->mechanism, f->state, i, &X, NULL), KM_OK);
    for (int k = 0; k < 3; ++k)
      size = fmax(size, fabs(X.p[k]));
  }
  return size;
}

static void path_of(const km_model *model, int frame, char out[400]) {
  int body = model->frames[frame].body, assembly = model->bodies[body].assembly;
  snprintf(out, 400, "%s/%s/%s", assembly < 0 ? "" : model->assemblies[assembly].name, model->bodies[body].name,
           model->frames[frame].name);
}

static int frame_like(const km_model *model, const char *path) {
  char own[400];
  for (int f = 0; f < model->frame_count; ++f) {
    path_of(model, f, own);
    if (strcmp(own, path) == 0)
      return f;
  }
  return -1;
}

/* A frame that a point of the drawing made: it may be turned about the joint's axis. */
static bool is_made(const km_model *model, int frame) {
  bool made = false;
  for (int j = 0; j < model->joint_count; ++j)
    made = made || ((model->joints[j].frame[0] == frame || model->joints[j].frame[1] == frame) &&
                    strcmp(model->joints[j].name, model->frames[frame].name) == 0);
  return made;
}

/* Frames that both have, but for the bodies' own, stand in one place. Returns how many. */
static int compare_frames(fixture *a, fixture *b, double tolerance) {
  int count = 0;
  double size = size_of(a);
  for (int f = 0; f < a->model->frame_count; ++f) {
    char path[400];
    path_of(a->model, f, path);
    bool origin = strcmp(a->model->frames[f].name, "origin") == 0 && a->model->frames[f].body > 0;
    int twin = origin ? -1 : frame_like(b->model, path);
    km_frame_pose X, Y;
    if (twin < 0)
      continue;
    assert_int_equal(km_frame_place(a->mechanism, a->state, f, &X, NULL), KM_OK);
    assert_int_equal(km_frame_place(b->mechanism, b->state, twin, &Y, NULL), KM_OK);
    for (int k = 0; k < 9 && !is_made(b->model, twin); ++k)
      assert_near(X.R[k], Y.R[k], tolerance);
    for (int k = 0; k < 3; ++k)
      assert_near(X.p[k], Y.p[k], tolerance * size);
    ++count;
  }
  return count;
}

/* Mass, centre of mass and inertia, all as the inertial frame sees them. */
static void compare_masses(const fixture *a, const fixture *b, double tolerance) {
  double size = size_of(a);
  assert_int_equal(a->model->body_count, b->model->body_count);
  for (int i = 1; i < a->model->body_count; ++i) {
    const km_model_body *x = &a->model->bodies[i], *y = &b->model->bodies[i];
    const km_pose *X = &a->state->pose[i], *Y = &b->state->pose[i];
    km_vec3 apart = km_vec3_sub(km_pose_point(X, x->center_of_mass), km_pose_point(Y, y->center_of_mass));
    assert_string_equal(x->name, y->name);
    assert_near(x->mass, y->mass, 0.0);
    assert_near(km_vec3_norm(apart), 0.0, x->mass > 0.0 ? tolerance * size : HUGE_VAL);
    double largest = fabs(x->inertia[0]) + fabs(x->inertia[1]) + fabs(x->inertia[2]);
    for (int k = 0; k < 9; ++k) { /* u · I w for unit vectors of the inertial frame, both by the body's own entries */
      km_vec3 u = km_rotation_identity().axis[k / 3], w = km_rotation_identity().axis[k % 3];
      double value[2];
      for (int side = 0; side < 2; ++side) {
        const double *I = side ? y->inertia : x->inertia;
        km_vec3 p = km_rotate_back(side ? &Y->R : &X->R, u), r = km_rotate_back(side ? &Y->R : &X->R, w);
        value[side] = p.x * (I[0] * r.x + I[3] * r.y + I[5] * r.z) + p.y * (I[3] * r.x + I[1] * r.y + I[4] * r.z) +
                      p.z * (I[5] * r.x + I[4] * r.y + I[2] * r.z);
      }
      assert_near(value[0], value[1], tolerance * largest);
    }
  }
}

/* True if the joint was added by a strut; such joints count from the initial configuration. */
static bool is_part(const fixture *f, int c) {
  return strchr(f->model->coordinates[c].label, ':') != NULL;
}

static void compare_poses(fixture *a, fixture *b, double tolerance) {
  km_mobility x, y;
  km_mobility_compute(a->mechanism, a->state, &x);
  km_mobility_compute(b->mechanism, b->state, &y);
  assert_int_equal(x.mobility, y.mobility);
  assert_int_equal(x.kutzbach, y.kutzbach);
  assert_int_equal(x.kutzbach_extended, y.kutzbach_extended);
  assert_int_equal(x.redundant_constraints, y.redundant_constraints);
  assert_int_equal(a->model->coordinate_count, b->model->coordinate_count);
  km_length_source source;
  double length = km_mechanism_characteristic_length(a->mechanism, &source);
  bool shared = source != KM_LENGTH_JOINTS; /* else it is of the pose where the mechanism was compiled */
  if (shared)
    assert_near(km_mechanism_characteristic_length(b->mechanism, NULL), length, 1e-12 * length);
  for (int c = 0; c < a->model->coordinate_count; ++c) {
    assert_string_equal(a->model->coordinates[c].label, b->model->coordinates[c].label);
    if (!is_part(a, c))
      assert_near(a->state->q[c], b->state->q[c], tolerance * fmax(1.0, fabs(a->state->q[c])));
    if (shared)
      assert_near(km_mobility_number(a->state, c), km_mobility_number(b->state, c), tolerance);
  }
  km_poses_compute(a->mechanism, a->state);
  km_poses_compute(b->mechanism, b->state);
  assert_true(compare_frames(a, b, tolerance) > 0);
}

static void compare(fixture *a, fixture *b, double tolerance) {
  compare_poses(a, b, tolerance);
  compare_masses(a, b, tolerance);
}

/* Compared along the model's default sweep. */
static void compare_motion(fixture *a, fixture *b, double tolerance) {
  enum { STEPS = 24 };
  const km_model_sweep *sweep = &a->model->sweep;
  km_driver_motion *drive[2];
  fixture *side[2] = {a, b};
  if (sweep->coordinate < 0)
    return;
  for (int i = 0; i < 2; ++i)
    assert_int_equal(
        km_driver_motion_create(side[i]->mechanism, side[i]->state, sweep->coordinate, true, &drive[i], NULL), KM_OK);
  for (int step = 0; step <= STEPS; ++step) {
    double goal = sweep->range[0] + (sweep->range[1] - sweep->range[0]) * step / STEPS;
    km_motion_end x = km_driver_motion_move_to(drive[0], goal), y = km_driver_motion_move_to(drive[1], goal);
    assert_int_equal(x.stop, y.stop);
    if (x.stop)
      break;
    compare_poses(a, b, tolerance);
  }
  for (int i = 0; i < 2; ++i)
    km_driver_motion_free(drive[i]);
}

static void shipped_models(void **state) {
  (void)state;
  int drawn = 0, count = 0;
  for (const char *const *name = all_models; *name; ++name, ++count) {
    fixture a = fixture_open(*name), b = redrawn(&a);
    if (b.model) {
      compare(&a, &b, 1e-12);
      compare_motion(&a, &b, 1e-11); /* both close their loops to 1e-12 */
      ++drawn;
      fixture_close(&b);
    }
    fixture_close(&a);
  }
  assert_int_equal(drawn, count);
}

/* Random joints, topologies and poses; and once more, from the drawing. */
static void random_mechanisms(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    fixture a = open_random_mechanism(&r, true);
    fixture b = redrawn(&a);
    compare(&a, &b, 1e-11);
    fixture c = redrawn(&b);
    compare(&b, &c, 1e-12);
    fixture_close(&a);
    fixture_close(&b);
    fixture_close(&c);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(shipped_models), cmocka_unit_test(random_mechanisms)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
