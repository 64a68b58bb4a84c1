/* The model for other modules: validated, references resolved, in the file's units. */
#ifndef KM_MODEL_MODEL_H
#define KM_MODEL_MODEL_H

#include "base/file.h"
#include "base/memory.h"
#include "base/text.h"
#include "kmech/model.h"
#include "model/curve/curve.h"
#include "model/joint_type.h"
#include "spatial/pose.h"

enum { KM_NO_ASSEMBLY = -1 };

typedef struct km_model_assembly {
  const char *name;
  int parent; /* enclosing assembly, or KM_NO_ASSEMBLY */
  bool drawn; /* drawn: its bodies' frames coincide with the inertial frame at the initial displacements */
} km_model_assembly;

/* Bodies; body 0 is the inertial frame, named `fixed`. */
typedef struct km_model_body {
  const char *name;
  int assembly;
  double mass;
  km_vec3 center_of_mass;
  double inertia[6];  /* Ixx Iyy Izz Ixy Iyz Izx about the centre of mass */
  double density;     /* < 0: not stated */
  bool is_strut_part; /* half of a strut: its position follows from the strut's ends */
  const char *mesh;   /* path as stated; NULL: none */
  const char *where;
} km_model_body;

/* Shape of a body. */
typedef struct km_model_shape {
  int body;
  km_shape_kind kind;
  const char *mesh, *where;
  double scale[3], size[3]; /* scale of a mesh; sizes of other kinds */
  km_pose pose;             /* pose in the body's frame */
  double density;           /* < 0: not stated */
  double color[4];          /* red, green, blue, opacity; opacity < 0: not stated */
} km_model_shape;

/* Frames; the first of each body is `origin`. */
typedef struct km_model_frame {
  const char *name;
  int body;
  km_pose pose; /* pose in the body's frame; lengths in the model's unit */
} km_model_frame;

/* Coulomb friction of a joint's surfaces. All 0: no friction. */
typedef struct km_joint_friction {
  double coefficient, radius, stiction_velocity; /* radius of the surface of rotating joints, length; sliding speed
                                                  * of regularisation, length per time */
} km_joint_friction;

/* Limit stops in a simulation: force or torque per unit beyond the limit, and per rate. */
typedef struct km_joint_stop {
  double stiffness, damping;
} km_joint_stop;

/* Tolerances of a joint's place and direction on each of its bodies, its play, and its stiffness against displacements
 * that it constrains; in the file's units. */
typedef struct km_joint_fit {
  bool has_tolerance, has_clearance;        /* the model states them */
  double position, direction;               /* tolerances: a length, an angle */
  double radial, axial, angular;            /* play across the axis, along it, and of its direction */
  double force_stiffness, moment_stiffness; /* force per length, moment per radian; 0: rigid */
} km_joint_fit;

/* Prescribed motion of a joint over time. Angles in the file's unit. */
typedef struct km_joint_prescribed {
  km_motion_law law;
  int count;          /* number of rows of the table, or of coefficients */
  double *values;     /* [2 · count] rows t, q; or [count] coefficients, lowest power first; or [4] offset, amplitude,
                   * frequency, phase */
  km_law_curve curve; /* law of KM_MOTION_CURVE */
} km_joint_prescribed;

typedef struct km_model_joint {
  const char *name, *label;
  km_joint_type type;
  int assembly;
  int frame[2];         /* parent frame, child frame */
  int first_coordinate; /* index of the first coordinate */
  double pitch;
  double most_turn; /* spherical joint: limit of the angle |q|, in the file's unit; 0: none */
  km_joint_friction friction;
  km_joint_stop stop;
  km_joint_fit fit;
  km_joint_prescribed prescribed;
  const char *where;
} km_model_joint;

typedef struct km_model_coordinate {
  const char *label;
  int joint, index;
  bool is_strut; /* slide of a strut: its length is |q|, and q is negative after the ends have passed each other */
  double position, rate, low, high, damping; /* in the file's units; ∓∞ if there is no limit */
  bool rate_stated;                          /* true if `rate` is stated; otherwise the other rates determine it */
  double max_rate, max_force;                /* largest force of the drive; ∞ if there is none */
  double armature, friction;                 /* inertia of the drive's rotor; constant friction */
} km_model_coordinate;

typedef struct km_model_coupling {
  const char *name, *where;
  int count;
  int *coordinates;
  double *ratios;      /* NULL: the first coordinate is a polynomial of the second */
  bool constant_given; /* true if `constant` is stated; otherwise the initial displacements determine it */
  double constant;
  int polynomial_count;
  double *polynomial; /* [polynomial_count] coefficients, lowest power first; radians, lengths */
} km_model_coupling;

enum { KM_MODULE_PORT_FRAMES = -1, KM_MODULE_PORT_FRAME = -3 };

