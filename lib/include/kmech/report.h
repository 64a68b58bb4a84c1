/* Results as records (JSON), tables (CSV), text, plots, drawings and reports. */
#ifndef KMECH_REPORT_H
#define KMECH_REPORT_H

#include "kmech/arm.h"
#include "kmech/base.h"
#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/mechanism.h"
#include "kmech/mobility.h"
#include "kmech/question.h"
#include "kmech/space.h"
#include "kmech/statics.h"
#include "kmech/study.h"
#include "kmech/transfer.h"
#include "kmech/volume.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- The formats of pictures. */

/* Format of a picture. Equal input gives equal bytes on every machine: no date, no random id. */
typedef enum km_picture_format {
  KM_PICTURE_SVG, /* text, for browsers and editors */
  KM_PICTURE_PDF, /* a page */
  KM_PICTURE_PNG  /* pixels, two for each point of 1/72 inch */
} km_picture_format;

/* ---- Answers as records (JSON), as tables in CSV, and as text. */

/* Tables. */
/* One header row (name, then _unit), then the numbers in their shortest exact form. */
KM_API void km_csv_write(const km_table *table, km_text *out);
/* Reads a CSV table: a header row, then rows of numbers (inf, -inf, nan; an empty field is nan). The part of a
 * column's name after the last underscore is its unit, if it is a unit of the model format or composed of them
 * (rad/mm); mobility numbers, m.LABEL, have none. `file` is used in messages, with the line. KM_IO: the text isn't a
 * table of numbers; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_csv_read(const km_text *text, const char *file, km_table **out, km_error *error);
/* The column that is called so, with or without its unit; -1 if there is none. */
KM_API int km_csv_find(const km_table *table, const char *name);
/* Appends a workbook (Office Open XML, .xlsx): a `sheet` of that name with the table, its header row and the columns
 * up to the variable frozen, and a sheet with a chart of the columns whose names begin with `curves` ("m.") over the
 * variable: at most eight that share the first one's unit. A number has 16 digits; a value that isn't finite is an
 * empty cell. Equal tables give equal bytes. KM_USAGE: more rows or columns than a sheet holds, a name that no sheet
 * can have; KM_IO: libxlsxwriter or a folder for temporary files is missing; KM_MEMORY. */
KM_API km_status km_xlsx_write(const km_table *table, const char *sheet, const char *curves, km_text *out,
                               km_error *error);
/* Appends the workbook of an answer's table. `sheet`: name of the table's sheet. The chart has the curves that the
 * plot shows: mobility numbers, advantage, forces, velocities or coordinates. KM_USAGE: also without an answer. */
KM_API km_status km_question_xlsx(const km_question *question, const char *sheet, km_text *out, km_error *error);

/* Records are trees of values for km_json_write; NULL when out of memory (arena->failed) or if an argument is
 * missing. The print functions append text. `name`: name of the model. */
/* The head that every record starts with: kmech, tool, model, model_sha256, units, characteristic_length. */
KM_API km_value *km_record_head(const km_mechanism *mechanism, const char *tool, const char *name, km_arena *arena);
/* Adds `columns` [{name, unit}] and `rows` of a table to a record. */
KM_API void km_table_record(const km_table *table, km_value *record, km_arena *arena);
/* Record of `kmob info` and `kmob at`. NULL when out of memory (arena->failed). */
KM_API km_value *km_mobility_record(const km_mechanism *mechanism, const km_state *state, const km_mobility *mobility,
                                    const char *name, km_arena *arena);
/* Text of `kmob info` and `kmob at`, with the finite mobility if `finite` is given (may be NULL); `verbose` adds the
 * evidence of each rank, and of planar mechanisms Kutzbach's count of six freedoms a body. */
KM_API void km_mobility_print(const km_mechanism *mechanism, const km_state *state, const km_mobility *mobility,
                              const km_finite_mobility *finite, const char *name, bool verbose, km_text *out);
/* Adds finite_mobility, motions, truncated, idle_mobility, idle_freedoms, redundancies and, if there are any,
 * remedy_set to a record. */
