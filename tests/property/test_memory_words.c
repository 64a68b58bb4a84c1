/* Out-of-memory errors of library functions that no tool reports: each allocation of a function fails once, the
 * function returns KM_MEMORY with an error text that contains its characteristic words. */
#include "support/arms.h"
#include "support/designs.h"
#include "support/failing.h"
#include "support/sheets.h"

#include "kinematics/loop_equations.h"
#include "kmech/model.h"
#include "linalg/sparse/sparse_qr.h"
#include "local/second_order_columns.h"
#include "mobility/massless_motions.h"
#include "model/geometry/hull.h"
#include "model/geometry/mass_properties.h"
#include "study/worker_processes.h"

#include <nlopt.h>
#include <string.h>

nlopt_opt __real_nlopt_create(nlopt_algorithm algorithm, unsigned count);
nlopt_opt __wrap_nlopt_create(nlopt_algorithm algorithm, unsigned count);

/* NLopt's memory is its own: here it finds none either. */
nlopt_opt __wrap_nlopt_create(nlopt_algorithm algorithm, unsigned count) {
  return failing_next() ? NULL : __real_nlopt_create(algorithm, count);
}

/* Calls a function between begin and end, with all that it needs made before. */
typedef km_status (*scene)(km_error *error);

static long failing, asked; /* the call that fails; how many there were */

static void begin(void) {
  failing_arm(failing);
}

static km_status end(km_status status) {
  asked = failing_calls();
  failing_arm(0);
  return status;
}

static void assert_says(scene run, const char *words) {
  bool said = false;
  failing = 0;
  do {
    km_error error = {.text = ""};
    ++failing;
    km_status status = run(&error);
    assert_int_equal(status, asked < failing ? KM_OK : KM_MEMORY);
    if (status && !strstr(error.text, "out of memory"))
      fail_msg("call %ld failed: \"%s\"", failing, error.text);
    said = said || strcmp(error.text, words) == 0;
  } while (asked >= failing);
  if (!said)
    fail_msg("%ld calls failed, and none made it say \"%s\"", failing - 1, words);
}

static km_status change(km_error *error) {
  fixture f = fixture_open("fourbar");
  begin();
  km_status status = end(km_model_set_position(f.model, 0, 0.5, error));
  fixture_close(&f);
  return status;
}

static km_status renumber(km_error *error) {
  fixture f = fixture_open("fourbar");
  begin();
  km_status status = end(km_mechanism_renumber(f.mechanism, error));
  fixture_close(&f);
  return status;
}

/* A tetrahedron, whose sides look outwards. */
static km_mesh *solid(void) {
  static const km_triangle sides[] = {
      {.corner = {0, 2, 1}}, {.corner = {0, 1, 3}}, {.corner = {0, 3, 2}}, {.corner = {1, 2, 3}}};
  km_mesh *mesh = km_mesh_create(4, 4);
  assert_non_null(mesh);
  mesh->vertices[1].x = mesh->vertices[2].y = mesh->vertices[3].z = 1.0;
  memcpy(mesh->triangles, sides, sizeof sides);
  return mesh;
}

static km_status wrap(km_error *error) {
  km_mesh *mesh = solid(), *hull = NULL;
  begin();
  km_status status = end(km_mesh_hull(mesh, &hull, error));
  km_mesh_free(hull);
  km_mesh_free(mesh);
  return status;
}

static km_status check_mesh(km_error *error) {
  km_mesh *mesh = solid();
  km_mesh_faults faults;
  begin();
  km_status status = end(km_mesh_check(mesh, &faults, error));
  km_mesh_free(mesh);
  return status;
}

static km_status factor(km_error *error) {
  km_sparse_qr *q = NULL;
  begin();
  km_status status = end(km_sparse_qr_create(3, 2, 6, &q, error));
  km_sparse_qr_free(q);
  return status;
}

/* A trellis: large enough to be sparse, with redundant constraints. */
static fixture trellis(void) {
  km_text text = {0};
  write_trellis(&text, 5, 5, 0.0);
  fixture f = fixture_read(text.data);
  km_text_free(&text);
  return f;
}

static km_status set_conditions(km_error *error) {
  fixture f = trellis();
  km_arena arena = {0};
  km_local *l = km_local_create(f.mechanism, f.state, 0, NULL, 0.0, &arena);
  assert_true(l && km_local_reserve_tangents(l, false));
  begin();
  km_status status = end(km_second_order_columns_create(l, error));
  km_local_free(l);
  km_arena_free(&arena);
  fixture_close(&f);
  return status;
}

static km_status weigh_motions(km_error *error) {
  fixture f = fixture_open("fourbar");
  bool inert;
  begin();
  km_status status = end(km_has_massless_motion(f.mechanism, f.state, 0, &inert, error));
  fixture_close(&f);
  return status;
}

static km_status sum(void *context, const double *x, double *f, km_error *error) {
  (void)context, (void)error;
  f[0] = x[0];
  return KM_OK;
}

static km_status open_crew(km_error *error) {
  static const double values[] = {0.0, 1.0};
  static const km_design_axis axis = {0, 2, values};
  const km_design_workers members = {.size = 2};
  designs d;
  km_design_study *study = NULL;
  km_worker_processes *crew = NULL;
  designs_of_function(&d, sum, 1, 1);
  d.def.axes = &axis;
  d.def.axis_count = 1;
  assert_int_equal(km_design_study_open(&d.def, NULL, false, &study, error), KM_OK);
  begin();
  km_status status = end(km_worker_processes_open(study, &members, &crew, error));
  km_worker_processes_close(crew);
  km_design_study_free(study);
  return status;
}

static km_status optimise(km_error *error) {
  fixture f = fixture_open("panda");
  km_study *study =
      study_of(&f, "{\"effector\": \"flange/origin\", \"path\": {\"segments\": [{\"type\": \"line\", \"to\": "
                   "[0.4, 0, 0.6], \"steps\": 2}]}, \"methods\": [{\"method\": \"global\", \"evaluations\": 10}]}");
  km_track_plan plan = km_study_plan(study, 0);
  km_track *track = NULL;
  begin();
  km_status status = end(km_track_run(km_study_arm(study), &plan, &track, error));
  km_track_free(track);
  km_study_free(study);
  fixture_close(&f);
  return status;
}

static void test_model(void **unused) {
  (void)unused;
  assert_says(change, "out of memory for a change of the model");
  assert_says(renumber, "out of memory for new numbers");
}

static void test_meshes(void **unused) {
  (void)unused;
  assert_says(wrap, "out of memory for a convex hull");
  assert_says(check_mesh, "out of memory while checking a mesh");
}

static void test_numbers(void **unused) {
  (void)unused;
  assert_says(factor, "out of memory for a factorisation");
  assert_says(set_conditions, "out of memory for the conditions of second order");
  assert_says(weigh_motions, "out of memory for the masses of motions");
}

static void test_studies(void **unused) {
  (void)unused;
  assert_says(open_crew, "out of memory for worker processes");
  assert_says(optimise, "out of memory for the optimisation");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_model),
      cmocka_unit_test(test_meshes),
      cmocka_unit_test(test_numbers),
      cmocka_unit_test(test_studies),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
