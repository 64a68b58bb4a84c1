/* Motions in a batch have the bits of single motions: in SIMD lanes, after leaving the lanes for a limit, a dead
 * point or new pivots, and whatever the other lanes contain. */
#include "support/linkages.h"
#include "support/planar.h"

#include "continuation/batch/batch_arrays.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "kmech/sweep.h"
#include "mobility/mobility_numbers.h"
#include "sweep/sweep_observer.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ROWS = 120 };

/* A design, and the drive of its sweep's joint. */
typedef struct design {
  fixture f;
  km_driver_motion *drive;
  double from, to;
} design;

/* Loops in space by their seed: seed / 100 is the shape, and those of one shape are a little different. The first
 * shapes are overconstrained, and differ in size; the others have hinges, slides and a screw, each in a place of its
 * own, and mostly a ball joint. */
static const char space_loop[] = "a loop in space";
enum { SHAPES = MOVING_KINDS + 12, AXES = 7 };
/* Ball joint: none; held, with seven axes; with four axes (one freedom); with six axes (three freedoms). */
typedef enum ball { NO_BALL, HELD, OF_ONE_FREEDOM, OF_SEVERAL, BALLS } ball;
static const int joint_counts[BALLS] = {AXES, AXES + 1, 5, AXES};

static linkage random_axes(int count, randomness *shape, randomness *own) {
  km_vec3 at[MOST_AXES], along[MOST_AXES];
  for (int j = 0; j < count; ++j) {
    at[j] = km_vec3_axpy(0.01, random_point(own), random_point(shape));
    along[j] = km_vec3_axpy(0.01, random_point(own), random_direction(shape));
    along[j] = km_vec3_scale(1.0 / km_vec3_norm(along[j]), along[j]);
  }
  linkage l = hinged_loop(at, along, count);
  for (int j = 1; j < count - 2; ++j)
    l.joint[j].slides = below(shape, 4) == 0;
  return l;
}

/* Replaces the text in place. */
static char *replaced(char *text, const char *place, const char *from, const char *to) {
  char *out = edited(text, place, from, to);
  km_free(text);
  return out;
}

static fixture open_overconstrained_loop(int kind, double size, randomness *shape) {
  linkage l = moving_loop(kind, shape);
  char *text = linkage_text(&l, (writing){.own_frames = true, .size = size}, shape);
  fixture f = fixture_read(text);
  km_free(text);
  return f;
}

static fixture open_own_axes(ball kind, randomness *shape, randomness *own) {
  char screw[64], hinge[16], last[16];
  int count = joint_counts[kind];
  snprintf(hinge, sizeof hinge, "\"J%d\"", kind == NO_BALL ? count - 1 : count - 2);
  snprintf(last, sizeof last, "\"J%d\"", count - 1);
  linkage l = random_axes(count, shape, own);
  char *text = linkage_text(&l, (writing){.size = 1.0}, own);
  snprintf(screw, sizeof screw, "\"screw\", \"pitch\": %.17g", uniform(own, 0.1, 0.11));
  text = replaced(text, hinge, "\"Rz\"", screw);
  if (kind != NO_BALL) {
    text = replaced(text, last, "\"Rz\"", "\"spherical\"");
    text = replaced(text, last, "displacement\": 0", "displacement\": [0, 0, 0]");
  }
  fixture f = fixture_read(text);
  km_free(text);
  if (kind != HELD)
    return f;
  const km_hold holds[3] = {{AXES, 0.0}, {AXES + 1, 0.0}, {AXES + 2, 0.0}};
  km_state_free(f.state);
  km_mechanism_free(f.mechanism);
  assert_int_equal(km_mechanism_compile(f.model, holds, 3, &f.mechanism, NULL), KM_OK);
  assert_int_equal(km_state_create(f.mechanism, &f.state, NULL), KM_OK);
  assert_int_equal(km_assemble(f.mechanism, f.state, NULL, NULL), KM_OK);
  return f;
}

static fixture open_space_loop(uint64_t seed) {
  int kind = (int)(seed / 100);
  randomness shape = {77 + seed / 100}, own = {seed};
  if (kind < MOVING_KINDS)
    return open_overconstrained_loop(kind, 1.0 + 0.01 * (double)(seed % 100), &shape);
  return open_own_axes((ball)(kind % BALLS), &shape, &own);
}