KM_API void km_diagnosis_record(const km_mechanism *mechanism, const km_diagnosis *diagnosis, km_value *record,
                                km_arena *arena);
/* Idle freedoms and redundant constraints. `all`: also what planar loops have by nature. */
KM_API void km_diagnosis_print(const km_mechanism *mechanism, const km_diagnosis *diagnosis, bool all, km_text *out);
/* Text of findings, each with its remedy; also if there are none. */
KM_API void km_findings_print(const km_findings *findings, const char *name, km_text *out);
/* Adds `findings` to a record. */
KM_API void km_findings_record(const km_findings *findings, km_value *record, km_arena *arena);
/* Record of `kma at` for a driving `input` and a driven `output`. */
KM_API km_value *km_advantage_record(const km_mechanism *mechanism, const km_state *state, const km_port *input,
                                     const km_port *output, const km_advantage *advantage,
                                     const km_transmission *transmission, const km_losses *losses, const char *name,
                                     km_arena *arena);
/* Text of `kma at`; `input` and `output` as above. */
KM_API void km_advantage_print(const km_mechanism *mechanism, const km_port *input, const km_port *output,
                               const km_advantage *advantage, const km_transmission *transmission,
                               const km_losses *losses, const char *name, km_text *out);
/* Record of `kstatic at`. NULL when out of memory (arena->failed). */
KM_API km_value *km_statics_record(const km_mechanism *mechanism, const km_state *state, const km_statics *statics,
                                   const char *name, km_arena *arena);
/* Text of `kstatic at`: forces of the actuators, minimum-norm forces, reactions. */
KM_API void km_statics_print(const km_mechanism *mechanism, const km_statics *statics, const char *name, km_text *out);
/* A gravity (length / time²; NULL: the model's), appended: "gravity (0, 0, -9.81) m/s²", or "no gravity". */
KM_API void km_gravity_words(const km_model *model, const double gravity[3], km_text *out);
/* That couplings, such as gears, put no forces on bearings, appended where the model has some; else nothing. A
 * record has it as `reactions_note`. */
KM_API void km_meshing_words(const km_model *model, km_text *out);
/* Joints that would move in a `direction` of the balance, the fastest first: "D by -1 rad, N by 0.9 m, …". */
KM_API void km_direction_words(const km_mechanism *mechanism, const km_statics *statics, int direction, km_text *out);
/* Record of clearances at a configuration, at[pair count] of km_clearance_compute: pairs [{bodies, clearance, error,
 * points, normal}], left_out, hulls. And their text: the least ones, pairs that are left out, errors of hulls. */
KM_API km_value *km_clearance_record(const km_mechanism *mechanism, const km_clearance *clearance,
                                     const km_pair_clearance *at, const char *name, km_arena *arena);
KM_API void km_clearance_print(const km_mechanism *mechanism, const km_clearance *clearance,
                               const km_pair_clearance *at, const char *name, km_text *out);
/* Record of an answer as by `--format json`. `name`: name of the model; `stopped_by`: km_sweep_stop_text. NULL when
 * out of memory (arena->failed) or without an answer. */
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
KM_API km_value *km_history_record(const km_mechanism *mechanism, const km_history_def *def, const km_history *history,
                                   const char *stopped_by, const char *name, km_arena *arena);
/* Summary of a run (`def`: its definition) or of inverse dynamics (NULL): extent, what acts, errors, events; largest
 * forces. */
KM_API void km_history_print(const km_mechanism *mechanism, const km_history_def *def, const km_history *history,
                             const char *name, km_text *out);
/* Record of inverse dynamics; `stopped_by` as above. */
KM_API km_value *km_inverse_record(const km_mechanism *mechanism, const km_history *history, const char *stopped_by,
                                   const char *name, km_arena *arena);

/* Pieces of text about sweeps. */
/* " mm", or nothing for an arc length. */
KM_API const char *km_sweep_unit(const km_mechanism *mechanism, const km_sweep_plan *plan);
/* Reason of a sweep's end as text; empty if the whole range was reached. */
KM_API void km_sweep_stop_text(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep,
                               km_text *out);

