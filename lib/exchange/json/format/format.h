/* The model format as a table: which keys an object may have, what each means and holds, and in which unit. The
 * reader's checks, the unit conversion, the published JSON schema and the guide's tables all come from it. */
#ifndef KM_EXCHANGE_JSON_FORMAT_FORMAT_H
#define KM_EXCHANGE_JSON_FORMAT_FORMAT_H

#include "base/text.h"
#include "base/value.h"
#include "exchange/json/json_location.h"
#include "kmech/base.h"
#include "model/units.h"

typedef enum km_shape {
  KM_SHAPE_NUMBER,
  KM_SHAPE_STRING,
  KM_SHAPE_BOOLEAN,
  KM_SHAPE_VECTOR,         /* three numbers */
  KM_SHAPE_POINT,          /* a point or a direction: three numbers, or two in the plane z = 0 */
  KM_SHAPE_MATRIX,         /* three rows of three numbers */
  KM_SHAPE_NUMBERS,        /* a list of numbers */
  KM_SHAPE_COORDINATES,    /* a number, or a list of numbers: one for each coordinate of a joint */
  KM_SHAPE_RANGE,          /* [low, high] */
  KM_SHAPE_RANGES,         /* [low, high], or one such pair for each coordinate */
  KM_SHAPE_ROWS,           /* a list of lists of numbers */
  KM_SHAPE_TIME_LAW,       /* a number, a list of coefficients, a list of rows [time, number], or an expression of t */
  KM_SHAPE_EXPRESSION,     /* an expression of t */
  KM_SHAPE_STRINGS,        /* a string or a list of strings */
  KM_SHAPE_PATH,           /* a name, or a list of names from the root */
  KM_SHAPE_PATHS,          /* a list of paths */
  KM_SHAPE_PATH_PAIR,      /* [parent path, child path] */
  KM_SHAPE_COORDINATE_MAP, /* {joint label: coordinates} */
  KM_SHAPE_POSES,          /* {name: {joint label: coordinates}} */
  KM_SHAPE_PARAMETERS,     /* {name: number, or an object that holds it} */
  KM_SHAPE_VALUE_MAPS,     /* {name: {name: number}} */
  KM_SHAPE_TEXT_MAP,       /* {name: text} */
  KM_SHAPE_MAP,            /* {name: object} */
  KM_SHAPE_LIST_MAP,       /* {name: object, or a list of numbers as its short form} */
  KM_SHAPE_WORD_MAP,       /* {name: object, or a text as its short form} */
  KM_SHAPE_OBJECT,
  KM_SHAPE_OBJECTS, /* a list of objects */
  KM_SHAPE_METHODS, /* a text, an object, or a list of either; checked by its reader */
  KM_SHAPE_END,     /* a joint's path, or an object; checked by its reader */
  KM_SHAPE_ANY      /* kept as it is, not looked into */
} km_shape;

/* Rule for the unit of a number, multiplied by the field's `dimension`. */
typedef enum km_measure {
  KM_MEASURE_FIXED,          /* `dimension` alone */
  KM_MEASURE_COORDINATE,     /* the joint's coordinate, an angle in the angle unit */
  KM_MEASURE_RATIO,          /* one over the coupled coordinate, an angle in radians */
  KM_MEASURE_FOLLOWING,      /* item k: the first coupled coordinate over the second one^k, angles in radians */
  KM_MEASURE_STIFFNESS,      /* the joint's generalised force over its coordinate, an angle in radians */
  KM_MEASURE_FORCE,          /* the joint's generalised force, an angle in radians */
  KM_MEASURE_INERTIA,        /* the generalised inertia of the joint's coordinate: a mass, of angles times length² */
  KM_MEASURE_POLYNOMIAL,     /* item k: the joint's coordinate over time^k */
  KM_MEASURE_TABLE,          /* rows of time and the joint's coordinate */
  KM_MEASURE_SWEEP,          /* the coordinate that `analysis.sweep` drives */
  KM_MEASURE_KNOTS,          /* a force module's variable */
  KM_MEASURE_PIECES,         /* rows; item k: the module's force over its variable^k */
  KM_MEASURE_LAW_TABLE,      /* rows of time and the module's force */
  KM_MEASURE_LAW_POLYNOMIAL, /* item k: the module's force over time^k */
  KM_MEASURE_REFERENCE,      /* the module's variable; of a polynomial over time^k, in rows after the time */
  KM_MEASURE_MODULE_FORCE,   /* the module's force */
  KM_MEASURE_GAIN,           /* the module's force over its variable */
  KM_MEASURE_LAW_X,          /* the variable of a law */
  KM_MEASURE_LAW_VALUE,      /* the value of a law */
  KM_MEASURE_LAW_ROWS,       /* rows of the variable and the value of a law */
  KM_MEASURE_LAW_SERIES      /* item k: the value of a law over its variable^k */
} km_measure;

typedef struct km_object_format km_object_format;

typedef struct km_field {
  const char *key;
  const char *help; /* meaning, in complete sentences */
  km_shape shape;
  bool required;
  km_dimension dimension;
  km_measure measure;
  const km_object_format
      *object; /* object format, for KM_SHAPE_OBJECT(S), KM_SHAPE_METHODS, KM_SHAPE_END, KM_SHAPE_PARAMETERS, maps of
                * objects */
  const char *unstated; /* default; NULL: none */
} km_field;

struct km_object_format {
  const char *name;       /* name of the definition in the JSON schema */
  const km_field *fields; /* ended by an entry without key */
};

extern const km_object_format km_format_model;
extern const km_object_format km_format_designs; /* format of studies of designs */
extern const km_object_format km_format_study;   /* format of path studies */
/* Objects whose contents decide the units of numbers inside. */
extern const km_object_format km_format_joint, km_format_coupling, km_format_module, km_format_strut, km_format_scale;
/* Objects that have frames. */
extern const km_object_format km_format_body, km_format_fixed;
extern const km_object_format km_format_assembly, km_format_parameters;

const km_field *km_format_field(const km_object_format *format, const char *key); /* NULL if unknown */

/* True if a field of this shape holds numbers only. */
bool km_shape_is_numeric(km_shape shape);

/* Checks kinds, required keys and number ranges of the whole tree; unknown keys are warnings with the
 * nearest known key. Every finding starts with the place, as `assemblies[0].joints[2].type`. */
void km_format_check(const km_value *root, km_messages *messages);
/* Checks an object against another table, at a location (NULL: the root). */
void km_format_check_as(const km_value *root, const km_object_format *format, const km_place *place,
                        km_messages *messages);

/* Kind of a JSON file that isn't the expected one: "a study of designs, which kstudy reads", "a path study, which
 * kredund reads", "a model"; NULL: none of them. */
const char *km_other_kind(const km_value *root, const km_object_format *expected);

/* A field's shape and unit in words, as `[x, y, z]` and `length/time^2`; the unit is empty where there is none. */
void km_field_shape_text(const km_field *field, km_text *out);
void km_field_unit_text(const km_field *field, km_text *out);

/* Every object's keys as tables in Markdown, each below a line `<!-- keys: NAME -->`. */
void km_format_markdown(const km_object_format *format, km_text *out);

/* JSON schema (draft 2020-12) of a table. `title`: described object; `expressions`: texts may replace numbers. */
const km_value *km_format_schema(const km_object_format *format, const char *title, bool expressions, km_arena *arena);

#endif
