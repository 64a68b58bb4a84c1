/* Models: what the user wrote. Bodies, joints and couplings in named assemblies, with units, defaults and loads. A
 * model is immutable, except by the functions that set its numbers. */
#ifndef KMECH_MODEL_H
#define KMECH_MODEL_H

#include "kmech/base.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- What the user wrote: bodies, joints and couplings in named assemblies, with units and defaults. */

/* A model: what a file says, or a builder was told. */
typedef struct km_model km_model;

/* Reads a model from `size` bytes of JSON, URDF, MJCF or SDF, which the text itself tells apart. Warnings, notes and up
 * to 20 errors go to `messages`, each with its place in the file; with any error the status is KM_MODEL, `error` holds
 * the first one and `*out` is NULL. The caller frees `*out`. Cost: linear in the file. */
KM_API km_status km_model_read(const char *bytes, size_t size, km_messages *messages, km_model **out, km_error *error);

/* The same from a file; "-" is the standard input. KM_IO if it can't be read. */
KM_API km_status km_model_read_file(const char *path, km_messages *messages, km_model **out, km_error *error);

/* A number of a model file, and the value that it is read with instead of its own, in the file's units. */
typedef struct km_assignment {
  const char *path; /* such as crank.tip.x */
  double value;     /* instead of the file's */
} km_assignment;

/* The variant of a model in which some numbers have other values: km_model_read, after the values have been put into
 * the file, in their order. What is read is bit for bit the model of a file that was edited by hand; expressions follow
 * the parameters that change, and km_model_sha256 stays that of `bytes`.
 *
 * A path is the name of a parameter, or names of elements and keys joined by dots, ending at a number:
 *   brake.left_arm.cable.x   assembly, body, frame, component (x y z of a frame's T or a joint's `at`)
 *   left_arm.cable.T.0       the same, if one body only is called left_arm
 *   crank.mass               A.limits.1   A.initial_displacement   lift.spring.stiffness   model_parameters.gravity.2
 *   loads.payload.force.2    an element of a list by its name, or by its number from 0
 * The names of the lists between elements (bodies, frames, joints …) may be left out. A path that fits from the root is
 * that; otherwise it may begin anywhere. A dot or backslash inside a name takes a backslash before it. Single numbers
 * and components of points that the file leaves at their default can be named too.
 *
 * `file`: where the bytes are from, for meshes; NULL: nowhere. KM_USAGE, with the nearest names: a path names no number,
 * or (with both) several; a value isn't finite. Otherwise as km_model_read. Cost: linear in the file, for each path. */
KM_API km_status km_model_read_varied(const char *bytes, size_t size, const char *file,
                                      const km_assignment *assignments, int count, km_messages *messages,
                                      km_model **out, km_error *error);
/* The same from a file; "-" is the standard input, which can be read once. KM_IO if it can't be read. */
KM_API km_status km_model_read_file_varied(const char *path, const km_assignment *assignments, int count,
                                           km_messages *messages, km_model **out, km_error *error);
/* The present values of the numbers that paths name in a file of kmech's own format: values[count], NaN where it doesn't
 * state them. `plain` [count] (may be NULL): the file uses the number as it is, in no expression with anything else.
 * KM_USAGE as above, KM_MODEL. */
KM_API km_status km_model_read_numbers(const char *bytes, size_t size, const char *const *paths, int count,
                                       double *values, bool *plain, km_error *error);
/* The text of such a file with other values in it, as an editor would write it: values[count] of paths[count]. Meshes
 * that the file `from` names (NULL: in the current folder) are called as from the file `to`; NULL: as they are. As text:
 * returns how many bytes there are without the closing NUL, and writes as many as fit into text[room] with one (text
 * NULL: none); 0 with `error` filled when that fails. */
KM_API size_t km_model_write_varied(const char *bytes, size_t size, const km_assignment *assignments, int count,
                                    const char *from, const char *to, char *text, size_t room, km_error *error);
/* How a model is read. Start from {0}. */
typedef struct km_read_def {
  const char *file; /* where the bytes are from, for meshes and other files that they name; NULL: nowhere */
  const km_assignment *assignments; /* [assignment_count], as above; of JSON only */
  int assignment_count;
  bool floating; /* what a robot description leaves untied is free to move, instead of fixed to the inertial frame */
  double closure_tolerance; /* instead of the file's, relative, below 0.1; 0: the file's */
} km_read_def;

/* As km_model_read and km_model_read_file (which knows `file` itself), with all that can be asked of a reader. KM_USAGE: also
 * assignments to the numbers of a format other than JSON, and a closure tolerance that is none. */
KM_API km_status km_model_read_as(const char *bytes, size_t size, const km_read_def *def, km_messages *messages,
                                  km_model **out, km_error *error);
KM_API km_status km_model_read_file_as(const char *path, const km_read_def *def, km_messages *messages, km_model **out,
                                       km_error *error);
KM_API void km_model_free(km_model *model);

/* Active elements, numbered in file order. Bodies don't count the inertial frame. */
KM_API int km_model_body_count(const km_model *model);
KM_API int km_model_joint_count(const km_model *model);
KM_API int km_model_coordinate_count(const km_model *model);