/* ---- Answers as plots, and reports about them. */

/* Words of a report's head in addition to its own; NULL: none. */
typedef struct km_report_header {
  const char *title;   /* in place of the report's own title */
  const char *author;  /* shown below the title, */
  const char *date;    /* and the date, as text */
  const char *note;    /* a paragraph behind the answer */
  const km_text *logo; /* bytes of a PNG file that km_logo_read accepts; shown beside the title */
  const char *over;    /* quantity across the curves of answers: a column such as q.shock, point.axle/hub.y, or a joint;
                        * NULL: the driver or the time */
} km_report_header;
/* Reads a logo. KM_IO: the file can't be read; KM_USAGE: it isn't a PNG picture of at most 4096 pixels a side and 4 MB,
 * or is damaged; `out` is then empty. The caller frees it (km_text_free). O(bytes). */
KM_API km_status km_logo_read(const char *file, km_text *out, km_error *error);

/* One of the answers that share a plot. Everything is borrowed. */
typedef struct km_answered {
  const km_question *question; /* the question, with an answer */
  const char *name;            /* name of the model or variant */
  const int *shown;            /* [shown_count] the coordinates whose curves are drawn; NULL: by default all, of several
                                * answers the driver's */
  int shown_count;
  const km_report_header *header; /* head of a report; NULL: none */
} km_answered;

/* Answers of several models or variants in one plot. */
typedef struct km_comparison {
  const km_answered *answers; /* all to questions of one kind */
  int count;                  /* number of answers */
  bool ordered;               /* variants, whose order the colours show; else models, whose colours differ most */
} km_comparison;

/* One of the tables that share a plot. Everything is borrowed. */
typedef struct km_plotted_table {
  const km_table *table; /* table with the columns */
  const char *name;      /* as the plot calls it */
  size_t x;              /* the column across */
  const size_t *y;       /* [columns] those upwards: the same columns of every table, with the same units */
} km_plotted_table;

/* Words of a plot of tables in place of its own; NULL: its own. Everything is borrowed. */
typedef struct km_chart_words {
  const char *title;        /* the title */
  const char *x_label;      /* label of the axis across, with the unit */
  const char *y_label;      /* label of the axis upwards, with the unit */
  const char *x_name;       /* name of the column across in the title and the label */
  const char *const *names; /* [columns] names of the columns upwards; NULL, also one of them: as in the table */
} km_chart_words;

/* Options of the plot of a history's table, or of some of its rows. Everything is borrowed. */
typedef struct km_plotted_history {
  const km_mechanism *mechanism; /* mechanism of the columns */
  const km_table *table;         /* its rows, all or some */
  const km_crossing *crossings;  /* members of the definition: */
  const km_crossing_met *met;    /* and those that were met: marked in the plot */
  int met_count;
  const char *name; /* name of the model */
  const int
      *joints; /* [joint_count] coordinates whose curves are drawn; NULL: up to eight that move most for their kind */
  int joint_count;
} km_plotted_history;

/* A plot, which is drawn as often as is wanted. It borrows what it was made of. */
typedef struct km_chart km_chart;
KM_API void km_chart_free(km_chart *chart);

/* Each of these makes a plot; the caller frees `*out`. KM_USAGE: something is missing, an index is out of range;
 * KM_MEMORY. O(rows · columns). */
/* Plot of answers. KM_USAGE: also without an answer. */
KM_API km_status km_question_chart(const km_comparison *comparison, km_chart **out, km_error *error);
/* Plot of columns of tables. Columns of one unit share a panel; panels are stacked. Scales of x and y are equal if
 * both are lengths and the curve is planar: coordinates of points, or an x that isn't monotonic. Numbers that aren't
 * finite interrupt a curve. */
KM_API km_status km_table_chart(const km_plotted_table *tables, int count, int columns, km_chart **out,
                                km_error *error);
/* Plot of columns of tables with words of its own. `words` may have NULL everywhere. KM_USAGE: also if the y axis is
 * labelled and columns of several units have several. */