/* Port of a force module: a coordinate, two frames, or (inputs only) one frame. */
typedef struct km_module_port {
  int coordinate; /* KM_MODULE_PORT_FRAMES: between two frames; KM_MODULE_PORT_FRAME: one frame */
  int frame[2];   /* parent frame, child frame; of one frame: frame[0] */
} km_module_port;

/* Derivative of its inputs that a force module's law or controller reads; or time. */
typedef enum km_module_variable {
  KM_VARIABLE_DISPLACEMENT,
  KM_VARIABLE_VELOCITY,
  KM_VARIABLE_ACCELERATION,
  KM_VARIABLE_TIME
} km_module_variable;

/* An input of a force module: a coordinate, a measure between two frames, or a component of one frame's motion. */
typedef struct km_module_input {
  km_module_port port;
  km_distance distance; /* measure between two frames */
  int component;        /* component of one frame: 0-2 its origin along x, y, z; 3-5 its angular motion about them */
  bool body_axes;       /* the component is along the frame's own axes, not the inertial ones */
  double weight;
} km_module_input;

/* Names of the types in the format: "stiffness", "damping" … */
const char *km_module_type_word(km_module_type type);
int km_module_type_find(const char *word); /* type with a name; -1 if there is none */
/* One input of weight 1; NULL without memory. */
const km_module_input *km_model_single_input(km_arena *arena, km_module_port port, km_distance distance);
/* Variable that a type reads unless another is stated. */
km_module_variable km_module_type_variable(km_module_type type);

/* A force law: piecewise polynomial of a variable in radians, length or time. */
typedef struct km_law {
  int knot_count;
  const double *knots;
  const int *start;           /* [knot_count + 2] index of the first coefficient of each piece */
  const double *coefficients; /* coefficients, lowest power first */
} km_law;

/* Parameters of a Fiala tyre. */
typedef struct km_tire {
  double radius, stiffness, damping; /* unloaded radius; vertical stiffness */
  double rolling_resistance, width;  /* relaxation lengths */
  double longitudinal, lateral;      /* stiffnesses: force per unit of slip */
  double friction_peak, friction_sliding, relaxation[2];
} km_tire;

/* Shapes that touch in a contact: the child's and the parent's. */
typedef enum km_contact_shape {
  KM_CONTACT_POINT_PLANE,      /* point, or ball with a radius, on the parent's plane z = 0, above it */
  KM_CONTACT_CIRCLE_LINE,      /* circle on the parent's line y = 0, above it */
  KM_CONTACT_CIRCLE_CIRCLE,    /* circles about the z axes, outside each other */
  KM_CONTACT_CIRCLE_IN_CIRCLE, /* the child's circle inside the parent's */
  KM_CONTACT_SHAPES
} km_contact_shape;

/* Words of the shapes in the format: "point-plane" …; shape with a word, -1 if there is none. */
const char *km_contact_shape_word(km_contact_shape shape);
int km_contact_shape_find(const char *word);

/* Parameters of a contact (forces/contact.c). */
typedef struct km_contact {
  km_contact_shape shape;
  double radius, parent_radius;
  double stiffness, exponent, reference_depth, dissipation;
  double friction, slip_speed;
} km_contact;

typedef struct km_model_module {
  const char *name, *where;
  km_module_type type;
  km_module_port input, output; /* first input; output */
  km_distance distance;         /* measure between the output's frames */
  km_module_variable variable;  /* variable of the sum of the weighted inputs */
  int input_count;
  const km_module_input *inputs; /* [input_count] */
  bool saturates;
  double least, most; /* bounds of the force, if it saturates */
  km_law law;
  double kp, ki, kd;      /* gains of a controller */
  km_law_curve reference; /* reference of a controller, over time */
  km_law_curve curve;     /* law of the variable, instead of `law` */
  km_tire tire;
  km_contact contact;
} km_model_module;

/* True for a force of the displacement of the joint in which it acts. */
/* Number of internal states: 1 of a controller, 2 of a tyre. */
int km_module_internal_count(const km_model_module *module);
bool km_module_is_spring_in_joint(const km_model_module *module);

/* Factor of a load, over a coordinate's value or the time. */
struct km_load_scale {
  int coordinate; /* < 0: time */
  km_law_curve curve;
};

typedef struct km_applied_load {
  const char *name;
  int frame;
  km_vec3 force, torque;
  bool turning;               /* true: along the frame's axes */
  const km_load_scale *scale; /* NULL: 1 */
} km_applied_load;

/* Port of a mechanical advantage: a joint, or a frame's origin along a direction. */
typedef struct km_model_port {
  int coordinate, frame; /* coordinate, frame; −1: not this kind; both −1: not stated */
  km_vec3 direction;     /* direction in inertial axes */
  const char *name;      /* name of a point: body/frame:dx,dy,dz */
} km_model_port;

typedef struct km_model_hold {
  int coordinate;
  double value; /* file's unit */
} km_model_hold;

