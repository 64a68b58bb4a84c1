/* Permanently shaky mechanisms: the instantaneous mobility exceeds the finite one everywhere. */
#include "support/random_mechanism.h"
#include "support/support.h"

#include "kmech/continuation.h"
#include "kmech/mobility.h"
#include "kmech/transfer.h"

#include <stdio.h>
#include <string.h>

enum { MOST_RODS = 6 };

/* A platform on equal parallel rods, each with a universal joint on the ground and a ball on the platform, at poses
 * where they lean: it moves across itself, all rods turning alike. With four rods and more it can't turn, but first
 * order allows that. */
static fixture platform(randomness *r, int rods) {
  km_text text = {0};
  double lean[3] = {uniform(r, 0.2, 0.5), uniform(r, 0.1, 0.4), uniform(r, 0.7, 1.1)}, base[MOST_RODS][2];
  for (int i = 0; i < rods; ++i) {
    base[i][0] = cos(6.283 * i / rods + 0.3) + uniform(r, -0.2, 0.2);
    base[i][1] = sin(6.283 * i / rods + 0.3) + uniform(r, -0.2, 0.2);
  }
  km_text_add(&text, "{\"fixed\": {\"frames\": [");
  for (int i = 0; i < rods; ++i)
    km_text_format(&text, "%s{\"name\": \"u%d\", \"T\": [%.17g, %.17g, 0]}", i ? ", " : "", i, base[i][0], base[i][1]);
  km_text_add(&text, "]}, \"assemblies\": [{\"name\": \"m\", \"bodies\": [{\"name\": \"p\", \"frames\": [");
  for (int i = 0; i < rods; ++i)
    km_text_format(&text, "%s{\"name\": \"s%d\", \"T\": [%.17g, %.17g, %.17g]}", i ? ", " : "", i, base[i][0] + lean[0],
                   base[i][1] + lean[1], lean[2]);
  km_text_add(&text, "]}");
  for (int i = 0; i < rods; ++i)
    km_text_format(&text, ", {\"name\": \"r%d\", \"frames\": [{\"name\": \"s\", \"T\": [%.17g, %.17g, %.17g]}]}", i,
                   lean[0], lean[1], lean[2]);
  km_text_add(&text, "], \"joints\": [");
  for (int i = 0; i < rods; ++i)
    km_text_format(
        &text,
        "%s{\"name\": \"U%d\", \"type\": \"universal\", \"body_frame_pairs\": [[\"fixed\", \"u%d\"], \"r%d\"]}, "
        "{\"name\": \"S%d\", \"type\": \"spherical\", \"body_frame_pairs\": [[\"r%d\", \"s\"], [\"p\", \"s%d\"]]}",
        i ? ", " : "", i, i, i, i, i, i);
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static int coordinate(const fixture *f, const char *name) {
  int found = -1;
  assert_int_equal(km_model_find_coordinate(f->model, name, &found, NULL), KM_OK);
  return found;
}

static void assert_moves(fixture *f, int mobility, int finite) {
  km_finite_mobility found;
  km_mobility at;
  km_mobility_compute(f->mechanism, f->state, &at);
  assert_int_equal(at.mobility, mobility);
  assert_int_equal(km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, NULL), KM_OK);
  assert_int_equal(found.mobility, finite);
  assert_false(found.undecided);
  for (int i = 0; i < found.motion_count; ++i)
    assert_int_equal(found.motions[i].kind, i < mobility - finite ? KM_MOTION_SHAKY : KM_MOTION_REGULAR);
  km_finite_mobility_free(&found);
  km_mobility_compute(f->mechanism, f->state, &at);
}

/* Tolerance: closure error of a driven configuration. */
static void assert_alike(const fixture *f, int rods) {
  for (int i = 1; i < rods; ++i)
    for (int k = 0; k < 2; ++k) {
      char name[32], first[32];
      snprintf(name, sizeof name, "U%d[%d]", i, k);
      snprintf(first, sizeof first, "U0[%d]", k);
      assert_near(km_state_coordinate(f->state, coordinate(f, name)),
                  km_state_coordinate(f->state, coordinate(f, first)), 1e-10);
    }
}

