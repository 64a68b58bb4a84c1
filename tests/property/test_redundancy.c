/* Redundant constraints: as many as the rank says, with the right meaning, and with remedies that work. */
#include "support/support.h"

#include "exchange/json/json.h"
#include "kmech/mobility.h"
#include "model/model.h"

#include <string.h>

static km_redundancies find(fixture *f) {
  km_redundancies found;
  km_error error;
  if (km_redundancies_find(f->mechanism, f->state, NULL, NULL, &found, &error))
    fail_msg("%s", error.text);
  return found;
}

static void as_many_as_the_rank_says(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    randomness r = {(uint64_t)(name - all_models) + 40};
    fixture f = fixture_open(*name);
    for (int pose = 0; pose < 3; ++pose) {
      km_mobility mobility;
      km_mobility_compute(f.mechanism, f.state, &mobility);
      km_redundancies found = find(&f);
      assert_int_equal(found.count, mobility.redundant_constraints);
      km_redundancies_free(&found);
      go_somewhere(&f, &r);
    }
    fixture_close(&f);
  }
}

/* A planar linkage in the x-y plane: along z, about x and about y, in every loop. */
static void planar_loops(void **state) {
  (void)state;
  static const char *const names[] = {"fourbar", "klann", "brake", NULL};
  for (const char *const *name = names; *name; ++name) {
    fixture f = fixture_open(*name);
    km_redundancies found = find(&f);
    for (int i = 0; i < found.count; ++i) {
      const km_redundancy *r = &found.items[i];
      assert_int_equal(r->loops, 1);
      assert_true(r->persistent);
      assert_near(fabs(r->direction[2]), r->rotation ? 0.0 : 1.0, 1e-9);
      assert_true(r->remedy_count > 0);
    }
    km_redundancies_free(&found);
    fixture_close(&f);
  }
}

/* Laid flat, a parallelogram has one more: along its links, and only there. */
static void a_pose_can_have_its_own(void **state) {
  (void)state;
  fixture f = parallelogram(0.0);
  km_redundancies found = find(&f);
  int own = 0;
  assert_int_equal(found.count, 4);
  for (int i = 0; i < found.count; ++i) {
    if (found.items[i].persistent)
      continue;
    ++own;
    assert_false(found.items[i].rotation);
    assert_near(found.items[i].direction[0], 1.0, 1e-9);
  }
  assert_int_equal(own, 1);
  km_redundancies_free(&found);
  fixture_close(&f);
}

/* Writes the joint of the text anew as `to`, and reads the model again. */
static fixture swapped(const char *name, const fixture *f, const km_remedy *remedy) {
  km_arena arena = {0};
  km_text out = {0};
  char *text = read_model_text(name);
  const km_value *root;
  const char *label = f->model->joints[remedy->joint].name;
  double q = km_state_coordinate(f->state, f->model->joints[remedy->joint].first_coordinate);
  assert_int_equal(km_json_parse(text, strlen(text), &arena, &root, NULL), KM_OK);
  km_value *joint = NULL;
  const km_value *joints = km_value_get(km_value_get(root, "assemblies")->first, "joints");
  for (km_value *j = joints->first; j; j = j->next)
    if (strcmp(km_value_get(j, "name")->string, label) == 0)
      joint = j;
  assert_non_null(joint);
  for (km_value *v = joint->first; v; v = v->next) {
    if (strcmp(v->key, "initial_displacement") == 0 || strcmp(v->key, "limits") == 0 ||
        strcmp(v->key, "damping") == 0 || strcmp(v->key, "initial_velocity") == 0)
      v->key = v->key[0] == 'd' ? "old_d" : v->key[0] == 'l' ? "old_l" : v->key[8] == 'd' ? "old_id" : "old_iv";
    if (strcmp(v->key, "type") == 0)
      v->string = remedy->to;
  }
  if (strcmp(remedy->to, "cylindrical") == 0)
    km_value_numbers(&arena, joint, "initial_displacement", (const double[]){0.0, q}, 2);
  else
    km_value_numbers(&arena, joint, "initial_displacement", (const double[]){0.0, 0.0, q}, 3);
  ((km_value *)(uintptr_t)km_value_get(root, "known"))->key = "old_known";
  if (km_value_get(root, "analysis"))
    ((km_value *)(uintptr_t)km_value_get(root, "analysis"))->key = "old_analysis";
  km_json_write(root, &out);
  fixture changed = fixture_read(out.data);
  km_text_free(&out);
  km_arena_free(&arena);
  km_free(text);
  return changed;
}

/* Hinges about z become cylindrical or spherical in their own frames: as much redundancy less as freedom more. */
static void remedies_work(void **state) {
  (void)state;
  static const char *const names[] = {"fourbar", "klann", "brake", "bricard", "bennett", NULL};
  int tried = 0;
  for (const char *const *name = names; *name; ++name) {
    fixture f = fixture_open(*name);
    km_redundancies found = find(&f);
    km_mobility before, after;
    km_mobility_compute(f.mechanism, f.state, &before);
    for (int i = 0; i < found.count; ++i) {
      for (int k = 0; k < found.items[i].remedy_count; ++k) {
        const km_remedy *remedy = &found.items[i].remedies[k];
        if (f.model->joints[remedy->joint].type != KM_RZ || strcmp(remedy->to, "universal") == 0)
          continue;
        fixture changed = swapped(*name, &f, remedy);
        km_mobility_compute(changed.mechanism, changed.state, &after);
        assert_int_equal(after.mobility, before.mobility);
        assert_int_equal(after.redundant_constraints, before.redundant_constraints - remedy->freedoms);
        fixture_close(&changed);
        ++tried;
      }
    }
    km_redundancies_free(&found);
    fixture_close(&f);
  }
  assert_true(tried > 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(as_many_as_the_rank_says), cmocka_unit_test(planar_loops),
                                     cmocka_unit_test(a_pose_can_have_its_own), cmocka_unit_test(remedies_work)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
