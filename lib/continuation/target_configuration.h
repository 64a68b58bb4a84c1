/* Bringing a mechanism to the pose that holds and set coordinates ask for, again and again with other numbers. Private to the
 * library. */
#ifndef KM_CONTINUATION_TARGET_CONFIGURATION_H
#define KM_CONTINUATION_TARGET_CONFIGURATION_H

#include "kmech/mechanism.h"

/* km_mechanism_compile_at of the model of `free`, which holds nothing; `there` is a state of it, which is left at the pose. Where
 * something is held, the mechanism that holds it and a state of that are *held and *at: those of an earlier call, in which
 * the same coordinates were held, take the new numbers, NULL: they are made. The caller frees both in any case. Errors as of
 * km_mechanism_compile_at; KM_PARTIAL: with the new numbers an earlier *held would have to be compiled again, see
 * km_mechanism_renumber. */
km_status km_mechanism_recompile_at(const km_mechanism *free, km_state *there, const km_hold *holds, int hold_count,
                                    const km_hold *sets, int set_count, km_mechanism **held, km_state **at,
                                    km_error *error);

#endif
