/* Complex closure systems of random platforms with balls at either end of the struts: configurations, derivatives, and
 * the place of a ball's hub beside a pole. */
#include "support/support.h"

#include "base/random.h"
#include "space/complex/complex_chain.h"
#include "spatial/rotation.h"

#include <float.h>
#include <string.h>

enum { LEGS = 6, SEEDS = 40 };

/* A platform at a random pose; each strut has its ball at the base or at the platform. */
static void write_platform(km_text *text, int n) {
  uint64_t random = 7 * (uint64_t)n + 1;
  for (int i = 0; i < 20; ++i) /* the first numbers of near seeds are near */
    km_uniform(&random);
  km_text_add(text, "{\"fixed\": {\"frames\": [");
  for (int k = 0; k < LEGS; ++k)
    km_text_format(text, "%s{\"name\": \"f%d\", \"T\": [%.17g, %.17g, %.17g]}", k ? ", " : "", k, km_uniform(&random),
                   km_uniform(&random), km_uniform(&random));
  km_text_add(text, "]}, \"assemblies\": [{\"name\": \"p\", \"drawn\": \"assembled\", \"bodies\": [{\"name\": \"top\", "
                    "\"frames\": [");
  for (int k = 0; k < LEGS; ++k)
    km_text_format(text, "%s{\"name\": \"e%d\", \"T\": [%.17g, %.17g, %.17g]}", k ? ", " : "", k, km_uniform(&random),
                   km_uniform(&random), 1.5 + 0.7 * km_uniform(&random));
  km_text_add(text, "]}], \"struts\": [");
  for (int k = 0; k < LEGS; ++k) {
    bool from_top = km_uniform(&random) > 0.0;
    km_text_format(text, "%s{\"name\": \"L%d\", \"from\": \"%s%d\", \"to\": \"%s%d\"}", k ? ", " : "", k,
                   from_top ? "top/e" : "fixed/f", k, from_top ? "fixed/f" : "top/e", k);
  }
  km_text_add(text, "]}]}");
}

/* The system of one platform with its struts held. */
typedef struct subject {
  fixture f;
  km_mechanism *m; /* loops cut at balls */
  km_state *s;
  km_arena arena;
  km_complex_closure c;
  uint64_t random;
} subject;

static subject subject_open(int n) {
  subject u = {.f = fixture_written(write_platform, n), .random = 3 * (uint64_t)n + 1};
  km_compiling options = km_mechanism_options(u.f.mechanism);
  km_error error = {0};
  int freedom;
  options.cuts_balls = true;
  if (km_mechanism_compile_as(u.f.mechanism->model, &options, &u.m, &error) || km_state_create(u.m, &u.s, &error))
    fail_msg("%s", error.text);
  km_state_copy(u.m, u.s, u.f.state);
  for (int k = 0; k < LEGS; ++k)
    km_state_lock(u.s, fixture_coordinate(&u.f, (const char[]){'L', (char)('0' + k), '\0'}));
  if (km_complex_closure_create(u.m, u.s, 0, &u.random, &u.arena, &u.c, &freedom, &error))
    fail_msg("%d: %s", n, error.text);
  return u;
}

static void subject_close(subject *u) {
  km_arena_free(&u->arena);
  km_state_free(u->s);
  km_mechanism_free(u->m);
  fixture_close(&u->f);
}

/* The hub of the ball in the tree; its chain has joints if the tree's strut has its ball at the base. */
static const km_complex_hub *hub_of(const subject *u) {
  for (int k = 0; k < u->c.sub->columns; ++k)
    if (u->c.hub[k].ball && u->c.unknown_of[k] >= 0)
      return &u->c.hub[k];
  fail_msg("no ball is in the tree");
  return NULL;
}

/* A state's configuration closes the loops and is copied back to the same state. */
static void test_configurations_are_states(void **state) {
  (void)state;
  int chains = 0, reversed = 0;
  for (int n = 0; n < SEEDS; ++n) {
    subject u = subject_open(n);
    km_wide x[128];
    km_complex F[64];
    km_complex_values values = {.F = F, .functional = -1};
    chains += hub_of(&u)->count > 0;
    reversed += hub_of(&u)->ball->sign < 0.0;
    km_complex_from_state(&u.c, u.s, x);
    km_complex_evaluate(&u.c, x, &values);
    for (int i = 0; i < u.c.size; ++i)
      assert_true(cabs(F[i]) <= 1e-12); /* assembled to 1e-12 */
    km_complex_to_state(&u.c, x, u.s);
    for (int i = 0; i < u.m->coordinate_count; ++i)
      if (u.m->ball_of[i] < 0)
        assert_true(fabs(remainder(u.s->q[i] - u.f.state->q[i], 2.0 * M_PI)) <= 16.0 * DBL_EPSILON);
    for (int i = 0; i < LEGS; ++i) {
      const km_quaternion *a = &u.s->ball[i], *b = &u.f.state->ball[i];
      double same = a->w * b->w + a->x * b->x + a->y * b->y + a->z * b->z;
      assert_true(fabs(fabs(same) - 1.0) <= 1e-12);
    }
    subject_close(&u);
  }
  assert_in_range(chains, 5, SEEDS - 5);
  assert_in_range(reversed, 5, SEEDS - 5);
}

