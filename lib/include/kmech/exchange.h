/* Writing models as files (JSON, URDF, MJCF, SDF), and the formats as JSON schema and as text. */
#ifndef KMECH_EXCHANGE_H
#define KMECH_EXCHANGE_H

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Models as text. */

/* Writes a model as JSON in its own units. Everything that was read is kept; numbers that calls have changed
 * (kmech/model.h) replace the file's. `q` [coordinate count]: initial displacements in the model's units; NULL: the
 * model's own. The caller frees `*out`. KM_USAGE: also a change that a file can't state: of a body's own frame, of
 * parts of a strut, of a mass that a density determines; KM_MEMORY. Cost: linear in the file. */
KM_API km_status km_model_write(const km_model *model, const double *q, km_bytes *out, km_error *error);

/* Formats of model files. */
typedef enum km_model_format {
  KM_FORMAT_JSON, /* JSON, the model format */
  KM_FORMAT_URDF, /* URDF, a tree: joints that close loops are omitted */
  KM_FORMAT_MJCF, /* MJCF; loops are equality constraints */
  KM_FORMAT_SDF   /* SDF; loops are joints */
} km_model_format;
/* Format by the extension of a file name: .urdf, .xml (MJCF), .sdf; otherwise JSON. */
KM_API km_model_format km_model_format_of(const char *file);

/* Writes a model in a format, in a configuration in which its loops are closed (q as above). Robot descriptions are
 * in SI units. Elements that the format can't hold are listed in `messages`, one note for each kind with their
 * number. Reading the text gives the same mechanism: mobility, body poses at equal coordinates, masses, gravity.
 * Coordinates of loop joints in SDF and of ball joints in MJCF are 0 in the written configuration. `file`: path of
 * the text, to which mesh paths are made relative (km_model_rename_meshes); NULL: unchanged. The caller frees
 * `*out`. KM_MODEL: the loops aren't closed; KM_USAGE, KM_MEMORY. Cost: bodies · joints. */
KM_API km_status km_model_write_as(const km_model *model, km_model_format format, const double *q, const char *file,
                                   km_messages *messages, km_bytes *out, km_error *error);

/* Converts a model to a JSON tree in other units, with the initial displacements q (as above) and the format version
 * of the file. Everything that was read is kept, inactive elements too. A drawing is kept in the drawn
 * configuration; in another one, or if `frames` is set, it becomes frames of the bodies. Expressions and parameters
 * are kept if units and drawing are, otherwise they become numbers. The tree and its text live in `arena`. KM_USAGE,
 * KM_MEMORY. Cost: linear in the file. */
KM_API km_status km_model_convert(const km_model *model, const km_units *units, const double *q, bool frames,
                                  km_arena *arena, const km_value **out, km_error *error);
/* Converts a model to a JSON tree whose assemblies are `drawn` in the configuration q, in other units: frames,
 * centres of mass and inertias of their bodies are expressed in the inertial frame, and joints by `bodies`, `at` and
 * `axis` where these suffice. A joint whose coordinates need complete frames (ball, float, rotated universal and
 * planar joints) keeps its pair of frames; frames used only by other joints are omitted. An assembly that can't be
 * drawn keeps its frames, with a note in `notes` (may be NULL). Expressions become numbers, struts stay struts.
 * Points are rounded to 1e-14 of the largest coordinate. A model that is already drawn in this configuration is
 * written like km_model_convert. KM_NO_RESULT: no assembly can be drawn; KM_USAGE, KM_MEMORY. Cost: linear in the
 * file. */
KM_API km_status km_model_draw(const km_model *model, const km_units *units, const double *q, km_messages *notes,
                               km_arena *arena, const km_value **out, km_error *error);
/* Makes the mesh paths of a `tree` of km_model_convert or km_model_draw relative to the folder of `file`, or
 * absolute if both share only the root. Paths of meshes that aren't found are unchanged, as are all paths if `file`
 * is NULL, "-" or in the model's own folder. The paths live in `arena`. KM_USAGE, KM_MEMORY. O(tree). */
KM_API km_status km_model_rename_meshes(const km_model *model, const km_value *tree, const char *file, km_arena *arena,
                                        km_error *error);
/* True if the model's file has parameters. */
KM_API bool km_model_has_parameters(const km_model *model);

/* ---- File formats as JSON schemas and as Markdown tables. */

/* Formats with a schema. */
typedef enum km_schema {
  KM_SCHEMA_MODEL,   /* models */
  KM_SCHEMA_DESIGNS, /* studies of designs */
  KM_SCHEMA_PATHS,   /* path studies */
  KM_SCHEMAS         /* number of enumerators */
} km_schema;

/* JSON schema (draft 2020-12) of a format. NULL: an invalid format, or out of memory (arena->failed). */
KM_API const km_value *km_schema_record(km_schema of, km_arena *arena);
/* Appends the keys of every object as Markdown tables, each after a line `<!-- keys: NAME -->`. */
KM_API void km_schema_markdown(km_schema of, km_text *out);

#ifdef __cplusplus
}
#endif
#endif
