/* Answers as records (JSON), as tables in CSV, and as text for people: what the tools print. */
#ifndef KMECH_RECORDS_H
#define KMECH_RECORDS_H

#include "kmech/diagnosis.h"
#include "kmech/history.h"
#include "kmech/linear.h"
#include "kmech/losses.h"
#include "kmech/mobility.h"
#include "kmech/question.h"
#include "kmech/statics.h"
#include "kmech/transmission.h"
#include "kmech/value.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Tables. */
/* One header row (name, then _unit), then the numbers in their shortest exact form. */
KM_API void km_csv_write(const km_table *table, km_text *out);
/* Reads a table: a header row, then rows of numbers (inf, -inf, nan and empty fields, which are nan, too). What stands
 * behind the last underscore of a column's name is its unit if it is one of the model format's or made of them (rad/mm);
 * mobility numbers, m.LABEL, have none. `file` is named in messages, with the line. KM_IO: the text is no table of
 * numbers; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_csv_read(const km_text *text, const char *file, km_table **out, km_error *error);
/* The column that is called so, with or without its unit; -1 if there is none. */
KM_API int km_csv_find(const km_table *table, const char *name);

/* Records: trees of values that km_json_write writes, NULL when out of memory (arena->failed) or where something is missing;
 * and the same as text for people, appended. Names are those of models, for people. */
/* The head that every record starts with: kmech, tool, model, model_sha256, units, characteristic_length. */
KM_API km_value *km_record_head(const km_mechanism *mechanism, const char *tool, const char *name, km_arena *arena);
/* What `kmob info` and `kmob at` give (cli.md). NULL when out of memory (arena->failed). */
KM_API km_value *km_mobility_record(const km_mechanism *mechanism, const km_state *state, const km_mobility *mobility,
                                    const char *name, km_arena *arena);
/* The same for people; `verbose` adds the evidence of each rank. */
KM_API void km_mobility_print(const km_mechanism *mechanism, const km_state *state, const km_mobility *mobility,
                              const char *name, bool verbose, km_text *out);
/* Adds finite_mobility, motions, truncated, idle_mobility, idle_freedoms and redundancies to a record. */
KM_API void km_diagnosis_record(const km_mechanism *mechanism, const km_diagnosis *diagnosis, km_value *record,
                                km_arena *arena);
/* `all`: also what planar loops have by nature. */
KM_API void km_diagnosis_print(const km_mechanism *mechanism, const km_diagnosis *diagnosis, bool all, km_text *out);
/* The findings for people: each with what to do; nothing found is said, too. */
KM_API void km_findings_print(const km_findings *findings, const char *name, km_text *out);
/* Adds `findings` to a record. */
KM_API void km_findings_record(const km_findings *findings, km_value *record, km_arena *arena);
/* What `kma at` gives (cli.md), of a driving `input` and a driven `output`. */
KM_API km_value *km_advantage_record(const km_mechanism *mechanism, const km_state *state, const km_handle *input,
                                     const km_handle *output, const km_advantage *advantage,
                                     const km_transmission *transmission, const km_losses *losses, const char *name,
                                     km_arena *arena);
/* The same for people, appended; `input` and `output` as above. */
KM_API void km_advantage_print(const km_mechanism *mechanism, const km_handle *input, const km_handle *output,
                               const km_advantage *advantage, const km_transmission *transmission,
                               const km_losses *losses, const char *name, km_text *out);
/* What `kstatic at` gives (cli.md). NULL when out of memory (arena->failed). */
KM_API km_value *km_statics_record(const km_mechanism *mechanism, const km_state *state, const km_statics *statics,
                                   const char *name, km_arena *arena);
/* The same for people, appended: forces of the actuators, least-norm forces, reactions. */
KM_API void km_statics_print(const km_mechanism *mechanism, const km_statics *statics, const char *name, km_text *out);
/* A gravity (length / time²; NULL: the model's), appended: "gravity (0, 0, -9.81) m/s²", or "no gravity". */
KM_API void km_gravity_words(const km_model *model, const double gravity[3], km_text *out);
/* That couplings, such as gears, put no forces on bearings, appended where the model has some; else nothing. A record has it
 * as `reactions_note`. */
KM_API void km_meshing_words(const km_model *model, km_text *out);
/* Which joints would move in a `direction` of the balance, the fastest first: "D by -1 rad, N by 0.9 m, …". */
KM_API void km_direction_words(const km_mechanism *mechanism, const km_statics *statics, int direction, km_text *out);
/* What a sweep's `--format json` gives (cli.md). `name`: the model's; `stopped_by`: km_sweep_stop_text. NULL when out of
 * memory (arena->failed) or without an answer. */
KM_API km_value *km_question_record(const km_question *question, const km_mechanism *mechanism, const char *stopped_by,
                                    const char *name, km_arena *arena);
/* A summary to act on. */
KM_API void km_question_print(const km_question *question, const km_mechanism *mechanism, const char *name,
                              km_text *out);
/* Frequencies, damping and the joints that move most, mode by mode. */
KM_API void km_linear_print(const km_mechanism *mechanism, const km_linear *linear, km_text *out);
/* kmech, tool … freedom, independent, A, B, N, eigenvalues, stability, configuration. NULL when out of memory. */
KM_API const km_value *km_linear_record(const km_mechanism *mechanism, const km_state *state, const km_linear *linear,
                                        const char *tool, const char *name, km_arena *arena);
/* A, B, N and the eigenvalues (real and imaginary parts as columns) as a MAT-file of level 4, for little-endian
 * machines. */
KM_API void km_linear_mat(const km_linear *linear, km_text *out);
/* A matrix[rows × columns], column-major, as CSV without header, row by row. */
KM_API void km_matrix_csv(const double *matrix, int rows, int columns, km_text *out);
/* kmech, tool, model … figures, events, columns, rows, complete, stopped_by. NULL when out of memory. */
KM_API const km_value *km_history_record(const km_mechanism *mechanism, const km_history_def *def,
                                         const km_history *history, const char *stopped_by, const char *name,
                                         km_arena *arena);
/* The same of a motion that is prescribed as a whole; `stopped_by` as above. */
KM_API const km_value *km_inverse_record(const km_mechanism *mechanism, const km_history *history,
                                         const char *stopped_by, const char *name, km_arena *arena);

/* Pieces of text about sweeps. */
/* " mm", or nothing for an arc length. */
KM_API const char *km_sweep_unit(const km_mechanism *mechanism, const km_sweep_plan *plan);
/* Why the sweep ended where it did, in words: empty where the whole range was reached. */
KM_API void km_sweep_stop_text(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep,
                               km_text *out);

#ifdef __cplusplus
}
#endif
#endif
