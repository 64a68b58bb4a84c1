/* Mechanical advantage against the closed loops, against the balance of forces, and against closed forms. */
#include "support/support.h"

#include "forces/forces.h"
#include "kinematics/body_poses.h"
#include "kmech/statics.h"
#include "kmech/sweep.h"
#include "kmech/transfer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static km_port joint(const km_model *model, int coordinate) {
  return (km_port){.kind = KM_PORT_JOINT, .coordinate = coordinate, .name = model->coordinates[coordinate].label};
}

static km_advantage advantage_of(fixture *f, const km_port *input, const km_port *output) {
  km_transfer *lever;
  km_advantage a;
  km_error error;
  km_mobility mobility;
  if (km_transfer_create(f->mechanism, input, output, &lever, &error))
    fail_msg("%s", error.text);
  km_mobility_compute(f->mechanism, f->state, &mobility);
  km_transfer_compute(f->mechanism, f->state, lever, &a);
  km_transfer_free(lever);
  return a;
}

/* Two different free coordinates of one substructure with one freedom; false if the model has none. */
static bool choose(const fixture *f, randomness *r, int *in, int *out) {
  const km_mechanism *m = f->mechanism;
  km_mobility mobility;
  km_mobility_compute(m, f->state, &mobility);
  for (int tries = 0; tries < 50 && m->topology.substructure_count; ++tries) {
    int s = below(r, m->topology.substructure_count);
    const km_substructure *sub = &m->substructures[s];
    if (km_factor_freedom(f->state->factor[s]) != 1)
      continue;
    *in = m->column_coordinate[sub->column_start + below(r, sub->columns)];
    *out = m->column_coordinate[sub->column_start + below(r, sub->columns)];
    /* rows next to a toggle of the driver are unreachable or far away */
    if (*in != *out && m->ball_of[*in] < 0 && m->ball_of[*out] < 0 && f->state->mobility_number[*in] > 1e-4 &&
        fabs(km_state_coordinate(f->state, *in)) < 1e6)
      return true;
  }
  return false;
}

/* The output where the input is driven to start + h; *reached is cleared if it can't go there. */
static double output_at(fixture *f, km_driver_motion *drive, double start, double h, int out, bool *reached) {
  *reached = !km_driver_motion_move_to(drive, start + h).stop && *reached;
  return f->state->q[out];
}

/* The fourth-order difference over steps of h. */
static double difference(fixture *f, km_driver_motion *drive, double start, double h, int out, bool *reached) {
  double y[4];
  for (int k = 0; k < 4; ++k)
    y[k] = output_at(f, drive, start, h * (k < 2 ? k - 2 : k - 1), out, reached);
  return (8.0 * (y[2] - y[1]) - (y[3] - y[0])) / (12.0 * h);
}

/* It errs by a fifteenth of its change when h doubles, and by rounding, 1e-12/h = 1e-9 at most. */
static void inverse_of_the_rate(void **state) {
  (void)state;
  randomness r = {11};
  int compared = 0;
  for (const char *const *name = all_models; *name; ++name) {
    for (int i = 0; i < 8; ++i) {
      fixture f = fixture_open(*name);
      int in, out;
      go_somewhere(&f, &r);
      if (choose(&f, &r, &in, &out)) {
        km_port input = joint(f.model, in), output = joint(f.model, out);
        km_advantage a = advantage_of(&f, &input, &output);
        double factor = km_model_coordinate_factor(f.model, in), start = km_state_coordinate(f.state, in);
        double h = 1e-3 * f.mechanism->unit[in] / factor;
        bool reached = true;
        km_driver_motion *drive;
        assert_int_equal(km_driver_motion_create(f.mechanism, f.state, in, true, &drive, NULL), KM_OK);
        double rate = difference(&f, drive, start, h, out, &reached) / factor;
        double coarse = difference(&f, drive, start, 2.0 * h, out, &reached) / factor;
        km_driver_motion_free(drive);
        double scale = f.mechanism->unit[out] / f.mechanism->unit[in];
        double ratio = a.state == KM_ADVANTAGE_INFINITE ? 0.0 : a.velocity_ratio;
        if (reached && fabs(rate) < 30.0 * scale) {
          assert_near(rate, ratio, 1e-8 * (1.0 + fabs(rate / scale)) * scale + fabs(coarse - rate) / 15.0);
          if (a.state == KM_ADVANTAGE_FINITE)
            assert_near(a.value * a.velocity_ratio, 1.0, 1e-14);
          ++compared;
        }
      }
      fixture_close(&f);
    }
  }
  assert_true(compared > 40);
}

