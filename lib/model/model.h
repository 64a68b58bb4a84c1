/* The model as the other modules see it: checked, resolved, in the file's units (angles too). */
#ifndef KM_MODEL_MODEL_H
#define KM_MODEL_MODEL_H

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "kmech/model.h"
#include "model/joint_type.h"
#include "spatial/pose.h"

enum { KM_NO_ASSEMBLY = -1 };

typedef struct km_model_assembly {
  const char *name;
  int parent; /* assembly, or KM_NO_ASSEMBLY */
  bool drawn; /* its bodies' frames are the inertial frame where the joints have the values that they start from */
} km_model_assembly;

/* Body 0 is the inertial frame, called `fixed`. */
typedef struct km_model_body {
  const char *name;
  int assembly;
  double mass;
  km_vec3 center_of_mass;
  double inertia[6];  /* Ixx Iyy Izz Ixy Iyz Izx about the centre of mass */
  double density;     /* < 0: not given */
  bool is_strut_part; /* a half of a strut: its place is that of the strut's ends */
  const char *mesh;   /* file name of the definition, NULL: none */
  const char *where;
} km_model_body;

/* A part of what a body looks like. */
typedef struct km_model_shape {
  int body;
  km_shape_kind kind;
  const char *mesh, *where;
  double scale[3], size[3]; /* of a mesh; of the others */
  km_pose pose;             /* in the body's frame */
  double density;           /* < 0: not given */
  double color[4];          /* opacity < 0: none is stated */
} km_model_shape;

/* Every body has its `origin` first. */
typedef struct km_model_frame {
  const char *name;
  int body;
  km_pose pose; /* in the body's frame; length in the model's unit */
} km_model_frame;

/* What resists a joint's motion where its surfaces touch (Coulomb). All 0: no friction. */
typedef struct km_joint_friction {
  double coefficient, radius, stiction_velocity; /* radius: length unit, for joints that turn; length per time */
} km_joint_friction;

/* What the limits do in a simulation: a force or torque per unit beyond them, and per rate. */
typedef struct km_joint_stop {
  double stiffness, damping;
} km_joint_stop;

/* A joint's motion over time. Angles in the file's unit. */
typedef struct km_joint_prescribed {
  km_motion_law law;
  int count;      /* rows of the table, or coefficients */
  double *values; /* [2 · count] t, q; or [count], lowest power first; or [4] offset, amplitude, frequency, phase */
} km_joint_prescribed;

typedef struct km_model_joint {
  const char *name, *label;
  km_joint_type type;
  int assembly;
  int frame[2];         /* parent, child */
  int first_coordinate; /* into the coordinates */
  double pitch;
  double most_turn; /* of a spherical joint: limit of the angle |q|, in the file's unit; 0: none */
  km_joint_friction friction;
  km_joint_stop stop;
  km_joint_prescribed prescribed;
  const char *where;
} km_model_joint;

typedef struct km_model_coordinate {
  const char *label;
  int joint, index;
  bool is_strut; /* the length of a strut is |q|: where its ends have passed each other, q is negative */
  double position, rate, low, high, damping; /* in the file's units; no limit is ∓infinity */
  bool rate_stated;                          /* else the rate at the start follows the others' */
  double max_rate, max_force;                /* of the drive; none is infinity */
  double armature, friction;                 /* of the drive's rotor; what resists every motion alike */
} km_model_coordinate;

typedef struct km_model_coupling {
  const char *name, *where;
  int count;
  int *coordinates;
  double *ratios;      /* NULL: of the first coordinate by a polynomial in the second one */
  bool constant_given; /* else it is that of the first positions */
  double constant;
  int polynomial_count;
  double *polynomial; /* [polynomial_count] lowest power first; radians, lengths */
} km_model_coupling;

enum { KM_MODULE_PORT_FRAMES = -1 };

/* Where a force module measures or acts: a coordinate, or between two frames. */
typedef struct km_module_port {
  int coordinate; /* KM_MODULE_PORT_FRAMES: between two frames */
  int frame[2];   /* the parent's, the child's */
} km_module_port;

/* "stiffness", "damping" …, as the format writes them. */
const char *km_module_type_word(km_module_type type);
int km_module_type_find(const char *word); /* -1: no type */

/* A force law: polynomials between knots of the plain variable (radians, lengths, time). */
typedef struct km_law {
  int knot_count;
  const double *knots;
  const int *start;           /* [knot_count + 2] where each polynomial begins in `coefficients` */
  const double *coefficients; /* lowest power first */
} km_law;

/* Numbers of a tyre by Fiala. */
typedef struct km_tire {
  double radius, stiffness, damping; /* without load; vertical */
  double rolling_resistance, width;  /* lengths */
  double longitudinal, lateral;      /* stiffnesses: force for each unit of slip */
  double friction_peak, friction_sliding, relaxation[2];
} km_tire;