/* A four-bar in a plane, and beside it a pendulum on a ball joint, in no loop. */
static const char beside_pendulum[] = "a four-bar beside a pendulum";

static fixture open_beside_pendulum(uint64_t seed) {
  char text[1024];
  snprintf(text, sizeof text,
           "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"crank\"}, "
           "{\"name\": \"coupler\"}, {\"name\": \"rocker\"}, {\"name\": \"bob\"}], \"joints\": ["
           "{\"name\": \"A\", \"type\": \"Rz\", \"bodies\": [\"fixed\", \"crank\"], \"at\": [0, 0, 0]}, "
           "{\"name\": \"B\", \"type\": \"Rz\", \"bodies\": [\"crank\", \"coupler\"], \"at\": [0, %.17g, 0]}, "
           "{\"name\": \"C\", \"type\": \"Rz\", \"bodies\": [\"coupler\", \"rocker\"], \"at\": [3, 2, 0]}, "
           "{\"name\": \"D\", \"type\": \"Rz\", \"bodies\": [\"fixed\", \"rocker\"], \"at\": [3, 0, 0]}, "
           "{\"name\": \"S\", \"type\": \"spherical\", \"bodies\": [\"fixed\", \"bob\"], \"at\": [5, 0, 0]}]}]}",
           1.0 + 1e-3 * (double)seed);
  return fixture_read(text);
}

/* A lever whose block shifts a slide at some height by its tangent: beyond all bounds at a right angle. */
static const char tangent[] = "a lever that shifts a slide away", tangent_end[] = "its last poses, close to each other";

static fixture open_tangent(uint64_t seed) {
  char text[1024];
  const double height = 1.0 + 1e-3 * (double)seed;
  snprintf(
      text, sizeof text,
      "{\"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"lever\"}, "
      "{\"name\": \"block\"}, {\"name\": \"slide\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"revolute\", \"bodies\": [\"fixed\", \"lever\"], \"at\": [0, 0]}, "
      "{\"name\": \"B\", \"type\": \"prismatic\", \"bodies\": [\"lever\", \"block\"], \"at\": [0, %.17g], \"axis\": [0, 1]}, "
      "{\"name\": \"C\", \"type\": \"revolute\", \"bodies\": [\"block\", \"slide\"], \"at\": [0, %.17g]}, "
      "{\"name\": \"D\", \"type\": \"prismatic\", \"bodies\": [\"fixed\", \"slide\"], \"at\": [0, %.17g], \"axis\": [1, 0]}]}]}",
      height, height, height);
  return fixture_read(text);
}

/* A linkage of ten hinges of which one stands twice between two of the few rows. */
static const char twice[] = "a joint that stands twice between two rows";

static fixture open_twice(uint64_t seed) {
  randomness shape = {3480}, own = {seed};
  planar p = planar_random(&shape, 1, 1 + below(&shape, 3), false);
  for (int j = 0; j < p.joints; ++j)
    p.joint[j].place[0] += 1e-4 * uniform(&own, -1.0, 1.0);
  char *text = planar_text(&p);
  fixture f = fixture_read(text);
  km_free(text);
  return f;
}

static fixture open_fixture(const char *name, uint64_t seed) {
  return name == space_loop                       ? open_space_loop(seed)
         : name == twice                          ? open_twice(seed)
         : name == beside_pendulum                ? open_beside_pendulum(seed)
         : name == tangent || name == tangent_end ? open_tangent(seed)
                                                  : fixture_open_variant(name, seed);
}

static km_sweep_plan plan_of(const char *name, const km_model *model) {
  km_sweep_plan plan = km_sweep_plan_default(model);
  if (name == space_loop || name == beside_pendulum)
    plan = (km_sweep_plan){.coordinate = 0, .from = 0.0, .to = 0.3};
  if (name == tangent)
    plan = (km_sweep_plan){.coordinate = 0, .from = -1.5, .to = 2.0};
  if (name == tangent_end)
    plan = (km_sweep_plan){.coordinate = 0, .from = 1.5697, .to = 1.5699};
  if (name == twice)
    plan = (km_sweep_plan){.coordinate = 1, .from = -0.148, .to = 0.437, .steps = 9};
  plan.direction = -1;
  return plan;
}

