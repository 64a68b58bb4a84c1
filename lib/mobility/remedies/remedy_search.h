/* Search of joint types that end all redundant constraints of a substructure (theory 7.5). Private to the library. */
#ifndef KM_MOBILITY_REMEDIES_REMEDY_SEARCH_H
#define KM_MOBILITY_REMEDIES_REMEDY_SEARCH_H

#include "mobility/left_null_space.h"
#include "mobility/remedies/joint_options.h"

/* Result in one substructure. */
typedef struct km_remedy_search {
  int redundant, remaining; /* constraints before and after the changes */
  int change_count;
  km_joint_change *changes; /* [change_count] in the arena, in the order of the joints */
} km_remedy_search;

/* Finds the changes for all left null vectors of a configuration. `driven`[joint count]: joints that are changed only
 * if the others don't suffice; joints of couplings and held ones are never changed. False without memory. */
bool km_remedy_search_run(const km_left_space *space, const km_left_null *null, const bool *driven, km_arena *arena,
                          km_remedy_search *out);

#endif
