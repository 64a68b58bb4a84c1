/* Models by calls: definitions with defaults are added to a builder, which then gives the same model that a file would.
 *
 *   km_builder *builder;
 *   km_builder_create(&builder, &error);
 *   km_body_def crank = km_body_default();
 *   crank.name = "crank";
 *   km_body_id id;
 *   km_model_add_body(builder, &crank, &id, &error);
 *   …
 *   km_builder_finish(builder, &model, &error);
 *   km_builder_free(builder);
 *
 * Every number is in the units of km_settings_def, as in a file; texts and arrays are copied. An id of 0 is none, so a
 * definition that is left at {0} is refused instead of meaning the first element. After a failed call the builder is as
 * it was before. */
#ifndef KMECH_BUILD_H
#define KMECH_BUILD_H

#include "kmech/base.h"
#include "kmech/model.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A model in the making. */
typedef struct km_builder km_builder;

/* An assembly of the builder; value 0: none. */
typedef struct km_assembly_id {
  int value; /* from 1 */
} km_assembly_id;
/* A body of the builder; value 0: none. */
typedef struct km_body_id {
  int value; /* from 1 */
} km_body_id;
/* A frame of a body; value 0: none. */
typedef struct km_frame_id {
  int value; /* from 1 */
} km_frame_id;
/* A joint of the builder; value 0: none. */
typedef struct km_joint_id {
  int value; /* from 1 */
} km_joint_id;

/* Freedom of a joint type along or about the axes of the parent frame. */
typedef enum km_joint_type {
  KM_RX,          /* a hinge about x; one angle */
  KM_RY,          /* a hinge about y */
  KM_RZ,          /* a hinge about z */
  KM_TX,          /* a slide along x; one length */
  KM_TY,          /* a slide along y */
  KM_TZ,          /* a slide along z */
  KM_RIGID,       /* no coordinate */
  KM_SPHERICAL,   /* a rotation vector */
  KM_FLOAT,       /* x, y, z and a rotation vector */
  KM_CYLINDRICAL, /* Tz, Rz */
  KM_UNIVERSAL,   /* Rx(q0) · Ry(q1) */
  KM_PLANAR,      /* Tx, Ty, Rz */
  KM_SCREW,       /* Rz(q) with Tz = pitch · q / 2π */
  KM_JOINT_TYPES  /* how many there are */
} km_joint_type;

enum {
  KM_MAX_FREEDOM = 6 /* the most coordinates of a joint */
};

/* What holds for the whole model. Start from km_settings_default(). */
typedef struct km_settings_def {
  const char *angle, *length, *mass, *time, *force; /* unit words of the format: "radians", "meters", "kilograms", … */
  double gravity[3];                                /* length / time²; 0: weightless */
  double characteristic_length;                     /* length; 0: the longest link */
  double closure_tolerance;                         /* relative; 0: 1e-9, and ranks don't follow it */
  const char *source;                               /* where the model is from, in words; NULL: not told */
} km_settings_def;
KM_API km_settings_def km_settings_default(void); /* SI units */

/* A frame of a body: where joints, loads and points are. */
typedef struct km_frame_def {
  const char *name;
  double T[3]; /* from the body's frame; length */
  double R[9]; /* by rows; identity by default; the nearest rotation is taken, 0.01 in an entry away at most */
} km_frame_def;
KM_API km_frame_def km_frame_default(void);

/* Massless by default. */
typedef struct km_body_def {
  const char *name;
  km_assembly_id assembly;  /* none: the model's first one, which is made where there is none */
  double mass;              /* model's mass unit */
  double center_of_mass[3]; /* in the body's frame */
  double inertia[6];        /* Ixx Iyy Izz Ixy Iyz Izx about the centre of mass, the matrix's own entries */
  double density;           /* < 0 (default): mass and inertia count; else they come from the mesh */
  const char *mesh;         /* file; NULL: none */
} km_body_def;
KM_API km_body_def km_body_default(void);

/* The bodies that a shape can be. */
typedef enum km_shape_kind {
  KM_SHAPE_OF_MESH,  /* a surface from a file */
  KM_SHAPE_BOX,      /* size: x, y, z */
  KM_SHAPE_SPHERE,   /* radius */
  KM_SHAPE_CYLINDER, /* radius, length along z */
  KM_SHAPE_CAPSULE,  /* radius, length along z without the caps */
  KM_SHAPE_KINDS     /* how many there are */
} km_shape_kind;

/* A part of what a body looks like, about its own origin. It is weighed where it has a density; the body's stated mass
 * doesn't count then. */
typedef struct km_shape_def {
  km_shape_kind kind; /* which of the sizes count */
  const char *mesh;   /* file; of a mesh */
  double scale[3];    /* of a mesh: the model's lengths per unit of its file; 1 by default */
  double size[3];     /* length */
  double T[3], R[9];  /* in the body's frame; R by rows */
  double density;     /* < 0 (default): not weighed */
  double color[4];    /* red, green, blue, opacity, 0 to 1; opacity < 0 (default): none is stated */
} km_shape_def;
KM_API km_shape_def km_shape_default(void); /* a sphere */

