/* Finite mobility of mechanisms for which it is known. */
#include "support/motion_families.h"
#include "support/support.h"

#include "kmech/mobility.h"
#include "model/model.h"

#include <stdio.h>
#include <string.h>

static km_finite_mobility find(fixture *f) {
  km_finite_mobility found;
  km_error error;
  if (km_finite_mobility_find(f->mechanism, f->state, NULL, NULL, &found, &error))
    fail_msg("%s", error.text);
  return found;
}

static void expect(fixture f, int mobility, int motions, km_motion_kind kind) {
  km_finite_mobility found = find(&f);
  assert_int_equal(found.mobility, mobility);
  assert_int_equal(found.motion_count, motions);
  for (int i = 0; i < found.motion_count; ++i) {
    assert_int_equal(found.motions[i].kind, kind);
    assert_true(kind == KM_MOTION_SHAKY ? found.motions[i].confirmed_length == 0.0
                                        : found.motions[i].confirmed_length > 0.01);
  }
  km_mobility mobility_there; /* the state is where it was */
  km_mobility_compute(f.mechanism, f.state, &mobility_there);
  assert_true(mobility_there.residual < 1e-11);
  km_finite_mobility_free(&found);
  fixture_close(&f);
}

static void regular_models(void **state) {
  (void)state;
  static const struct {
    const char *name;
    int mobility, listed;
  } models[] = {{"fourbar", 1, 1}, {"brake", 1, 1},   {"klann", 1, 1},   {"excavator", 4, 3},
                {"bennett", 1, 1}, {"bricard", 1, 1}, {"sarrus3", 1, 1}, {"sarrus4", 1, 1},
                {"stewart", 6, 6}, {"delta", 3, 3},   {"panda", 7, 0}};
  for (size_t i = 0; i < sizeof models / sizeof *models; ++i)
    expect(fixture_open(models[i].name), models[i].mobility, models[i].listed, KM_MOTION_REGULAR);
}

/* Bricard's linkage in a planar pose still moves with one freedom. */
static void bricard_in_its_plane(void **state) {
  (void)state;
  fixture f = fixture_open("bricard");
  km_driver_motion *drive;
  int b;
  assert_int_equal(km_model_find_coordinate(f.model, "B", &b, NULL), KM_OK);
  assert_int_equal(km_driver_motion_create(f.mechanism, f.state, b, true, &drive, NULL), KM_OK);
  assert_int_equal(km_driver_motion_move_to(drive, 0.0).stop, KM_STOP_NONE);
  km_driver_motion_free(drive);
  expect(f, 1, 1, KM_MOTION_REGULAR);
}

/* A planar chain of hinges between two fixed points: `angles` are the joints', `lengths` the links'. */
static fixture chain(int links, const double *lengths, const double *angles, double distance) {
  km_text t = {0};
  km_text_format(&t,
                 "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [%.17g, 0, 0]}]}, \"assemblies\": [{\"name\": "
                 "\"a\", \"bodies\": [",
                 distance);
  for (int i = 0; i < links; ++i)
    km_text_format(&t, "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"t\", \"T\": [%.17g, 0, 0]}]}", i ? ", " : "", i,
                   lengths[i]);
  km_text_add(&t, "], \"joints\": [");
  for (int i = 0; i <= links; ++i) {
    char parent[32], child[32];
    snprintf(parent, sizeof parent, i ? "\"b%d\", \"t\"" : "\"fixed\"", i - 1);
    snprintf(child, sizeof child, i < links ? "\"b%d\"" : "\"fixed\", \"p\"", i);
    km_text_format(
        &t,
        "%s{\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[%s], [%s]], \"initial_displacement\": %.17g}",
        i ? ", " : "", i, parent, child, angles[i]);
  }
  km_text_add(&t, "]}]}");
  fixture f = fixture_read(t.data);
  km_text_free(&t);
  return f;
}

/* Two collinear bars: first order lets the middle hinge move, nothing else does. */
static void collinear_bars_shake(void **state) {
  (void)state;
  expect(chain(2, (const double[]){1, 1}, (const double[]){0, 0, 0}, 2.0), 0, 1, KM_MOTION_SHAKY);
  expect(chain(2, (const double[]){1, 0.6}, (const double[]){0, 0, 0}, 1.6), 0, 1, KM_MOTION_SHAKY);
  expect(chain(4, (const double[]){1, 0.5, 0.7, 0.4}, (const double[]){0, 0, 0, 0, 0}, 2.6), 0, 3, KM_MOTION_SHAKY);
}

/* Any number of bars on a line: stretched they are infinitesimally mobile, since the middle ones can't leave the
 * line; with one bar reversed the chain has the freedoms of its joints minus three. */
static void bars_on_a_line(void **state) {
  (void)state;
  static const double lengths[] = {1.0, 0.7, 1.3, 0.9, 0.4, 1.1};
  for (int links = 2; links <= 6; ++links) {
    double distance = 0.0, angles[7] = {0};
    for (int i = 0; i < links; ++i)
      distance += lengths[i];
    expect(chain(links, lengths, angles, distance), 0, links - 1, KM_MOTION_SHAKY);
    if (links < 3)
      continue;
    angles[1] = M_PI;
    angles[2] = -M_PI;
    fixture f = chain(links, lengths, angles, distance - 2.0 * lengths[1]);
    km_finite_mobility found = find(&f);
    assert_int_equal(found.mobility, links - 2);
    assert_false(found.undecided);
    km_finite_mobility_free(&found);
    fixture_close(&f);
  }
}