static void platforms(void **state) {
  (void)state;
  randomness r = {11};
  for (int i = 0; i < 24; ++i) {
    int rods = 4 + i % 3;
    fixture f = platform(&r, rods);
    km_driver_motion *drive;
    assert_moves(&f, 3, 2);
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, coordinate(&f, "U0[0]"), true, &drive, NULL), KM_OK);
    for (int step = 1; step <= 3; ++step) {
      assert_int_equal(km_driver_motion_move_to(drive, (i % 2 ? -0.2 : 0.2) * step).stop, KM_STOP_NONE);
      assert_alike(&f, rods);
    }
    km_driver_motion_free(drive);
    assert_moves(&f, 3, 2);
    fixture_close(&f);
  }
}

static void platforms_by_arc_length(void **state) {
  (void)state;
  randomness r = {12};
  for (int i = 0; i < 9; ++i) {
    int rods = 4 + i % 3;
    fixture f = platform(&r, rods);
    km_arc_motion *follow;
    assert_int_equal(km_arc_motion_create(f.mechanism, f.state, coordinate(&f, "U1[1]"), 1.0, true, &follow, NULL),
                     KM_OK);
    assert_int_equal(km_arc_motion_start_branches(follow), 0);
    for (int step = 0; step < 5; ++step) {
      assert_int_equal(km_arc_motion_advance(follow, 0.1), KM_OK);
      assert_alike(&f, rods);
    }
    km_arc_motion_free(follow);
    fixture_close(&f);
  }
}

/* A parallelogram; optionally with a stretched chain of two bars between points of its cranks, parallel to its
 * coupler; and with two bars from the coupler to the ground that are stretched to within `gap`. */
typedef struct cranks {
  double x, y, width, part, middle, gap; /* negative: no bars beside */
  bool chain;
} cranks;

static cranks drawn_cranks(randomness *r) {
  return (cranks){.x = uniform(r, 0.2, 0.8),
                  .y = uniform(r, 0.8, 1.4),
                  .width = uniform(r, 1.5, 2.5),
                  .part = uniform(r, 0.2, 0.8),
                  .middle = uniform(r, 0.2, 0.8),
                  .gap = -1.0,
                  .chain = true};
}

static void add_pin(km_text *out, const char *name, const char *parent, const char *child, double x, double y) {
  km_text_format(out,
                 "%s{\"name\": \"%s\", \"type\": \"revolute\", \"bodies\": [\"%s\", \"%s\"], \"at\": [%.17g, %.17g]}",
                 strcmp(name, "A") == 0 ? "" : ", ", name, parent, child, x, y);
}

/* The coupler's point goes on a circle about its own centre, which is furthest from the ground's point in line with
 * that. */
static void add_bars_beside(const cranks *c, km_text *out) {
  const double centre[2] = {0.5 * c->width, 1.0}, point[2] = {centre[0] + c->x, centre[1] + c->y},
               ground[2] = {4.0, -1.0};
  double radius = hypot(c->x, c->y), furthest = hypot(ground[0] - centre[0], ground[1] - centre[1]) + radius;
  double first = 0.55 * (furthest + c->gap), second = furthest + c->gap - first;
  double way[2] = {ground[0] - point[0], ground[1] - point[1]}, apart = hypot(way[0], way[1]);
  double along = (first * first - second * second + apart * apart) / (2.0 * apart),
         aside = sqrt(first * first - along * along);
  double elbow[2] = {point[0] + (along * way[0] - aside * way[1]) / apart,
                     point[1] + (along * way[1] + aside * way[0]) / apart};
  add_pin(out, "T", "c", "t", point[0], point[1]);
  add_pin(out, "U", "t", "u", elbow[0], elbow[1]);
  add_pin(out, "V", "u", "fixed", ground[0], ground[1]);
}

