/* Reader of models. Private to exchange/json. */
#ifndef KM_EXCHANGE_JSON_READ_READER_H
#define KM_EXCHANGE_JSON_READ_READER_H

#include "base/name_map.h"
#include "base/text.h"
#include "base/value.h"
#include "exchange/json/json_location.h"
#include "model/validation.h"

/* A model as it was read: what writing it again needs beside the model. Kept in the model's arena. */
struct km_origin {
  const km_value *root;
  const char *version; /* that writes it again: "1.0", or "1.1" where the file needs it */
  const km_value **bodies, **joints, **couplings, **modules; /* the objects that became them; NULL: part of a strut */
};

/* State of the reader. Inactive elements are in the name tables with KM_LEFT_OUT, so that a path to one is
 * distinguished from a misspelt path. */
typedef struct km_reader {
  km_model *model;
  struct km_origin *origin;
  km_messages *messages;
  const km_arena *arena;                       /* memory of the model */
  double rotation_misfit;                      /* the largest entry of RᵀR − I so far */
  int rounded_count;                           /* rotations that are replaced by the nearest one: */
  double rounded_most;                         /* the largest change of an entry, */
  char rounded_first[KM_PLACE_TEXT];           /* and the first one's place */
  km_names assemblies, bodies, frames, joints; /* scope: the parent */
  km_names labels;                             /* scopes: see validation.h */
  size_t strut_room;                           /* struts in the file, left-out ones too */
  const km_pose *start; /* [body] of the bodies where the assembly starts, while struts are read */
  int start_count;
  int *cylinders; /* coordinates of struts that are actuators */
  int cylinder_count;
  bool unreadable; /* a file that the text names can't be read */
} km_reader;

enum { KM_NOT_FOUND = -1, KM_LEFT_OUT = -2, KM_FAULTY = -5 };

