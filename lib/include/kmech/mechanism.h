/* A compiled mechanism: immutable, shared by threads. And its per-thread state. */
#ifndef KMECH_MECHANISM_H
#define KMECH_MECHANISM_H

#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A compiled model. Immutable but for km_mechanism_renumber, shared by threads. */
typedef struct km_mechanism km_mechanism;
/* A pose of a mechanism with its workspace: one thread's. */
typedef struct km_state km_state;

/* A coordinate kept at a value; the joint then counts as rigid in it. In the model's unit. */
typedef struct km_hold {
  int coordinate; /* of the model */
  double value;   /* in the coordinate's unit */
} km_hold;

/* Compiles the model: topology, each loop's own motion space, and the list of operations that kinematics
 * replays. `holds` keep coordinates at values from the start. The model must outlive the mechanism. The
 * caller frees `*out`. Cost: linear in joints plus the lengths of the loops. */
KM_API km_status km_mechanism_compile(const km_model *model, const km_hold *holds, int hold_count, km_mechanism **out,
                                      km_error *error);
KM_API void km_mechanism_free(km_mechanism *mechanism);

/* Takes over the model's numbers after some have changed (kmech/edit.h): dimensions, displacements, limits, ratios. What
 * was held stays held at its value. The bits are those of a new compilation. The mechanism's states stay usable:
 * km_state_restart them. KM_PARTIAL, with the mechanism as it was: a loop's motion space has changed, compile again.
 * No allocation after the first call. Not while another thread uses the mechanism. Cost: as compiling
 * without the topology. */
KM_API km_status km_mechanism_renumber(km_mechanism *mechanism, km_error *error);

/* What rates of lengths are divided by where they are compared with those of angles: the length that the model states;
 * else the greatest distance between the frames of two joints on one moving body; else, where all of these coincide,
 * the greatest distance between two joints in the assembled pose; else one length unit. Of several models that are
 * compared the first one's serves all. In the model's length unit. `source` may be NULL. */
typedef enum km_length_source {
  KM_LENGTH_STATED,       /* the model states it */
  KM_LENGTH_SHARED,       /* another model's (km_model_share_length) */
  KM_LENGTH_LONGEST_LINK, /* between two joints of one body */
  KM_LENGTH_JOINTS,       /* between two joints in the assembled pose */
  KM_LENGTH_UNIT          /* one length unit */
} km_length_source;
KM_API double km_mechanism_characteristic_length(const km_mechanism *mechanism, km_length_source *source);
KM_API const char *km_length_source_name(km_length_source source); /* "stated", "longest link" … */

/* One thread's workspace at the model's initial displacements, not yet assembled. The mechanism must outlive
 * it. Everything that kinematics needs is allocated here, once. The caller frees `*out`. */
KM_API km_status km_state_create(const km_mechanism *mechanism, km_state **out, km_error *error);
KM_API void km_state_free(km_state *state);

/* Puts a state back to the model's initial displacements, not assembled; after km_mechanism_renumber. */
KM_API void km_state_restart(km_state *state);

/* Coordinates in the model's units; angles are continuous, never wrapped. */
KM_API double km_state_coordinate(const km_state *state, int coordinate);
/* All of them: values[coordinate count]. KM_USAGE. */
KM_API km_status km_state_coordinates(const km_mechanism *mechanism, const km_state *state, double *values,
                                      km_error *error);
/* Puts the free coordinates at these values, or one of them; held ones stay. The loops are open then: km_assemble
 * closes them on the branch that is nearest, and poses and mobility must be updated again. KM_USAGE: a value isn't
 * finite, the one coordinate is held. O(coordinates). */
KM_API km_status km_state_set_coordinates(const km_mechanism *mechanism, km_state *state, const double *values,
                                          km_error *error);
KM_API km_status km_state_set_coordinate(const km_mechanism *mechanism, km_state *state, int coordinate, double value,
                                         km_error *error);

/* Each `rate` of coordinates in the model's units per time unit, and accelerations; those of a ball joint are the components
 * of its angular velocity along its parent frame's axes. NaN: there is no such coordinate. A rate that is set is stated: the
 * start of a motion keeps it, and joints without a stated rate follow (km_dynamics_project_rates). */
KM_API double km_state_rate(const km_state *state, int coordinate);
KM_API double km_state_acceleration(const km_state *state, int coordinate);
KM_API km_status km_state_set_rate(const km_mechanism *mechanism, km_state *state, int coordinate, double rate,
                                   km_error *error);
/* Copies coordinates, rates and time `from` one state to another of the same mechanism. KM_USAGE. O(coordinates). */
KM_API km_status km_state_assign(const km_mechanism *mechanism, km_state *to, const km_state *from, km_error *error);
/* Does a full turn of the coordinate bring the mechanism back? True for hinges, not for slides, screws, balls. */
KM_API bool km_coordinate_turns(const km_mechanism *mechanism, int coordinate);
/* The `time` at which the state is, in the model's unit: prescribed motions and motors follow it. KM_USAGE: not finite. */
KM_API double km_state_time(const km_state *state);
KM_API km_status km_state_set_time(const km_mechanism *mechanism, km_state *state, double time, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
