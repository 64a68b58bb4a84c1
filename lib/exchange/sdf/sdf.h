/* Models and worlds as SDFormat describes them: links and joints in frames that may be relative to each other. */
#ifndef KM_EXCHANGE_SDF_SDF_H
#define KM_EXCHANGE_SDF_SDF_H

#include "exchange/robot/robot.h"

/* Reads the element `sdf`: a km_robot_read. */
void km_sdf_read(km_robot *robot, km_xml *root);

typedef enum km_sdf_kind { KM_SDF_WORLD, KM_SDF_MODEL, KM_SDF_LINK, KM_SDF_JOINT, KM_SDF_FRAME } km_sdf_kind;

/* Whatever has a name and a frame. Entity 0 is the world. */
typedef struct km_sdf_entity {
  km_sdf_kind kind;
  const char *name;
  const km_xml *at, *pose; /* pose: the element that says where it is; NULL: none */
  int scope;               /* the model or world among whose names its own is, -1: none */
  int home;      /* the model or world that it was written in; not the scope where that one was merged into it */
  int base;      /* its frame is relative to this one, -1: to none */
  int attached;  /* link of a frame, child of a joint; −1: unknown */
  km_pose raw;   /* pose in the base */
  km_pose world; /* as the file has it */
  bool known;    /* `world` is */
  bool is_child; /* a link that some joint has as its child */
  km_body_id body;
  km_assembly_id assembly;  /* a model's: */
  bool is_static, old_axes; /* model: axes are in its frame, as before version 1.5 */
  bool is_merged;           /* a model that is no more than the frame from which its former members are seen */
  const char *placement;    /* model: inner frame whose pose is the model's; NULL: its own */
  int first_link;           /* model: canonical link; −1: none */
} km_sdf_entity;

/* An element that may tie links, and the model or world that contains it. */
typedef struct km_sdf_other {
  const km_xml *at;
  int home;
} km_sdf_other;

/* The files that are being read, the innermost first. */
typedef struct km_sdf_file {
  const char *path;
  const struct km_sdf_file *outer;
} km_sdf_file;

typedef struct km_sdf {
  km_robot *robot;
  const km_sdf_file *file; /* NULL: the main one */
  km_names frames, joints; /* scope: the entity around; what may be meant by a name, joints last */
  km_sdf_entity *entities;
  int entity_count, includes;
  bool incomplete; /* a model to include isn't there: names may mean what it holds */
  size_t entity_room;
  km_sdf_other *others;
  int other_count;
  size_t other_room;
  km_coordinate_ref (*axes)[2]; /* [entity] of joints, of their axis and axis2, once they are added */
  int *leaders;                 /* [entity] the root of what is tied together */
} km_sdf;

/* A child's text; "" if there is no such child. */
const char *km_sdf_text(const km_xml *element, const char *child);
double km_sdf_number(km_robot *robot, const km_xml *element, const char *child, double otherwise);
bool km_sdf_is_true(const char *text);
/* The element `pose`: six numbers, or seven with a quaternion. */
km_pose km_sdf_pose(km_robot *robot, const km_xml *element);

/* Adds what a link looks like, by an element `visual`. */
void km_sdf_show(km_robot *robot, const km_xml *visual, const char *link, km_body_id body);
/* Mass properties of a link. */
km_mass km_sdf_mass(km_robot *robot, const km_xml *link);

/* Entity of a name in a model or world: `a::b` is b in the model a. −1: none. */
int km_sdf_find(const km_sdf *sdf, int home, const char *name);
/* Entity of a name; a missing one is reported, as a warning if a model that may contain it is missing. `kind`: kind
 * of the entity as text. */
int km_sdf_need(km_sdf *sdf, int home, const char *name, const km_xml *at, const char *kind);
/* The link that an entity moves with; 0: the world; -1: none. */
int km_sdf_link_of(const km_sdf *sdf, int entity);
/* Says what each entity is relative to, then where it is. */
void km_sdf_place_all(km_sdf *sdf);

/* The model that an element `include` names, of SDFormat or URDF; NULL: reported, a warning where it isn't there.
 * `version` and `path`: those of its file. */
const km_xml *km_sdf_include(km_sdf *sdf, const km_xml *include, const char **version, const char **path);

/* The root of a URDF file as a model; NULL: reported. */
const km_xml *km_sdf_from_urdf(km_robot *robot, const km_xml *root);

/* Joints of all models, couplings, and what ties the rest to the world. */
void km_sdf_add_joints(km_sdf *sdf);
/* Couplings by gears and by imitation. */
void km_sdf_add_couplings(km_sdf *sdf);
/* Reads limits, damping, friction and drive of coordinate k from the element of an axis. */
void km_sdf_read_axis(km_robot *robot, const km_xml *axis, bool is_continuous, int k, km_robot_joint *joint);
/* The travel of a screw in one turn. */
double km_sdf_pitch(km_robot *robot, const km_xml *joint);
/* The value that the coordinate of a joint's axis (0) or axis2 (1) has in the file's pose: 0, or what the axis that
 * it imitates gives. */
double km_sdf_start(const km_sdf *sdf, int joint, int axis);
/* A joint's axis in the joint's frame. */
km_vec3 km_sdf_axis(km_sdf *sdf, int joint, const km_xml *axis);

#endif
