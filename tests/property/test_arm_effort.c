/* Joint forces of arms against the equations of motion, and the objectives from them against their laws. */
#include "support/arms.h"

#include "arm/arm_dynamics.h"
#include "arm/tracking/joint_effort.h"
#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "kmech/dynamics.h"

#include <stdio.h>
#include <string.h>

/* The odd arm in millimetres, milliseconds, grams and degrees. */
static fixture odd_arm_in_small_units(void) {
  fixture f = odd_arm(), g = fixture_in_units(&f, "degrees", "millimeters", "grams", "milliseconds");
  fixture_close(&f);
  return g;
}

/* Equations of motion of a fixture whose coordinates beside an arm are prescribed at rest. */
typedef struct plant {
  fixture *f;
  const km_arm *arm;
  km_forces *forces;
  km_dynamics *dynamics;
} plant;

static plant plant_of(fixture *f, const km_arm *arm, const double *rates, bool prescribe_all) {
  plant p = {f, arm, NULL, NULL};
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &p.forces, NULL), KM_OK);
  assert_int_equal(km_dynamics_create(f->mechanism, p.forces, &p.dynamics, NULL), KM_OK);
  for (int c = 0; c < f->mechanism->coordinate_count; ++c) {
    const double factor = km_model_coordinate_factor(f->model, c);
    double rate = 0.0;
    bool is_own = false;
    for (int k = 0; k < arm->n; ++k)
      if (arm->coordinate[k] == c) {
        rate = rates[k] * arm->unit[k] * f->model->units.time->si;
        is_own = true;
      }
    f->state->rate[c] = rate;
    if (!is_own || prescribe_all)
      assert_int_equal(km_dynamics_prescribe(p.dynamics, c, f->state->q[c] / factor, rate / factor, NULL), KM_OK);
  }
  assert_int_equal(km_dynamics_accelerate(p.dynamics, f->state, NULL), KM_OK);
  return p;
}

static void plant_close(plant *p) {
  km_dynamics_free(p->dynamics);
  km_forces_free(p->forces);
}

/* Largest magnitude of x[n], at least 1e-3. */
static double largest(const double *x, int n) {
  double most = 1e-3;
  for (int k = 0; k < n; ++k)
    most = fmax(most, fabs(x[k]));
  return most;
}

/* The joint forces at constant rates are the driving forces; those at the accelerations of the free motion are 0. */
static void check_forces(fixture f, const char *body, const char *frame, uint64_t seed) {
  km_arm *arm = arm_of(&f, body, frame, KM_TASK_POSE);
  randomness r = {seed};
  for (int trial = 0; trial < 10; ++trial) {
    double q[KM_ARM_MAX_JOINTS], rates[KM_ARM_MAX_JOINTS], accelerations[KM_ARM_MAX_JOINTS] = {0.0},
                                                           force[KM_ARM_MAX_JOINTS], zero[KM_ARM_MAX_JOINTS];
    random_pose(arm, &r, q);
    for (int k = 0; k < arm->n; ++k) {
      rates[k] = uniform(&r, -2.0, 2.0);
      f.state->q[arm->coordinate[k]] = q[k] * arm->unit[k];
    }
    km_arm_joint_forces(arm, q, rates, accelerations, force);
    const double most = largest(force, arm->n);
    plant p = plant_of(&f, arm, rates, true);
    for (int k = 0; k < arm->n; ++k)
      assert_near(km_arm_force_to_units(arm, k, force[k]),
                  km_dynamics_driving_force(p.dynamics, f.state, arm->coordinate[k]), 1e-11 * most / arm->unit[k]);
    plant_close(&p);
    p = plant_of(&f, arm, rates, false);
    const double per_second = f.model->units.time->si;
    for (int k = 0; k < arm->n; ++k)
      accelerations[k] = f.state->acceleration[arm->coordinate[k]] / (arm->unit[k] * per_second * per_second);
    km_arm_joint_forces(arm, q, rates, accelerations, zero);
    for (int k = 0; k < arm->n; ++k)
      assert_near(zero[k], 0.0, 1e-10 * most * largest(accelerations, arm->n));
    plant_close(&p);
  }
  km_arm_free(arm);
  fixture_close(&f);
}

static void joint_forces_satisfy_the_equations_of_motion(void **state) {
  (void)state;
  check_forces(fixture_open("iiwa14"), "flange", "tool", 1);
  check_forces(fixture_open("panda"), "flange", "tool", 2);
  check_forces(fixture_open("robot7r"), "link_7", "tool", 3);
  check_forces(odd_arm(), "hand", "tip", 4);
  check_forces(odd_arm_in_small_units(), "hand", "tip", 5);
}

