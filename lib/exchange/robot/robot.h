/* Functions shared by readers of robot descriptions: building a model in SI units from XML elements. */
#ifndef KM_EXCHANGE_ROBOT_ROBOT_H
#define KM_EXCHANGE_ROBOT_ROBOT_H

#include "base/name_map.h"
#include "exchange/robot/omissions.h"
#include "exchange/xml/xml.h"
#include "model/geometry/solids.h"
#include "model/validation.h"

/* Options and results of a reader. */
typedef struct km_robot_request {
  const char *file;         /* origin of the text; NULL: none */
  bool floating;            /* bodies without a parent are free, not fixed */
  double closure_tolerance; /* instead of the file's; 0: the file's */
  km_messages *messages;
} km_robot_request;

/* Half a unit of the last digit of the coarsest number of a kind. */
typedef struct km_robot_digits {
  double several; /* numbers with five digits or more, which are rounded for certain */
  double written; /* numbers with four too, and directions whose length is nearly 1 */
} km_robot_digits;

typedef struct km_robot {
  const km_robot_request *request;
  km_arena arena; /* memory that is freed after reading */
  km_builder *builder;
  km_settings_def settings;
  km_names joints, bodies,
      frames; /* taken names: scope assembly, assembly, body; 0 where they wait for their element */
  km_omissions omissions;
  bool closes;                     /* there are loops */
  km_robot_digits angles, lengths; /* rounding errors of axes and points of loops, from the digits of the file */
  double reach;                    /* the largest distance of a frame from its body's origin */
  double total_mass;               /* > 0: what the whole is to weigh */
  bool failed;                     /* an error was reported */
} km_robot;

/* A model from a tree: what each of the formats does. False only where nothing further can be done; faults are
 * reported. */
typedef void (*km_robot_read)(km_robot *robot, km_xml *root);

/* Builds the model that `read` describes. The caller frees `*out`. KM_MODEL, with the first of the errors. */
km_status km_robot_build(km_robot_read read, km_xml *root, const km_robot_request *request, km_model **out,
                         km_error *error);

