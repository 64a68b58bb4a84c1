/* Models by calls. Definitions with defaults are added to a builder, which then creates the same model as a file.
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
 * Numbers are in the units of km_settings_def; texts and arrays are copied. An id of 0 is invalid, so a definition left
 * at {0} is refused. A failed call leaves the builder unchanged. */
#ifndef KMECH_BUILD_H
#define KMECH_BUILD_H

#include "kmech/base.h"
#include "kmech/model.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Builder of a model. */
typedef struct km_builder km_builder;

/* Assembly of a builder; 0: none. */
typedef struct km_assembly_id {
  int value; /* 1 … count */
} km_assembly_id;
/* Body of a builder; 0: none. */
typedef struct km_body_id {
  int value; /* 1 … count */
} km_body_id;
/* Frame of a body; 0: none. */
typedef struct km_frame_id {
  int value; /* 1 … count */
} km_frame_id;
/* Joint of a builder; 0: none. */
typedef struct km_joint_id {
  int value; /* 1 … count */
} km_joint_id;

/* Joint types, with their coordinates along or about the axes of the parent frame. */
typedef enum km_joint_type {
  KM_RX,          /* revolute about x; one angle */
  KM_RY,          /* revolute about y */
  KM_RZ,          /* revolute about z */
  KM_TX,          /* prismatic along x; one length */
  KM_TY,          /* prismatic along y */
  KM_TZ,          /* prismatic along z */
  KM_RIGID,       /* rigid: no coordinate */
  KM_SPHERICAL,   /* a rotation vector */
  KM_FLOAT,       /* x, y, z and a rotation vector */
  KM_CYLINDRICAL, /* Tz, Rz */
  KM_UNIVERSAL,   /* Rx(q0) · Ry(q1) */
  KM_PLANAR,      /* Tx, Ty, Rz */
  KM_SCREW,       /* Rz(q) with Tz = pitch · q / 2π */
  KM_JOINT_TYPES  /* number of enumerators */
} km_joint_type;

enum {
  KM_MAX_FREEDOM = 6 /* largest number of coordinates of a joint */
};

/* Settings of a model. Start from km_settings_default(). */
typedef struct km_settings_def {
  const char *angle, *length, *mass, *time, *force; /* unit words of the format: "radians", "meters", "kilograms" … */
  double gravity[3];                                /* length / time²; 0: weightless */
  double characteristic_length;                     /* length; 0: the longest link */
  double closure_tolerance;                         /* relative closure tolerance; 0: 1e-9, without effect on rank
                                                     * tolerances */
  const char *source;                               /* origin of the model as text; NULL: none */
} km_settings_def;
KM_API km_settings_def km_settings_default(void); /* SI units */

/* Definition of a frame of a body, to which joints, loads and points refer. */
typedef struct km_frame_def {
  const char *name;
  double T[3]; /* position in the body's frame, length */
  double R[9]; /* rotation by rows; default identity; replaced by the nearest rotation, at most 0.01 away in an entry */
} km_frame_def;
KM_API km_frame_def km_frame_default(void);

/* Definition of a body; massless by default. */
typedef struct km_body_def {
  const char *name;
  km_assembly_id assembly;  /* none: the first assembly of the model, which is created if necessary */
  double mass;              /* mass unit of the model */
  double center_of_mass[3]; /* in the body's frame */
  double inertia[6];        /* Ixx Iyy Izz Ixy Iyz Izx about the centre of mass, entries of the matrix */
  double density;   /* ≥ 0: mass and inertia are computed from the mesh; < 0 (default): they are those above */
  const char *mesh; /* path; NULL: none */
} km_body_def;
KM_API km_body_def km_body_default(void);

/* Kinds of shapes. */
typedef enum km_shape_kind {
  KM_SHAPE_OF_MESH,  /* surface from a file */
  KM_SHAPE_BOX,      /* size: x, y, z */
  KM_SHAPE_SPHERE,   /* radius */
  KM_SHAPE_CYLINDER, /* radius, length along z */
  KM_SHAPE_CAPSULE,  /* radius, length along z without the caps */
  KM_SHAPE_KINDS     /* number of enumerators */
} km_shape_kind;

/* Shape of a body about its own origin. With a density the shape determines the mass, and the body's stated mass is
 * ignored. */
typedef struct km_shape_def {
  km_shape_kind kind; /* selects the sizes that are valid */
  const char *mesh;   /* path of a mesh */
  double scale[3];    /* mesh: length units of the model per unit of the file; default 1 */
  double size[3];     /* length */
  double T[3], R[9];  /* in the body's frame; R by rows */
  double density;     /* ≥ 0: determines the mass; < 0 (default): doesn't */
  double color[4];    /* red, green, blue, opacity, 0 … 1; opacity < 0 (default): not stated */
} km_shape_def;
KM_API km_shape_def km_shape_default(void); /* defaults: a sphere */

