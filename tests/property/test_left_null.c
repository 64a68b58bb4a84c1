/* Left null vectors: as many as constraints are redundant, orthonormal or at least independent, and without work in any
 * motion of the joints. */
#include "support/linkages.h"
#include "support/random_mechanism.h"
#include "support/sheets.h"
#include "support/support.h"

#include "kinematics/body_poses.h"
#include "mobility/full_jacobian.h"
#include "mobility/persistent_redundancy.h"

#include <math.h>
#include <string.h>

/* Vector v in all rows, whether it is one loop's own or of several. */
static void vector_of(const km_left_space *space, const km_left_null *null, int v, double *out) {
  memset(out, 0, (size_t)space->rows * sizeof *out);
  if (v >= null->local_count) {
    int n = v - null->local_count;
    for (int i = null->part_start[n]; i < null->part_start[n + 1]; ++i)
      memcpy(out + km_left_row(space, null->part[i].block), null->part[i].w,
             (size_t)km_left_rows(space, null->part[i].block) * sizeof *out);
    return;
  }
  int loop = 0;
  while (null->first[loop + 1] <= v)
    ++loop;
  memcpy(out + 6 * loop, null->local + 6 * v, 6 * sizeof *out);
}

/* The power of w on column c of each loop, by the joints' twists about the loop's point: the whole Jacobian moved to
 * the points that the left space counts about. */
static double power(const km_left_space *space, const double *J, const double *w, int c) {
  double sum = 0.0;
  for (int l = 0; l < space->sub->loop_count; ++l) {
    const double *h = J + (size_t)c * (size_t)space->rows + 6 * l;
    km_vec3 v = km_vec3_from_array(h), turn = km_vec3_from_array(h + 3),
            o = km_vec3_scale(1.0 / space->sub->size, space->about[l]);
    v = km_vec3_add(v, km_vec3_cross(turn, o)); /* J is about the inertial origin */
    const double moved[6] = {v.x, v.y, v.z, turn.x, turn.y, turn.z};
    for (int r = 0; r < 6; ++r)
      sum += moved[r] * w[6 * l + r];
  }
  for (int r = 6 * space->sub->loop_count; r < space->rows; ++r)
    sum += J[(size_t)c * (size_t)space->rows + (size_t)r] * w[r];
  return sum;
}

/* The vectors of several loops of a large substructure aren't at right angles to each other; those of one loop are to
 * all. */
static bool need_be_square(const km_left_null *null, int a, int b) {
  return null->is_orthonormal || a < null->local_count || b < null->local_count || a == b;
}

static void check_independent(const km_left_space *space, const km_left_null *null) {
  km_arena arena = {0};
  int count = km_left_null_count(null);
  double *W = KM_ARENA_NEW(&arena, double, (size_t)(space->rows * count + 1));
  km_factor *p = km_factor_create(space->rows, count, NULL, &arena);
  for (int a = 0; a < count; ++a)
    vector_of(space, null, a, W + (size_t)a * (size_t)space->rows);
  km_factor_compute(p, W, space->rows, count, &(km_factor_options){.tolerance = 1e-6});
  assert_int_equal(km_factor_rank(p), count);
  km_arena_free(&arena);
}

/* Persistent vectors, where one of the neighbouring configuration has vanished: by sums over orthonormal vectors,
 * and by QR. */
static void check_lasting(const km_left_space *space, const km_left_null *null) {
  km_arena arena = {0};
  int count = km_left_null_count(null), gone = 0;
  bool *by_sums = KM_ARENA_NEW(&arena, bool, (size_t)count + 1), *by_qr = KM_ARENA_NEW(&arena, bool, (size_t)count + 1);
  km_left_null nearby = *null;
  if (null->spanning_count && null->is_orthonormal) {
    nearby.spanning_count--;
    assert_int_equal(km_persistent_redundancy_find(space, null, &nearby, by_sums, NULL), KM_OK);
    nearby.is_orthonormal = false;
    assert_int_equal(km_persistent_redundancy_find(space, null, &nearby, by_qr, NULL), KM_OK);
    for (int k = 0; k < count; ++k) {
      assert_int_equal(by_sums[k], by_qr[k]);
      gone += !by_qr[k];
    }
    assert_int_equal(gone, 1); /* they are orthonormal: only that one has nothing in common with the others */
  }
  km_arena_free(&arena);
}

