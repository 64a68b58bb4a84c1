/* Moves a mechanism to the configuration given by held and set coordinates, repeatedly with new numbers. Private to
 * the library. */
#ifndef KM_CONTINUATION_TARGET_CONFIGURATION_H
#define KM_CONTINUATION_TARGET_CONFIGURATION_H

#include "kmech/mechanism.h"

/* Does km_mechanism_compile_at with the compiled mechanism `free`, which holds nothing; `there`, a state of it, is
 * left at the configuration. With holds, *held and *at are the mechanism that holds them and its state: taken from an
 * earlier call with the same held coordinates and renumbered, or NULL and then created. The caller frees both in any
 * case. Errors as of km_mechanism_compile_at; KM_PARTIAL: the new numbers require compiling *held again, see
 * km_mechanism_renumber. */
km_status km_mechanism_recompile_at(const km_mechanism *free, km_state *there, const km_hold *holds, int hold_count,
                                    const km_hold *sets, int set_count, km_mechanism **held, km_state **at,
                                    km_error *error);

#endif