/* Prescribed motions over time. Angles in the model's unit. */
typedef enum km_motion_law {
  KM_MOTION_FREE,       /* not prescribed: forces move the coordinate */
  KM_MOTION_TABLE,      /* cubic spline through values at times */
  KM_MOTION_POLYNOMIAL, /* Σ c_k t^k */
  KM_MOTION_SINE,       /* offset + amplitude · sin(2π · frequency · t + phase) */
  KM_MOTION_CURVE       /* another law of a file: segments, a periodic table, a cosine, an expression */
} km_motion_law;

/* Definition of a joint. Arrays have an entry for each coordinate of the type. */
typedef struct km_joint_def {
  const char *name;
  km_assembly_id assembly;         /* none: the first assembly, as for bodies */
  km_joint_type type;              /* type of motion */
  km_frame_id parent, child;       /* X_child = X_parent · motion(q) */
  double pitch;                    /* screw: translation per turn */
  double position[KM_MAX_FREEDOM]; /* initial displacement */
  double velocity[KM_MAX_FREEDOM]; /* initial rates; a joint with all rates 0 follows the joints that state rates */
  double damping[KM_MAX_FREEDOM];  /* force per unit rate */
  double low[KM_MAX_FREEDOM], high[KM_MAX_FREEDOM]; /* default ∓∞ */
  double most_turn; /* spherical joint: limit of the angle |q| of its rotation vector; 0: none */
  double max_rate[KM_MAX_FREEDOM], max_force[KM_MAX_FREEDOM]; /* largest force of the drive; default ∞ */
  double armature[KM_MAX_FREEDOM];                            /* inertia of the drive's rotor, referred to the
                                                               * coordinate */
  double constant_friction[KM_MAX_FREEDOM];                   /* force, or torque about an angle */
  double friction, friction_radius;    /* Coulomb coefficient; radius of the sliding surface of a revolute joint
                                        * (length) */
  double stiction_velocity;            /* sliding speed below which a simulation regularises Coulomb friction */
  double stop_stiffness, stop_damping; /* stiffness and damping of the limit stops in a simulation */
  km_motion_law law;                   /* prescribed motion in a simulation */
  int law_count; /* number of rows (t, q) of a table, or of coefficients; 1 for a sine (offset, amplitude, frequency,
                  * phase) */
  const double *law_values; /* [2 · law_count], [law_count] or [4] */
} km_joint_def;
KM_API km_joint_def km_joint_default(void);

/* Reference to a coordinate of a joint. */
typedef struct km_coordinate_ref {
  km_joint_id joint; /* joint; 0: no coordinate */
  int index;         /* index in the joint */
} km_coordinate_ref;

/* Definition of a coupling: Σ ratio · q = constant over `count` coordinates, or q1 = Σ c_k q2^k for two; angles in
 * radians. */
typedef struct km_coupling_def {
  const char *name;
  km_assembly_id assembly; /* none: the first assembly, as for bodies */
  int count;
  const km_coordinate_ref *coordinates; /* [count] coupled coordinates */
  const double *ratios;                 /* [count] ratios; NULL for a polynomial */
  bool constant_given;                  /* true if `constant` is stated; otherwise the initial displacements
                                         * determine it */
  double constant;                      /* constant of Σ ratio · q */
  int polynomial_count;                 /* number of coefficients; 0: linear */
  const double *polynomial;             /* [polynomial_count] coefficients, lowest power first */
} km_coupling_def;

/* Types of force modules. */
typedef enum km_module_type {
  KM_MODULE_STIFFNESS, /* force as a function of displacement (spring) */
  KM_MODULE_DAMPING,   /* force as a function of rate (damper) */
  KM_MODULE_FRICTION,  /* force as a function of rate (dry friction) */
  KM_MODULE_MOTOR,     /* force as a function of time */
  KM_MODULE_PID,       /* controller of a coordinate */
  KM_MODULE_TIRE,      /* Fiala tyre */
  KM_MODULE_CONTACT,   /* unilateral contact with friction */
  KM_MODULE_TYPES      /* number of enumerators */
} km_module_type;

/* Measure between two frames: distance of their origins, a component along an axis of the parent frame, or the angle of
 * the child frame about such an axis, from -pi to pi. */
typedef enum km_distance {
  KM_DISTANCE_EUCLID, /* distance */
  KM_DISTANCE_X,      /* component along x */
  KM_DISTANCE_Y,      /* component along y */
  KM_DISTANCE_Z,      /* component along z */
  KM_DISTANCE_RX,     /* angle about x: of the child's y axis in the parent's plane x = 0 */
  KM_DISTANCE_RY,     /* angle about y: of the child's z axis in the parent's plane y = 0 */
  KM_DISTANCE_RZ      /* angle about z: of the child's x axis in the parent's plane z = 0 */
} km_distance;

