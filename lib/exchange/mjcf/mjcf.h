/* Models as MuJoCo's MJCF describes them: nested bodies, with joints inside of them and constraints beside them. */
#ifndef KM_EXCHANGE_MJCF_MJCF_H
#define KM_EXCHANGE_MJCF_MJCF_H

#include "exchange/robot/robot.h"
#include "model/geometry/mesh.h"

/* Reads the element `mujoco`: a km_robot_read. */
void km_mjcf_read(km_robot *robot, km_xml *root);

typedef struct km_mjcf_body {
  const char *name;
  km_body_id id;
  km_pose world; /* pose at the reference values of the joints */
} km_mjcf_body;

typedef struct km_mjcf_joint {
  const char *name;
  km_joint_id id;
  km_joint_type type;
  double reference; /* value of its coordinate in the configuration of the file */
} km_mjcf_joint;

typedef struct km_mjcf_site {
  int body;
  km_pose pose; /* pose in the body */
  km_frame_id frame;
} km_mjcf_site;

/* A class of defaults; several elements may add to one. */
typedef struct km_mjcf_class {
  const km_xml *element;
  int next, parent; /* the next element of the same class, and the class around it; -1: none */
} km_mjcf_class;

typedef enum km_mjcf_answer { KM_MJCF_NO, KM_MJCF_YES, KM_MJCF_AUTO } km_mjcf_answer;

typedef struct km_mjcf_compiler {
  double angle;  /* radians per unit of angle */
  char order[3]; /* axis sequence of Euler angles */
  bool autolimits;
  km_mjcf_answer from_geoms; /* masses are those of the geoms; auto: where a body states none */
  double groups[2];          /* group range of geoms with mass */
  double least_mass, least_inertia;
  bool balances;      /* principal moments that no body has are made alike */
  bool exact_meshes;  /* volumes of meshes are signed */
  const char *meshes; /* folder of the meshes; NULL: that of the file */
} km_mjcf_compiler;

typedef struct km_mjcf {
  km_robot *robot;
  const km_xml *root;
  const char *prefix, *suffix; /* prefix of the names of an attached model, otherwise "" */
  int depth;                   /* depth of attachment; 0: the main model */
  km_assembly_id assembly;
  km_mjcf_compiler compiler;
  km_names class_names, missing_classes, body_names, joint_names, site_names, driven_names, mesh_names;
  km_mjcf_class *classes;
  km_mjcf_body *bodies; /* [0] is the world */
  km_mjcf_joint *joints;
  km_mjcf_site *sites;
  km_mass *mesh_masses; /* mass properties of meshes by name, for density 1 */
  double *most_forces;  /* actuated joints by name */
  int class_count, body_count, joint_count, site_count, driven_count, mesh_count, copies;
  size_t class_room, body_room, joint_room, site_room, mesh_room;
} km_mjcf;

/* Context of elements: pose of their frame in the body, default class, prefix of names. */
typedef struct km_mjcf_place {
  km_pose pose;
  const char *class, *suffix;
} km_mjcf_place;

/* Calls `visit` for the members of an element; those of frames and replicas too, at their own places. */
typedef void (*km_mjcf_visit)(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, void *context);
void km_mjcf_walk(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, km_mjcf_visit visit, void *context);

/* Replaces the elements `include` by what they include. */
void km_mjcf_include(km_robot *robot, km_xml *root);
/* Settings of the compiler, classes of defaults. */
void km_mjcf_read_compiler(km_mjcf *m);
void km_mjcf_read_classes(km_mjcf *m);
/* The class of the defaults inside of an element, where around it `class` is. */
const char *km_mjcf_class_inside(km_mjcf *m, const km_xml *element, const char *class);
/* An element's own attribute, or that of its class; NULL: none. */
const char *km_mjcf_get(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, const char *key);
/* Reads 1 … `most` numbers of an attribute. Returns how many were set. */
int km_mjcf_numbers(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, const char *key, double *out,
                    int most);
double km_mjcf_number(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, const char *key, double otherwise);
/* The pose of an element in the frame around it: pos, and quat, axisangle, xyaxes, zaxis or euler. */
km_pose km_mjcf_pose(km_mjcf *m, const km_xml *element, const km_mjcf_place *place);
/* The ends of an element's axis: half its length, and a pose in the middle whose third axis points from the second
 * end to the first one, as MuJoCo has it. False: it has none. */
typedef struct km_mjcf_line {
  km_pose pose;
  double half;
} km_mjcf_line;
bool km_mjcf_find_line(km_mjcf *m, const km_xml *element, const km_mjcf_place *place, km_mjcf_line *out);
km_vec3 km_mjcf_unit(km_robot *robot, const km_xml *at, const char *what, const double u[3]);

