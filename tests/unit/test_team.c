/* Threads that stay: every pass of a round is done once, and before the round ends. */
#include "support/support.h"

#include "base/parallel.h"

#include <stdatomic.h>
#include <time.h>

enum { THREADS = 6, ROUNDS = 400, MOST_PASSES = 20 };

typedef struct tally {
  atomic_int begun[MOST_PASSES], ended[MOST_PASSES], outside;
  int round;
} tally;

static void wait_for(long nanoseconds) {
  nanosleep(&(struct timespec){.tv_nsec = nanoseconds}, NULL);
}

static void count_pass(void *context, int index) {
  tally *t = context;
  if (index < 0 || index >= MOST_PASSES) { /* no thread but the first one can let a test fail */
    atomic_fetch_add(&t->outside, 1);
    return;
  }
  atomic_fetch_add(&t->begun[index], 1);
  if ((t->round + index) % 7 == 0) /* other threads come to the end before this one */
    wait_for(50000);
  atomic_fetch_add(&t->ended[index], 1);
}

static void every_pass_is_done_once(void **state) {
  (void)state;
  km_team *team = km_team_create(THREADS);
  tally t = {.round = 0};
  assert_non_null(team);
  for (; t.round < ROUNDS; ++t.round) {
    int count = t.round % (MOST_PASSES + 1);
    for (int i = 0; i < MOST_PASSES; ++i) {
      atomic_store(&t.begun[i], 0);
      atomic_store(&t.ended[i], 0);
    }
    if (t.round % 50 == 0) /* longer than a thread watches: it sleeps, and is woken late */
      wait_for(2000000);
    km_team_run(team, count, count_pass, &t);
    assert_int_equal(atomic_load(&t.outside), 0);
    for (int i = 0; i < MOST_PASSES; ++i) {
      assert_int_equal(atomic_load(&t.begun[i]), i < count);
      assert_int_equal(atomic_load(&t.ended[i]), i < count);
    }
  }
  km_team_free(team);
}

static void no_team_is_the_callers_thread(void **state) {
  (void)state;
  tally t = {.round = 1};
  km_team_run(NULL, 5, count_pass, &t);
  for (int i = 0; i < MOST_PASSES; ++i)
    assert_int_equal(atomic_load(&t.ended[i]), i < 5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_pass_is_done_once),
      cmocka_unit_test(no_team_is_the_callers_thread),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
