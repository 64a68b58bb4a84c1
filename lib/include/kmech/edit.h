/* Changing the numbers of a model, for variants: its bodies, joints and names stay. A mechanism compiled from the model
 * takes them over with km_mechanism_renumber. Units are the model's. KM_USAGE: no such element; KM_MODEL: a number that the
 * element can't have. A refused call changes nothing. Not while another thread uses the model. */
#ifndef KMECH_EDIT_H
#define KMECH_EDIT_H

#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Place of a frame in its body: T (length), and R by rows (NULL: as it is). */
KM_API km_status km_model_set_frame(km_model *model, int frame, const double T[3], const double R[9], km_error *error);
/* The `position` that a coordinate starts the assembly from, and its limits `low` and `high` (∓infinity: none). */
KM_API km_status km_model_set_position(km_model *model, int coordinate, double position, km_error *error);
KM_API km_status km_model_set_limits(km_model *model, int coordinate, double low, double high, km_error *error);
/* A body's `mass`, center_of_mass (in the body's frame) and inertia about it: Ixx Iyy Izz Ixy Iyz Izx; NULL: as it is. */
KM_API km_status km_model_set_mass(km_model *model, int body, double mass, const double center_of_mass[3],
                                   const double inertia[6], km_error *error);
/* A load's force and torque; NULL: as it is. */
KM_API km_status km_model_set_load(km_model *model, int load, const double force[3], const double torque[3],
                                   km_error *error);

#ifdef __cplusplus
}
#endif
#endif