/* A study of an arc of the panda's flange at 0.5 m/s; methods and the closing brace follow. */
#define PANDA_ARC(steps)                                                                                               \
  PANDA_START                                                                                                          \
  "{\"type\": \"arc\", \"center\": [0.4, 0.0, 0.45], \"axis\": [0, 0, 1], \"angle\": 1.2, \"steps\": " #steps          \
  "}]}, \"q0\": [1.188359, -0.3642308, -1.092908, -2.1855599, -0.3532835, 1.987876, 0.2719783]"
#define PANDA_START                                                                                                    \
  "{\"effector\": [\"flange\", \"tool\"], \"path\": {\"speed\": 0.5, \"start\": {\"T\": [0.5, 0.0, 0.45], \"R\": "     \
  "[[1, 0, 0], [0, -1, 0], [0, 0, -1]]}, \"segments\": ["

/* Kinetic and potential energy of the panda at a row of a track, by the equations of motion. */
static double energy_at(fixture *f, const km_track *track, size_t row) {
  const double *cells = km_table_row(track->table, row);
  const size_t q = km_table_span(track->table, "q.").first, v = km_table_span(track->table, "v.").first;
  km_forces *forces;
  km_dynamics *dynamics;
  km_state *s = f->state;
  assert_int_equal(km_forces_create(f->mechanism, NULL, NULL, 0, &forces, NULL), KM_OK);
  assert_int_equal(km_dynamics_create(f->mechanism, forces, &dynamics, NULL), KM_OK);
  for (int c = 0; c < 7; ++c) {
    s->q[c] = cells[q + (size_t)c];
    s->rate[c] = cells[v + (size_t)c];
  }
  assert_int_equal(km_dynamics_accelerate(dynamics, s, NULL), KM_OK);
  km_energy energy;
  assert_int_equal(km_dynamics_energy(dynamics, s, &energy, NULL), KM_OK);
  km_dynamics_free(dynamics);
  km_forces_free(forces);
  return energy.kinetic + energy.potential;
}

/* Work of the joint forces minus the change of the energy, over the whole path. */
static double balance_of(fixture *f, const char *text, double *scale) {
  km_study *study = study_of(f, text);
  km_track *track = track_of(study, 0, 1);
  const size_t rows = km_table_rows(track->table);
  const size_t q = km_table_span(track->table, "q.").first, force = km_table_span(track->table, "f.").first;
  double work = 0.0;
  assert_int_equal(track->end.stop, KM_TRACK_COMPLETE);
  for (size_t i = 1; i < rows; ++i)
    for (size_t k = 0; k < 7; ++k)
      work += km_table_row(track->table, i)[force + k] *
              (km_table_row(track->table, i)[q + k] - km_table_row(track->table, i - 1)[q + k]);
  const double before = energy_at(f, track, 0), after = energy_at(f, track, rows - 1);
  assert_near(track->summary.energy, track_cell(track, rows - 1, "energy"), 0.0);
  *scale = track->summary.energy;
  km_track_free(track);
  km_study_free(study);
  return work - (after - before);
}

/* The work of the joint forces is the change of the energy, with an error of first order in the steps, as that of the
 * self-motion of the track. */
static void work_is_the_change_of_energy(void **state) {
  (void)state;
  fixture f = fixture_open("panda");
  double scale, coarse = balance_of(&f, PANDA_ARC(20) ", \"methods\": [\"greedy\"]}", &scale),
                fine = balance_of(&f, PANDA_ARC(320) ", \"methods\": [\"greedy\"]}", &scale);
  assert_true(fabs(coarse) < 1e-3 * scale);
  assert_true(fabs(fine) < fabs(coarse) / 8.0);
  fixture_close(&f);
}

/* The mean over the time of an effort that the summary of a track states, by the objective's kind. */
static double effort_of(const km_track *track, int kind) {
  const km_track_summary *s = &track->summary;
  const double seconds = track->end.t;
  return kind == KM_EFFORT ? s->effort : kind == KM_ENERGY ? s->energy / seconds : s->positive_work / seconds;
}

/* Dynamic programming by an objective gives the least effort of that kind; tracks by other objectives have more. */
static void each_optimum_is_the_least_of_its_kind(void **state) {
  (void)state;
  static const char *const words[] = {"effort",         "energy",         "positive-work", "limit-distance",
                                      "manipulability", "singular-value", "path-control",  "joint-travel"};
  enum { WORDS = sizeof words / sizeof *words, KINDS = 3 };
  static const int kinds[KINDS] = {KM_EFFORT, KM_ENERGY, KM_POSITIVE_WORK};
  fixture f = fixture_open("panda");
  km_track *tracks[WORDS];
  km_study *studies[WORDS];
  for (int i = 0; i < WORDS; ++i) {
    char text[1024];
    snprintf(
        text, sizeof text,
        "{\"effector\": [\"flange\", \"tool\"], \"path\": {\"speed\": 0.5, \"segments\": [{\"type\": \"line\", \"to\": "
        "[-0.19, 0.25, 0.46], \"steps\": 96}]}, \"methods\": [\"dp\"], \"objective\": \"%s\"}",
        words[i]);
    studies[i] = study_of(&f, text);
    tracks[i] = track_of(studies[i], 0, 2);
    assert_int_equal(tracks[i]->end.stop, KM_TRACK_COMPLETE);
    if (i < KINDS)
      assert_near(tracks[i]->summary.objective_mean, -effort_of(tracks[i], kinds[i]),
                  1e-12 * effort_of(tracks[i], kinds[i]));
  }
  for (int k = 0; k < KINDS; ++k)
    for (int i = 0; i < WORDS; ++i)
      if (i != k)
        assert_true(effort_of(tracks[k], kinds[k]) < effort_of(tracks[i], kinds[k]));
  for (int i = 0; i < WORDS; ++i) {
    km_track_free(tracks[i]);
    km_study_free(studies[i]);
  }
  fixture_close(&f);
}