/* Two hinges in no loop, links 2 and 1 in line: the tip goes 3 a radian of the first and 1 a radian of the second. */
static void an_arm_in_no_loop(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"model_parameters\": {\"characteristic_length\": 0.5}, \"assemblies\": [{\"name\": \"a\", \"drawn\": "
      "\"assembled\", \"bodies\": [{\"name\": \"b\"}, {\"name\": \"c\", \"frames\": [{\"name\": \"tip\", "
      "\"T\": [3, 0]}]}, {\"name\": \"d\"}], \"joints\": [{\"name\": \"A\", \"type\": \"revolute\", "
      "\"bodies\": [\"fixed\", \"b\"], \"at\": [0, 0]}, {\"name\": \"B\", \"type\": \"revolute\", "
      "\"bodies\": [\"b\", \"c\"], \"at\": [2, 0]}, {\"name\": \"C\", \"type\": \"revolute\", "
      "\"bodies\": [\"fixed\", \"d\"], \"at\": [9, 9]}]}]}");
  static const char *const tip[] = {"c", "tip"};
  static const double rates[3] = {3.0, 1.0, 0.0};
  km_port output = {.kind = KM_PORT_POINT, .direction = {0, 1, 0}, .name = "tip"};
  assert_int_equal(km_model_find_frame(f.model, tip, 2, &output.frame, NULL), KM_OK);
  for (int c = 0; c < 2; ++c) {
    km_port input = joint(f.model, c);
    km_advantage a = advantage_of(&f, &input, &output);
    assert_int_equal(a.state, KM_ADVANTAGE_FINITE);
    assert_near(a.velocity_ratio, rates[c], 1e-14);
    assert_near(a.value, 1.0 / rates[c], 1e-14);
  }
  fixture_close(&f);
}

/* A generalised force of 1 on a coordinate: its axis' force or couple on the child, the opposite on the parent. */
static void pair_of_loads(const fixture *f, int c, km_load out[2]) {
  const km_model_joint *def = &f->model->joints[f->model->coordinates[c].joint];
  km_twist h = km_coordinate_twist(f->mechanism, f->state, c);
  bool turns = km_vec3_norm(h.w) > 0.5;
  km_vec3 axis = turns ? h.w : h.v, none = {0, 0, 0}, moment = none;
  const km_model_frame *a = &f->model->frames[def->frame[0]], *b = &f->model->frames[def->frame[1]];
  if (!turns) {
    km_vec3 from = km_pose_point(&f->state->pose[a->body], a->pose.p);
    km_vec3 to = km_pose_point(&f->state->pose[b->body], b->pose.p);
    moment = km_vec3_scale(-1.0, km_vec3_cross(km_vec3_sub(to, from), axis)); /* opposite force at `to` */
  }
  km_vec3 force = turns ? none : axis, couple = turns ? axis : none;
  km_vec3 back = turns ? km_vec3_scale(-1.0, axis) : moment;
  out[0] = (km_load){def->frame[1], {force.x, force.y, force.z}, {couple.x, couple.y, couple.z}, false, NULL};
  out[1] = (km_load){def->frame[0], {-force.x, -force.y, -force.z}, {back.x, back.y, back.z}, false, NULL};
}