KM_API km_status km_table_chart_worded(const km_plotted_table *tables, int count, int columns,
                                       const km_chart_words *words, km_chart **out, km_error *error);
/* Plot of a time history: coordinates and rates by unit, driving forces, mobility numbers if present, energies.
 * KM_USAGE: also if the table isn't from km_history_run of this mechanism. */
KM_API km_status km_history_chart(const km_plotted_history *history, km_chart **out, km_error *error);
/* Options of the plot of an answer of kind "run" or "inverse", borrowed; empty for another kind. */
KM_API km_plotted_history km_question_plotted_history(const km_answered *answer);
/* Plot of inverse dynamics (km_inverse_run): driving forces, shaking force, coordinates. */
KM_API km_status km_inverse_chart(const km_plotted_history *history, km_chart **out, km_error *error);

/* Appends the picture's bytes to `out`, which stays as it was with any status but KM_OK. KM_USAGE, KM_MEMORY,
 * KM_INTERNAL (the graphics library's own failure). */
KM_API km_status km_chart_picture(const km_chart *chart, km_picture_format format, km_text *out, km_error *error);

/* Look of a map's picture. Start from {0}. Everything is borrowed. */
typedef struct km_map_look {
  const char *column; /* column of the cells that the colours show; NULL: sigma.input */
  bool over_point;    /* drawn over the place of the map's point, instead of the drivers */
  const char *title;  /* NULL: "Map" */
} km_map_look;
/* Appends a picture of a map (km_space_map_compute): filled contours of a column, a panel for each sheet, or over the
 * point for each aspect, the six largest, and the singularity curves. The colours survive a grey print and colour
 * blindness; 2 % of the values at each end share those of the ends. KM_USAGE: no such column, or no point;
 * KM_NO_RESULT: no cell; KM_MEMORY. O(cells · log cells). */
KM_API km_status km_space_map_picture(const km_mechanism *mechanism, const km_space_map_def *def,
                                      const km_space_map *map, const km_map_look *look, km_picture_format format,
                                      km_text *out, km_error *error);

/* Page of a map: one HTML file without other files, in which the sheets, or over the point the aspects, are surfaces
 * that the reader turns; height and colour are a column, which can be chosen, with five digits; the curves lie on the
 * surfaces. The page keeps every k-th grid point of more than 100 intervals. Appends it; errors as
 * km_space_map_picture. O(cells + points of curves). */
KM_API km_status km_space_map_page(const km_mechanism *mechanism, const km_space_map_def *def, const km_space_map *map,
                                   const km_map_look *look, km_text *out, km_error *error);

/* Appends "volume 0.1372 m³, 95 % interval 0.1365 to 0.1379 m³", or an area, and how many samples are undecided.
 * Nothing without samples. */
KM_API void km_space_volume_text(const km_space_volume *volume, km_text *out);
/* Appends the name of an axis of a workspace: "x", "y", "z", or "along (0.6, 0, 0.8)". Nothing without such an axis. */
KM_API void km_space_volume_axis_text(const km_space_volume *volume, int axis, km_text *out);
/* Appends a picture of a workspace (km_space_volume_find): its views along the three axes, whose colours are the depth
 * of the workspace along the line of sight; in a plane the share of the samples that are reached. All axes have one
 * scale, unless one would be too short to be read. The colours survive a grey print and colour blindness. title: NULL:
 * "Workspace". KM_USAGE: no samples; KM_MEMORY. O(samples). */
KM_API km_status km_space_volume_picture(const km_space_volume *volume, const char *title, km_picture_format format,
                                         km_text *out, km_error *error);

/* Report about an answer to "advantage" with option `transmission`, or to "forces": configurations, curves, tables.
 * `stopped_by`: km_sweep_stop_text. `html`: one self-contained file, otherwise PDF pages. Appends the bytes.
 * KM_USAGE: a question without report, or no answer; KM_MEMORY, KM_INTERNAL. */
