/* Answers don't depend on the units of the file: mobility numbers, the order in which joints could drive, the pose that
 * a poor start is assembled to, leverage. Where no length is stated, lengths are compared over the longest link. */
#include "support/support.h"

#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "kmech/transfer.h"

#include <math.h>
#include <string.h>

enum { SYSTEMS = 4 };

static km_units system_of(int i) {
  static const char *const words[SYSTEMS][KM_QUANTITIES] = {
      {"radians", "meters", "kilograms", "seconds", "newtons"},
      {"degrees", "millimeters", "grams", "milliseconds", "newtons"},
      {"degrees", "inches", "pounds", "seconds", "pounds-force"},
      {"radians", "centimeters", "pounds", "seconds", "newtons"},
  };
  km_units units;
  for (int q = 0; q < KM_QUANTITIES; ++q)
    *km_units_slot(&units, (km_quantity)q) = km_unit_find((km_quantity)q, words[i][q]);
  return units;
}

/* The model in other units, started from q [coordinate] (a's units), not assembled; without a stated length. */
static fixture converted(const fixture *a, int i, const double *q) {
  km_units units = system_of(i);
  km_arena arena = {0};
  km_text text = {0};
  const km_value *tree;
  fixture b = {0};
  km_error error;
  assert_int_equal(km_model_convert(a->model, &units, q, false, &arena, &tree, NULL), KM_OK);
  km_json_write(tree, &text);
  if (km_model_read(text.data, text.size, NULL, &b.model, &error))
    fail_msg("%s", error.text);
  b.model->characteristic_length = 0.0;
  assert_int_equal(km_mechanism_compile(b.model, NULL, 0, &b.mechanism, &error), KM_OK);
  assert_int_equal(km_state_create(b.mechanism, &b.state, &error), KM_OK);
  km_text_free(&text);
  km_arena_free(&arena);
  return b;
}

/* Metres, or radians, of one unit in which the state counts a coordinate. */
static double unit_of(const fixture *f, int c) {
  const km_model_coordinate *def = &f->model->coordinates[c];
  return km_joint_is_length(f->model->joints[def->joint].type, def->index) ? f->model->units.length->si : 1.0;
}

static double in_si(const fixture *f, int c) {
  return f->state->q[c] * unit_of(f, c);
}

static bool pick(const fixture *f, randomness *r, int *in, int *out) {
  *in = below(r, f->mechanism->coordinate_count);
  *out = below(r, f->mechanism->coordinate_count);
  const int *substructure = f->mechanism->substructure_of;
  return *in != *out && substructure[*in] >= 0 && substructure[*in] == substructure[*out] &&
         f->mechanism->ball_of[*in] < 0 && f->mechanism->ball_of[*out] < 0;
}

static km_advantage leverage(fixture *f, int in, int out) {
  km_port input = {.kind = KM_PORT_JOINT, .coordinate = in, .name = "in"},
          output = {.kind = KM_PORT_JOINT, .coordinate = out, .name = "out"};
  km_transfer *lever;
  km_advantage a;
  km_error error;
  if (km_transfer_create(f->mechanism, &input, &output, &lever, &error))
    fail_msg("%s", error.text);
  km_transfer_compute(f->mechanism, f->state, lever, &a);
  km_transfer_free(lever);
  return a;
}

/* Number of coordinates with a larger number than c; ties to 1e-9 don't count. */
static int place_of(const fixture *f, int c) {
  int place = 0;
  for (int o = 0; o < f->mechanism->coordinate_count; ++o)
    place += km_mobility_number(f->state, o) > km_mobility_number(f->state, c) + 1e-9;
  return place;
}

static void assert_alike(fixture *a, fixture *b, int in, int out) {
  km_mobility ma, mb;
  km_mobility_compute(a->mechanism, a->state, &ma);
  km_mobility_compute(b->mechanism, b->state, &mb);
  assert_int_equal(ma.mobility, mb.mobility);
  double length = km_mechanism_characteristic_length(a->mechanism, NULL) * a->model->units.length->si;
  assert_near(km_mechanism_characteristic_length(b->mechanism, NULL) * b->model->units.length->si, length,
              1e-14 * length);
  for (int c = 0; c < a->mechanism->coordinate_count; ++c) {
    assert_near(in_si(a, c), in_si(b, c), 1e-9 * (1.0 + fabs(in_si(a, c))));
    assert_near(km_mobility_number(a->state, c), km_mobility_number(b->state, c), 1e-9);
    assert_int_equal(place_of(a, c), place_of(b, c));
  }
  if (in < 0)
    return;
  km_advantage x = leverage(a, in, out), y = leverage(b, in, out);
  assert_int_equal(x.state, y.state);
  if (x.state == KM_ADVANTAGE_FINITE && fabs(x.value) < 1e6)
    assert_near(x.value * unit_of(a, in) / unit_of(a, out), y.value * unit_of(b, in) / unit_of(b, out),
                1e-8 * fabs(x.value * unit_of(a, in) / unit_of(a, out)));
}