static design open_design(const char *name, uint64_t seed, bool ignore_limits) {
  design d = {.f = open_fixture(name, seed)};
  km_sweep_plan plan = plan_of(name, d.f.model);
  d.from = plan.from;
  d.to = plan.to;
  assert_int_equal(km_driver_motion_create(d.f.mechanism, d.f.state, plan.coordinate, ignore_limits, &d.drive, NULL),
                   KM_OK);
  return d;
}

static void close_design(design *d) {
  km_driver_motion_free(d->drive);
  fixture_close(&d->f);
}

/* Data of a row of a sweep. */
typedef struct shown {
  double residual;
  double direction[64];
} shown;

static shown look(design *d) {
  const km_mechanism *m = d->f.mechanism;
  int sub = d->drive->c.substructure;
  const km_substructure *s = &m->substructures[sub];
  shown out = {0};
  if (km_driver_motion_is_batched(d->drive)) {
    out.residual = km_driver_motion_batched_residual(d->drive);
    if (km_factor_freedom(d->f.state->factor[sub]) == 1)
      km_driver_motion_batched_direction(d->drive, out.direction);
    return out;
  }
  km_numbers_update(m, d->f.state, sub);
  out.residual = km_loops_residual(m, d->f.state, s);
  const double *Z = km_state_basis(d->f.state, sub);
  double sense = Z[d->drive->c.column] < 0.0 ? -1.0 : 1.0;
  for (int k = 0; k < s->columns && km_factor_freedom(d->f.state->factor[sub]) == 1; ++k)
    out.direction[m->column_coordinate[s->column_start + k]] = sense * Z[k];
  return out;
}

static void same_bits(const char *name, int row, design *a, design *b) {
  int n = a->f.mechanism->coordinate_count;
  assert_true(n <= 64);
  shown x = look(a), y = look(b);
  for (int c = 0; c < n; ++c)
    if (a->f.state->q[c] != b->f.state->q[c] || x.direction[c] != y.direction[c] ||
        a->f.state->mobility_number[c] != b->f.state->mobility_number[c])
      fail_msg("%s, row %d, coordinate %d: %.17g %.17g %.17g beside others, %.17g %.17g %.17g alone", name, row, c,
               a->f.state->q[c], x.direction[c], a->f.state->mobility_number[c], b->f.state->q[c], y.direction[c],
               b->f.state->mobility_number[c]);
  assert_true(x.residual == y.residual);
}

/* All that a drive leaves, when it goes on alone. */
static void same_end(design *a, design *b) {
  double x[64] = {0}, y[64] = {0}; /* a motion without tangent writes nothing */
  const km_mechanism *m = a->f.mechanism;
  assert_true(km_driver_motion_tangent(a->drive, x) == km_driver_motion_tangent(b->drive, y));
  assert_memory_equal(x, y, (size_t)m->coordinate_count * sizeof *x);
  assert_memory_equal(a->f.state->jacobian, b->f.state->jacobian, m->matrix_size * sizeof(double));
}

static void same_reach(const km_motion_end *a, const km_motion_end *b) {
  assert_int_equal(a->stop, b->stop);
  assert_true(a->position == b->position);
  assert_int_equal(a->coordinate, b->coordinate);
}

/* Target of design i of `count` at a row. Uneven: some designs have a several times larger range. */
static double target_at(const design *d, int i, int row, int rows, bool uneven) {
  double part = (double)row / rows;
  return d->from + (d->to - d->from) * (uneven ? part / (1 + i % 4) : part);
}

/* Ranges and rows of the designs. */
typedef struct manner {
  int rows;
  bool ignore_limits, uneven;
  bool in_turns; /* not all of them at once: mostly most of them, sometimes few */
  bool tries;    /* km_batch_try, then singly if that fails */
} manner;

static const manner plain = {.rows = ROWS};

static unsigned whose_turn(const manner *how, int round) {
  unsigned most = 0;
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    most |= (round + i) % 4 ? 1u << i : 0;
  return !how->in_turns ? ~0u : round % 9 == 8 ? 0x21u : most;
}