/* Name of a body as the file has it, 0 … the number of bodies; 0 is the inertial frame. Borrowed. */
KM_API const char *km_model_body_name(const km_model *model, int body);
/* Frames, in the order in which the model has them: those of the inertial frame first, every body's `origin` first.
 * Name
 * ("" if there is no such frame, borrowed) and body (-1). */
KM_API int km_model_frame_count(const km_model *model);
KM_API const char *km_model_frame_name(const km_model *model, int frame);
KM_API int km_model_frame_body(const km_model *model, int frame);
/* Labels as every output writes them: `name`, or `assembly/name` where the name isn't unique; coordinate k of
 * a joint with several is `label[k]`. Borrowed. */
KM_API const char *km_model_joint_label(const km_model *model, int joint);
KM_API const char *km_model_coordinate_label(const km_model *model, int coordinate);
/* "rad", "deg", "m", "mm" … : the unit of a coordinate in the model's units. Borrowed. */
KM_API const char *km_model_coordinate_unit(const km_model *model, int coordinate);
/* Number of coordinates of a joint, and the index of its first. */
KM_API int km_model_joint_freedom(const km_model *model, int joint, int *first);
/* The joint that a coordinate belongs to; -1: there is no such coordinate. */
KM_API int km_model_coordinate_joint(const km_model *model, int coordinate);
/* Limits `*low` and `*high` in the coordinate's unit, minus or plus infinity where there is none. False if it has none at all. */
KM_API bool km_model_coordinate_limits(const km_model *model, int coordinate, double *low, double *high);
/* Is it a length, and not an angle? False if there is no such coordinate. */
KM_API bool km_model_coordinate_is_length(const km_model *model, int coordinate);
/* The model is to use this characteristic length (in its own length unit, > 0), that of another one that it is compared
 * with. To be called before the model is compiled. */
KM_API void km_model_share_length(km_model *model, double length);
/* The model's length unit in metres. */
KM_API double km_model_length_unit(const km_model *model);
KM_API const char *km_model_sha256(const km_model *model); /* of the bytes read; borrowed */

/* The poses that the model names, 0 … the count; "" if there is no such pose. And the index of one by its name; KM_USAGE
 * with the nearest names. */
KM_API int km_model_pose_count(const km_model *model);
KM_API const char *km_model_pose_name(const km_model *model, int pose);
KM_API km_status km_model_find_pose(const km_model *model, const char *name, int *pose, km_error *error);
/* What a pose says of a coordinate, in its unit; NaN: nothing, or there is no such pose or coordinate. O(what it says). */
KM_API double km_model_pose_value(const km_model *model, int pose, int coordinate);

/* Index of the joint or coordinate that a label (or full path) names; KM_USAGE with the nearest labels if
 * none does. A joint's label is also that of its coordinate where it has just one. */
KM_API km_status km_model_find_joint(const km_model *model, const char *label, int *joint, km_error *error);
KM_API km_status km_model_find_coordinate(const km_model *model, const char *label, int *coordinate, km_error *error);
/* Index of a frame from the names of a path: from the root, or [body, frame] where the body is unique. */
KM_API km_status km_model_find_frame(const km_model *model, const char *const *names, size_t count, int *frame,
                                     km_error *error);

/* ---- The units a model is written in, and what they are in SI. */

/* One unit of a quantity: the word in a file, the suffix in a column, its size in SI. */
typedef struct km_unit {
  const char *word, *suffix; /* in a file: "degrees"; in a column: "deg" */
  double si;                 /* radians, metres, kilograms, seconds, newtons of one */
} km_unit;

/* A unit for each quantity. */
typedef struct km_units {
  const km_unit *angle, *length, *mass, *time, *force; /* borrowed for ever */
} km_units;

/* Exponents of the five base units; generalised forces and rates of angles count radians, so `angle` is 1 only for angles
 * written in the angle unit. */
typedef struct km_dimension {
  signed char angle, length, mass, time, force; /* exponents */
} km_dimension;

/* What has a unit of its own. */
typedef enum km_quantity {
  KM_ANGLE,     /* radians in SI */
  KM_LENGTH,    /* metres */
  KM_MASS,      /* kilograms */
  KM_TIME,      /* seconds */
  KM_FORCE,     /* newtons */
  KM_QUANTITIES /* how many there are */
} km_quantity;

KM_API km_units km_units_default(void); /* radians, metres, kilograms, seconds, newtons */
/* Those of a model; the default ones without a model. */
KM_API km_units km_model_units(const km_model *model);
/* "angle" …; "" for none. */
KM_API const char *km_quantity_name(km_quantity quantity);
/* The unit of that word or suffix; NULL if there is none. */
KM_API const km_unit *km_unit_find(km_quantity quantity, const char *word);
/* The place of a quantity's unit among the others; NULL if there is none. */
KM_API const km_unit **km_units_slot(km_units *units, km_quantity quantity);
/* Size in SI of one unit of a dimension. NaN without units. */
KM_API double km_units_factor(const km_units *units, km_dimension dimension);

/* ---- Changing the numbers of a model, for variants: its bodies, joints and names stay. A mechanism compiled from the model
 * takes them over with km_mechanism_renumber. Units are the model's. KM_USAGE: no such element; KM_MODEL: a number that the
 * element can't have. A refused call changes nothing. Not while another thread uses the model. */

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
