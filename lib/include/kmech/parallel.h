/* Independent pieces of work on several threads. */
#ifndef KMECH_PARALLEL_H
#define KMECH_PARALLEL_H

#include "kmech/api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Calls work(context, i) once for every i below `count`, on up to `jobs` threads (1: on the caller's). Pieces must not
 * share anything that they change; then the results don't depend on `jobs`. */
KM_API void km_parallel_for(int count, int jobs, void (*work)(void *context, int index), void *context);

#ifdef __cplusplus
}
#endif
#endif
