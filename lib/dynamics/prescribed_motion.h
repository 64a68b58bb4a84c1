/* Motions over time that the model prescribes. */
#ifndef KM_DYNAMICS_PRESCRIBED_MOTION_H
#define KM_DYNAMICS_PRESCRIBED_MOTION_H

#include "topology/mechanism.h"

/* The prescribed coordinates of a mechanism, with their laws in radians and the model's length unit. */
typedef struct km_prescribed km_prescribed;

/* KM_MEMORY; KM_MODEL: a table whose times don't increase, or of fewer than two rows. The caller frees `*out`. */
km_status km_prescribed_create(const km_mechanism *mechanism, km_prescribed **out, km_error *error);
void km_prescribed_free(km_prescribed *prescribed);

/* Adds value + rate · t, or puts it in the place of the coordinate's law; radians and the model's length unit. */
void km_prescribed_set(km_prescribed *prescribed, int coordinate, double value, double rate);

int km_prescribed_count(const km_prescribed *prescribed);
/* Law `index` at a time: its coordinate; value, rate and acceleration. */
int km_prescribed_at(const km_prescribed *prescribed, int index, double time, double motion[3]);

#endif
