/* Answers as plots, and reports about them. */
#ifndef KMECH_PICTURES_H
#define KMECH_PICTURES_H

#include "kmech/history.h"
#include "kmech/picture_format.h"
#include "kmech/question.h"
#include "kmech/text.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One of the answers that share a plot. Everything is borrowed. */
typedef struct km_answered {
  const km_question *question; /* with an answer */
  const char *name;            /* of the model, or the variant */
  const int *shown;            /* [shown_count] the coordinates whose curves are drawn; NULL: by default all, of several
                                * answers the driver's */
  int shown_count;
} km_answered;

/* Answers of several models or variants in one plot. */
typedef struct km_comparison {
  const km_answered *answers; /* all to questions of one kind */
  int count;                  /* of the answers */
  bool ordered;               /* variants, whose order the colours show; else models, whose colours differ most */
} km_comparison;

/* One of the tables that share a plot. Everything is borrowed. */
typedef struct km_plotted_table {
  const km_table *table; /* with the columns */
  const char *name;      /* as the plot calls it */
  size_t x;              /* the column across */
  const size_t *y;       /* [columns] those upwards: the same columns of every table, with the same units */
} km_plotted_table;

/* What to show of a history's table, or of some of its rows. Everything is borrowed. */
typedef struct km_plotted_history {
  const km_mechanism *mechanism; /* whose coordinates the columns are */
  const km_table *table;         /* its rows, all or some */
  const km_crossing *crossings;  /* of the definition, */
  const km_crossing_met *met;    /* and those that were met: marked in the plot */
  int met_count;
  const char *name; /* of the model */
  const int
      *joints; /* [joint_count] coordinates whose curves are drawn; NULL: up to eight that move most for their kind */
  int joint_count;
} km_plotted_history;

/* A plot, which is drawn as often as is wanted. It borrows what it was made of. */
typedef struct km_chart km_chart;
KM_API void km_chart_free(km_chart *chart);

/* Each of these makes a plot; the caller frees `*out`. KM_USAGE: something is missing, an index is out of range; KM_MEMORY.
 * O(rows · columns). */
/* Of answers. KM_USAGE: also without an answer. */
KM_API km_status km_question_chart(const km_comparison *comparison, km_chart **out, km_error *error);
/* Of columns of tables. Those of one unit share a panel, others stand in panels above each other. The scales of x and y
 * are equal where both are lengths and the curve is one in a plane: coordinates of points, or an x that goes forth and
 * back. Numbers that aren't finite break a curve. */
KM_API km_status km_table_chart(const km_plotted_table *tables, int count, int columns, km_chart **out,
                                km_error *error);
/* Of a motion over time: coordinates and rates by unit, driving forces, mobility numbers where the table has them,
 * energies. KM_USAGE: also where the table isn't km_history_run's of this mechanism. */
KM_API km_status km_history_chart(const km_plotted_history *history, km_chart **out, km_error *error);
/* Of a prescribed motion (km_inverse_run): driving forces, shaking force, coordinates. */
KM_API km_status km_inverse_chart(const km_plotted_history *history, km_chart **out, km_error *error);

/* Appends the picture's bytes to `out`, which stays as it was with any status but KM_OK. KM_USAGE, KM_MEMORY, KM_INTERNAL
 * (the graphics library's own failure). */
KM_API km_status km_chart_picture(const km_chart *chart, km_picture_format format, km_text *out, km_error *error);

/* The report about an answer to "advantage", asked with `transmission`, or to "forces": poses, curves, tables. `stopped_by`:
 * km_sweep_stop_text. `html`: one file that needs no other, else PDF pages. Appends the bytes. KM_USAGE: there is no
 * report about this question, or no answer; KM_MEMORY, KM_INTERNAL. */
KM_API km_status km_question_report(const km_answered *answer, const char *stopped_by, bool html, km_text *out,
                                    km_error *error);

#ifdef __cplusplus
}
#endif
#endif