/* The input force that balances an output force τ is −τ / MA. */
static void minus_the_ratio_of_forces(void **state) {
  (void)state;
  static const double weightless[3] = {0, 0, 0};
  randomness r = {12};
  int compared = 0;
  for (const char *const *name = all_models; *name; ++name) {
    for (int i = 0; i < 8; ++i) {
      fixture f = fixture_open(*name);
      int in, out;
      go_somewhere(&f, &r);
      bool chosen = choose(&f, &r, &in, &out);
      const km_model_joint *def = chosen ? &f.model->joints[f.model->coordinates[out].joint] : NULL;
      if (chosen && def->type != KM_SCREW && f.model->module_count == 0) {
        km_port input = joint(f.model, in), output = joint(f.model, out);
        km_advantage a = advantage_of(&f, &input, &output);
        km_load loads[2];
        km_forces *forces;
        km_statics statics;
        km_poses_compute(f.mechanism, f.state);
        pair_of_loads(&f, out, loads);
        assert_int_equal(km_forces_create(f.mechanism, weightless, loads, 2, &forces, NULL), KM_OK);
        assert_int_equal(km_statics_create(f.mechanism, &in, 1, KM_AXES_JOINT, &statics, NULL), KM_OK);
        km_statics_compute(f.mechanism, f.state, forces, &statics);
        double scale = f.mechanism->unit[out] / f.mechanism->unit[in];
        if (a.state == KM_ADVANTAGE_FINITE)
          assert_near(statics.actuator_forces[0], -a.velocity_ratio, 1e-8 * (fabs(a.velocity_ratio) + scale));
        compared += a.state == KM_ADVANTAGE_FINITE;
        km_statics_free(&statics);
        km_forces_free(forces);
      }
      fixture_close(&f);
    }
  }
  assert_true(compared > 40);
}

static void characteristic_length_does_not_count(void **state) {
  (void)state;
  randomness r = {13};
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name), g = fixture_open(*name);
    int in, out;
    km_model_share_length(g.model, 0.037);
    km_mechanism_free(g.mechanism);
    km_state_free(g.state);
    g = fixture_of(g.model);
    go_somewhere(&f, &r);
    if (choose(&f, &r, &in, &out)) {
      km_port input = joint(f.model, in), output = joint(f.model, out);
      km_state_copy(g.mechanism, g.state, f.state);
      km_advantage a = advantage_of(&f, &input, &output), b = advantage_of(&g, &input, &output);
      assert_int_equal(a.state, b.state);
      if (a.state == KM_ADVANTAGE_FINITE)
        assert_near(a.value, b.value, 1e-9 * fabs(a.value));
    }
    fixture_close(&f);
    fixture_close(&g);
  }
}

/* A frame turned about y, its origin at (x, 0, z). */
static void turned(char *out, size_t size, const char *name, double angle, double x, double z) {
  snprintf(out, size,
           "{\"name\": \"%s\", \"T\": [%.17g, 0, %.17g], \"R\": [[%.17g, 0, %.17g], [0, 1, 0], [%.17g, 0, %.17g]]}",
           name, x, z, cos(angle), sin(angle), -sin(angle), cos(angle));
}

/* theory.md 5: ω_out / ω_in = cos β / (1 − sin²β cos²θ). */
static void single_cardan_joint(void **state) {
  (void)state;
  const double beta = 0.6;
  char frame[512], text[2048];
  turned(frame, sizeof frame, "out", beta, 0.0, 0.0);
  snprintf(text, sizeof text,
           "{\"fixed\": {\"frames\": [%s]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"in\"}, "
           "{\"name\": \"out\"}], \"joints\": ["
           "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"in\"]},"
           "{\"name\": \"U\", \"type\": \"universal\", \"body_frame_pairs\": [\"in\", \"out\"], "
           "\"initial_displacement\": [0, %.17g]},"
           "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"out\"], \"out\"]}]}]}",
           frame, beta);
  fixture f = fixture_read(text);
  km_port input = joint(f.model, 0), output = joint(f.model, 3);
  km_driver_motion *drive;
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, false, &drive, NULL), KM_OK);
  for (int i = 0; i <= 24; ++i) {
    double theta = 2.0 * M_PI * i / 24, c = cos(theta), s = sin(beta);
    assert_int_equal(km_driver_motion_move_to(drive, theta).stop, KM_STOP_NONE);
    km_advantage a = advantage_of(&f, &input, &output);
    assert_near(a.velocity_ratio, cos(beta) / (1.0 - s * s * c * c), 1e-12);
  }
  km_driver_motion_free(drive);
  fixture_close(&f);
}

