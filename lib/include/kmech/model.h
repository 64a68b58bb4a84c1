/* Models: what the user wrote. Bodies, joints and couplings in named assemblies, with units, defaults and loads. A
 * model is immutable, except by the functions that set its numbers. */
#ifndef KMECH_MODEL_H
#define KMECH_MODEL_H

#include "kmech/base.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A model, read from a file or built by calls. */
typedef struct km_model km_model;

/* Factor of a load over a joint's value or the time: `scale` of a model's load. */
typedef struct km_load_scale km_load_scale;

/* Reads a model from `size` bytes of JSON, URDF, MJCF or SDF; the format is recognised from the text. Warnings,
 * notes and up to 20 errors are added to `messages`, each with its location in the file. With an error the status is
 * KM_MODEL, `error` holds the first one and `*out` is NULL. The caller frees `*out`. Cost: linear in the file. */
KM_API km_status km_model_read(const char *bytes, size_t size, km_messages *messages, km_model **out, km_error *error);

/* Reads a model from a file; "-" is the standard input. KM_IO if it can't be read. Otherwise like km_model_read. */
KM_API km_status km_model_read_file(const char *path, km_messages *messages, km_model **out, km_error *error);

/* A new value for a number of a model file, in the file's units. */
typedef struct km_assignment {
  const char *path; /* path of the number, such as crank.tip.x */
  double value;     /* value that replaces the file's */
} km_assignment;

/* Reads a variant of a model: km_model_read after `assignments` have been applied to the file in their order. The
 * model is bit for bit that of a file edited by hand; expressions follow their parameters, and km_model_sha256 is
 * that of `bytes`. A path is the name of a parameter, or names of elements and keys joined by dots that end at a
 * number: brake.left_arm.cable.x (assembly, body, frame, component x y z of a frame's T or a joint's `at`);
 * left_arm.cable.T.0 (the same number, if only one body is named left_arm); crank.mass; A.limits.1;
 * A.initial_displacement; lift.spring.stiffness; model_parameters.gravity.2; loads.payload.force.2 (an element of a
 * list by its name, or by its index from 0). Names of lists (bodies, frames, joints …) may be omitted between
 * elements. A path that matches from the root has precedence; otherwise it may begin anywhere. A dot or backslash
 * inside a name is escaped by a backslash. Numbers that the file leaves at their default can be named. `file`:
 * origin of the bytes, for meshes; NULL: none. KM_USAGE, with the nearest names: a path matches no number or several
 * (all are listed), or a value isn't finite. Otherwise like km_model_read. Cost: linear in the file for each path. */
KM_API km_status km_model_read_varied(const char *bytes, size_t size, const char *file,
                                      const km_assignment *assignments, int count, km_messages *messages,
                                      km_model **out, km_error *error);
/* Reads a variant from a file; "-" is the standard input, which can be read once. KM_IO if it can't be read.
 * Otherwise like km_model_read_varied. */
KM_API km_status km_model_read_file_varied(const char *path, const km_assignment *assignments, int count,
                                           km_messages *messages, km_model **out, km_error *error);
/* Reads the values[count] of the numbers that paths[count] name in a JSON file of kmech; NaN if the file doesn't
 * state one. `plain`[count] (may be NULL): true if the number occurs in no expression together with other terms.
 * KM_USAGE as above, KM_MODEL. */
KM_API km_status km_model_read_numbers(const char *bytes, size_t size, const char *const *paths, int count,
                                       double *values, bool *plain, km_error *error);
/* Writes the text of a JSON file of kmech in which paths[count] have the values[count], as an editor would. Mesh
 * paths relative to the file `from` (NULL: the current folder) become relative to the file `to` (NULL: unchanged).
 * Writes as many bytes as fit, with a NUL, into text[capacity] (may be NULL) and returns the full length without the
 * NUL; 0 on failure, with `error` filled. */
KM_API size_t km_model_write_varied(const char *bytes, size_t size, const km_assignment *assignments, int count,
                                    const char *from, const char *to, char *text, size_t capacity, km_error *error);
