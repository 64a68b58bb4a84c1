/* The formats that files are written in, as a JSON schema and in words. */
#ifndef KMECH_SCHEMA_H
#define KMECH_SCHEMA_H

#include "kmech/value.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A format that has a schema. */
typedef enum km_schema {
  KM_SCHEMA_MODEL,   /* models */
  KM_SCHEMA_DESIGNS, /* studies of designs */
  KM_SCHEMA_PATHS,   /* path studies */
  KM_SCHEMAS         /* how many there are */
} km_schema;

/* The JSON schema (draft 2020-12). NULL: there is no such format, or out of memory (arena->failed). */
KM_API const km_value *km_schema_record(km_schema of, km_arena *arena);
/* Every object's keys as tables in Markdown, each below a line `<!-- keys: NAME -->`. Appended. */
KM_API void km_schema_markdown(km_schema of, km_text *out);

#ifdef __cplusplus
}
#endif
#endif