/* Three links of 1 m and 2 kg in a vertical plane, whose tip follows a line: one spare freedom. */
#define LINK(name)                                                                                                     \
  "{\"name\": \"" name "\", \"mass\": 2, \"center_of_mass\": [0.5, 0, 0], \"moment_of_inertia\": {\"Izz\": 0.2}, "     \
  "\"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}"
static const char planar_arm[] =
    "{\"model_parameters\": {\"gravity\": [0, -9.81, 0]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [" LINK("l1") ", " LINK(
        "l2") ", " LINK("l3") "], \"joints\": ["
                              "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"l1\"], \"initial_displacement\": 1.2},"
                              "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l1\", \"t\"], \"l2\"], \"initial_displacement\": -1.0},"
                              "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l2\", \"t\"], \"l3\"], \"initial_displacement\": "
                              "-0.8}]}]}";
static const char planar_study[] =
    "{\"effector\": [\"l3\", \"t\"], \"task\": \"position\", \"path\": {\"speed\": 1, \"segments\": [{\"type\": "
    "\"line\", \"to\": [1.6, 0.9, 0], \"steps\": 5}]}, \"objective\": \"%s\", \"methods\": [{\"method\": \"dp\", "
    "\"spacing\": 0.002, \"stride\": 1}]}";

/* The best sum of the objective over all tracks with tan φ of a grid at each of the last `left` samples. */
static double best_of_all(const km_tracker *tracker, km_tracker_space *space, const km_path_node *from, int sample,
                          km_arena *arena) {
  enum { GRID = 9 };
  if (sample == tracker->path->samples - 1)
    return 0.0;
  double best = -(double)INFINITY;
  km_path_node to;
  assert_true(km_path_node_create(tracker->arm, arena, &to));
  for (int i = 0; i < GRID; ++i) {
    const double tan_phi = tan(M_PI / 6.0) * (i - GRID / 2) / (GRID / 2);
    const km_step_choice choice = {.tan_phi = &tan_phi};
    if (km_tracker_step(tracker, space, sample, 1.0, from, &choice, &to).stop)
      continue;
    best = fmax(best, to.weight * to.value + best_of_all(tracker, space, &to, sample + 1, arena));
  }
  return best;
}

/* No track of a full search over a grid of null-space steps has a lower effort than dynamic programming, and its
 * optimum is close to that of the search. */
static void dynamic_programming_finds_the_optimum(void **state) {
  (void)state;
  static const char *const words[] = {"effort", "energy", "positive-work"};
  fixture f = fixture_read(planar_arm);
  for (int w = 0; w < 3; ++w) {
    char text[1024];
    snprintf(text, sizeof text, planar_study, words[w]);
    km_study *study = study_of(&f, text);
    km_track *track = track_of(study, 0, 1);
    const km_track_plan plan = km_study_plan(study, 0);
    const km_tracker tracker = {track->arm, plan.path, &plan.objective};
    km_tracker_space space;
    km_arena arena = {0};
    km_path_node start;
    assert_int_equal(track->end.stop, KM_TRACK_COMPLETE);
    assert_true(km_tracker_space_create(track->arm, &space) && km_path_node_create(track->arm, &arena, &start));
    static const km_step_choice greedy_choice = {0};
    km_tracker_compute_node(&tracker, &space, 0, plan.start, &greedy_choice, &start);
    assert_near(start.weight, 0.0, 0.0);
    const double best = best_of_all(&tracker, &space, &start, 0, &arena) / plan.path->samples;
    assert_true(track->summary.objective_mean >= best);
    assert_true(track->summary.objective_mean <= best * 0.95);
    km_tracker_space_free(&space);
    km_arena_free(&arena);
    km_track_free(track);
    km_study_free(study);
  }
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(joint_forces_satisfy_the_equations_of_motion),
      cmocka_unit_test(work_is_the_change_of_energy),
      cmocka_unit_test(each_optimum_is_the_least_of_its_kind),
      cmocka_unit_test(dynamic_programming_finds_the_optimum),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