typedef struct km_model_module {
  const char *name, *where;
  km_module_type type;
  km_module_port input, output;
  km_distance distance;
  km_law law;
  double reference, kp, ki, kd; /* of a controller */
  int table_count;              /* of a motor's table: rows */
  const double *table;          /* [2 · table_count] t, f */
  km_tire tire;
} km_model_module;

typedef struct km_applied_load {
  const char *name;
  int frame;
  km_vec3 force, torque;
  bool turning; /* axes turn with the frame */
} km_applied_load;

/* An end of a mechanical advantage: a joint, or a frame's origin along a direction. */
typedef struct km_model_port {
  int coordinate, frame; /* -1: not this kind; both -1: none given */
  km_vec3 direction;     /* inertial axes */
  const char *name;      /* of a point: body/frame:dx,dy,dz */
} km_model_port;

typedef struct km_model_hold {
  int coordinate;
  double value; /* file's unit */
} km_model_hold;

/* A pose by name: values of some coordinates, in the file's units. */
typedef struct km_model_pose {
  const char *name;
  int count;
  int *coordinates;
  double *values;
} km_model_pose;

typedef struct km_model_sweep {
  int coordinate;   /* -1: none given */
  double range[2];  /* file's unit */
  double arclength; /* 0: none given */
  int direction;    /* coordinate of `direction`, -1: none */
  double sign;
  int steps;
} km_model_sweep;

/* Settings of a simulation; 0: not given. */
typedef struct km_simulation_settings {
  double span, step, relative, absolute;
  const char *integration_type; /* NULL: not given */
} km_simulation_settings;

/* Where the meshes of a model are. */
typedef struct km_folders {
  const char *folder;        /* of the file, where include_dirs start */
  const char **include_dirs; /* where meshes are looked for */
  int include_dir_count;
} km_folders;

/* The numbers that calls can change, as they were before the first change. */
typedef struct km_unedited {
  km_model_body *bodies;
  km_model_frame *frames;
  km_model_coordinate *coordinates;
  km_applied_load *loads;
} km_unedited;

struct km_model {
  km_arena arena;
  const struct km_origin
      *origin; /* what the room of exchange/ that read it needs to write it again; NULL: built by calls */
  char sha256[KM_SHA256_TEXT];
  const char *source; /* where the model is from, in words; NULL: not told */
  km_folders folders;
  km_units units;
  km_vec3 gravity;
  bool gravity_assumed, angle_assumed, length_assumed; /* the file states none: the format's default counts */
  km_simulation_settings simulation;
  double characteristic_length; /* 0: the file states none */
  bool length_shared;           /* it is that of another model, which this one is compared with */
  double closure_tolerance;
  bool closure_tolerance_given;
  double rotation_misfit; /* the largest entry of RᵀR − I, as the file states its frames */
  km_model_assembly *assemblies;
  km_model_body *bodies;
  km_model_frame *frames;
  km_model_shape *shapes; /* by body */
  km_model_joint *joints;
  km_model_coordinate *coordinates;
  km_model_coupling *couplings;
  km_model_module *modules;
  km_applied_load *loads;
  km_model_hold *holds;
  km_model_pose *poses;
  int *actuators;       /* coordinates */
  bool actuators_given; /* also where the list is empty */
  km_model_port advantage_input, advantage_output;
  km_model_sweep sweep;
  const km_unedited *unedited; /* NULL: nothing was changed */
  int assembly_count, body_count, frame_count, shape_count, joint_count, coordinate_count, coupling_count, module_count;
  int load_count, hold_count, pose_count, actuator_count;
};

/* Before a change: keeps the numbers as they were read, once. KM_MEMORY: the model is as it was. */
km_status km_model_keep_unedited(km_model *model, km_error *error);

static inline int km_model_freedom(const km_model *model, int joint) {
  return km_joint_kind_of(model->joints[joint].type)->freedom;
}

/* Is the coordinate a component of a rotation vector? */
static inline bool km_model_turns(const km_model *model, int coordinate) {
  const km_model_coordinate *c = &model->coordinates[coordinate];
  km_joint_type type = model->joints[c->joint].type;
  return type == KM_SPHERICAL || (type == KM_FLOAT && c->index >= 3);
}

/* Radians per angle unit for an angle, 1 for a length: file's value × this = the engine's value. */
static inline double km_model_coordinate_factor(const km_model *model, int coordinate) {
  const km_model_coordinate *c = &model->coordinates[coordinate];
  return km_joint_is_length(model->joints[c->joint].type, c->index) ? 1.0 : model->units.angle->si;
}

#endif