static fixture cranks_fixture(const cranks *c) {
  km_text text = {0};
  km_text_add(
      &text,
      "{\"assemblies\": [{\"name\": \"m\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"l\"}, {\"name\": \"c\"}, "
      "{\"name\": \"r\"}");
  km_text_add(&text, c->chain ? ", {\"name\": \"x\"}, {\"name\": \"y\"}" : "");
  km_text_add(&text, c->gap > 0.0 ? ", {\"name\": \"t\"}, {\"name\": \"u\"}" : "");
  km_text_add(&text, "], \"joints\": [");
  add_pin(&text, "A", "fixed", "l", 0.0, 0.0);
  add_pin(&text, "B", "l", "c", c->x, c->y);
  add_pin(&text, "C", "c", "r", c->x + c->width, c->y);
  add_pin(&text, "D", "fixed", "r", c->width, 0.0);
  if (c->chain) {
    add_pin(&text, "E", "l", "x", c->part * c->x, c->part * c->y);
    add_pin(&text, "F", "x", "y", c->part * c->x + c->middle * c->width, c->part * c->y);
    add_pin(&text, "G", "y", "r", c->part * c->x + c->width, c->part * c->y);
  }
  if (c->gap > 0.0)
    add_bars_beside(c, &text);
  km_text_add(&text, "]}]}");
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static void stretched_chains(void **state) {
  (void)state;
  randomness r = {13};
  for (int i = 0; i < 20; ++i) {
    const cranks c = drawn_cranks(&r);
    fixture f = cranks_fixture(&c);
    km_driver_motion *drive;
    km_transfer *lever;
    km_advantage a;
    km_error error;
    const km_port input = {.kind = KM_PORT_JOINT, .coordinate = coordinate(&f, "A")},
                  output = {.kind = KM_PORT_JOINT, .coordinate = coordinate(&f, "G")};
    assert_moves(&f, 2, 1);
    assert_int_equal(km_transfer_create(f.mechanism, &input, &output, &lever, &error), KM_OK);
    assert_int_equal(km_driver_motion_create(f.mechanism, f.state, input.coordinate, true, &drive, NULL), KM_OK);
    for (int step = 1; step <= 4; ++step) {
      km_mobility at;
      assert_int_equal(km_driver_motion_move_to(drive, (i % 2 ? -0.2 : 0.2) * step).stop, KM_STOP_NONE);
      assert_near(km_state_coordinate(f.state, coordinate(&f, "F")), 0.0, 1e-10);
      km_mobility_compute(f.mechanism, f.state, &at);
      assert_int_equal(at.mobility, 2);
      km_transfer_compute(f.mechanism, f.state, lever, &a);
      assert_int_equal(a.method, KM_ADVANTAGE_SINGLE_FREEDOM);
      assert_near(fabs(a.value), 1.0, 1e-9);
    }
    km_driver_motion_free(drive);
    km_transfer_free(lever);
    fixture_close(&f);
  }
}

/* The chain hinders nothing: all other joints go as without it, also where the bars beside come so near to being
 * stretched that a step could lead over. */
static void chains_hinder_nothing(void **state) {
  (void)state;
  static const double gaps[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5};
  static const char *const names[] = {"A", "B", "C", "D", "T", "U", "V"};
  randomness r = {14};
  for (int i = 0; i < 25; ++i) {
    cranks c = drawn_cranks(&r);
    c.gap = gaps[i % 5];
    fixture with = cranks_fixture(&c);
    c.chain = false;
    fixture without = cranks_fixture(&c);
    km_driver_motion *drives[2];
    assert_int_equal(
        km_driver_motion_create(with.mechanism, with.state, coordinate(&with, "A"), true, &drives[0], NULL), KM_OK);
    assert_int_equal(
        km_driver_motion_create(without.mechanism, without.state, coordinate(&without, "A"), true, &drives[1], NULL),
        KM_OK);
    for (int step = 1; step <= 8; ++step) {
      const double target = 0.785 * step;
      km_stop stop = km_driver_motion_move_to(drives[1], target).stop;
      assert_int_equal(km_driver_motion_move_to(drives[0], target).stop, stop);
      for (size_t k = 0; k < sizeof names / sizeof *names && stop == KM_STOP_NONE; ++k)
        assert_near(km_state_coordinate(with.state, coordinate(&with, names[k])),
                    km_state_coordinate(without.state, coordinate(&without, names[k])), 1e-7);
    }
    for (int k = 0; k < 2; ++k)
      km_driver_motion_free(drives[k]);
    fixture_close(&with);
    fixture_close(&without);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(platforms),
      cmocka_unit_test(platforms_by_arc_length),
      cmocka_unit_test(stretched_chains),
      cmocka_unit_test(chains_hinder_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
