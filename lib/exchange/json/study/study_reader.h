/* What the parts of the reader of path studies share: JSON text, and CSV files of poses, into a definition. */
#ifndef KM_EXCHANGE_JSON_STUDY_STUDY_READER_H
#define KM_EXCHANGE_JSON_STUDY_STUDY_READER_H

#include "exchange/json/format/format.h"
#include "exchange/json/read/reader.h"
#include "kmech/arm.h"

typedef struct km_study_reader {
  km_reader reader;   /* for its messages */
  km_arena *arena;    /* the definition's */
  const char *folder; /* where files that the text names are looked for */
} km_study_reader;

extern const km_object_format km_format_path, km_format_method;

/* The parts of the reader. What is wrong goes to the reader's messages. */
void km_study_path_of(km_study_reader *s, const km_value *value, km_study_path *out);
/* Poses of a CSV file: x, y, z and a quaternion w, x, y, z or a rotation vector, and perhaps times, as one spline. */
void km_study_poses_of(km_study_reader *s, const char *file, km_study_path *out);
/* Methods as a name, an object, or a list of them. */
void km_study_methods_of(km_study_reader *s, const km_value *value, km_study_def *def);
/* An objective's name, or {name: weight}. */
void km_study_objective_of(km_study_reader *s, const km_value *value, km_objective *out);
/* A text, or a list of texts. */
void km_study_names_of(km_study_reader *s, const km_value *value, km_study_names *out);

#endif
