/* Contents of a model for programs that display it: topology, shapes, and the analyses that its file states.
 * Lengths, angles and masses are in the model's units. */
#ifndef KMECH_INSPECT_H
#define KMECH_INSPECT_H

#include "kmech/base.h"
#include "kmech/build.h"
#include "kmech/mechanism.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Assemblies: their number, name ("" if the index is invalid, borrowed), enclosing assembly (-1: none), and the
 * assembly of a body (-1 for the inertial frame). */
KM_API int km_model_assembly_count(const km_model *model);
KM_API const char *km_model_assembly_name(const km_model *model, int assembly);
KM_API int km_model_assembly_parent(const km_model *model, int assembly);
KM_API int km_model_body_assembly(const km_model *model, int body);
/* Mass of a body (NaN if the index is invalid), and its center_of_mass in the body's frame (may be NULL). */
KM_API double km_model_body_mass(const km_model *model, int body, double center_of_mass[3]);

/* Path of a body's mesh as stated in its definition; NULL if it has none. Borrowed. */
KM_API const char *km_model_body_mesh(const km_model *model, int body);
/* Type of a joint, -1 if the index is invalid; and the word of a type in files: "Rz", "spherical" …, "" if invalid. */
KM_API int km_model_joint_type(const km_model *model, int joint);
KM_API const char *km_joint_type_word(km_joint_type type);
/* Parent frame of a joint, or child frame (`child`); -1 if invalid. X_child = X_parent · motion(q). */
KM_API int km_model_joint_frame(const km_model *model, int joint, bool child);
/* Pose of a frame in its body: R by rows, T. KM_USAGE. */
KM_API km_status km_model_frame_pose(const km_model *model, int frame, double R[9], double T[3], km_error *error);
/* True if the assembly of the joint is drawn: its joints state points of one configuration ("at") instead of frames. */
KM_API bool km_model_joint_is_drawn(const km_model *model, int joint);

/* Label of the first joint or name of the first force module with friction, borrowed; NULL if there is none. */
KM_API const char *km_model_first_friction(const km_model *model);
/* The first joint from index `from` on that rotates and has a friction coefficient but no radius, so that its
 * friction torque is 0. -1 if there is none. */
KM_API int km_model_next_without_radius(const km_model *model, int from);
/* Simulation settings of the model (model_parameters.simulation) in its time unit: `*span`, and `*step` between
 * rows; 0 if not stated. Each may be NULL. */
KM_API void km_model_simulated(const km_model *model, double *span, double *step);
/* Integration method of the model (integration_type), borrowed; NULL if not stated. */
KM_API const char *km_model_integration_type(const km_model *model);

/* Number of internal states of the force modules, module by module: of a controller the integral of its error, of a
 * tyre its slip and slip angle. */
KM_API int km_model_internal_count(const km_model *model);

/* Actuators of the model (analysis.actuators): their number, and the coordinate of each; -1 if invalid. */
KM_API int km_model_actuator_count(const km_model *model);
KM_API int km_model_actuator(const km_model *model, int index);

/* Held coordinates of the model (analysis.hold): their number, and each of them; coordinate −1 if invalid. */
KM_API int km_model_hold_count(const km_model *model);
KM_API km_hold km_model_hold_at(const km_model *model, int index);

/* Driver of the model's default sweep (analysis.sweep); -1 if not stated. */
KM_API int km_model_sweep_coordinate(const km_model *model);

/* Substructure of a coordinate, -1 outside loops and couplings; and true if the mechanism holds the coordinate. */
KM_API int km_coordinate_substructure(const km_mechanism *mechanism, int coordinate);
KM_API bool km_coordinate_is_held(const km_mechanism *mechanism, int coordinate);

/* Surface of a body part as triangles in the body's frame. Round shapes are polyhedra. */
typedef struct km_surface_patch {
  int vertex_count, triangle_count; /* numbers of vertices and triangles */
  double *vertices;                 /* [3 · vertex_count] */
  int *triangles;                   /* [3 · triangle_count] vertex indices, counter-clockwise seen from outside */
  double color[4];                  /* red, green, blue, opacity, 0 … 1; opacity < 0: not stated */
} km_surface_patch;

/* Number of parts of a body's surface: its mesh, then its shapes. */
KM_API int km_body_patch_count(const km_model *model, int body);
/* Part `index` of a body's surface. KM_IO: its file can't be found or read; KM_USAGE, KM_MEMORY. Free `*out` in any
 * case. */
KM_API km_status km_body_patch(const km_model *model, int body, int index, km_surface_patch *out, km_error *error);
KM_API void km_surface_patch_free(km_surface_patch *patch);

/* ---- Force modules */

/* Number of force modules, springs of struts included; name of a module, "" for an index out of range; index of the
 * module with a name, -1: none or several. */
KM_API int km_model_module_count(const km_model *model);
KM_API const char *km_model_module_name(const km_model *model, int index);
KM_API int km_model_find_module(const km_model *model, const char *name);

#ifdef __cplusplus
}
#endif
#endif
