/* Blocks shared by reports of sweeps: configurations, plots, tables, facts about the model. */
#ifndef KM_REPORT_DOCUMENT_SWEEP_REPORT_H
#define KM_REPORT_DOCUMENT_SWEEP_REPORT_H

#include "report/charts/sweep_plot.h"
#include "report/document/document.h"
#include "report/drawing/drawing.h"

/* Rows of a name and what it is, in the making. */
typedef struct km_report_facts {
  const char *cells[2 * 32];
  size_t rows;
} km_report_facts;
void km_report_fact(km_report_facts *facts, const char *name, const char *what);
/* Facts: driver, range, mobility, held coordinates, reason of the end. */
void km_report_motion(km_document_maker *maker, const km_swept *swept, const char *stopped_by, km_report_facts *facts);
/* Fact about the digits of the model's numbers, where loops depend on them. */
void km_report_digits(const km_mechanism *mechanism, km_report_facts *facts);
/* Source, hash, units and characteristic length of the model, and how the numbers were computed, at the end. */
void km_report_model(km_document_maker *maker, const km_swept *swept, const char *method);
/* "of K from 20 to 32 mm", "along an arc of 3.2": the stroke in a sentence. */
const char *km_report_stroke(km_document_maker *maker, const km_swept *swept);
/* The facts as a block. */
void km_report_close_facts(km_document_maker *maker, const km_report_facts *facts);

/* The mechanism in poses over the sweep: one large drawing with names, and a row of small ones. */
void km_report_poses(km_document_maker *maker, const km_swept *swept);
/* A drawing of the maker's arena as a picture. */
void km_report_drawing(km_document_maker *maker, km_drawing_def *drawing, const char *shows, double height);
/* As km_report_poses for a motion over time, whose table has the time in its first column. */
void km_report_run_poses(km_document_maker *maker, const km_mechanism *mechanism, const km_table *table,
                         const char *name);
/* A plot of the maker's arena as a picture. */
void km_report_plot(km_document_maker *maker, const km_plot *plot, const char *shows, double height);

/* Finds the column of a header's quantity across the curves: its name, with q., point. or frame. before it. KM_USAGE:
 * there is none. */
km_status km_report_find_over(const km_table *table, const char *over, size_t *column, km_error *error);
/* "shock (mm)": its words on an axis. */
const char *km_report_over_label(km_document_maker *maker, const km_table *table, size_t column);
/* Draws the plots that follow over this quantity instead of the table's own variable. `over` NULL: no change. KM_USAGE
 * as above. */
km_status km_report_set_over(km_document_maker *maker, const km_table *table, const char *over, km_error *error);

/* A column of a table at chosen poses. */
typedef struct km_report_column {
  size_t column;
  const char *head;
} km_report_column;
/* The column of the driver's value or the arc length. */
size_t km_report_s(const km_swept *swept);
/* Selects a dozen rows: both ends, the rows nearest to the `special` values, and evenly spaced ones between. */
void km_report_rows(km_document_maker *maker, const km_swept *swept, const km_report_column *columns, size_t count,
                    const double *special, size_t special_count);
/* A unit with raised exponents: "rad/s²" for rad/s^2. */
const char *km_report_unit(km_document_maker *maker, const char *unit);
/* "1.2345", "∞", "–" where there is none. */
const char *km_report_number(km_document_maker *maker, double value);

/* "fourbar · SHA-256 0123456789abcdef…": a model in the footer. */
const char *km_report_subject(km_document_maker *maker, const char *name, const km_model *model);
/* Appends the document of all blocks, HTML or PDF; `header` (may be NULL) has words for its head, `subject` opens the
 * footer. Frees the maker. KM_MEMORY, KM_INTERNAL. */
km_status km_report_finish(km_document_maker *maker, const char *subject, const km_report_header *header,
                           const char *tool, const char *title, bool html, km_text *out, km_error *error);

#endif
