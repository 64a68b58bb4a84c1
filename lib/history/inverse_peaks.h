/* Peaks and root mean square of the forces of a prescribed motion. Private to history/. */
#ifndef KM_HISTORY_INVERSE_PEAKS_H
#define KM_HISTORY_INVERSE_PEAKS_H

#include "history/history_table.h"

/* Advances the state to a later time of the motion. */
typedef km_status km_inverse_motion(km_history_writer *writer, double time, km_error *error);

/* Finds the peaks of the driving forces and of the shaking force; the state is at the last row afterwards.
 * KM_MEMORY. */
km_status km_inverse_find_peaks(km_history_writer *writer, km_inverse_motion *advance_to, km_error *error);

#endif