KM_API km_status km_question_report(const km_answered *answer, const char *stopped_by, bool html, km_text *out,
                                    km_error *error);

/* Report about the answers of several models or variants: first which figures differ and by how much, with the curves
 * that differ most; then each answer briefly. `name`: name of the model, or of all. `stopped_by`[count] (may be NULL):
 * texts of km_sweep_stop_text, each may be NULL. `header` may be NULL. `html`: one self-contained file, otherwise PDF
 * pages. Answers without rows are named and left out: their question may be NULL. Appends the bytes. KM_USAGE: no
 * answer has rows, kinds differ, or a kind has no report; KM_MEMORY, KM_INTERNAL. */
KM_API km_status km_comparison_report(const km_comparison *comparison, const char *name, const char *const *stopped_by,
                                      const km_report_header *header, bool html, km_text *out, km_error *error);

/* ---- Drawings of a mechanism: joints by the symbols of textbooks, links as bars and plates, in one pose or several;
 * as moving pictures, as outlines of links, and its graph.
 *
 *   km_drawing_create(mechanism, &drawing, &error);
 *   km_poses_compute(mechanism, state);
 *   km_drawing_add_pose(drawing, mechanism, state, &error);
 *   km_drawing_picture(drawing, &(km_drawing_look){.title = "Brake"}, KM_PICTURE_SVG, &text, &error);
 *   km_drawing_free(drawing); */

/* The poses that a drawing shows, and the paths of points. */
typedef struct km_drawing km_drawing;

/* Creates a drawing without poses of a mechanism, which must outlive it. The caller frees `*out`. KM_USAGE,
 * KM_MEMORY. */
KM_API km_status km_drawing_create(const km_mechanism *mechanism, km_drawing **out, km_error *error);
KM_API void km_drawing_free(km_drawing *drawing);
/* Adds the pose of a state, after km_poses_compute. The state's mechanism may be another one of the same model, with
 * other holds. KM_USAGE, KM_MEMORY. O(bodies). */
KM_API km_status km_drawing_add_pose(km_drawing *drawing, const km_mechanism *mechanism, const km_state *state,
                                     km_error *error);
/* Adds the poses of all rows of a table with the columns q. of every coordinate, such as a sweep's or a history's, and
 * leads the paths through them. KM_USAGE: it has other columns; KM_MEMORY. O(rows · bodies). */
KM_API km_status km_drawing_add_rows(km_drawing *drawing, const km_table *table, km_error *error);
/* Draws the path of a frame's origin, too; empty until it is led on. `name` is borrowed. KM_USAGE, KM_MEMORY. */
KM_API km_status km_drawing_add_path(km_drawing *drawing, int frame, const char *name, km_error *error);
/* Leads every path on to where its frame is, after km_poses_compute; else as km_drawing_add_pose. */
KM_API km_status km_drawing_lead_paths(km_drawing *drawing, const km_mechanism *mechanism, const km_state *state,
                                       km_error *error);
/* Number of poses; 0 without a drawing. */
KM_API int km_drawing_poses(const km_drawing *drawing);
/* True if every body ends where it began and moved in between. False with fewer than three poses. */
KM_API bool km_drawing_comes_round(const km_drawing *drawing);

/* Viewing direction. AUTO: along the normal of the plane of motion, or ISO if there is none. */
typedef enum km_view {
  KM_VIEW_AUTO, /* chosen */
  KM_VIEW_XY,   /* view along z */
  KM_VIEW_XZ,   /* view along y */
  KM_VIEW_YZ,   /* view along x */
  KM_VIEW_ISO   /* view from (1, 1, 1) */
} km_view;
/* "xy", "iso", "auto" …; false if the word is no view. */
KM_API bool km_view_find(const char *word, km_view *view);
/* True if the view is along the axes of a mechanism that moves in a plane. False without a pose. */
KM_API bool km_drawing_is_planar(const km_drawing *drawing, km_view view);

