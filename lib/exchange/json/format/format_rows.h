/* Abbreviations for rows of the format table, and shared objects. Private to exchange/json. */
#ifndef KM_EXCHANGE_JSON_FORMAT_FORMAT_ROWS_H
#define KM_EXCHANGE_JSON_FORMAT_FORMAT_ROWS_H

#include "exchange/json/format/format.h"

/* A row is a key, its help, its shape, then what it measures and what counts without it. */
#define NUMBER      .shape = KM_SHAPE_NUMBER
#define STRING      .shape = KM_SHAPE_STRING
#define BOOLEAN     .shape = KM_SHAPE_BOOLEAN
#define VECTOR      .shape = KM_SHAPE_VECTOR
#define POINT       .shape = KM_SHAPE_POINT
#define OBJECT(f)   .shape = KM_SHAPE_OBJECT, .object = &(f)
#define OBJECTS(f)  .shape = KM_SHAPE_OBJECTS, .object = &(f)
#define SHAPE(s)    .shape = KM_SHAPE_##s
#define UNIT(...)   .dimension = {__VA_ARGS__}
#define BY(m)       .measure = KM_MEASURE_##m
#define REQUIRED    .required = true
#define UNSTATED(t) .unstated = (t)

/* Rows that several objects have. */
#define ACTIVE                                                                                                         \
  { "active", "Whether it takes part. False leaves it out, with what depends on it.", BOOLEAN, UNSTATED("true") }

/* Other ways to write a rotation than its matrix. */
#define ORIENTATION                                                                                                    \
  {"quaternion", "Instead of R: its rotation as a quaternion [w, x, y, z] of length 1.", SHAPE(NUMBERS)},              \
      {"euler", "Instead of R: its rotation by Euler angles.", OBJECT(km_format_euler)}, {                             \
    "rotation_vector", "Instead of R: its rotation as the axis times the angle.", VECTOR, UNIT(.angle = 1)             \
  }
extern const km_object_format km_format_euler;

extern const km_object_format km_format_parameter, km_format_analysis;

/* Keys of a law over a variable. */
#define LAW_OVER(unstated_text)                                                                                        \
  {                                                                                                                    \
    "over", "Variable x of the law: a joint, whose value counts in the file's unit, or t, the time.", SHAPE(PATH),     \
        UNSTATED(unstated_text)                                                                                        \
  }
#define LAW_PERIOD                                                                                                     \
  { "period", "The table or cosine repeats after this change of x.", NUMBER, BY(LAW_X), UNSTATED("none") }
#define LAW_INTERPOLATION                                                                                              \
  { "interpolation", "How the rows of the table are joined: linear, or cubic by a spline.", STRING, UNSTATED("linear") }
#define LAW_COSINE                                                                                                     \
  { "cosine", "offset + amplitude cos(2 pi x/period + phase), with the `period` beside it.", OBJECT(km_format_cosine) }
#define LAW_STEP                                                                                                       \
  { "step", "A step from one value to another.", OBJECT(km_format_step) }
#define LAW_EXPRESSION                                                                                                 \
  {                                                                                                                    \
    "expression", "The value as an expression of the time t, in the file's units; angles of sin and cos in radians.",  \
        SHAPE(EXPRESSION), BY(LAW_VALUE)                                                                               \
  }
extern const km_object_format km_format_cosine, km_format_step;

#endif
