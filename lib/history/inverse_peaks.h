/* Largest and root mean square forces of a prescribed motion. Private to analysis/. */
#ifndef KM_HISTORY_INVERSE_PEAKS_H
#define KM_HISTORY_INVERSE_PEAKS_H

#include "history/history_table.h"

/* Takes the state on to a later time of the motion. */
typedef km_status km_inverse_motion(km_history_writer *writer, double time, km_error *error);

/* Of the driving forces and the shaking force, into the result's peaks; the state is at the last row then. KM_MEMORY. */
km_status km_inverse_find_peaks(km_history_writer *writer, km_inverse_motion *go_to, km_error *error);

#endif