/* F and the functional are differentiated by central differences along each unknown, at a random complex
 * configuration. */
static void test_derivatives(void **state) {
  (void)state;
  const double h = 1e-5; /* error h² = 1e-10 times third derivatives, rounding 1e-16/h */
  for (int n = 0; n < SEEDS; ++n) {
    subject u = subject_open(n);
    km_wide centre[128], x[128];
    km_complex F[64], other[64], J[64 * 64], gradient[64], step[64] = {0};
    int size = u.c.size;
    km_complex_values values = {.J = J, .stride = size, .functional = 0, .gradient = gradient};
    km_complex_from_state(&u.c, u.s, centre);
    km_complex_randomise(&u.c, centre, 0.5, &u.random, centre);
    km_complex_evaluate(&u.c, centre, &values);
    double largest = 0.0;
    for (int i = 0; i < size * size; ++i)
      largest = fmax(largest, cabs(J[i]));
    for (int k = 0; k < size; ++k) {
      km_complex_values ahead = {.F = F, .functional = 0}, behind = {.F = other, .functional = 0};
      memcpy(x, centre, sizeof x);
      step[k] = h;
      km_complex_move(&u.c, step, x);
      km_complex_evaluate(&u.c, x, &ahead);
      memcpy(x, centre, sizeof x);
      step[k] = -h;
      km_complex_move(&u.c, step, x);
      km_complex_evaluate(&u.c, x, &behind);
      step[k] = 0.0;
      for (int i = 0; i < size; ++i)
        assert_true(cabs((F[i] - other[i]) / (2.0 * h) - J[i * size + k]) <= 1e-6 * (1.0 + largest));
      assert_true(cabs((ahead.value - behind.value) / (2.0 * h) - gradient[k]) <= 1e-6 * (1.0 + cabs(gradient[k])));
    }
    subject_close(&u);
  }
}

/* Doubles and long doubles give the same values. */
static void test_both_types_agree(void **state) {
  (void)state;
  for (int n = 0; n < SEEDS; ++n) {
    subject u = subject_open(n);
    km_wide x[128];
    km_complex F[2][64], J[2][64 * 64], gradient[2][64];
    km_complex_values values[2];
    int size = u.c.size;
    double largest = 1.0;
    km_complex_from_state(&u.c, u.s, x);
    km_complex_randomise(&u.c, x, 0.5, &u.random, x);
    for (int k = 0; k < 2; ++k) {
      values[k] = (km_complex_values){
          .F = F[k], .J = J[k], .stride = size, .functional = 0, .gradient = gradient[k], .is_narrow = k};
      km_complex_evaluate(&u.c, x, &values[k]);
    }
    /* Parts of poses are at most the largest entry of J; 60 products each */
    for (int i = 0; i < size * size; ++i)
      largest = fmax(largest, cabs(J[0][i]));
    double tolerance = 60.0 * DBL_EPSILON * largest * largest;
    for (int i = 0; i < size * size; ++i)
      assert_true(cabs(J[0][i] - J[1][i]) <= tolerance);
    for (int i = 0; i < size; ++i) {
      assert_true(cabs(F[0][i] - F[1][i]) <= tolerance);
      assert_true(cabs(gradient[0][i] - gradient[1][i]) <= tolerance * 6.0 * LEGS);
    }
    subject_close(&u);
  }
}

/* Chains at the hub stay at constant distances however near a pole the angles of the chain from its ball are. */
static void test_hub_is_rigid_beside_a_pole(void **state) {
  (void)state;
  for (int n = 0; n < SEEDS; ++n) {
    subject u = subject_open(n);
    const km_complex_hub *hub = hub_of(&u);
    km_wide x[128];
    km_complex_from_state(&u.c, u.s, x);
    for (int k = 0; k < hub->count; ++k)
      if (hub->steps[k]->primitive == KM_REVOLUTE)
        x[u.c.start_of[km_complex_column(&u.c, hub->steps[k]->coordinate)]] += km_wide_of(0.3, 12.0);
    const km_program *program = &u.m->programs[u.c.sub->program_start];
    km_complex_compute_chains(&u.c, program, x, &(km_complex_values){0});
    km_wide_pose *H = &u.c.wide_slot[hub->count ? hub->steps[hub->count - 1]->to : hub->ball->to];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        km_wide product = H->R[i][0] * H->R[j][0] + H->R[i][1] * H->R[j][1] + H->R[i][2] * H->R[j][2];
        assert_true(cabsl(product - (i == j)) <= 64.0 * DBL_EPSILON);
      }
    subject_close(&u);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(test_configurations_are_states),
                                     cmocka_unit_test(test_derivatives), cmocka_unit_test(test_both_types_agree),
                                     cmocka_unit_test(test_hub_is_rigid_beside_a_pole)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