static void move_beside(const manner *how, km_batch *lanes, unsigned wanted, const double *targets,
                        km_motion_end *reaches) {
  if (!how->tries) {
    km_batch_move_to(lanes, wanted, targets, reaches);
    return;
  }
  unsigned there = km_batch_try(lanes, wanted, targets, reaches);
  for (unsigned left = wanted & ~there; left; left &= left - 1) {
    int i = __builtin_ctz(left);
    reaches[i] = km_driver_motion_move_to(lanes->drives[i], targets[i]);
  }
}

/* Drives `count` designs in a batch, and singly. Returns the number of rows reached in lanes. */
static int compare(const char *name, int count, uint64_t seed, manner how) {
  design beside[KM_BATCH_LANES], alone[KM_BATCH_LANES];
  km_driver_motion *drives[KM_BATCH_LANES] = {NULL};
  km_batch *lanes;
  int ridden = 0, rows[KM_BATCH_LANES] = {0};
  for (int i = 0; i < count; ++i) {
    beside[i] = open_design(name, seed ? seed + (uint64_t)i : 0, how.ignore_limits);
    alone[i] = open_design(name, seed ? seed + (uint64_t)i : 0, how.ignore_limits);
    drives[i] = beside[i].drive;
  }
  assert_int_equal(km_batch_create(NULL, drives, count, &lanes, NULL), KM_OK);
  unsigned going = lanes ? (1u << count) - 1 : 0;
  for (int round = 0; going; ++round) {
    double targets[KM_BATCH_LANES];
    km_motion_end reaches[KM_BATCH_LANES];
    unsigned wanted = going & whose_turn(&how, round);
    if (!wanted)
      continue;
    for (int i = 0; i < count; ++i)
      targets[i] = target_at(&beside[i], i, rows[i], how.rows, how.uneven);
    move_beside(&how, lanes, wanted, targets, reaches);
    ridden += __builtin_popcount(lanes->unwritten & wanted);
    for (unsigned left = wanted; left; left &= left - 1) {
      int i = __builtin_ctz(left);
      km_motion_end reach = km_driver_motion_move_to(alone[i].drive, targets[i]);
      same_reach(&reaches[i], &reach);
      same_bits(name, rows[i], &beside[i], &alone[i]);
      if ((rows[i] > 0 && reach.stop) || rows[i] == how.rows)
        going &= ~(1u << i);
      ++rows[i];
    }
  }
  km_batch_free(NULL, lanes);
  for (int i = 0; i < count; ++i) {
    same_bits(name, -1, &beside[i], &alone[i]);
    same_end(&beside[i], &alone[i]);
    close_design(&beside[i]);
    close_design(&alone[i]);
  }
  return ridden;
}

static bool has_sweep(const char *name) {
  fixture f = fixture_open(name);
  km_sweep_plan plan = km_sweep_plan_default(f.model);
  bool has = plan.coordinate >= 0 && f.mechanism->substructure_of[plan.coordinate] >= 0;
  fixture_close(&f);
  return has;
}

static void as_alone(void **state) {
  (void)state;
  int rode = 0;
  for (const char *const *name = all_models; *name; ++name) {
    if (!has_sweep(*name))
      continue;
    int steps = compare(*name, KM_BATCH_LANES, 1, plain) +
                compare(*name, KM_BATCH_LANES, 100, (manner){.rows = ROWS, .ignore_limits = true}) +
                compare(*name, KM_BATCH_LANES, 200, (manner){.rows = ROWS / 10, .uneven = true});
    rode += steps > 0;
  }
  assert_true(rode >= 5);
}

/* Any number of drives, equal ones too. */
static void any_number(void **state) {
  (void)state;
  for (int count = 1; count <= KM_BATCH_LANES; ++count)
    assert_true(compare("slider_crank", count, 7, plain) > count * ROWS / 2);
  assert_true(compare("excavator", KM_BATCH_LANES, 0, plain) > KM_BATCH_LANES * ROWS / 2);
}

/* The step history of a lane is kept while others advance, and after it has left the batch. */
static void in_turns(void **state) {
  (void)state;
  static const char *const names[] = {"slider_crank", "excavator", "klann", "toggle_press", "bennett", "delta"};
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
    for (int tries = 0; tries < 2; ++tries)
      assert_true(compare(names[k], KM_BATCH_LANES, 1, (manner){.rows = ROWS, .in_turns = true, .tries = tries}) >
                  ROWS);
}