/* A motion over time that a simulation prescribes. Angles in the model's unit. */
typedef enum km_motion_law {
  KM_MOTION_FREE,       /* none: forces move it */
  KM_MOTION_TABLE,      /* values at times, joined by a cubic spline */
  KM_MOTION_POLYNOMIAL, /* Σ c_k t^k */
  KM_MOTION_SINE        /* offset + amplitude · sin(2π · frequency · t + phase) */
} km_motion_law;

/* Arrays have an entry for each coordinate of the type. */
typedef struct km_joint_def {
  const char *name;
  km_assembly_id assembly;         /* none: as for bodies */
  km_joint_type type;              /* which motion it allows */
  km_frame_id parent, child;       /* X_child = X_parent · motion(q) */
  double pitch;                    /* of a screw: travel in one turn */
  double position[KM_MAX_FREEDOM]; /* at the start */
  double velocity[KM_MAX_FREEDOM]; /* at the start; a joint with 0 in all of them follows the joints that state one */
  double damping[KM_MAX_FREEDOM];  /* force against a unit rate */
  double low[KM_MAX_FREEDOM], high[KM_MAX_FREEDOM]; /* ∓infinity by default */
  double most_turn; /* of a spherical joint: limit of the angle |q| of its rotation vector; 0: none */
  double max_rate[KM_MAX_FREEDOM], max_force[KM_MAX_FREEDOM]; /* of the drive; infinity by default */
  double armature[KM_MAX_FREEDOM];                            /* inertia of the drive's rotor, seen by the coordinate */
  double constant_friction[KM_MAX_FREEDOM];                   /* force, or torque of angles */
  double friction, friction_radius;    /* Coulomb's coefficient; where the pin of a hinge slides (length) */
  double stiction_velocity;            /* sliding speed below which a simulation counts it as sticking */
  double stop_stiffness, stop_damping; /* of the limits, in a simulation */
  km_motion_law law;                   /* how a simulation moves it */
  int law_count; /* rows of a table (t, q), or coefficients; 1 for a sine (offset, amplitude, frequency, phase) */
  const double *law_values; /* [2 · law_count], [law_count] or [4] */
} km_joint_def;
KM_API km_joint_def km_joint_default(void);

/* One coordinate of a joint. */
typedef struct km_coordinate_ref {
  km_joint_id joint; /* whose; 0: no coordinate */
  int index;         /* 0 … */
} km_coordinate_ref;

/* Σ ratio · q = const over `count` coordinates, or of two q1 = Σ c_k q2^k; angles in radians. */
typedef struct km_coupling_def {
  const char *name;
  km_assembly_id assembly; /* none: as for bodies */
  int count;
  const km_coordinate_ref *coordinates; /* [count] which are tied together */
  const double *ratios;                 /* [count]; NULL where there is a polynomial */
  bool constant_given;                  /* else the constant is what the first positions give */
  double constant;                      /* of Σ ratio · q */
  int polynomial_count;                 /* 0: none */
  const double *polynomial;             /* [polynomial_count] lowest power first */
} km_coupling_def;

/* What a force follows. */
typedef enum km_module_type {
  KM_MODULE_STIFFNESS, /* a force from the displacement: a spring */
  KM_MODULE_DAMPING,   /* a force from the rate */
  KM_MODULE_FRICTION,  /* the same, as dry friction is told */
  KM_MODULE_MOTOR,     /* a force from time */
  KM_MODULE_PID,       /* a controller of a coordinate */
  KM_MODULE_TIRE,      /* Fiala's tyre */
  KM_MODULE_TYPES      /* how many there are */
} km_module_type;

/* What a port between frames measures: the distance of their origins, or along an axis of the parent's. */
typedef enum km_distance {
  KM_DISTANCE_EUCLID, /* how far apart they are */
  KM_DISTANCE_X,      /* along x */
  KM_DISTANCE_Y,      /* along y */
  KM_DISTANCE_Z       /* along z */
} km_distance;

/* A force from a displacement, a rate or time: in a joint's coordinate, or between the origins of two frames. The value
 * of the piece between two knots is a polynomial, lowest power first; angles in radians; positive pushes the
 * coordinate or the distance to grow. A spring of stiffness k has no knot and the piece {0, -k}. */
typedef struct km_force_def {
  const char *name;
  km_module_type type;          /* what the law follows */
  km_coordinate_ref coordinate; /* where it measures and acts, or … */
  km_frame_id from, to;         /* … between these */
  km_distance distance;         /* of frames: what is measured */
  int knot_count;
  const double *knots;          /* [knot_count] where pieces of the law meet, increasing */
  const int *piece_sizes;       /* [knot_count + 1] how many coefficients each piece has */
  const double *coefficients;   /* [Σ piece_sizes] piece by piece */
  double reference, kp, ki, kd; /* of a controller */
} km_force_def;
KM_API km_force_def km_force_default(void);