/* Two Cardan joints with an even middle shaft in Z or W turn alike. */
static void double_cardan_joint(void **state) {
  (void)state;
  const double beta = 0.5, length = 2.0;
  for (int w = 0; w < 2; ++w) {
    double bend = w ? -beta : beta;
    char frame[512], text[3072];
    turned(frame, sizeof frame, "out", w ? 2.0 * beta : 0.0, length * sin(beta), length * cos(beta));
    snprintf(text, sizeof text,
             "{\"fixed\": {\"frames\": [%s]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"in\"}, "
             "{\"name\": \"mid\", \"frames\": [{\"name\": \"end\", \"T\": [0, 0, %.17g]}]}, {\"name\": \"out\"}], "
             "\"joints\": [{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"in\"]},"
             "{\"name\": \"U\", \"type\": \"universal\", \"body_frame_pairs\": [\"in\", \"mid\"], "
             "\"initial_displacement\": [0, %.17g]},"
             "{\"name\": \"V\", \"type\": \"universal\", \"body_frame_pairs\": [\"out\", [\"mid\", \"end\"]], "
             "\"initial_displacement\": [0, %.17g]},"
             "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"out\"], \"out\"]}]}]}",
             frame, length, beta, bend);
    fixture f = fixture_read(text);
    km_port input = joint(f.model, 0), output = joint(f.model, 5);
    km_driver_motion *drive;
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, false, &drive, NULL), KM_OK);
    for (int i = 0; i <= 12; ++i) {
      assert_int_equal(km_driver_motion_move_to(drive, 0.5 * i).stop, KM_STOP_NONE);
      assert_near(advantage_of(&f, &input, &output).value, 1.0, 1e-9);
    }
    km_driver_motion_free(drive);
    fixture_close(&f);
  }
}

/* Planar four-bars: the transmission angle by the cosine rule, and both indices its sine. */
static void transmission_of_a_four_bar(void **state) {
  (void)state;
  fixture f = fixture_open("fourbar");
  km_port input = joint(f.model, 0), output = joint(f.model, 3);
  km_transmission_workspace *work;
  km_driver_motion *drive;
  assert_int_equal(km_transmission_create(f.mechanism, &input, &output, &work, NULL), KM_OK);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, false, &drive, NULL), KM_OK);
  for (int i = 0; i < 12; ++i) {
    km_transmission t;
    km_mobility mobility;
    assert_int_equal(km_driver_motion_move_to(drive, 0.5 * i).stop, KM_STOP_NONE);
    km_mobility_compute(f.mechanism, f.state, &mobility);
    km_transmission_compute(f.mechanism, f.state, work, &t);
    double diagonal = 0.4 * 0.4 + 0.15 * 0.15 - 2.0 * 0.4 * 0.15 * cos(0.5 * i);
    double angle = acos((0.5 * 0.5 + 0.45 * 0.45 - diagonal) / (2.0 * 0.5 * 0.45));
    assert_near(t.angle.value, angle, 1e-12);
    assert_near(t.sutherland_roth.value, sin(angle), 1e-12);
    assert_near(t.chen_angeles.value, sin(angle), 1e-12);
    assert_near(t.virtual_coefficient.value, 0.5 * 0.45 * sin(angle), 1e-12);
  }
  km_driver_motion_free(drive);
  km_transmission_free(work);
  fixture_close(&f);
}

/* A slide with friction: the rod at angle β to it pushes R = 1 / (cos β − μ sin β), so the efficiency is 1 − μ tan β.
 */
