/* The leader's side of a crew: pieces of work out, answers in. Private to study/. */
#ifndef KM_STUDY_WORKER_PROCESSES_H
#define KM_STUDY_WORKER_PROCESSES_H

#include "study/design_study.h"

typedef struct km_crew km_crew;

km_status km_crew_check(const km_design_crew *members, km_error *error);
km_status km_crew_open(km_design_study *study, const km_design_crew *members, km_crew **out, km_error *error);
void km_crew_close(km_crew *crew);
/* Gives every member that has nothing to do some designs from *next on, which moves past them; those that the store has are
 * counted, not given. */
km_status km_crew_give(km_crew *crew, int *next, int end, km_error *error);
/* Takes the answers that have come; `all`: waits for those of all pieces. */
km_status km_crew_take(km_crew *crew, bool all, km_error *error);

#endif