/* Options of reading a model. Start from {0}. */
typedef struct km_read_def {
  const char *file;                 /* origin of the bytes, for meshes and other files that they name; NULL: none */
  const km_assignment *assignments; /* [assignment_count], as in km_model_read_varied; JSON only */
  int assignment_count;
  bool floating; /* bodies without a parent in a robot description are free, instead of fixed to the inertial frame */
  double closure_tolerance; /* relative closure tolerance that replaces the file's, below 0.1; 0: the file's */
} km_read_def;

/* Like km_model_read and km_model_read_file (which sets `file`), with options. KM_USAGE: also assignments to a
 * format other than JSON, and an invalid closure tolerance. */
KM_API km_status km_model_read_as(const char *bytes, size_t size, const km_read_def *def, km_messages *messages,
                                  km_model **out, km_error *error);
KM_API km_status km_model_read_file_as(const char *path, const km_read_def *def, km_messages *messages, km_model **out,
                                       km_error *error);
KM_API void km_model_free(km_model *model);

/* Numbers of active elements, which are indexed in file order. The inertial frame isn't counted as a body. */
KM_API int km_model_body_count(const km_model *model);
KM_API int km_model_joint_count(const km_model *model);
KM_API int km_model_coordinate_count(const km_model *model);

/* Texts of a model for the head of reports. */
typedef enum km_model_word {
  KM_WORD_TITLE,  /* title */
  KM_WORD_AUTHOR, /* author */
  KM_WORD_DATE,   /* date as text */
  KM_WORD_NOTES,  /* a paragraph */
  KM_WORD_LOGO,   /* PNG file, seen from the folder of the model's file */
  KM_MODEL_WORDS  /* number of enumerators */
} km_model_word;
/* Such a text; NULL: not stated, or an invalid argument. Borrowed. */
KM_API const char *km_model_word_text(const km_model *model, km_model_word word);
/* Name of body 0 … number of bodies in the file; 0 is the inertial frame. Borrowed. */
KM_API const char *km_model_body_name(const km_model *model, int body);
/* Frames in model order: those of the inertial frame first, each body's `origin` first. Name ("" if the index is
 * invalid, borrowed) and body (-1). */
KM_API int km_model_frame_count(const km_model *model);
KM_API const char *km_model_frame_name(const km_model *model, int frame);
KM_API int km_model_frame_body(const km_model *model, int frame);
/* Labels as in every output: `name`, or `assembly/name` if the name isn't unique; coordinate k of a joint with
 * several is `label[k]`. Borrowed. */
KM_API const char *km_model_joint_label(const km_model *model, int joint);
KM_API const char *km_model_coordinate_label(const km_model *model, int coordinate);
/* Unit of a coordinate in the model's units: "rad", "deg", "m", "mm" … Borrowed. */
KM_API const char *km_model_coordinate_unit(const km_model *model, int coordinate);
/* Number of coordinates of a joint, and the index of its first. */
KM_API int km_model_joint_freedom(const km_model *model, int joint, int *first);
/* Joint of a coordinate; -1 if the index is invalid. */
KM_API int km_model_coordinate_joint(const km_model *model, int coordinate);
/* Limits of a coordinate in its unit: `*low` is −∞ or `*high` +∞ where there is none. False if it has no limit. */
KM_API bool km_model_coordinate_limits(const km_model *model, int coordinate, double *low, double *high);
/* True if the coordinate is a length; false for an angle or an invalid index. */
KM_API bool km_model_coordinate_is_length(const km_model *model, int coordinate);
/* Sets the characteristic length (> 0, in the model's length unit), so that models that are compared share one. Call
 * before the model is compiled. */
KM_API void km_model_share_length(km_model *model, double length);
/* Length unit of the model in metres. */
KM_API double km_model_length_unit(const km_model *model);
KM_API const char *km_model_sha256(const km_model *model); /* SHA-256 of the bytes read; borrowed */

/* Named poses of the model: their number, the name of `pose` ("" if the index is invalid), and the index *pose of a
 * name. KM_USAGE with the nearest names. */
