/* What a model is made of, for programs that show it: how bodies and joints hang together, what they look like, and what
 * its file proposes to ask. Lengths, angles and masses are in the model's units. */
#ifndef KMECH_INSPECT_H
#define KMECH_INSPECT_H

#include "kmech/base.h"
#include "kmech/build.h"
#include "kmech/mechanism.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The assemblies, 0 … the count: name ("" if there is no such assembly, borrowed), and the assembly around it (-1: none).
 * And that of a body; -1 for the inertial frame. */
KM_API int km_model_assembly_count(const km_model *model);
KM_API const char *km_model_assembly_name(const km_model *model, int assembly);
KM_API int km_model_assembly_parent(const km_model *model, int assembly);
KM_API int km_model_body_assembly(const km_model *model, int body);
/* Mass of a body, NaN if there is no such body, and its center_of_mass in the body's frame (may be NULL). */
KM_API double km_model_body_mass(const km_model *model, int body, double center_of_mass[3]);

/* The file of a body's mesh, as its definition names it; NULL: it has none. Borrowed. */
KM_API const char *km_model_body_mesh(const km_model *model, int body);
/* A joint's type; -1: there is no such joint. The type's word as files write it: "Rz", "spherical" …; "". */
KM_API int km_model_joint_type(const km_model *model, int joint);
KM_API const char *km_joint_type_word(km_joint_type type);
/* The frame that a joint starts from, or (`child`) that it carries; -1. X_child = X_parent · motion(q). */
KM_API int km_model_joint_frame(const km_model *model, int joint, bool child);
/* The pose of a frame in its body: R by rows, T. KM_USAGE. */
KM_API km_status km_model_frame_pose(const km_model *model, int frame, double R[9], double T[3], km_error *error);
/* Do the joints of this one's assembly state where they are in one drawn pose ("at"), instead of by frames? */
KM_API bool km_model_joint_is_drawn(const km_model *model, int joint);

/* The first joint or force module with friction, a coefficient or a constant one: its label or name, borrowed; NULL: there is none. */
KM_API const char *km_model_first_friction(const km_model *model);
/* The first joint from joint `from` on that turns and has a coefficient of friction but no radius, at which nothing rubs: neither
 * a force across its axis nor a thrust along it is resisted. -1: there is none. */
KM_API int km_model_next_without_radius(const km_model *model, int from);
/* What the model states of its simulation (model_parameters.simulation), in its time unit: the `*span` of it, and the `*step`
 * between rows; 0: it doesn't. Each place may be NULL. */
KM_API void km_model_simulated(const km_model *model, double *span, double *step);
/* The integration method that the model states (integration_type), borrowed; NULL: it states none. */
KM_API const char *km_model_integration_type(const km_model *model);

/* Has it controllers with integrals, or tyres, whose state isn't in coordinates and rates? */
KM_API bool km_model_remembers(const km_model *model);

/* The actuators that the model names (analysis.actuators): how many, and the coordinate of each; -1. */
KM_API int km_model_actuator_count(const km_model *model);
KM_API int km_model_actuator(const km_model *model, int index);

/* What the model keeps at values (analysis.hold): how many coordinates, and each of them; coordinate -1: there is none. */
KM_API int km_model_hold_count(const km_model *model);
KM_API km_hold km_model_hold_at(const km_model *model, int index);

/* The coordinate that the model proposes to drive (analysis.sweep); -1: none. */
KM_API int km_model_sweep_coordinate(const km_model *model);

/* The substructure that a coordinate lies in, -1: in no loop and no coupling. And is it held in this mechanism? */
KM_API int km_coordinate_substructure(const km_mechanism *mechanism, int coordinate);
KM_API bool km_coordinate_is_held(const km_mechanism *mechanism, int coordinate);

/* What a body looks like: its mesh and its shapes as triangles in the body's frame. Round shapes come as polyhedra. */
typedef struct km_surface_patch {
  int vertex_count, triangle_count; /* lengths of both lists */
  double *vertices;                 /* [3 · vertex_count] */
  int *triangles;                   /* [3 · triangle_count] vertices, counter-clockwise seen from outside */
  double color[4];                  /* red, green, blue, opacity, 0 to 1; opacity < 0: none is stated */
} km_surface_patch;

/* The parts of a body's surface, 0 … the count: its mesh first, then its shapes. 0: it has none. */
KM_API int km_body_patch_count(const km_model *model, int body);
/* One of them. KM_IO: its file can't be found or read; KM_USAGE, KM_MEMORY. Free `*out` in any case. */
KM_API km_status km_body_patch(const km_model *model, int body, int index, km_surface_patch *out, km_error *error);
KM_API void km_surface_patch_free(km_surface_patch *patch);

#ifdef __cplusplus
}
#endif
#endif
