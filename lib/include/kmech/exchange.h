/* Writing models as files (JSON, URDF, MJCF, SDF), and the formats as JSON schema and as text. */
#ifndef KMECH_EXCHANGE_H
#define KMECH_EXCHANGE_H

#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- Models as the text of files. */

/* A model in its own format (JSON), in its own units; all that was read is kept, and what calls have changed since
 * (kmech/edit.h) takes the place of the file's numbers. `q` [coordinate count]: initial
 * displacements in the model's units, NULL: the model's own. The caller frees `*out`. KM_USAGE: also where a
 * change is one that no file says: of a body's own frame, of a strut's parts, of a mass that is weighed by a density;
 * KM_MEMORY. Cost: linear in the file. */
KM_API km_status km_model_write(const km_model *model, const double *q, km_bytes *out, km_error *error);

/* The formats that a model is written in. */
typedef enum km_model_format {
  KM_FORMAT_JSON, /* the model format */
  KM_FORMAT_URDF, /* a tree: joints that close loops are left out */
  KM_FORMAT_MJCF, /* loops by constraints */
  KM_FORMAT_SDF   /* loops as joints */
} km_model_format;
/* The format that the ending of a file's name tells: .urdf, .xml (MJCF), .sdf; JSON for all others. */
KM_API km_model_format km_model_format_of(const char *file);

/* The model in one of these formats, at a pose in which its loops are closed (q as above). Robot descriptions are in SI
 * units. What a format can't hold is a note in `messages`, one for each kind, with the number. What is read back is the
 * same mechanism: mobility, poses at the same coordinates, masses, gravity. In SDF the joints of loops count from the pose
 * that is written; in MJCF ball joints do. The caller frees `*out`. KM_MODEL: the loops are open; KM_USAGE, KM_MEMORY. Cost:
 * bodies · joints. `file`: where the text will stand; meshes are named as from its folder (km_model_rename_meshes); NULL: they
 * keep their names. */
KM_API km_status km_model_write_as(const km_model *model, km_model_format format, const double *q, const char *file,
                                   km_messages *messages, km_bytes *out, km_error *error);

/* The model as a tree in other units, version 1.0 or newer as the file, with the given initial displacements (q as above).
 * Everything that was read is kept, left-out elements too. A drawing stays one where the pose is the drawn one; for another
 * pose, or where `frames` asks for it, it is written as frames of the bodies. Expressions and parameters stay where both
 * the units and the drawing do, else they become numbers. The tree and its text live in `arena`. KM_USAGE, KM_MEMORY. Cost:
 * linear in the file. */
KM_API km_status km_model_convert(const km_model *model, const km_units *units, const double *q, bool frames,
                                  km_arena *arena, const km_value **out, km_error *error);
/* The model as a tree whose assemblies are `drawn` in the pose q, in other units: the frames, centres of mass and inertias
 * of their bodies stand where the inertial frame sees them, and joints are told by `bodies`, `at` and `axis` where that
 * says all. A joint whose coordinates need whole frames (ball, float, universal and planar joints that are turned) keeps
 * its pair of frames. Frames that only such joints named are left out. An assembly that can't be drawn keeps its frames,
 * with a note in `notes` (may be NULL). Expressions become numbers, struts stay struts. Points are rounded to 1e-14 of the
 * largest coordinate. A model that is drawn in this pose already is written as by km_model_convert, expressions and all.
 * KM_NO_RESULT: no assembly can be drawn; KM_USAGE, KM_MEMORY. Cost: linear in the file. */
KM_API km_status km_model_draw(const km_model *model, const km_units *units, const double *q, km_messages *notes,
                               km_arena *arena, const km_value **out, km_error *error);
/* Names the meshes of a `tree` that such a call has made as from the folder of `file`, where the tree will stand, if that
 * isn't the model's own: relative to it, or by their whole path where both have nothing but the root in common. Meshes that
 * aren't found keep their names; so do all where `file` is NULL, or "-". The names live in `arena`. KM_USAGE, KM_MEMORY.
 * O(tree). */
KM_API km_status km_model_rename_meshes(const km_model *model, const km_value *tree, const char *file, km_arena *arena,
                                        km_error *error);
/* Does the model's file name numbers by parameters? */
KM_API bool km_model_has_parameters(const km_model *model);

/* ---- The formats that files are written in, as a JSON schema and in words. */

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
