/* How long work tells how far it is, and is stopped. */
#ifndef KMECH_PROGRESS_H
#define KMECH_PROGRESS_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Asked now and then during long work with how much is done (0 … 1); returns false to cancel: the work then ends with
 * KM_CANCELLED. Called from the thread that called the library. Wherever it is taken NULL is legal: nobody asks. */
typedef bool (*km_progress)(void *context, double done);

#ifdef __cplusplus
}
#endif
#endif