static void friction_of_a_slide(void **state) {
  (void)state;
  char *text = read_model_text("slider_crank");
  char *rubbing = edited(text, NULL, "\"damping\": 1.0", "\"friction\": {\"coefficient\": 0.2}");
  fixture f = fixture_read(rubbing);
  km_port input = joint(f.model, 0), output = joint(f.model, 1);
  km_losses_workspace *work;
  km_driver_motion *drive;
  assert_int_equal(km_losses_create(f.mechanism, &input, &output, &work, NULL), KM_OK);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, 0, false, &drive, NULL), KM_OK);
  for (int i = 1; i < 6; ++i) {
    km_losses losses;
    km_mobility mobility;
    assert_int_equal(km_driver_motion_move_to(drive, 0.5 * i).stop, KM_STOP_NONE);
    km_mobility_compute(f.mechanism, f.state, &mobility);
    km_losses_compute(f.mechanism, f.state, work, &losses);
    double beta = asin(0.6 * sin(0.5 * i) / 1.5);
    assert_null(losses.why);
    assert_false(losses.locks);
    assert_near(losses.efficiency, 1.0 - 0.2 * tan(beta), 1e-10);
  }
  km_driver_motion_free(drive);
  km_losses_free(work);
  fixture_close(&f);
  km_free(rubbing);
  km_free(text);
}

/* A jack: a screw on the ground, a plate that turns on it and slides on the ground. `pitch` in a turn. */
static fixture jack(double pitch, double radius, double coefficient) {
  char text[700];
  snprintf(
      text, sizeof text,
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"s\"}, {\"name\": \"p\"}], \"joints\": [{\"name\": "
      "\"S\", \"type\": \"screw\", \"pitch\": %.17g, \"body_frame_pairs\": [\"fixed\", \"s\"], \"friction\": "
      "{\"coefficient\": %.17g, \"radius\": %.17g}}, {\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [\"s\", "
      "\"p\"]}, {\"name\": \"G\", \"type\": \"Tz\", \"body_frame_pairs\": [\"fixed\", \"p\"]}]}]}",
      pitch, coefficient, radius);
  return fixture_read(text);
}

/* Screws of all lead angles λ, right and left-handed: the torque is F r tan(λ + φ) against the load, and a load
 * gives F r tan(λ − φ), nothing from φ = λ on; the torque that lifts grows without bound at λ + φ = 90°. */
static void friction_of_threads(void **state) {
  (void)state;
  randomness r = {5};
  for (int i = 0; i < 200; ++i) {
    double radius = uniform(&r, 0.5, 3.0), slope = uniform(&r, 0.02, 3.0), phi = atan(uniform(&r, 0.01, 0.6));
    double lambda = atan(slope), sense = i % 2 ? 1.0 : -1.0;
    fixture f = jack(sense * slope * 2.0 * M_PI * radius, radius, tan(phi));
    km_mobility mobility;
    km_mobility_compute(f.mechanism, f.state, &mobility);
    for (int back = 0; back < 2; ++back) {
      km_port input = joint(f.model, back ? 2 : 0), output = joint(f.model, back ? 0 : 2);
      km_losses_workspace *work;
      km_losses losses;
      assert_int_equal(km_losses_create(f.mechanism, &input, &output, &work, NULL), KM_OK);
      km_losses_compute(f.mechanism, f.state, work, &losses);
      double efficiency = back ? tan(lambda - phi) / slope : slope / tan(lambda + phi);
      bool locks = back ? phi >= lambda : lambda + phi >= 0.5 * M_PI;
      assert_null(losses.why);
      assert_int_equal(losses.locks, locks);
      assert_near(losses.efficiency, locks ? 0.0 : efficiency, 1e-9);
      km_losses_free(work);
    }
    fixture_close(&f);
  }
}

/* With several freedoms, too, the first row of a sweep is what its pose gives: in the vehicle's steering, in a delta.
 */
