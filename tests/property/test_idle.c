/* Idle freedoms of rods and struts between ball joints; none where every body has something to move. */
#include "support/support.h"

#include "base/text.h"
#include "kmech/mobility.h"

#include <string.h>

static km_passive_freedoms idle_of(fixture *f) {
  km_passive_freedoms idle;
  km_error error;
  if (km_passive_freedoms_find(f->mechanism, f->state, NULL, NULL, &idle, &error))
    fail_msg("%s", error.text);
  return idle;
}

/* A triangle in space: a ground pivot with a link, and a leg from its end to the ground at (x, y, z). The leg is one
 * rod (types: two ends) or two bodies (types: end, joint between, end); the first end on the ground. */
static fixture leg(const char *const *types, int joints, double x, double y, double z) {
  km_text t = {0};
  km_text_format(
      &t,
      "{\"fixed\": {\"frames\": [{\"name\": \"g\", \"T\": [%g, %g, %g]}]}, \"assemblies\": [{\"name\": \"a\", "
      "\"bodies\": [{\"name\": \"link\", \"frames\": [{\"name\": \"e\", \"T\": [1, 0, 0]}]}, {\"name\": "
      "\"foot\", \"frames\": [{\"name\": \"e\", \"T\": [0, 0, 0.8]}]}%s], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"link\"]},"
      "{\"name\": \"B\", \"type\": \"%s\", \"body_frame_pairs\": [[\"fixed\", \"g\"], \"foot\"]},",
      x, y, z, joints == 3 ? ", {\"name\": \"head\", \"frames\": [{\"name\": \"e\", \"T\": [0, 0, 0.4]}]}" : "",
      types[0]);
  if (joints == 3)
    km_text_format(
        &t,
        "{\"name\": \"C\", \"type\": \"%s\", \"body_frame_pairs\": [[\"foot\", \"e\"], \"head\"]},"
        "{\"name\": \"D\", \"type\": \"%s\", \"body_frame_pairs\": [[\"head\", \"e\"], [\"link\", \"e\"]]}]}]}",
        types[1], types[2]);
  else
    km_text_format(
        &t, "{\"name\": \"C\", \"type\": \"%s\", \"body_frame_pairs\": [[\"foot\", \"e\"], [\"link\", \"e\"]]}]}]}",
        types[1]);
  fixture f = fixture_read(t.data);
  km_text_free(&t);
  return f;
}

typedef struct expectation {
  const char *types[3];
  int joints, mobility, groups; /* idle freedoms, and how many groups have them */
} expectation;

static void legs(void **state) {
  (void)state;
  static const expectation all[] = {
      {{"spherical", "spherical"}, 2, 1, 1},                /* a rod */
      {{"universal", "spherical"}, 2, 0, 0},                /* its fork keeps it from spinning */
      {{"spherical", "Tz", "spherical"}, 3, 1, 1},          /* cylinder and piston spin together */
      {{"spherical", "cylindrical", "spherical"}, 3, 2, 2}, /* each by itself */
      {{"universal", "cylindrical", "spherical"}, 3, 1, 1},
      {{"universal", "Tz", "spherical"}, 3, 0, 0},
      {{"universal", "cylindrical", "universal"}, 3, 0, 0},
  };
  randomness r = {1};
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    for (int k = 0; k < 5; ++k) {
      fixture f =
          leg(all[i].types, all[i].joints, uniform(&r, 0.5, 0.9), uniform(&r, 0.1, 0.4), uniform(&r, -0.6, -0.4));
      double before = f.state->q[0];
      km_passive_freedoms idle = idle_of(&f);
      assert_int_equal(idle.mobility, all[i].mobility);
      assert_int_equal(idle.count, all[i].groups);
      assert_true(f.state->q[0] == before);
      for (int n = 0; n < idle.count; ++n)
        for (int b = 0; b < idle.items[n].body_count; ++b)
          assert_string_not_equal(km_model_body_name(f.model, idle.items[n].bodies[b]), "link");
      km_passive_freedoms_free(&idle);
      fixture_close(&f);
    }
}

/* A shaft in two bearings turns; that is what it is for. */
static void a_shaft_is_not_idle(void **state) {
  (void)state;
  fixture f = fixture_read(
      "{\"fixed\": {\"frames\": [{\"name\": \"g\", \"T\": [0, 0, 1]}]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": "
      "[{\"name\": \"shaft\", \"frames\": [{\"name\": \"e\", \"T\": [0, 0, 1]}]}], \"joints\": ["
      "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"shaft\"]},"
      "{\"name\": \"B\", \"type\": \"cylindrical\", \"body_frame_pairs\": [[\"fixed\", \"g\"], [\"shaft\", "
      "\"e\"]]}]}]}");
  km_passive_freedoms idle = idle_of(&f);
  assert_int_equal(idle.mobility, 0);
  km_passive_freedoms_free(&idle);
  fixture_close(&f);
}

static void shipped_models_have_none_but_a_rod(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    km_passive_freedoms idle = idle_of(&f);
    assert_int_equal(idle.mobility, strcmp(*name, "rssr") == 0);
    km_passive_freedoms_free(&idle);
    fixture_close(&f);
  }
}

static bool refuse(void *context, double done) {
  (void)context, (void)done;
  return false;
}

static void searches_can_be_cancelled(void **state) {
  (void)state;
  fixture f = fixture_open("rssr");
  km_passive_freedoms idle;
  km_error error;
  assert_int_equal(km_passive_freedoms_find(f.mechanism, f.state, refuse, NULL, &idle, &error), KM_CANCELLED);
  assert_string_equal(error.text, "the search for the passive freedoms was cancelled");
  km_passive_freedoms_free(&idle);
  fixture_close(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(legs), cmocka_unit_test(a_shaft_is_not_idle),
                                     cmocka_unit_test(shipped_models_have_none_but_a_rod),
                                     cmocka_unit_test(searches_can_be_cancelled)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
