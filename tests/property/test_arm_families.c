/* The families of random arms and paths, over enough seeds. */
#include "support/arm_families.h"

typedef bool (*family)(uint64_t seed, char *why, size_t size);

static void over(family test, uint64_t seeds) {
  char why[400] = "";
  for (uint64_t seed = 1; seed <= seeds; ++seed)
    if (!test(seed, why, sizeof why))
      fail_msg("seed %llu: %s", (unsigned long long)seed, why);
}

static void paths_take_the_time_of_the_slower(void **state) {
  (void)state;
  over(family_path_times, 40);
}

static void tracks_keep_their_rates_to_the_edge(void **state) {
  (void)state;
  over(family_workspace_edge, 40);
}

static void dynamic_programming_ends(void **state) {
  (void)state;
  char why[400] = "";
  const uint64_t slow = 127; /* took a minute: steps near singular poses were cut thousands of times */
  if (!family_dp_work(slow, why, sizeof why))
    fail_msg("seed %llu: %s", (unsigned long long)slow, why);
  over(family_dp_work, 3);
}

static void six_hinges_reach_a_pose_in_all_ways(void **state) {
  (void)state;
  over(family_six_hinges, 40);
}

static void seven_hinges_reach_a_pose_on_all_components(void **state) {
  (void)state;
  over(family_seven_hinges, 20);
}

static void every_turn_is_listed_from_any_pose(void **state) {
  (void)state;
  char why[400] = "";
  const uint64_t at_limit =
      77100043; /* regression: starting at a limit, rounding separated the end of a cycle from the start of the next */
  if (!family_turns(at_limit, why, sizeof why))
    fail_msg("seed %llu: %s", (unsigned long long)at_limit, why);
  over(family_turns, 12);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(paths_take_the_time_of_the_slower),
                                     cmocka_unit_test(tracks_keep_their_rates_to_the_edge),
                                     cmocka_unit_test(dynamic_programming_ends),
                                     cmocka_unit_test(six_hinges_reach_a_pose_in_all_ways),
                                     cmocka_unit_test(seven_hinges_reach_a_pose_on_all_components),
                                     cmocka_unit_test(every_turn_is_listed_from_any_pose)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