/* Reports an error at a place. */
void km_reader_error(km_reader *reader, const km_place *place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void km_reader_note(km_reader *reader, const km_place *place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void km_reader_warning(km_reader *reader, const km_place *place, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
const char *km_reader_where(km_reader *reader, const km_place *place); /* kept in the model */

bool km_reader_active(const km_value *object);
double km_reader_number(const km_value *object, const char *key, double otherwise);
km_vec3 km_reader_vector(const km_value *object, const char *key);
/* The member `key`, a matrix, as the nearest rotation; the identity if it is absent or (reported) no rotation. */
km_rotation km_reader_rotation(km_reader *reader, const km_value *frame, const char *key, const km_place *place);
/* The orientation that an object states by its R, quaternion, euler or rotation_vector; the identity if it is absent or
 * (reported) none. */
km_rotation km_reader_orientation(km_reader *reader, const km_value *object, const km_place *place);
/* True if the key is one of these four. */
bool km_is_orientation(const char *key);
/* One note on the rotations that were replaced by the nearest one. */
void km_reader_report_rotations(km_reader *reader);
/* The file uses what came with this version of the format. */
void km_reader_needs(km_reader *reader, const char *version);
const char *km_reader_string(const km_value *object, const char *key); /* NULL if absent */
/* Reports a value that isn't greater than 0. */
void km_reader_positive(km_reader *reader, const km_place *place, const char *key, double value);
/* Reports a member that is less than 0. */
void km_reader_not_negative(km_reader *reader, const km_value *object, const char *key, const km_place *place);
/* Name of an element, checked: not empty, not reserved, new among its siblings in `names`. */
const char *km_reader_name(km_reader *reader, const km_value *object, const km_place *place, km_names *names, int scope,
                           const char *reserved);

/* Reports an empty name. */
void km_reader_named(km_reader *reader, const km_value *object, const km_place *place);

/* A frame of a body, entered under its name; its index. */
int km_reader_add_frame(km_reader *reader, const char *name, int body, km_pose pose);
/* A name like `name` that no element of the scope has: itself, else with a colon and `mark`, else with more colons.
 * Kept in the model, whose arena fails when out of memory. */
const char *km_reader_free_name(km_reader *reader, const km_names *names, int scope, const char *name,
                                const char *mark);
/* A frame that the file doesn't write: of a joint or strut, whose name it bears if that is free. */
int km_reader_make_frame(km_reader *reader, int body, const char *name, km_pose pose);

/* Frame of a path seen from an assembly. KM_NOT_FOUND (reported) or KM_LEFT_OUT. */
int km_reader_frame(km_reader *reader, const km_value *path, int assembly, const km_place *place);
/* Frame of a path from the root, or [body, frame] where the body's name is unique. KM_NOT_FOUND (reported), or
 * KM_LEFT_OUT with a note that `what` is left out with it. */
int km_reader_frame_anywhere(km_reader *reader, const km_value *path, const km_place *place, const char *what);
/* Joint of a path seen from an assembly; KM_NOT_FOUND is reported, KM_LEFT_OUT and KM_FAULTY aren't. */
int km_reader_joint(km_reader *reader, const km_value *path, int assembly, const km_place *place);
/* Coordinate of a joint path, if the joint has one coordinate, or of `label[k]`; results as above. */
int km_reader_coordinate(km_reader *reader, const km_value *path, int assembly, const km_place *place);
/* Coordinates of a member {label: number or list}, one or all of a joint: number (0: error reported, or inactive
 * with a note), the first, and the first of the values. */
int km_reader_values(km_reader *reader, const km_value *value, const km_place *place, int *first,
                     const km_value **item);
/* A path as a person reads it: `a/b/c`. */
const char *km_path_text(const km_value *path, char out[KM_PLACE_TEXT]);

/* Records the numbers of an object that place a frame: its T and orientation. */
void km_reader_record_pose(km_reader *reader, const km_value *object, int frame);
/* Records the numbers of a drawn joint, `at` and `axis`, which place both of its frames. */
void km_reader_record_drawn(km_reader *reader, const km_value *joint, const int frame[2]);

/* `drawn` of an assembly. */
void km_read_drawn(km_reader *reader, const km_value *assembly, const km_place *place, km_model_assembly *out);
/* `bodies`, `at` and `axis` of a joint: its two frames, both at the point; false if there are none, which is reported
 * unless a body is left out. */
bool km_read_drawn_ends(km_reader *reader, const km_value *joint, int assembly, const km_place *place,
                        km_model_joint *out, int body[2]);
/* Axis of the joint's frame that `axis` states: that of its first rotation or translation; the normal of a planar
 * joint. */
int km_drawn_axis(km_joint_type type);
/* True if the joint is defined by a point of a drawing. */
bool km_joint_is_drawn(const km_value *joint);
/* Puts the child frame where the joint's first values have it in the drawing, and the bodies into one pose. */
void km_place_drawn_child(km_model *model, int joint);
/* Notes on joints whose frames the drawing leaves apart. */
void km_report_drawing_gaps(km_reader *reader);

/* A shape of a body: a km_element_read. */
void km_read_shape(km_reader *reader, const km_value *shape, int body, const km_place *place);
/* Mass, centre of mass and inertia as the file states them; a density. */
void km_read_mass(km_reader *reader, const km_value *body, const km_place *place, km_model_body *out);
/* The second pass over the assemblies: joints, then what names joints. */
void km_read_joints(km_reader *reader, const km_value *root);
/* Reads the coordinates of joint `index`: initial displacements, rates, damping, limits. `value` NULL: defaults. */
void km_read_coordinates(km_reader *reader, const km_value *value, const km_place *place, int index);
/* After all joints: a strut's parts lie as they start. */
void km_read_struts(km_reader *reader, const km_value *root);
void km_read_couplings(km_reader *reader, const km_value *root);

/* Laws over a variable x (read_curves.c). `factor`: x of the model over x of the file. */
/* Reports rows that aren't [x, value] or whose x doesn't increase. */
void km_check_rows(km_reader *reader, const km_value *table, const char *first_column, const km_place *place);
double km_read_period(km_reader *reader, const km_value *object, const km_place *place); /* 0: none */
void km_read_table(km_reader *reader, const km_value *object, bool cubic, double factor, const km_place *place,
                   km_law_curve *out);
void km_read_cosine(km_reader *reader, const km_value *object, double factor, const km_place *place, km_law_curve *out);
/* An expression of the time, as `expression` or another key states it. */
void km_read_expression(km_reader *reader, const char *text, const km_place *place, km_law_curve *out);
/* Number of laws that an object states: table, cosine, step, polynomial, expression. */
int km_count_laws(const km_value *object);
/* The first law that an object states, in this order. */
void km_read_curve(km_reader *reader, const km_value *object, double factor, const km_place *place, km_law_curve *out);
/* `segments` of a prescribed motion that begins at `start`. */
void km_read_segments(km_reader *reader, const km_value *object, double start, const km_place *place,
                      km_law_curve *out);

void km_read_force_modules(km_reader *reader, const km_value *root);
void km_read_analysis(km_reader *reader, const km_value *root);
void km_read_poses(km_reader *reader, const km_value *root);

/* Visits the active assemblies in file order, nested ones after their parent. */
typedef void (*km_assembly_visit)(km_reader *reader, const km_value *assembly, int index, const km_place *place);
void km_reader_visit(km_reader *reader, const km_value *root, km_assembly_visit visit);

/* Calls `read` for the members of a list in an object: `bodies`, `joints` … */
typedef void (*km_element_read)(km_reader *reader, const km_value *element, int owner, const km_place *place);
void km_reader_each(km_reader *reader, const km_value *object, const char *key, int owner, const km_place *place,
                    km_element_read read);

#endif
