/* Force modules on displacements, velocities and accelerations of joints, frames and angles, against closed forms. */
#include "support/moving.h"

#include "kmech/dynamics.h"
#include "kmech/inspect.h"

#include <stdio.h>
#include <string.h>

/* A slide of mass 2 along x; the modules follow. */
static fixture slide(const char *joint, const char *modules) {
  km_text text = {0};
  km_text_format(
      &text,
      "{\"model_parameters\": {\"gravity\": [0, 0, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"b\", \"mass\": 2, \"frames\": [{\"name\": \"p\"}]}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", "
      "\"body_frame_pairs\": [\"fixed\", \"b\"]%s}], \"force_modules\": [%s]}]}",
      joint, modules);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

/* A force −3 a adds a mass of 3: under a motor of 10 the acceleration is 10/(2 + 3). The law's piece beyond a = 1 has
 * the slope −1: 2 a = 10 − 3 − (a − 1), a = 8/3. */
static void accelerations(void **state) {
  (void)state;
  static const struct {
    const char *law;
    double acceleration;
  } laws[] = {{"\"coefficients\": [[0, -3]]", 2.0},
              {"\"knot_points\": [1], \"coefficients\": [[0, -3], [-2, -1]]", 8.0 / 3.0}};
  static const char *const inputs[] = {"{\"type\": \"joint\", \"joint\": \"X\"}",
                                       "{\"frame\": \"b/p\", \"component\": \"x\"}",
                                       "{\"frame\": \"b/p\", \"component\": \"x\", \"axes\": \"body\"}",
                                       "{\"body_frame_pair\": [\"fixed\", \"b/p\"], \"distance_type\": \"Tx\"}"};
  for (size_t i = 0; i < 2; ++i)
    for (size_t k = 0; k < 4; ++k) {
      char modules[600];
      snprintf(
          modules, sizeof modules,
          "{\"name\": \"mass\", \"type\": \"stiffness\", \"variable\": \"acceleration\", \"input\": %s, \"output\": "
          "{\"type\": \"joint\", \"joint\": \"X\"}, %s}, {\"name\": \"push\", \"type\": \"motor\", \"output\": {\"type\": "
          "\"joint\", \"joint\": \"X\"}, \"polynomial\": [10]}",
          inputs[k], laws[i].law);
      fixture f = slide("", modules);
      km_history h = history_of(&f, 1.0, 0.5, 1e-10, false);
      for (size_t r = 0; r < km_table_rows(h.table); ++r) {
        double t = history_entry(&h, r, "t");
        assert_near(history_entry(&h, r, "a.X"), laws[i].acceleration, 1e-11);
        assert_near(history_entry(&h, r, "v.X"), laws[i].acceleration * t, 1e-9);
        assert_near(history_entry(&h, r, "q.X"), 0.5 * laws[i].acceleration * t * t, 1e-9);
      }
      assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
      km_history_free(&h);
      fixture_close(&f);
    }
}

/* A speed controller with bounds: v rises by 6/2 per second until k_p (1 − v) falls to the bound, then e^(−k_p t/m).
 * Its derivative part adds the mass k_d. */
static void controlled_speed(void **state) {
  (void)state;
  const double kp = 20.0, kd = 0.5, bound = 6.0, mass = 2.0;
  fixture f =
      slide("", "{\"name\": \"c\", \"type\": \"pid\", \"variable\": \"velocity\", \"input\": {\"joint\": \"X\"}, "
                "\"reference\": 1, \"kp\": 20, \"kd\": 0.5, \"saturation\": [-6, 6]}");
  km_history h = history_of(&f, 1.0, 0.02, 1e-11, false);
  /* unbounded force: kp e − kd a with a = kp e/(m + kd), that is kp e m/(m + kd) */
  double e0 = bound * (mass + kd) / (kp * mass), v0 = 1.0 - e0, t0 = v0 * mass / bound;
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double t = history_entry(&h, r, "t");
    double v = t < t0 ? bound / mass * t : 1.0 - e0 * exp(-kp / (mass + kd) * (t - t0));
    assert_near(history_entry(&h, r, "v.X"), v, 1e-8);
  }
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

/* The integral of a bounded controller stops where the bound acts: m ẍ = clamp(k_p e + k_i ∫e), by Euler steps so short
 * that they err by less than the tolerance. */
static void bounded_integral(void **state) {
  (void)state;
  enum { STEPS = 4000000 };
  const double kp = 4.0, ki = 6.0, bound = 3.0, mass = 2.0, end = 4.0;
  fixture f =
      slide("", "{\"name\": \"c\", \"type\": \"pid\", \"variable\": \"velocity\", \"input\": {\"joint\": \"X\"}, "
                "\"reference\": 2, \"kp\": 4, \"ki\": 6, \"saturation\": [-3, 3]}");
  km_history h = history_of(&f, end, end, 1e-9, false);
  double v = 0.0, integral = 0.0;
  for (int i = 0; i < STEPS; ++i) {
    double e = 2.0 - v, force = kp * e + ki * integral, applied = fmin(fmax(force, -bound), bound);
    integral += (force != applied && (force - applied) * e > 0.0 ? 0.0 : e) * end / STEPS;
    v += applied / mass * end / STEPS;
  }
  assert_near(history_entry(&h, km_table_rows(h.table) - 1, "v.X"), v, 1e-5);
  km_history_free(&h);
  fixture_close(&f);
}

/* References over time: with k_d = 2 √(k m) and the feed of the reference's rate the error decays from 0, but for the
 * mass: m ẍ = k (r − x) + d (ṙ − ẋ), r = t/2 + t²; x = r − (2 m/k)(1 − (1 + w t) e^(−w t)) + …, w = √(k/m). */
static void references(void **state) {
  (void)state;
  static const char *const forms[] = {"[0, 0, 1]", "[[0, 0], [1, 2], [2, 2]]"};
  for (int i = 0; i < 2; ++i) {
    char modules[300];
    snprintf(
        modules, sizeof modules,
        "{\"name\": \"c\", \"type\": \"pid\", \"input\": {\"joint\": \"X\"}, \"reference\": %s, \"kp\": 50, \"kd\": 20}",
        forms[i]);
    fixture f = slide(i ? ", \"initial_velocity\": 2" : "", modules);
    km_history h = history_of(&f, 1.0, 0.1, 1e-11, false);
    for (size_t r = 0; r < km_table_rows(h.table); ++r) {
      double t = history_entry(&h, r, "t"), w = 5.0; /* both roots: 2 s² + 20 s + 50 = 2 (s + 5)² */
      double lag = 4.0 / 50.0;                       /* m r̈/k */
      double x = i ? 2.0 * t : t * t - lag * (1.0 - (1.0 + w * t) * exp(-w * t));
      assert_near(history_entry(&h, r, "q.X"), x, 1e-8);
    }
    km_history_free(&h);
    fixture_close(&f);
  }
}

/* Two slides with the inputs x − y: as a spring between them, −k (x − y) on x; its power isn't its own energy. */
static void weighted_inputs(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, 0, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", "
      "\"mass\": 2}, {\"name\": \"c\", \"mass\": 3}], \"joints\": [{\"name\": \"X\", \"type\": \"Tx\", "
      "\"body_frame_pairs\": [\"fixed\", \"b\"], \"initial_displacement\": 1}, {\"name\": \"Y\", \"type\": \"Tx\", "
      "\"body_frame_pairs\": [\"fixed\", \"c\"]}], \"force_modules\": [{\"name\": \"s\", \"type\": \"stiffness\", "
      "\"inputs\": [{\"joint\": \"X\"}, {\"joint\": \"Y\", \"weight\": -1}], \"output\": {\"joint\": \"X\"}, "
      "\"coefficients\": [[0, -18]]}, {\"name\": \"t\", \"type\": \"stiffness\", \"inputs\": [{\"joint\": \"X\"}, "
      "{\"joint\": \"Y\", \"weight\": -1}], \"output\": {\"joint\": \"Y\"}, \"coefficients\": [[0, 18]]}]}]}");
  km_history h = history_of(&f, 3.0, 0.25, 1e-11, false);
  double w = sqrt(18.0 * (1.0 / 2.0 + 1.0 / 3.0));
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double t = history_entry(&h, r, "t"), difference = history_entry(&h, r, "q.X") - history_entry(&h, r, "q.Y");
    assert_near(difference, cos(w * t), 1e-8);
    assert_near(2.0 * history_entry(&h, r, "q.X") + 3.0 * history_entry(&h, r, "q.Y"), 2.0, 1e-9);
  }
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