/* The meshes and shapes of a model's bodies. */
typedef struct km_meshes km_meshes;
/* KM_USAGE: no body has one; KM_IO: a file can't be found or read; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_model_read_meshes(const km_model *model, km_meshes **out, km_error *error);
KM_API void km_meshes_free(km_meshes *meshes);

/* Style of a drawing. Everything is borrowed; start from {0}. */
typedef struct km_drawing_look {
  km_view view;             /* viewing direction */
  const km_meshes *meshes;  /* meshes of the model, drawn instead of bars and plates; NULL: none */
  bool bodies;              /* names them, too */
  bool loads;               /* the model's loads as arrows */
  const char *title, *name; /* title; the model's name. May be NULL */
  double width, height;     /* points (1/72 inch); 0: chosen from the shape */
} km_drawing_look;

/* Each of these appends a file's bytes to `out`, which stays as it was with any status but KM_OK. KM_USAGE: there is no
 * pose, or a page would be too small or too large; KM_MEMORY; KM_INTERNAL. */
/* A page with the first pose in full and the others pale, the paths, title, scale bar and axes. */
KM_API km_status km_drawing_picture(const km_drawing *drawing, const km_drawing_look *look, km_picture_format format,
                                    km_text *out, km_error *error);
/* Caption of one drawing of a grid. Texts are borrowed and may be NULL. */
typedef struct km_gallery_caption {
  const char *title, *text; /* first line, and the line below it */
  int group;                /* number of its group, from 1, which decides the colour of the frame; 0: grey */
} km_gallery_caption;
/* A page with a grid of small drawings: each pose by itself, captions[poses] below. All have one view and one scale.
 * Colours are those of Okabe and Ito, which colour-blind readers distinguish; they repeat after eight groups. At most
 * 400 poses. View, meshes, title and name of the look are used. */
KM_API km_status km_drawing_gallery(const km_drawing *drawing, const km_drawing_look *look,
                                    const km_gallery_caption *captions, km_picture_format format, km_text *out,
                                    km_error *error);
/* An animated PNG of at most 73 of the poses: round and round where they come round, else forth and back, in
 * `seconds` from the first to the last. Names of joints are left out. */
KM_API km_status km_drawing_apng(const km_drawing *drawing, const km_drawing_look *look, double seconds, km_text *out,
                                 km_error *error);

/* The links of a mechanism that moves in a plane as they could be cut, in the first pose: each body as wide as
 * `width` about its points (model's length unit; 0: as drawn, two digits of it), with a hole of half that at every
 * hinge; the inertial frame has holes alone. A page on which a length is `scale` times as long as it is; and the
 * same in AutoCAD's exchange format (release 12) as lines, arcs and circles in the model's length unit, a layer for
 * each body. KM_USAGE: also where the mechanism moves in no plane of this view. */
KM_API km_status km_drawing_outlines(const km_drawing *drawing, km_view view, double width, double scale,
                                     km_picture_format format, km_text *out, km_error *error);
KM_API km_status km_drawing_dxf(const km_drawing *drawing, km_view view, double width, km_text *out, km_error *error);

/* A named place on a motion's slider. */
typedef struct km_motion_stop {
  double pose;      /* values between poses, too */
  const char *name; /* label of the mark */
} km_motion_stop;

/* A page that plays the poses, with a slider. Everything is borrowed; start from {0}. */
typedef struct km_motion_page {
  const char *title, *subtitle, *footer; /* its headings and its last line; may be NULL */
  const char *quantity, *unit;           /* name and unit of the slider's variable; unit may be "" */
  const double *values;                  /* [poses] of it */
  const km_motion_stop *stops;           /* marked on the slider */
  size_t stop_count;
  bool closed;           /* the last pose is followed by the first; else it goes forth and back */
  double seconds;        /* [pose] values of the slider */
  const km_chart *chart; /* played beside it: every curve has a row for each pose; NULL: none */
  const char *chart_alt; /* alternative text of the chart */
} km_motion_page;
/* Writes one self-contained HTML file. Meshes aren't drawn. View, bodies and size of the look are used. KM_USAGE:
 * also without values. */
KM_API km_status km_drawing_page(const km_drawing *drawing, const km_drawing_look *look, const km_motion_page *page,
                                 km_text *out, km_error *error);