/* A named pose: values of some coordinates, in the file's units. */
typedef struct km_model_pose {
  const char *name;
  int count;
  int *coordinates;
  double *values;
} km_model_pose;

typedef struct km_model_sweep {
  int coordinate;   /* −1: not stated */
  double range[2];  /* file's unit */
  double arclength; /* 0: not stated */
  int direction;    /* coordinate of `direction`; −1: none */
  double sign;
  int steps;
} km_model_sweep;

/* Settings of a simulation; 0: not stated. */
typedef struct km_simulation_settings {
  double span, step, relative, absolute;
  const char *integration_type; /* NULL: not stated */
} km_simulation_settings;

/* Folders of a model's meshes. */
typedef struct km_folders {
  const char *folder;        /* folder of the file, to which include_dirs are relative */
  const char **include_dirs; /* folders that are searched for meshes */
  int include_dir_count;
} km_folders;

/* Copies of the numbers that calls can change, before the first change. */
typedef struct km_unedited {
  km_model_body *bodies;
  km_model_frame *frames;
  km_model_coordinate *coordinates;
  km_applied_load *loads;
} km_unedited;

typedef struct km_written_number km_written_number;

struct km_model {
  km_arena arena;
  const struct km_origin *origin; /* data of the reader in exchange/ for writing the model; NULL: built by calls */
  char sha256[KM_SHA256_TEXT];
  const char *source;                /* origin of the model as text; NULL: not stated */
  const char *words[KM_MODEL_WORDS]; /* words for reports; NULL: not stated */
  km_folders folders;
  km_units units;
  km_vec3 gravity;
  bool gravity_assumed, angle_assumed, length_assumed; /* true: not stated, the format's default applies */
  km_simulation_settings simulation;
  double characteristic_length; /* 0: not stated */
  bool length_shared;           /* true: shared with models that are compared */
  double closure_tolerance;
  bool closure_tolerance_given, closure_tolerance_inferred; /* inferred by a reader from the digits of the file */
  const char *digits;     /* verdict of km_model_idealise in words; NULL: not examined */
  double rotation_misfit; /* largest entry of RᵀR − I over the stated frames */
  km_model_assembly *assemblies;
  km_model_body *bodies;
  km_model_frame *frames;
  km_model_shape *shapes; /* [body] */
  km_model_joint *joints;
  km_model_coordinate *coordinates;
  km_model_coupling *couplings;
  km_model_module *modules;
  km_applied_load *loads;
  km_model_hold *holds;
  km_model_pose *poses;
  struct km_written_number *written; /* [written_count] numbers of the file that place frames (written_numbers.h) */
  size_t written_room;
  int *actuators;       /* coordinate indices */
  bool actuators_given; /* true if stated, even if the list is empty */
  km_model_port advantage_input, advantage_output;
  km_model_sweep sweep;
  const km_unedited *unedited; /* NULL: unchanged */
  int assembly_count, body_count, frame_count, shape_count, joint_count, coordinate_count, coupling_count, module_count;
  int load_count, hold_count, pose_count, actuator_count, written_count;
};

/* Saves the numbers as they were read, before the first change. KM_MEMORY: the model is unchanged. */
km_status km_model_keep_unedited(km_model *model, km_error *error);

static inline int km_model_freedom(const km_model *model, int joint) {
  return km_joint_kind_of(model->joints[joint].type)->freedom;
}

/* Body of a joint's parent frame (end 0) or child frame (end 1). */
static inline int km_joint_body(const km_model *model, int joint, int end) {
  return model->frames[model->joints[joint].frame[end]].body;
}

/* True if a coupling contains a coordinate of the joint. */
bool km_joint_is_coupled(const km_model *model, int joint);

/* Origin of a frame by the poses of all bodies, pose[body]. */
static inline km_vec3 km_frame_origin(const km_model *model, const km_pose *pose, int frame) {
  const km_model_frame *own = &model->frames[frame];
  return km_pose_point(&pose[own->body], own->pose.p);
}

/* Factor from mass · acceleration in the model's units to the model's force unit. */
double km_inertial_factor(const km_model *model);

/* True if the coordinate is a component of a rotation vector. */
static inline bool km_model_turns(const km_model *model, int coordinate) {
  const km_model_coordinate *c = &model->coordinates[coordinate];
  km_joint_type type = model->joints[c->joint].type;
  return type == KM_SPHERICAL || (type == KM_FLOAT && c->index >= 3);
}

/* Factor from the file's unit to that of computations: radians per angle unit, 1 for a length. */
static inline double km_model_coordinate_factor(const km_model *model, int coordinate) {
  const km_model_coordinate *c = &model->coordinates[coordinate];
  return km_joint_is_length(model->joints[c->joint].type, c->index) ? 1.0 : model->units.angle->si;
}

#endif