/* A mesh of the assets: x = pose · scale · v. */
typedef struct km_mjcf_mesh {
  const km_xml *element;
  const char *file; /* NULL: the model contains its vertices */
  double scale[3];
  km_pose pose;
} km_mjcf_mesh;
/* False: there is none of that name. */
bool km_mjcf_find_mesh(km_mjcf *m, const char *name, km_mjcf_mesh *out);
/* Its surface, neither scaled nor moved; the caller frees it. NULL: it can't be read. */
km_mesh *km_mjcf_read_mesh(km_mjcf *m, const km_mjcf_mesh *mesh);
/* Its mass properties, of density 1. False: there is no such mesh, or it can't be read or weighed. */
bool km_mjcf_weigh_mesh(km_mjcf *m, const char *name, km_mass *out);

/* Adds the mass of a geom to a sum, in the body's frame. */
void km_mjcf_weigh(km_mjcf *m, const km_xml *geom, const km_mjcf_place *place, km_mass *sum);
/* Adds a geom to what its body looks like. */
void km_mjcf_show(km_mjcf *m, const km_xml *geom, const km_mjcf_place *place, km_body_id body);
/* The element `inertial`. */
km_mass km_mjcf_inertial(km_mjcf *m, const km_xml *inertial, const km_mjcf_place *place);

/* The tree of bodies. */
void km_mjcf_read_bodies(km_mjcf *m);
/* A body at a place of another one (index), with all that it carries; and the members of a frame, or of a world. */
void km_mjcf_read_body(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, int parent);
void km_mjcf_read_members(km_mjcf *m, const km_xml *e, const km_mjcf_place *place, int body, bool frame);
/* The element `attach` of a body. */
void km_mjcf_attach(km_mjcf *m, const km_xml *attach, const km_mjcf_place *place, int body);
/* Name in the model of an element of the file. */
const char *km_mjcf_full(const km_mjcf *m, const char *name);
/* True if all elements that an element of an attached model names have been attached. */
bool km_mjcf_is_here(const km_mjcf *m, const km_xml *element);
/* Adds a joint between a body (or an intermediate body) and its parent. */
typedef struct km_mjcf_link {
  km_body_id parent, child;
  km_pose pose; /* pose of the child in the parent at the reference value of the joint */
  bool on_world;
  const char *body; /* its name, and the joint's if it has none itself */
} km_mjcf_link;
/* The kind of a joint; another word than MJCF has is reported. */
km_joint_type km_mjcf_joint_type(km_mjcf *m, const km_xml *joint, const km_mjcf_place *place);
void km_mjcf_add_joint(km_mjcf *m, const km_xml *joint, const km_mjcf_place *place, const km_mjcf_link *link);

/* Equality constraints and actuators, when the bodies are there. */
void km_mjcf_read_constraints(km_mjcf *m);
void km_mjcf_read_actuators(km_mjcf *m);
/* The constraint between two fixed tendons, or of one of them, as a coupling; c: its polynomial. */
void km_mjcf_couple_tendons(km_mjcf *m, const km_xml *constraint, const double c[5]);
/* True if all joints of a fixed tendon have been attached, or without a tendon. */
bool km_mjcf_tendon_is_here(const km_mjcf *m, const char *name);
/* Counts the tendons that are neither couplings nor springs. */
void km_mjcf_count_tendons(km_mjcf *m);
/* The length of a fixed tendon, Σ ratio · q over hinges and slides. */
enum { KM_MJCF_MOST_TERMS = 256 };
typedef struct km_mjcf_sum {
  int count, joints[KM_MJCF_MOST_TERMS];
  double ratios[KM_MJCF_MOST_TERMS];
} km_mjcf_sum;
/* Adds such a length, times a factor; false: reported. */
bool km_mjcf_add_length(km_mjcf *m, const km_xml *tendon, double factor, km_mjcf_sum *out);
/* Springs and dampers of tendons, as forces along what changes their length. */
void km_mjcf_read_tendon_springs(km_mjcf *m);
/* True if a tendon has a spring or a damper. */
bool km_mjcf_is_spring(km_mjcf *m, const km_xml *tendon);
/* Keyframes, as named poses. */
void km_mjcf_read_keyframes(km_mjcf *m);
/* Keyframes of an attached model: poses of its joints, from the index of the first one. */
void km_mjcf_read_attached_keyframes(km_mjcf *m, const km_xml *part, int first_joint);
/* The index of what an attribute names; -1: reported. */
int km_mjcf_find(km_mjcf *m, const km_xml *e, const char *key, const km_names *names, const char *kind);
/* The largest forces that actuators give, before the joints are there; and that of one joint, infinite: any. */
void km_mjcf_read_forces(km_mjcf *m);
double km_mjcf_most_force(const km_mjcf *m, const char *joint);
/* The constant of an equality that sets the joint's first value beside its reference; 0: none. */
double km_mjcf_start_offset(const km_mjcf *m, const char *joint);

#endif
