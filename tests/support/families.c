/* The list of all families of random cases. */
#include "support/families.h"

#include "support/arm_families.h"
#include "support/forces.h"
#include "support/motion_families.h"

#include <stdio.h>

/* Adapts families that count their cases, and families that return their failure, to the common signature. */
#define COUNTING(NAME)                                                                                                 \
  static bool counting_##NAME(uint64_t seed) {                                                                         \
    family_count count = {0};                                                                                          \
    return family_##NAME(seed, &count);                                                                                \
  }
#define EXPLAINING(NAME)                                                                                               \
  static bool explaining_##NAME(uint64_t seed) {                                                                       \
    char why[400] = "";                                                                                                \
    bool agrees = family_##NAME(seed, why, sizeof why);                                                                \
    if (!agrees)                                                                                                       \
      fprintf(stderr, #NAME " %llu: %s\n", (unsigned long long)seed, why);                                             \
    return agrees;                                                                                                     \
  }

COUNTING(friction)
COUNTING(wedge)
COUNTING(planar_forces)
COUNTING(two_freedoms)
COUNTING(spatial_forces)
COUNTING(leverage)
EXPLAINING(path_times)
EXPLAINING(workspace_edge)
EXPLAINING(dp_work)
EXPLAINING(six_hinges)
EXPLAINING(seven_hinges)
EXPLAINING(turns)

const family all_families[] = {{"inertia", family_inertia},
                               {"limits", family_limits},
                               {"dead points", family_dead_points},
                               {"least path", family_least_path},
                               {"moving", family_moving},
                               {"contact", family_contact},
                               {"shaky", family_shaky},
                               {"change point", family_change_point},
                               {"powers", family_powers},
                               {"tied twins", family_twins},
                               {"stretched chains", family_stretched},
                               {"beside a toggle", family_change_beside_toggle},
                               {"straight start", family_straight_start},
                               {"mirrored legs", family_mirrored_legs},
                               {"rounded", family_rounded},
                               {"short link", family_short_link},
                               {"rank flags", family_rank_flags},
                               {"friction", counting_friction},
                               {"wedge", counting_wedge},
                               {"planar forces", counting_planar_forces},
                               {"two freedoms", counting_two_freedoms},
                               {"spatial forces", counting_spatial_forces},
                               {"leverage", counting_leverage},
                               {"path times", explaining_path_times},
                               {"workspace edge", explaining_workspace_edge},
                               {"dynamic programming", explaining_dp_work},
                               {"six hinges", explaining_six_hinges},
                               {"seven hinges", explaining_seven_hinges},
                               {"turns", explaining_turns},
                               {NULL, NULL}};