/* A double pendulum whose second link has a spring, a damper or a mass on its angle, its angular velocity or
 * acceleration against the ground; and the same by the joints' sum of angles. */
static void angles_between_frames(void **state) {
  (void)state;
  static const char *const kinds[] = {
      "\"type\": \"stiffness\", \"coefficients\": [[1, -5]]", "\"type\": \"damping\", \"coefficients\": [[0, -2]]",
      "\"type\": \"stiffness\", \"variable\": \"acceleration\", \"coefficients\": [[0, -0.3]]"};
  static const char *const axes[] = {"Rz", "Rx", "Ry"};
  for (int k = 0; k < 3; ++k)
    for (int axis = 0; axis < 3; ++axis) {
      double end[2];
      for (int form = 0; form < 2; ++form) {
        char text[2600], ports[3][400];
        if (form == 0)
          snprintf(ports[0], sizeof *ports,
                   "\"input\": {\"body_frame_pair\": [\"fixed/o\", \"c/o\"], \"distance_type\": \"%s\"}", axes[axis]);
        for (int i = 0; i < 2 && form; ++i)
          snprintf(ports[i], sizeof *ports,
                   "\"inputs\": [{\"joint\": \"A\"}, {\"joint\": \"B\"}], \"output\": {\"joint\": \"%c\"}", 'A' + i);
        int size = snprintf(
            text, sizeof text,
            "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"fixed\": {\"frames\": [{\"name\": \"o\", \"rotation_vector\": "
            "[%s]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", \"mass\": 1, \"center_of_mass\": "
            "[1, 0, 0], \"frames\": [{\"name\": \"e\", \"T\": [1, 0, 0]}]}, {\"name\": \"c\", \"mass\": 1, "
            "\"center_of_mass\": [0.7, 0, 0], \"frames\": [{\"name\": \"o\", \"T\": [0.3, 0.2, 0], \"rotation_vector\": "
            "[%s]}]}], \"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"], "
            "\"initial_displacement\": -1}, {\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [\"b/e\", \"c\"], "
            "\"initial_displacement\": 0.4}], \"force_modules\": [",
            axis == 0   ? "0, 0, 0"
            : axis == 1 ? "0, -1.5707963267948966, 0"
                        : "1.5707963267948966, 0, 0",
            axis == 0   ? "0, 0, 0"
            : axis == 1 ? "0, -1.5707963267948966, 0"
                        : "1.5707963267948966, 0, 0");
        for (int i = 0; i <= form; ++i)
          size += snprintf(text + size, sizeof text - (size_t)size, "%s{\"name\": \"m%d\", %s, %s}", i ? ", " : "", i,
                           kinds[k], ports[i]);
        snprintf(text + size, sizeof text - (size_t)size, "]}]}");
        fixture f = fixture_read(text);
        km_history h = history_of(&f, 0.8, 0.4, 1e-11, false);
        end[form] = history_entry(&h, km_table_rows(h.table) - 1, "q.B");
        assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
        km_history_free(&h);
        fixture_close(&f);
      }
      assert_near(end[0], end[1], 1e-8);
    }
}