static void rows_are_those_of_their_poses(void **state) {
  (void)state;
  static const char *const cases[][3] = {{"vehicle", "L", "J"}, {"delta", "A1", "A2"}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    fixture f = fixture_open(cases[i][0]);
    int in, out;
    assert_int_equal(km_model_find_coordinate(f.model, cases[i][1], &in, NULL), KM_OK);
    assert_int_equal(km_model_find_coordinate(f.model, cases[i][2], &out, NULL), KM_OK);
    km_port input = joint(f.model, in), output = joint(f.model, out);
    km_advantage at_pose = advantage_of(&f, &input, &output);
    km_sweep_plan plan = {.coordinate = in, .direction = -1, .steps = 2};
    plan.from = km_state_coordinate(f.state, in);
    plan.to = plan.from + 0.01;
    km_advantage_sweep sweep;
    km_error error;
    assert_int_equal(km_advantage_sweep_run(f.mechanism, f.state, &plan, &input, &output, false, &sweep, &error),
                     KM_OK);
    double first = km_table_row(sweep.motion.table, 0)[sweep.column];
    double last = km_table_row(sweep.motion.table, 2)[sweep.column];
    assert_near(first, at_pose.value, 1e-9 * fabs(at_pose.value));
    at_pose = advantage_of(&f, &input, &output);
    assert_near(last, at_pose.value, 1e-9 * fabs(at_pose.value));
    km_advantage_sweep_free(&sweep);
    fixture_close(&f);
  }
}

/* The slider's own dead point is where crank and rod are one line, at 0.6 + 1.5: a pole, however near to it one of
 * the 360 poses lies that the sweep looks at on its way. */
static void pole_at_the_drivers_end(void **state) {
  (void)state;
  const double end = 2.1, from = 1.8;
  for (int k = 3; k <= 9; ++k) {
    fixture f = fixture_open("slider_crank");
    int crank, slider;
    assert_int_equal(km_model_find_coordinate(f.model, "A", &crank, NULL), KM_OK);
    assert_int_equal(km_model_find_coordinate(f.model, "B", &slider, NULL), KM_OK);
    km_port input = joint(f.model, crank), output = joint(f.model, slider);
    km_sweep_plan plan = {.coordinate = slider, .direction = -1, .sign = 1.0, .from = from, .steps = 40};
    plan.to = from + (end - pow(10.0, -k) - from) * 360.0 / 250.0;
    km_advantage_sweep sweep;
    assert_int_equal(km_advantage_sweep_run(f.mechanism, f.state, &plan, &input, &output, false, &sweep, NULL),
                     KM_PARTIAL);
    assert_int_equal(sweep.toggle_count, 1);
    assert_int_equal(sweep.toggles[0].state, KM_ADVANTAGE_INFINITE);
    assert_near(sweep.toggles[0].s, end, 5e-9 * (1.0 + end)); /* as well as an end is located */
    km_advantage_sweep_free(&sweep);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      claim_test(
          inverse_of_the_rate,
          "The mechanical advantage is the inverse of the rate at which the closed loops move the output",
          "a fifteenth of the change of a fourth-order difference as its step doubles, and rounding over the step"),
      cmocka_unit_test(an_arm_in_no_loop),
      cmocka_unit_test(rows_are_those_of_their_poses),
      cmocka_unit_test(pole_at_the_drivers_end),
      claim_test(minus_the_ratio_of_forces, "The input force that balances an output force τ is −τ/MA",
                 "1e-8 of the ratio: rounding over the input's mobility number, above 1e-4"),
      claim_test(characteristic_length_does_not_count,
                 "The mechanical advantage doesn't depend on the characteristic length", "rounding: 1e-9 of it"),
      claim_test(single_cardan_joint, "A Cardan joint turns at cos β/(1 − sin²β cos²θ) of its input's rate",
                 "the loops are closed to 1e-12"),
      cmocka_unit_test(double_cardan_joint),
      claim_test(transmission_of_a_four_bar,
                 "A four-bar's transmission angle is that of the cosine rule, and its indices are the sine",
                 "the loops are closed to 1e-12"),
      claim_test(friction_of_threads,
                 "Screws take F r tan(λ + φ) against a load and give F r tan(λ − φ), on 200 threads of all lead angles",
                 "Newton's method ends at 1e-13 of the forces"),
      claim_test(friction_of_a_slide, "The efficiency of a crank that drives a slide with friction is 1 − μ tan β",
                 "the loops are closed to 1e-12, over the rod's angle"),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