/* Reports an error, or a warning, at an element. */
void km_robot_error(km_robot *robot, const km_xml *at, const char *format, ...) __attribute__((format(printf, 3, 4)));
void km_robot_warn(km_robot *robot, const km_xml *at, const char *format, ...) __attribute__((format(printf, 3, 4)));
/* Counts a thing of some kind ("collision shapes") that is left out; each kind is one note at the end. */
void km_robot_omit(km_robot *robot, const char *kind, const char *name);
/* Reports a macro of xacro among the elements of a URDF file, if there is one. */
bool km_robot_refuses_macros(km_robot *robot, const km_xml *root);
/* Text that lives as long as the reading; "" when out of memory. */
const char *km_robot_text(km_robot *robot, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Number of words separated by blanks or commas. */
int km_robot_count(const char *text);
/* Finite numbers between blanks. False if there are none in `text` (NULL too), or (reported) not exactly `count`; `out`
 * may hold some of them then. */
bool km_robot_parse(km_robot *robot, const km_xml *at, const char *what, const char *text, double *out, int count);
/* Reads `least` … `most` numbers. Returns their number; −1: error reported, or absent. */
int km_robot_parse_some(km_robot *robot, const km_xml *at, const char *what, const char *text, double *out, int least,
                        int most);
/* Reads the numbers of an attribute; unchanged if it is absent. */
bool km_robot_numbers(km_robot *robot, const km_xml *element, const char *attribute, double *out, int count);
double km_robot_number(km_robot *robot, const km_xml *element, const char *attribute, double otherwise);
/* A number that may be infinite. */
double km_robot_bound(km_robot *robot, const km_xml *at, const char *what, const char *text, double otherwise);
/* Records the rounding of a pose's numbers. `period`: a multiple of it within the rounding is taken as exact; 0:
 * none. */
void km_robot_judge_digits(const char *text, double period, km_robot_digits *worst);
/* Records the rounding of the attributes `rpy` and `xyz` of an element. */
void km_robot_judge_origin(km_robot *robot, const km_xml *element);

/* R = Rz(yaw) Ry(pitch) Rx(roll). */
km_rotation km_rotation_rpy(const double rpy[3]);

/* An assembly, whose name is made free. */
km_assembly_id km_robot_assembly(km_robot *robot, const km_xml *at, const char *name, km_assembly_id parent);
/* A body. A negative mass or inertia is a warning and dropped. A name that is taken is an error. `mesh`: NULL: none. */
km_body_id km_robot_body(km_robot *robot, const km_xml *at, km_assembly_id assembly, const char *name,
                         const km_mass *mass, const char *mesh);
/* A shape of a body: its kind, sizes or file, place, colour. One that has no size is dropped, and counted. */
void km_robot_shape(km_robot *robot, const km_xml *at, km_body_id body, km_shape_def *def, const km_pose *pose);
/* A frame of a body, under a free name like the given one. */
km_frame_id km_robot_frame(km_robot *robot, const km_xml *at, km_body_id body, const char *name, const km_pose *pose);
/* The name of a frame without that of its body before it, as the writers put "body/frame" where the frame's own name
 * is taken. */
const char *km_robot_name_within(const char *body, const char *name);
/* Adds an anonymous frame for a joint; the body's own frame if the pose is the identity. */
km_frame_id km_robot_place(km_robot *robot, const km_xml *at, km_body_id body, const char *name, const km_pose *pose);

/* A joint: of the type KM_RZ or KM_TZ it is about or along `axis`. */
typedef struct km_robot_joint {
  const km_xml *at;
  const char *name;
  km_assembly_id assembly;
  km_joint_type type;
  km_body_id parent, child;
  km_pose in_parent, in_child; /* the joint's frame */
  km_vec3 axis;                /* unit, in the joint's frame; ignored by joints without an axis */
  double pitch, most_turn;     /* pitch of a screw; limit of a ball joint, 0: none */
  double position[KM_MAX_FREEDOM], damping[KM_MAX_FREEDOM], low[KM_MAX_FREEDOM], high[KM_MAX_FREEDOM];
  double max_rate[KM_MAX_FREEDOM], max_force[KM_MAX_FREEDOM], armature[KM_MAX_FREEDOM], friction[KM_MAX_FREEDOM];
  bool locked[KM_MAX_FREEDOM]; /* held at `position`, as analysis.hold does */
} km_robot_joint;
km_robot_joint km_robot_joint_default(void);
/* A name that is taken is an error. {0} if it could not be added. */
km_joint_id km_robot_add_joint(km_robot *robot, const km_robot_joint *joint);
/* A spring in a coordinate of the joint of this name: -stiffness (q - rest). None where the stiffness is 0. */
void km_robot_spring(km_robot *robot, const km_xml *at, const char *name, km_coordinate_ref coordinate,
                     double stiffness, double rest);
/* Adds a coupling q1 = c0 + c1 q2 + … with `count` ≥ 2 coefficients; q1 = c0 without a second coordinate. */
void km_robot_couple(km_robot *robot, const km_xml *at, const char *name, km_assembly_id assembly,
                     km_coordinate_ref one, km_coordinate_ref two, const double *c, int count);
/* Connects a body to the inertial frame at a pose: rigidly, or freely if requested. */
void km_robot_tie(km_robot *robot, const km_xml *at, km_assembly_id assembly, km_body_id body, const char *name,
                  const km_pose *pose, bool floating);
/* Equal limits lock the coordinate at their value, and are counted; limits that are no range are dropped, and
 * counted. */
void km_robot_limit(km_robot *robot, km_robot_joint *joint, int k, double low, double high);
/* The largest angle of a ball; one that isn't above 0 is dropped, and counted. */
void km_robot_limit_turn(km_robot *robot, km_robot_joint *joint, double most);
/* Limits of the drive of coordinate k: force and rate; ∞ if not stated. Values ≤ 0 are omitted and counted. */
void km_robot_drive(km_robot *robot, km_robot_joint *joint, int k, double force, double rate);
/* The rotor's inertia and the constant friction of coordinate k; negative ones are dropped, and counted. */
void km_robot_rotor(km_robot *robot, km_robot_joint *joint, int k, double armature, double friction);
/* Handles a failed call of the builder: out of memory, or an error reported at the element. */
void km_robot_builder_failed(km_robot *robot, const km_xml *at, km_status status, const km_error *error);
/* Enters a name in a table. */
void km_robot_take_name(km_robot *robot, km_names *names, int scope, const char *name, int value);
/* A name like `name` that no element of the scope has. */
const char *km_robot_free_name(km_robot *robot, const km_names *names, int scope, const char *name, const char *mark);

/* The path at which a file is found that a description names: beside it, in a folder above it, or behind the package's
 * name there. NULL if nowhere. */
const char *km_robot_find(km_robot *robot, const char *name);
/* Searches by the complete path, with the package's name. */
const char *km_robot_find_whole(km_robot *robot, const char *name);
/* The tree of a file that the description includes; NULL: reported at `at`. */
km_xml *km_robot_read_file(km_robot *robot, const char *path, const km_xml *at);
/* Path of a file relative to the model's folder; if it isn't found, the part after the scheme. */
const char *km_robot_mesh(km_robot *robot, const char *name);

#endif