/* A damper on a frame's velocity along its own axis, and on its angular velocity, act as those of the joint. */
static void frames_in_body_axes(void **state) {
  (void)state;
  static const char *const ports[] = {
      "\"input\": {\"joint\": \"A\"}",
      "\"input\": {\"frame\": \"b/e\", \"component\": \"wz\"}, \"output\": {\"joint\": \"A\"}",
      "\"inputs\": [{\"frame\": \"b/e\", \"component\": \"y\", \"axes\": \"body\", \"weight\": 0.5}], \"output\": {\"joint\": \"A\"}"};
  double end[3];
  for (int i = 0; i < 3; ++i) {
    char text[1200];
    snprintf(
        text, sizeof text,
        "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
        "\"b\", \"mass\": 1, \"center_of_mass\": [1, 0, 0], \"frames\": [{\"name\": \"e\", \"T\": [2, 0, 0]}]}], "
        "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}], \"force_modules\": "
        "[{\"name\": \"d\", \"type\": \"damping\", %s, \"coefficients\": [[0, -0.7]]}]}]}",
        ports[i]);
    fixture f = fixture_read(text);
    km_history h = history_of(&f, 1.5, 0.5, 1e-11, false);
    end[i] = history_entry(&h, km_table_rows(h.table) - 1, "q.A");
    km_history_free(&h);
    fixture_close(&f);
  }
  assert_near(end[1], end[0], 1e-9);
  assert_near(end[2], end[0], 1e-9);
}

/* A motor whose torque falls with the speed, f = 4 − 2 v: v = 2 (1 − e^(−t)); by pieces and by a table. */
static void motors_over_speed(void **state) {
  (void)state;
  static const char *const laws[] = {"\"polynomial\": [4, -2]", "\"table\": [[-1, 6], [0, 4], [2, 0]]"};
  for (int i = 0; i < 2; ++i) {
    char modules[300];
    snprintf(modules, sizeof modules,
             "{\"name\": \"m\", \"type\": \"motor\", \"variable\": \"velocity\", \"input\": {\"joint\": \"X\"}, %s}",
             laws[i]);
    fixture f = slide("", modules);
    km_history h = history_of(&f, 2.0, 0.25, 1e-11, false);
    for (size_t r = 0; r < km_table_rows(h.table); ++r)
      assert_near(history_entry(&h, r, "v.X"), 2.0 * (1.0 - exp(-history_entry(&h, r, "t"))), 1e-9);
    km_history_free(&h);
    fixture_close(&f);
  }
}