/* Spatial loops are batched, too. */
static void in_space(void **state) {
  (void)state;
  int rode = 0;
  for (int shape = 0; shape < SHAPES; ++shape) {
    uint64_t seed = 100 * (uint64_t)shape + 1;
    int steps = compare(space_loop, KM_BATCH_LANES, seed, plain) +
                compare(space_loop, 5, seed + 40, (manner){.rows = ROWS / 4, .ignore_limits = true, .uneven = true});
    rode += steps > 0;
  }
  assert_true(rode > SHAPES / 2); /* the others end at once */
  static const char *const names[] = {"bennett", "bricard", "sarrus3", "delta", "stewart"};
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
    assert_true(compare(names[k], KM_BATCH_LANES, 0, plain) > KM_BATCH_LANES * ROWS / 2);
  assert_true(compare(beside_pendulum, KM_BATCH_LANES, 1, plain) > KM_BATCH_LANES * ROWS / 2);
}

/* Samples near a row in lanes: the rates equal those of a single motion that is restored afterwards, and later rows
 * are unchanged. */
static void compare_visits(const char *name) {
  design beside[KM_BATCH_LANES], alone[KM_BATCH_LANES];
  km_driver_motion *drives[KM_BATCH_LANES];
  double rates[KM_BATCH_LANES][64], expected[64], *out[KM_BATCH_LANES];
  const unsigned all = (1u << KM_BATCH_LANES) - 1;
  km_batch *lanes;
  int visited = 0;
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    beside[i] = open_design(name, 50 + (uint64_t)i, false);
    alone[i] = open_design(name, 50 + (uint64_t)i, false);
    drives[i] = beside[i].drive;
    out[i] = rates[i];
  }
  assert_int_equal(km_batch_create(NULL, drives, KM_BATCH_LANES, &lanes, NULL), KM_OK);
  for (int row = 0; row <= ROWS; ++row) {
    double targets[KM_BATCH_LANES], places[KM_BATCH_LANES];
    km_motion_end reaches[KM_BATCH_LANES];
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      targets[i] = target_at(&beside[i], i, row, ROWS, false);
      places[i] = targets[i] - 0.4 * (beside[i].to - beside[i].from) / ROWS * (i % 5 - 2);
    }
    km_batch_move_to(lanes, all, targets, reaches);
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      km_driver_motion_move_to(alone[i].drive, targets[i]);
      same_bits(name, row, &beside[i], &alone[i]);
    }
    unsigned there = km_batch_sample(lanes, all & ~(1u << row % KM_BATCH_LANES), places, out);
    visited += __builtin_popcount(there);
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      if (!(there >> i & 1))
        continue;
      km_driver_motion_save(alone[i].drive);
      assert_int_equal(km_driver_motion_move_to(alone[i].drive, places[i]).stop, KM_STOP_NONE);
      assert_true(km_driver_motion_tangent(alone[i].drive, expected));
      km_driver_motion_restore(alone[i].drive);
      assert_memory_equal(rates[i], expected, (size_t)beside[i].f.mechanism->coordinate_count * sizeof *expected);
    }
  }
  assert_true(visited > ROWS);
  km_batch_free(NULL, lanes);
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    same_end(&beside[i], &alone[i]);
    close_design(&beside[i]);
    close_design(&alone[i]);
  }
}

static void visits(void **state) {
  (void)state;
  compare_visits("slider_crank");
  compare_visits("klann");
  compare_visits("brake");
  compare_visits("rssr");
}

/* The ninth joint, between two rows, so that its number shows nothing. */
static void stands_twice(const km_mobility_sweep *sweep) {
  double s[2];
  int count = 0;
  for (size_t t = 0; t < sweep->toggle_count; ++t)
    if (sweep->toggles[t].coordinate == 8 && count < 2)
      s[count++] = sweep->toggles[t].s;
  assert_int_equal(count, 2);
  for (size_t row = 0; row < km_table_rows(sweep->motion.table); ++row) {
    double at = km_table_row(sweep->motion.table, row)[1];
    assert_false(at >= s[0] && at <= s[1]);
  }
}

