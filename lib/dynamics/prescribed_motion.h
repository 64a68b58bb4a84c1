/* Prescribed motions of the model as functions of time. */
#ifndef KM_DYNAMICS_PRESCRIBED_MOTION_H
#define KM_DYNAMICS_PRESCRIBED_MOTION_H

#include "topology/mechanism.h"

/* The prescribed coordinates of a mechanism with their laws, in radians and the model's length unit. */
typedef struct km_prescribed km_prescribed;

/* Creates the prescribed motions of the model. KM_MEMORY. The caller frees `*out`. */
km_status km_prescribed_create(const km_mechanism *mechanism, km_prescribed **out, km_error *error);
void km_prescribed_free(km_prescribed *prescribed);

/* Prescribes value + rate · t for a coordinate, in place of its law if it has one; radians and the model's length
 * unit. */
void km_prescribed_set(km_prescribed *prescribed, int coordinate, double value, double rate);

int km_prescribed_count(const km_prescribed *prescribed);
/* Evaluates law `index` at a time: motion = value, rate, acceleration. Returns its coordinate. */
int km_prescribed_at(const km_prescribed *prescribed, int index, double time, double motion[3]);

#endif