/* Every model, started up to `off` (radians, or longest links) from its own pose. */
static void compare(const char *name, double off, randomness *r) {
  fixture own = fixture_open(name);
  double *q = KM_NEW(double, (size_t)own.model->coordinate_count);
  for (int c = 0; c < own.model->coordinate_count; ++c)
    q[c] =
        (own.state->q[c] + uniform(r, -off, off) / own.mechanism->scale[c]) / km_model_coordinate_factor(own.model, c);
  fixture all[SYSTEMS];
  bool assembled[SYSTEMS];
  int in, out;
  for (int i = 0; i < SYSTEMS; ++i) {
    all[i] = converted(&own, i, q);
    assembled[i] = km_assemble(all[i].mechanism, all[i].state, NULL, NULL) == KM_OK;
    assert_int_equal(assembled[i], assembled[0]);
  }
  bool some = pick(&own, r, &in, &out);
  for (int i = 1; i < SYSTEMS && assembled[0]; ++i)
    assert_alike(&all[0], &all[i], some ? in : -1, out);
  for (int i = 0; i < SYSTEMS; ++i)
    fixture_close(&all[i]);
  km_free(q);
  fixture_close(&own);
}

static void exact_starts(void **state) {
  (void)state;
  randomness r = {1};
  for (const char *const *name = all_models; *name; ++name)
    compare(*name, 0.0, &r);
}

static void poor_starts(void **state) {
  (void)state;
  randomness r = {2};
  for (const char *const *name = all_models; *name; ++name)
    for (int i = 0; i < 10; ++i)
      compare(*name, 0.02, &r);
}

/* A wedge: three slides whose frames coincide on every body. Joints are apart in the assembled pose alone. */
static void no_link_has_a_length(void **state) {
  (void)state;
  static const char wedge[] =
      "{\"model_parameters\": {\"units\": {\"length\": \"millimeters\"}}, \"fixed\": {\"frames\": [{\"name\": \"p\", "
      "\"T\": [30, "
      "40, 0]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\"}, {\"name\": \"c\"}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"]},"
      "{\"name\": \"B\", \"type\": \"Ty\", \"body_frame_pairs\": [\"b\", \"c\"]},"
      "{\"name\": \"C\", \"type\": \"Tx\", \"body_frame_pairs\": [[\"fixed\", \"p\"], \"c\"]}]}]}";
  static const char alone[] =
      "{\"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\"}], \"joints\": [{\"name\": \"A\", \"type\": "
      "\"Tx\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}";
  km_length_source source;
  fixture f = fixture_read(wedge);
  /* A, C move least: A = 15, C = -15 mm, B = 40 mm. Joint B starts at (15, 0), joint C at (30, 40). */
  assert_near(km_mechanism_characteristic_length(f.mechanism, &source), 50.0, 1e-9);
  assert_int_equal(source, KM_LENGTH_JOINTS);
  fixture_close(&f);
  f = fixture_read(alone);
  assert_near(km_mechanism_characteristic_length(f.mechanism, &source), 1.0, 0.0);
  assert_int_equal(source, KM_LENGTH_UNIT);
  fixture_close(&f);
}

/* The longest link is on a moving body, whatever ties it to others; ground pivots and what is bolted to the ground
 * don't count. */
static void the_longest_link(void **state) {
  (void)state;
  static const struct {
    const char *name;
    double length;
  } expected[] = {{"fourbar", 0.5}, {"bricard", 1.5}, {"klann", 1.1051}, {"toggle_press", 250.0}};
  for (size_t i = 0; i < sizeof expected / sizeof *expected; ++i) {
    km_length_source source;
    fixture f = fixture_open(expected[i].name);
    assert_near(km_mechanism_characteristic_length(f.mechanism, &source), expected[i].length,
                1e-14 * expected[i].length);
    assert_int_equal(source, KM_LENGTH_LONGEST_LINK);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(exact_starts), cmocka_unit_test(poor_starts),
                                     cmocka_unit_test(no_link_has_a_length), cmocka_unit_test(the_longest_link)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