/* Batched sweeps, over many rows at once without events, have the tables and toggles of single sweeps. */
static void sweeps_as_alone(void **state) {
  (void)state;
  static const char *const models[] = {"slider_crank", "fourbar", "excavator", "klann", "brake",
                                       "rssr",         "delta",   "stewart",   twice};
  for (size_t k = 0; k < sizeof models / sizeof *models; ++k) {
    design d[KM_BATCH_LANES];
    km_mobility_sweep beside[KM_BATCH_LANES];
    km_sweep_job jobs[KM_BATCH_LANES];
    km_error errors[KM_BATCH_LANES];
    km_sweep_plan plan;
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      d[i] = open_design(models[k], 300 + (uint64_t)i, false);
      plan = plan_of(models[k], d[i].f.model);
      jobs[i] = (km_sweep_job){.m = d[i].f.mechanism, .s = d[i].f.state, .plan = &plan, .error = &errors[i]};
      km_mobility_sweep_open(&jobs[i], NULL, &beside[i]);
    }
    km_sweeps_run(jobs, KM_BATCH_LANES);
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      design again = open_design(models[k], 300 + (uint64_t)i, false);
      km_mobility_sweep alone;
      assert_int_equal(km_mobility_sweep_run(again.f.mechanism, again.f.state, &plan, &alone, NULL), jobs[i].status);
      size_t rows = km_table_rows(alone.motion.table), columns = km_table_columns(alone.motion.table);
      assert_int_equal(km_table_rows(beside[i].motion.table), rows);
      for (size_t row = 0; row < rows; ++row)
        for (size_t c = 0; c < columns; ++c) {
          double x = km_table_row(beside[i].motion.table, row)[c], y = km_table_row(alone.motion.table, row)[c];
          if (x != y && !(isnan(x) && isnan(y)))
            fail_msg("%s, design %d, row %zu, %s: %.17g beside others, %.17g alone", models[k], i, row,
                     km_table_name(alone.motion.table, c), x, y);
        }
      assert_int_equal(beside[i].toggle_count, alone.toggle_count);
      for (size_t t = 0; t < alone.toggle_count; ++t) {
        assert_int_equal(beside[i].toggles[t].coordinate, alone.toggles[t].coordinate);
        assert_true(beside[i].toggles[t].s == alone.toggles[t].s);
      }
      if (models[k] == twice)
        stands_twice(&alone);
      for (int c = 0; c < again.f.mechanism->coordinate_count; ++c)
        assert_true(beside[i].extremes[c].number == alone.extremes[c].number);
      km_mobility_sweep_free(&alone);
      close_design(&again);
    }
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      km_mobility_sweep_free(&beside[i]);
      close_design(&d[i]);
    }
  }
}

/* Searches pivots that may include the driver, as an analysis of a configuration does. */
static void search_pivots(design *d) {
  km_search_pivots(d->f.mechanism, d->f.state, d->drive->c.substructure, KM_NO_DRIVER, 1e-9);
}

/* A drive that is looked at stays in its lane, and its state shows what it shows alone. It leaves it where pivots
 * were searched meanwhile. Returns how many looks found the drive in its lane. */
static int compare_looks(const char *name) {
  design beside[KM_BATCH_LANES], alone[KM_BATCH_LANES];
  km_driver_motion *drives[KM_BATCH_LANES];
  km_batch *lanes;
  const unsigned all = (1u << KM_BATCH_LANES) - 1;
  int ridden = 0;
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    beside[i] = open_design(name, 1 + (uint64_t)i, true);
    alone[i] = open_design(name, 1 + (uint64_t)i, true);
    drives[i] = beside[i].drive;
  }
  assert_int_equal(km_batch_create(NULL, drives, KM_BATCH_LANES, &lanes, NULL), KM_OK);
  assert_non_null(lanes);
  for (int row = 0; row <= ROWS; ++row) {
    double targets[KM_BATCH_LANES];
    km_motion_end reaches[KM_BATCH_LANES];
    for (int i = 0; i < KM_BATCH_LANES; ++i)
      targets[i] = target_at(&beside[i], i, row, ROWS, false);
    km_batch_move_to(lanes, all, targets, reaches);
    for (int i = 0; i < KM_BATCH_LANES; ++i) {
      bool rides = km_driver_motion_is_batched(drives[i]);
      km_driver_motion_move_to(alone[i].drive, targets[i]);
      km_driver_motion_prepare_read(drives[i]);
      assert_int_equal(km_driver_motion_is_batched(drives[i]), rides);
      same_bits(name, row, &beside[i], &alone[i]);
      same_end(&beside[i], &alone[i]);
      assert_int_equal(km_driver_motion_is_batched(drives[i]), rides);
      ridden += rides;
      if (i % 3 == 0 && row % 7 == 3) {
        search_pivots(&beside[i]);
        search_pivots(&alone[i]);
      }
    }
  }
  km_batch_free(NULL, lanes);
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    same_end(&beside[i], &alone[i]);
    close_design(&beside[i]);
    close_design(&alone[i]);
  }
  return ridden;
}

