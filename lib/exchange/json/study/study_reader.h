/* Reader of path studies: JSON text, and CSV files of poses. Private to exchange/json/study. */
#ifndef KM_EXCHANGE_JSON_STUDY_STUDY_READER_H
#define KM_EXCHANGE_JSON_STUDY_STUDY_READER_H

#include "exchange/json/format/format.h"
#include "exchange/json/read/reader.h"
#include "kmech/arm.h"

typedef struct km_study_reader {
  km_reader reader;   /* reader for messages */
  km_arena *arena;    /* the definition's */
  const char *folder; /* folder of the files that the text names */
} km_study_reader;

extern const km_object_format km_format_path, km_format_method;

/* Parts of the reader. Errors are added to the reader's messages. */
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