static void a_truss_stands(void **state) {
  (void)state;
  expect(chain(2, (const double[]){1, 1}, (const double[]){M_PI / 3, -2 * M_PI / 3, M_PI / 3}, 1.0), 0, 0,
         KM_MOTION_REGULAR);
}

/* A flat parallelogram: a branch point of two motions of one freedom. */
static void change_point_branches(void **state) {
  (void)state;
  expect(chain(3, (const double[]){1, 2, 1}, (const double[]){0, 0, M_PI, -M_PI}, 2.0), 1, 2, KM_MOTION_BRANCH);
}

/* A ring of eight links of length 1 with perpendicular axes at their ends, folded flat by half turns. Joints 1, 5
 * and 7 (from 1) are coaxial, as are 2 and 4, and 6 and 8; the part between two coaxial joints rotates about their
 * axis. Rotation about 6 and 8 moves joint 7 off its axis. So either that part rotates with those of 1 and 5, and of
 * 2 and 4, or 1, 5 and 7 have two freedoms, and 2 and 4 one: two motions of three freedoms, while the instantaneous
 * mobility is four. */
static void flat_ring(void **state) {
  (void)state;
  static const int turned[8] = {0, 0, 1, 0, 0, 1, 1, 1};
  km_text t = {0};
  km_text_add(&t, "{\"assemblies\": [{\"name\": \"ring\", \"bodies\": [");
  for (int i = 0; i < 8; ++i)
    km_text_format(&t,
                   "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0], \"R\": [[1, 0, 0], [0, 0, "
                   "%d], [0, %d, 0]]}]}",
                   i ? ", " : "", i, i % 2 ? 1 : -1, i % 2 ? -1 : 1);
  km_text_add(&t,
              "], \"joints\": [{\"name\": \"ground\", \"type\": \"rigid\", \"body_frame_pairs\": [\"fixed\", \"b7\"]}");
  for (int i = 0; i < 8; ++i)
    km_text_format(&t,
                   ", {\"name\": \"J%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"b%d\", \"t\"], \"b%d\"], "
                   "\"initial_displacement\": %.17g}",
                   i + 1, (i + 7) % 8, i, turned[i] * M_PI);
  km_text_add(&t, "]}]}");
  fixture f = fixture_read(t.data);
  km_text_free(&t);
  km_mobility first_order;
  km_mobility_compute(f.mechanism, f.state, &first_order);
  assert_int_equal(first_order.mobility, 4);
  km_finite_mobility found = find(&f);
  assert_int_equal(found.mobility, 3);
  assert_false(found.undecided);
  km_finite_mobility_free(&found);
  fixture_close(&f);
}

/* A loop of seven revolute joints, by their axes and points. Joints 1 and 4 (from 1) are coaxial, as are 2 and 5:
 * the part between such a pair rotates about its axis, and moves a joint of the other pair. A branch point of two
 * motions of one freedom whose separation no second-order condition shows. */
static void two_pairs_in_a_chain(void **state) {
  (void)state;
  static const struct {
    char axis;
    int x, y, z;
  } hinges[7] = {{'z', -1, -1, -1}, {'x', -1, -1, -1}, {'y', 1, 0, -1}, {'z', -1, -1, 1},
                 {'x', 1, -1, -1},  {'y', 0, 1, 1},    {'y', -1, -1, 0}};
  km_text t = {0};
  km_text_add(
      &t,
      "{\"model_parameters\": {\"version\": \"1.1\"}, \"assemblies\": [{\"name\": \"a\", \"drawn\": \"assembled\", \"bodies\": [");
  for (int i = 0; i < 6; ++i)
    km_text_format(&t, "%s{\"name\": \"b%d\"}", i ? ", " : "", i);
  km_text_add(&t, "], \"joints\": [");
  for (int i = 0; i < 7; ++i) {
    char parent[16], child[16];
    snprintf(parent, sizeof parent, i ? "b%d" : "fixed", i - 1);
    snprintf(child, sizeof child, i < 6 ? "b%d" : "fixed", i);
    km_text_format(&t,
                   "%s{\"name\": \"J%d\", \"type\": \"revolute\", \"bodies\": [\"%s\", \"%s\"], \"at\": [%d, %d, %d], "
                   "\"axis\": [%d, %d, %d]}",
                   i ? ", " : "", i + 1, parent, child, hinges[i].x, hinges[i].y, hinges[i].z, hinges[i].axis == 'x',
                   hinges[i].axis == 'y', hinges[i].axis == 'z');
  }
  km_text_add(&t, "]}]}");
  expect(fixture_read(t.data), 1, 2, KM_MOTION_BRANCH);
  km_text_free(&t);
}

static void random_families(void **state) {
  (void)state;
  static bool (*const families[])(uint64_t) = {family_moving, family_contact, family_shaky, family_change_point};
  int failed = 0;
  for (size_t i = 0; i < sizeof families / sizeof *families; ++i)
    for (uint64_t seed = 1; seed <= 200; ++seed)
      failed += !families[i](seed);
  assert_int_equal(failed, 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(regular_models), cmocka_unit_test(bricard_in_its_plane), cmocka_unit_test(collinear_bars_shake),
      cmocka_unit_test(bars_on_a_line), cmocka_unit_test(a_truss_stands),       cmocka_unit_test(change_point_branches),
      cmocka_unit_test(flat_ring),      cmocka_unit_test(two_pairs_in_a_chain), cmocka_unit_test(random_families)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