/* Appends the graph of a mechanism in the DOT language of graphviz: bodies by level of the spanning tree, tree
 * joints solid, chords dashed. A chord ends at its virtual body, the copy of the body at which its loop was cut.
 * Arrows point from parent to child, colours are substructures. `title` begins the caption. With more than 300
 * joints positions are included, as a tidy tree, because the layout of graphviz takes more than linear time. */
KM_API void km_graph_write(const km_mechanism *mechanism, const char *title, km_text *out);

/* ---- What arms do, as records, tables, text and pictures: tracks, self-motions, inverse kinematics. */

/* The tracks of one study, method by method. Everything is borrowed. */
typedef struct km_tracks {
  const km_study *study;  /* study with the methods */
  const char *name;       /* name of the study or model */
  const char *model;      /* meshes for pictures */
  km_track *const *items; /* [count]; NULL where a method failed */
  int count;              /* at most km_study_methods */
} km_tracks;

/* "lookahead", or "lookahead 2" for the second of its kind, with this separator. "" if there is no such track. */
KM_API void km_tracks_label(const km_tracks *tracks, int index, char separator, char *out, size_t size);
/* The track that goes furthest; of those that go as far (to 1e-6) the best by the objective's least value, or by its
 * mean where it is one of means; of those that are equal in this (to 1e-9) the best by the other of the two, then
 * the one of less joint travel, then of the lower largest rate, then the first. -1: none. */
KM_API int km_tracks_best(const km_tracks *tracks);
/* Appends reason and location of a track's end; nothing if it is complete. */
KM_API void km_track_end_text(const km_track *track, km_text *out);
/* The table of summaries, appended. */
KM_API void km_tracks_print(const km_tracks *tracks, km_text *out);
/* Record of `kredund track --format json`. `model`: name of the model. NULL when out of memory (arena->failed) or if
 * an argument is missing, as for the records below. */
KM_API km_value *km_tracks_record(const km_tracks *tracks, const char *model, km_arena *arena);

/* Pictures append their bytes to `out`, which stays as it was with any status but KM_OK. KM_USAGE: there is no track;
 * KM_MEMORY, KM_INTERNAL. */
/* Plots joint angles with limits, path-control entries, objectives, limit margin and tracking error over the path on
 * one page; several methods in adjacent columns. O(samples). */
KM_API km_status km_tracks_picture(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error);
/* The arm along the best track, with the effector's path. */
KM_API km_status km_tracks_drawing(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error);
/* The map of self-motions: self-motion over path length, coloured by the objective, hatched where a joint is outside
 * its limits, with the tracks, if there are any. KM_USAGE: the study has no path, no start, or not one spare
 * freedom. */
KM_API km_status km_tracks_map(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error);

/* Page that plays the arm along the best track beside the curves of its joints: one HTML file. Appends it. KM_USAGE:
 * there is no track with rows; KM_MEMORY. */
KM_API km_status km_tracks_page(const km_tracks *tracks, km_text *out, km_error *error);
/* Report about tracks: the best one in a sentence, each joint's margin and rate against its limits, the table of the
 * methods, the arm along the path (in HTML as an animation with the curves of its joints), plots. `header` may be NULL.
 * `html`: one self-contained file, otherwise PDF pages. Appends the bytes. KM_USAGE: there is no track with rows;
 * KM_MEMORY, KM_INTERNAL. */
KM_API km_status km_tracks_report(const km_tracks *tracks, const km_report_header *header, bool html, km_text *out,
                                  km_error *error);

/* Report about the best tracks of several studies: first which figures differ and by how much, with the curves that
 * differ most; then each study briefly. `names`[count] of the studies or variants, `name` of all; `ordered`: variants,
 * whose order the colours show. `header` may be NULL. `html` as above. Studies without a track are named and left out.
 * KM_USAGE: none has a track; KM_MEMORY, KM_INTERNAL. */
