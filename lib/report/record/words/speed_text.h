/* Text about the speed of a driver over its last cycle, and about its place at a time. */
#ifndef KM_REPORT_RECORD_WORDS_SPEED_TEXT_H
#define KM_REPORT_RECORD_WORDS_SPEED_TEXT_H

#include "base/text.h"
#include "kmech/dynamics.h"

/* "A turns at 2981 rpm on average, from 2875 (at 35 deg) to …; coefficient of fluctuation 0.068, over the last 720
 * deg". Nothing where no hinge drives the motion round. */
void km_speed_words(const km_mechanism *mechanism, const km_table *table, km_text *out);
/* " (A = 35.1 deg)": value of a coordinate (−1: of the driver) at a time, of the driver within a cycle. Nothing where
 * nothing drives the motion. */
void km_place_words(const km_mechanism *mechanism, const km_table *table, int coordinate, double time, km_text *out);

#endif