/* Returns how many vectors belong to several loops. */
static int check(fixture *f, int index) {
  km_arena arena = {0};
  km_left_space space;
  km_left_null null;
  const km_substructure *sub = &f->mechanism->substructures[index];
  assert_true(km_left_space_create(f->mechanism, f->state, index, &arena, &space));
  assert_true(km_left_null_find(&space, &arena, &null));
  int count = km_left_null_count(&null);
  assert_int_equal(count, space.rows - km_factor_rank(f->state->factor[index]));
  km_twist *twist = KM_ARENA_NEW(&arena, km_twist, (size_t)f->mechanism->coordinate_count);
  double *J = KM_ARENA_NEW(&arena, double, (size_t)(space.rows * sub->columns + 1));
  double *w = KM_ARENA_NEW(&arena, double, (size_t)space.rows), *x = KM_ARENA_NEW(&arena, double, (size_t)space.rows);
  for (int c = 0; c < f->mechanism->coordinate_count; ++c)
    twist[c] = km_coordinate_twist(f->mechanism, f->state, c);
  km_full_jacobian(f->mechanism, f->state, index, twist, (km_vec3){0, 0, 0}, 1, (size_t)space.rows, J);
  double size = 1.0;
  for (int i = 0; i < space.rows * sub->columns; ++i)
    size = fmax(size, fabs(J[i]));
  for (int a = 0; a < count; ++a) {
    vector_of(&space, &null, a, w);
    for (int c = 0; c < sub->columns; ++c)
      assert_near(power(&space, J, w, c), 0.0, 1e-7 * size);
    for (int b = 0; b <= a; ++b) {
      double dot = 0.0;
      vector_of(&space, &null, b, x);
      for (int r = 0; r < space.rows; ++r)
        dot += w[r] * x[r];
      if (need_be_square(&null, a, b))
        assert_near(dot, a == b, 1e-9);
    }
  }
  check_independent(&space, &null);
  check_lasting(&space, &null);
  km_arena_free(&arena);
  return null.spanning_count;
}

static int check_all_of(fixture *f) {
  int whole = 0;
  km_mobility mobility;
  km_mobility_compute(f->mechanism, f->state, &mobility);
  km_poses_compute(f->mechanism, f->state);
  for (int i = 0; i < f->mechanism->topology.substructure_count; ++i)
    whole += check(f, i);
  return whole;
}

static void shipped_models(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    check_all_of(&f);
    fixture_close(&f);
  }
}

static void random_mechanisms(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed <= 150; ++seed) {
    randomness r = {seed};
    fixture f = open_random_mechanism(&r, true);
    check_all_of(&f);
    fixture_close(&f);
  }
}

/* Loops of a trellis and of a folded sheet are redundant jointly. */
static void lattices(void **state) {
  (void)state;
  int whole = 0;
  for (int kind = 0; kind < 4; ++kind) {
    km_text text = {0};
    int n = kind < 2 ? 3 : 8; /* the larger ones are solved by the sparse factor */
    if (kind % 2)
      write_miura(&text, n, n, 0.0);
    else
      write_trellis(&text, n, n, 0.0);
    fixture f = fixture_read(text.data);
    whole += check_all_of(&f);
    km_text_free(&text);
    fixture_close(&f);
  }
  assert_true(whole > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(shipped_models), cmocka_unit_test(random_mechanisms),
                                     cmocka_unit_test(lattices)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