static void looks(void **state) {
  (void)state;
  static const char *const names[] = {"slider_crank", "excavator", "klann", "bennett", "rssr", "delta"};
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k)
    assert_true(compare_looks(names[k]) > KM_BATCH_LANES * ROWS / 2);
}

/* A target that takes too many steps: given up at the same place. */
static void too_far(void **state) {
  (void)state;
  design beside[2] = {open_design("slider_crank", 1, false), open_design("slider_crank", 2, false)};
  design alone[2] = {open_design("slider_crank", 1, false), open_design("slider_crank", 2, false)};
  km_driver_motion *drives[2] = {beside[0].drive, beside[1].drive};
  static const double targets[2] = {1e6, -1e300};
  km_batch *lanes;
  km_motion_end reaches[2];
  assert_int_equal(km_batch_create(NULL, drives, 2, &lanes, NULL), KM_OK);
  for (int i = 0; i < 2; ++i)
    assert_int_equal(km_driver_motion_move_to(beside[i].drive, 0.1).stop,
                     km_driver_motion_move_to(alone[i].drive, 0.1).stop);
  km_batch_move_to(lanes, 3, targets, reaches);
  for (int i = 0; i < 2; ++i) {
    km_motion_end reach = km_driver_motion_move_to(alone[i].drive, targets[i]);
    assert_int_equal(reach.stop, KM_STOP_MAX_STEPS);
    same_reach(&reaches[i], &reach);
  }
  km_batch_free(NULL, lanes);
  for (int i = 0; i < 2; ++i) {
    same_end(&beside[i], &alone[i]);
    close_design(&beside[i]);
    close_design(&alone[i]);
  }
}

/* A slide that leaves ends the drive where it is 1000 sizes away, ahead and back, whatever the rows. */
static void slides_leave(void **state) {
  (void)state;
  for (uint64_t seed = 0; seed < 3; ++seed) {
    design d = open_design(tangent, seed, false);
    const km_mechanism *m = d.f.mechanism;
    const double height = 1.0 + 1e-3 * (double)seed, end = atan(km_driver_motion_diverging * m->unit[3] / height);
    assert_string_equal(d.f.model->coordinates[3].label, "D");
    for (double to = 2.0, part = 0.1; to >= -2.0; to -= 4.0, part = 1.0) {
      km_motion_end reach = km_driver_motion_move_to(d.drive, part * to);
      reach = reach.stop ? reach : km_driver_motion_move_to(d.drive, to);
      assert_int_equal(reach.stop, KM_STOP_UNBOUNDED);
      assert_int_equal(reach.coordinate, 3);
      assert_near(reach.position, copysign(end, to), 1e-9);
      assert_near(d.f.state->q[3], -height * tan(reach.position),
                  1e-9 * km_driver_motion_diverging * km_driver_motion_diverging);
    }
    close_design(&d);
  }
  assert_true(compare(tangent, KM_BATCH_LANES, 1, plain) > 0);
  compare(tangent_end, KM_BATCH_LANES, 0, (manner){.rows = 400}); /* true if lanes sample there */
  assert_true(compare(tangent, KM_BATCH_LANES, 9, (manner){.rows = 20 * ROWS}) > ROWS);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(as_alone), cmocka_unit_test(any_number), cmocka_unit_test(in_turns),
      cmocka_unit_test(in_space), cmocka_unit_test(visits),     cmocka_unit_test(sweeps_as_alone),
      cmocka_unit_test(looks),    cmocka_unit_test(too_far),    cmocka_unit_test(slides_leave)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