/* Definition of a force as a piecewise polynomial of a displacement, rate or time: in a joint's coordinate, or
 * between the origins of two frames. Coefficients from the lowest power; angles in radians. A positive force
 * increases the coordinate or distance. A spring of stiffness k has no knot and the piece {0, -k}. */
typedef struct km_force_def {
  const char *name;
  km_module_type type;          /* argument of the law */
  km_coordinate_ref coordinate; /* coordinate at which it measures and acts, or … */
  km_frame_id from, to;         /* … frames between which it measures and acts */
  km_distance distance;         /* measure between the frames */
  int knot_count;
  const double *knots;          /* [knot_count] ends of the pieces, increasing */
  const int *piece_sizes;       /* [knot_count + 1] numbers of coefficients of the pieces */
  const double *coefficients;   /* [Σ piece_sizes] coefficients, piece by piece */
  double reference, kp, ki, kd; /* gains and reference of a controller */
} km_force_def;
KM_API km_force_def km_force_default(void);

/* Definition of a load: a wrench at a frame's origin, along inertial axes or the frame's axes. */
typedef struct km_load_def {
  const char *name;
  km_frame_id frame;          /* frame at whose origin the load acts */
  double force[3], torque[3]; /* units of force and of force · length of the model */
  bool turning;               /* true: along the frame's axes; false: along inertial axes */
} km_load_def;

/* Default sweep: a driver over a range, or (arclength > 0) a motion by arc length. */
typedef struct km_sweep_def {
  km_coordinate_ref driver;    /* driver; none for a sweep by arc length */
  double from, to;             /* unit of the driver */
  double arclength;            /* > 0: arc length of a step in radians and scaled lengths, without a driver */
  km_coordinate_ref direction; /* coordinate that determines the direction by arc length; joint 0: that with the
                                * largest mobility number */
  double sign;                 /* sense of that coordinate: +1 or −1 */
  int steps;                   /* number of intervals */
} km_sweep_def;
KM_API km_sweep_def km_sweep_default(void); /* 100 steps */

/* Definition of a port of a mechanical advantage: a coordinate, or a frame's origin along a direction (inertial
 * axes). */
typedef struct km_end_def {
  km_coordinate_ref coordinate; /* coordinate; joint 0: the port is the frame */
  km_frame_id frame;            /* frame whose origin is the port */
  double direction[3];          /* direction in inertial axes; any length except 0 */
} km_end_def;

/* Creates a builder. The caller frees `*out`. KM_MEMORY. */
KM_API km_status km_builder_create(km_builder **out, km_error *error);
KM_API void km_builder_free(km_builder *builder);

/* Add a copy of a definition. `out` may be NULL. `parent`: enclosing assembly; none: top level. KM_MODEL: an invalid
 * definition, with the name, found and expected; KM_MEMORY. Cost: O(1), O(length) for names. */
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
/* analysis.hold: holds the coordinate at a value. The three components of a ball joint are held together. */
KM_API km_status km_model_add_hold(km_builder *builder, km_coordinate_ref coordinate, double value, km_error *error);
/* analysis.actuators: the coordinate is an actuator of the static analyses. KM_MODEL: named twice. */
KM_API km_status km_model_add_actuator(km_builder *builder, km_coordinate_ref coordinate, km_error *error);
/* Adds a named pose: values of `count` coordinates. */
KM_API km_status km_model_add_pose(km_builder *builder, const char *name, const km_coordinate_ref *coordinates,
                                   const double *values, int count, km_error *error);
/* analysis.sweep. KM_MODEL: neither or both of a driver and an arc length, or steps out of range. */
KM_API km_status km_model_set_sweep(km_builder *builder, const km_sweep_def *def, km_error *error);
/* analysis.mechanical_advantage between an `input` and an `output`. KM_MODEL: a port is neither a coordinate nor a
 * point. */
KM_API km_status km_model_set_advantage(km_builder *builder, const km_end_def *input, const km_end_def *output,
                                        km_error *error);

/* The inertial frame as a body; and the frame at the origin of a body. {0} for an invalid id. */
KM_API km_body_id km_builder_fixed(const km_builder *builder);
KM_API km_frame_id km_builder_origin(const km_builder *builder, km_body_id body);

/* Labels the joints, checks the complete model (each body connected to the inertial frame, valid inertias) and
 * creates it; the builder is then empty, whatever the status. KM_MODEL: the first fault. The caller frees `*out`
 * with km_model_free. */
KM_API km_status km_builder_finish(km_builder *builder, km_model **out, km_error *error);
/* Computes the mass properties of bodies with a density from their meshes, relative to the current folder. Readers
 * of files call it themselves. KM_MODEL: a mesh isn't found or isn't closed. */
KM_API km_status km_model_weigh_meshes(km_model *model, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