/* A wrench at a frame's origin, along the inertial axes, or turning with the frame. */
typedef struct km_load_def {
  const char *name;
  km_frame_id frame;          /* at whose origin it acts */
  double force[3], torque[3]; /* model's units of force, and of force × length */
  bool turning;               /* along the frame's axes, else along the inertial frame's */
} km_load_def;

/* What sweeps do by default: a driver over a range, or (arclength > 0) along the motion. */
typedef struct km_sweep_def {
  km_coordinate_ref driver; /* what moves; of a sweep by arc length none */
  double from, to;          /* the driver's unit */
  double arclength; /* > 0: length of a step along the motion, over radians and scaled lengths, without a driver */
  km_coordinate_ref direction; /* by arc length: what starts the motion; joint 0: the liveliest */
  double sign;                 /* +1 or -1 */
  int steps;                   /* intervals */
} km_sweep_def;
KM_API km_sweep_def km_sweep_default(void); /* 100 steps */

/* An end of a mechanical advantage: a coordinate, or a frame's origin along a direction (inertial axes). */
typedef struct km_end_def {
  km_coordinate_ref coordinate; /* joint 0: none, the frame counts */
  km_frame_id frame;            /* whose origin moves */
  double direction[3];          /* inertial axes; any length but 0 */
} km_end_def;

/* The caller frees `*out`. KM_MEMORY. */
KM_API km_status km_builder_create(km_builder **out, km_error *error);
KM_API void km_builder_free(km_builder *builder);

/* Each of these copies what it is given. KM_MODEL: the definition is wrong, and says which name, what was found and
 * what is expected; KM_MEMORY. `out` may be NULL. `parent`: the assembly around it; none: it stands alone.
 * Cost: O(1), O(name) for names. */
KM_API km_status km_model_set(km_builder *builder, const km_settings_def *def, km_error *error);
KM_API km_status km_model_add_assembly(km_builder *builder, const char *name, km_assembly_id parent,
                                       km_assembly_id *out, km_error *error);
KM_API km_status km_model_add_body(km_builder *builder, const km_body_def *def, km_body_id *out, km_error *error);
KM_API km_status km_model_add_frame(km_builder *builder, km_body_id body, const km_frame_def *def, km_frame_id *out,
                                    km_error *error);
KM_API km_status km_model_add_shape(km_builder *builder, km_body_id body, const km_shape_def *def, km_error *error);
KM_API km_status km_model_add_joint(km_builder *builder, const km_joint_def *def, km_joint_id *out, km_error *error);
KM_API km_status km_model_add_coupling(km_builder *builder, const km_coupling_def *def, km_error *error);
KM_API km_status km_model_add_force(km_builder *builder, const km_force_def *def, km_error *error);
KM_API km_status km_model_add_load(km_builder *builder, const km_load_def *def, km_error *error);
/* analysis.hold: the coordinate is kept at the value. Of a ball all three components together. */
KM_API km_status km_model_add_hold(km_builder *builder, km_coordinate_ref coordinate, double value, km_error *error);
/* analysis.actuators: a coordinate that kstatic and others take as driven. KM_MODEL: named twice. */
KM_API km_status km_model_add_actuator(km_builder *builder, km_coordinate_ref coordinate, km_error *error);
/* A pose by name: values of `count` coordinates. */
KM_API km_status km_model_add_pose(km_builder *builder, const char *name, const km_coordinate_ref *coordinates,
                                   const double *values, int count, km_error *error);
/* analysis.sweep. KM_MODEL: neither a driver nor a step along the motion, or both; steps out of range. */
KM_API km_status km_model_set_sweep(km_builder *builder, const km_sweep_def *def, km_error *error);
/* analysis.mechanical_advantage: that of an `input` for an `output`. KM_MODEL: an end is neither a coordinate nor a point. */
KM_API km_status km_model_set_advantage(km_builder *builder, const km_end_def *input, const km_end_def *output,
                                        km_error *error);

/* The inertial frame as a body, and the frame that every body has at its own origin. {0} for an id that is none. */
KM_API km_body_id km_builder_fixed(const km_builder *builder);
KM_API km_frame_id km_builder_origin(const km_builder *builder, km_body_id body);

/* Labels the joints, checks what needs the whole (every body tied to the inertial frame, inertias), and hands the model
 * over; the builder is empty afterwards, whatever the status. KM_MODEL tells the first fault. The caller frees
 * `*out` with km_model_free. */
KM_API km_status km_builder_finish(km_builder *builder, km_model **out, km_error *error);
/* Mass properties of the bodies with a density, from their meshes, which are looked for from the current folder. Files
 * do this by themselves. KM_MODEL: a mesh isn't found or isn't closed. */
KM_API km_status km_model_weigh_meshes(km_model *model, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