KM_API int km_model_pose_count(const km_model *model);
KM_API const char *km_model_pose_name(const km_model *model, int pose);
KM_API km_status km_model_find_pose(const km_model *model, const char *name, int *pose, km_error *error);
/* Value of a coordinate in a named pose, in its unit; NaN if the pose doesn't state it or an index is invalid.
 * O(stated values). */
KM_API double km_model_pose_value(const km_model *model, int pose, int coordinate);

/* Index of the joint or coordinate with a label (or full path). KM_USAGE with the nearest labels. The label of a
 * joint with one coordinate is also that of the coordinate. */
KM_API km_status km_model_find_joint(const km_model *model, const char *label, int *joint, km_error *error);
KM_API km_status km_model_find_coordinate(const km_model *model, const char *label, int *coordinate, km_error *error);
/* Index of a frame from the names of its path, from the root, or [body, frame] if the body's name is unique. */
KM_API km_status km_model_find_frame(const km_model *model, const char *const *names, size_t count, int *frame,
                                     km_error *error);

/* ---- Units of a model, and their sizes in SI. */

/* A unit: word in a file, suffix of a column, size in SI. */
typedef struct km_unit {
  const char *word, *suffix; /* word in a file ("degrees"); suffix of a column ("deg") */
  double si;                 /* size in radians, metres, kilograms, seconds or newtons */
} km_unit;

/* A unit for each quantity. */
typedef struct km_units {
  const km_unit *angle, *length, *mass, *time, *force; /* static */
} km_units;

/* Exponents of the five base units; generalised forces and rates of angles count radians, so `angle` is 1 only for
 * angles written in the angle unit. */
typedef struct km_dimension {
  signed char angle, length, mass, time, force; /* exponents of the quantities */
} km_dimension;

/* Base quantities. */
typedef enum km_quantity {
  KM_ANGLE,     /* in radians */
  KM_LENGTH,    /* metres */
  KM_MASS,      /* kilograms */
  KM_TIME,      /* seconds */
  KM_FORCE,     /* newtons */
  KM_QUANTITIES /* number of enumerators */
} km_quantity;

KM_API km_units km_units_default(void); /* in radians, metres, kilograms, seconds or newtons */
/* Units of a model; the default units if `model` is NULL. */
KM_API km_units km_model_units(const km_model *model);
/* "angle" …; "" if invalid. */
KM_API const char *km_quantity_name(km_quantity quantity);
/* The unit with a word or suffix; NULL if there is none. */
KM_API const km_unit *km_unit_find(km_quantity quantity, const char *word);
/* Address of the unit of a quantity in `units`; NULL if the quantity is invalid. */
KM_API const km_unit **km_units_slot(km_units *units, km_quantity quantity);
/* Size in SI of the unit of a dimension. NaN if `units` is NULL. */
KM_API double km_units_factor(const km_units *units, km_dimension dimension);

/* ---- Changing the numbers of a model. Bodies, joints and names don't change. km_mechanism_renumber updates a
 * mechanism that was compiled from the model. Units are the model's. KM_USAGE: an invalid index; KM_MODEL: an
 * invalid number; the model is then unchanged. No other thread may use the model during a call. */

/* Sets the position T (length) of a frame in its body, and R by rows (NULL: unchanged). */
KM_API km_status km_model_set_frame(km_model *model, int frame, const double T[3], const double R[9], km_error *error);
/* Sets the initial `position` of a coordinate; and its limits `low` and `high` (∓∞: none). */
KM_API km_status km_model_set_position(km_model *model, int coordinate, double position, km_error *error);
KM_API km_status km_model_set_limits(km_model *model, int coordinate, double low, double high, km_error *error);
/* Sets `mass`, center_of_mass (body frame) and inertia about it (Ixx Iyy Izz Ixy Iyz Izx) of a body; NULL:
 * unchanged. */
KM_API km_status km_model_set_mass(km_model *model, int body, double mass, const double center_of_mass[3],
                                   const double inertia[6], km_error *error);
/* Sets force and torque of a load; NULL: unchanged. */
KM_API km_status km_model_set_load(km_model *model, int load, const double force[3], const double torque[3],
                                   km_error *error);

#ifdef __cplusplus
}
#endif
#endif