KM_API km_status km_tracks_comparison_report(const km_tracks *tracks, const char *const *names, int count,
                                             const char *name, bool ordered, const km_report_header *header, bool html,
                                             km_text *out, km_error *error);

/* A self-motion as record, text and table. Rows are the configurations within the limits, or the whole curve with
 * `all`. `model` and `name`: those of the model. The caller frees the table; NULL when out of memory. */
KM_API km_value *km_selfmotion_record(const km_arm *arm, const km_selfmotion *motion, bool all, const char *model,
                                      km_arena *arena);
KM_API void km_selfmotion_print(const km_arm *arm, const km_selfmotion *motion, const char *name, km_text *out);
KM_API km_table *km_selfmotion_table(const km_arm *arm, const km_selfmotion *motion, bool all);

/* All branches of inverse kinematics; `model` and `name` as above. */
KM_API km_value *km_ik_solutions_record(const km_arm *arm, const km_ik_solutions *solutions, const char *model,
                                        km_arena *arena);
KM_API void km_ik_solutions_print(const km_arm *arm, const km_ik_solutions *solutions, const char *name, km_text *out);

/* ---- What a study of designs came to: text, tables, a record, pictures, a report. */

/* The study was opened with this definition, and run or looked up. `name`: name of the study. Output is appended to
 * `out`. KM_USAGE: an argument is missing; KM_IO: the store can't be read; KM_MEMORY. */
/* Tables of figures of merit, with the best marked; statistics of a sample; what an optimisation found. */
KM_API km_status km_designs_print(km_design_study *study, const km_design_study_def *def, const char *name,
                                  km_text *out, km_error *error);
/* Every design as one row: number, name, parameters, outcome, figures. */
KM_API km_status km_designs_csv(const km_design_study *study, const km_design_study_def *def, km_text *out,
                                km_error *error);
/* The study as JSON record with statistics, in the arena. */
KM_API km_status km_designs_record(km_design_study *study, const km_design_study_def *def, const char *name,
                                   km_arena *arena, km_value **out, km_error *error);
/* "as built", "pivot=33, crank=0.6", "17": what a design is called. Nothing if there is no such design. */
KM_API void km_design_label(const km_design_study *study, const km_design_study_def *def, int design, km_text *out);

/* Pictures of a study. */
typedef enum km_designs_plot {
  KM_DESIGNS_HISTOGRAM,   /* histogram of a figure, with quantiles and limits */
  KM_DESIGNS_SCATTER,     /* a figure over each parameter's place in its spread: a panel each, the strongest first */
  KM_DESIGNS_CONVERGENCE, /* a figure's mean and its interval over the number of designs */
  KM_DESIGNS_BANDS,       /* quantiles of a question's column over the driver */
  KM_DESIGNS_PROGRESS,    /* goal of an optimisation over the evaluated designs: for each start, and the best so far */
  KM_DESIGNS_FRONT,       /* both goals of all designs, and the front */
  /* a question's answers for all designs over each other; for the start and the best of an optimisation */
  KM_DESIGNS_ANSWERS,
  KM_DESIGNS_PATHS /* the path of the first point that the question traces */
} km_designs_plot;

enum {
  KM_MAX_OVERLAID_DESIGNS = 64 /* number of designs whose answers and paths are drawn */
};

/* Picture of a study. `index`: figure or question; `band`: band of the question. KM_NO_RESULT: nothing to draw;
 * KM_INTERNAL: a failure of the graphics library. O(designs); answers and paths of a question are computed again for
 * KM_MAX_OVERLAID_DESIGNS designs at most. */
KM_API km_status km_designs_picture(km_design_study *study, const km_design_study_def *def, const char *name,
                                    km_designs_plot plot, int index, int band, km_picture_format format, km_text *out,
                                    km_error *error);
/* Report of a study: questions, main table, outcomes of the designs. `header` may be NULL. `html`: one self-contained
 * file, otherwise PDF pages. KM_INTERNAL as above. */
KM_API km_status km_designs_report(km_design_study *study, const km_design_study_def *def, const char *name,
                                   const km_report_header *header, bool html, km_text *out, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
