/* Any number of threads gives the same bits: one mechanism shared, a state each. */
#include "support/support.h"

#include "base/parallel.h"

#include <string.h>

enum { RUNS = 8 };

typedef struct shared {
  const km_mechanism *mechanism;
  km_sweep_plan plan;
  km_mobility_sweep sweeps[RUNS];
  km_status status[RUNS];
} shared;

static void sweep(void *context, int index) {
  shared *s = context;
  km_state *state;
  s->status[index] = km_state_create(s->mechanism, &state, NULL);
  if (!s->status[index])
    s->status[index] = km_assemble(s->mechanism, state, NULL, NULL);
  if (!s->status[index])
    s->status[index] = km_mobility_sweep_run(s->mechanism, state, &s->plan, &s->sweeps[index], NULL);
  km_state_free(state);
}

static void threads_share_a_mechanism(void **state) {
  (void)state;
  for (const char *const *name = all_models; *name; ++name) {
    fixture f = fixture_open(*name);
    shared s = {.mechanism = f.mechanism, .plan = km_sweep_plan_default(f.model)};
    s.plan.steps = 20;
    s.plan.to = s.plan.from + 0.2 * (s.plan.to - s.plan.from);
    km_parallel_for(1, 1, sweep, &s); /* the first alone, the others four at a time */
    km_mobility_sweep alone = s.sweeps[0];
    memset(&s.sweeps[0], 0, sizeof s.sweeps[0]);
    km_parallel_for(RUNS, 4, sweep, &s);
    for (int i = 0; i < RUNS; ++i) {
      assert_int_equal(s.status[i], KM_OK);
      assert_int_equal(km_table_rows(s.sweeps[i].motion.table), km_table_rows(alone.motion.table));
      for (size_t r = 0; r < km_table_rows(alone.motion.table); ++r)
        assert_same_bits(km_table_row(s.sweeps[i].motion.table, r), km_table_row(alone.motion.table, r),
                         km_table_columns(alone.motion.table));
      km_mobility_sweep_free(&s.sweeps[i]);
    }
    km_mobility_sweep_free(&alone);
    fixture_close(&f);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {claim_test(threads_share_a_mechanism,
                                                "A sweep has the same bits on one thread and on four, every model",
                                                "none: the bits are compared")};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