/* Force, power and work of modules as columns: the works of all are the run's own, and a frame's motion along its own
 * axes is that of a pendulum: velocity l ω along y, acceleration −l ω² along x. */
static void modules_as_columns(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
      "\"b\", \"mass\": 1, \"center_of_mass\": [1, 0, 0], \"frames\": [{\"name\": \"e\", \"T\": [2, 0, 0]}]}], \"joints\": "
      "[{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}], \"force_modules\": [{\"name\": "
      "\"s\", \"type\": \"stiffness\", \"input\": {\"joint\": \"A\"}, \"coefficients\": [[1, -3]]}, {\"name\": \"d\", "
      "\"type\": \"damping\", \"input\": {\"joint\": \"A\"}, \"coefficients\": [[0, -0.7]]}, {\"name\": \"m\", \"type\": "
      "\"motor\", \"output\": {\"joint\": \"A\"}, \"polynomial\": [0, 2]}]}]}");
  static const int modules[] = {0, 1, 2};
  const km_traced_frame frame = {f.model->frame_count - 1, "b/e"};
  km_forces *forces;
  km_history h;
  km_history_def def = km_history_default(f.model);
  def.until = 2.0;
  def.every = 0.25;
  def.simulation.relative = def.simulation.absolute = 1e-10;
  def.modules = modules;
  def.module_count = 3;
  def.frames = &frame;
  def.frame_count = 1;
  def.frame_rotations = true;
  assert_int_equal(km_model_module_count(f.model), 3);
  assert_int_equal(km_model_find_module(f.model, "m"), 2);
  assert_int_equal(km_model_find_module(f.model, "x"), -1);
  assert_int_equal(km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_history_run(f.mechanism, forces, f.state, &def, &h, NULL), KM_OK);
  for (size_t r = 0; r < km_table_rows(h.table); ++r) {
    double q = history_entry(&h, r, "q.A"), v = history_entry(&h, r, "v.A"), t = history_entry(&h, r, "t");
    assert_near(history_entry(&h, r, "module.s.variable"), q, 1e-12);
    assert_near(history_entry(&h, r, "module.s.value"), 1.0 - 3.0 * q, 1e-11);
    assert_near(history_entry(&h, r, "module.s.power"), (1.0 - 3.0 * q) * v, 1e-10);
    assert_near(history_entry(&h, r, "module.s.work"), q - 1.5 * q * q, 1e-7);
    assert_near(history_entry(&h, r, "module.d.value"), -0.7 * v, 1e-11);
    assert_near(history_entry(&h, r, "module.d.work"), -history_entry(&h, r, "energy_dissipated"), 1e-9);
    assert_near(history_entry(&h, r, "module.m.variable"), t, 1e-12);
    assert_near(history_entry(&h, r, "module.m.work"), history_entry(&h, r, "motor_work"), 1e-9);
    assert_near(history_entry(&h, r, "frame.b/e.vy"), 2.0 * v, 1e-10);
    assert_near(history_entry(&h, r, "frame.b/e.ax"), -2.0 * v * v, 1e-9);
    assert_near(history_entry(&h, r, "frame.b/e.wz"), v, 1e-11);
    assert_near(history_entry(&h, r, "frame.b/e.alphaz"), history_entry(&h, r, "a.A"), 1e-9);
  }
  km_history_free(&h);
  km_forces_free(forces);
  fixture_close(&f);
}

/* A cart on a tyre carries a four-bar with joint friction, stops, a spring to the ground, a damper, air drag on the
 * cart, a motor, a bounded controller and a contact with a wall: all modules at once keep the energy. */
static void energy_of_all_modules(void **state) {
  (void)state;
  fixture f = fixture_open("../tests/golden/models/all_modules");
  assert_int_equal(km_model_module_count(f.model), 7);
  km_history h = history_of(&f, 3.0, 0.1, 1e-10, false);
  assert_true(h.energy_scale > 100.0);
  assert_at_most(h.energy_error, 1e-8 * h.energy_scale);
  assert_true(history_end(&h, "energy_dissipated") > 0.5 * h.energy_scale);
  km_history_free(&h);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(accelerations),       cmocka_unit_test(controlled_speed),
                                     cmocka_unit_test(bounded_integral),    cmocka_unit_test(references),
                                     cmocka_unit_test(weighted_inputs),     cmocka_unit_test(angles_between_frames),
                                     cmocka_unit_test(frames_in_body_axes), cmocka_unit_test(motors_over_speed),
                                     cmocka_unit_test(modules_as_columns),
                                     cmocka_unit_test(energy_of_all_modules)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
