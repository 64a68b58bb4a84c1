/* Figures of merit that reports of several models, variants or studies compare. */
#ifndef KM_REPORT_DOCUMENT_COMPARISON_COMPARED_FIGURES_H
#define KM_REPORT_DOCUMENT_COMPARISON_COMPARED_FIGURES_H

#include "kmech/report.h"
#include "report/document/document.h"

/* Side of a figure on which it is better. */
typedef enum km_better { KM_BETTER_LESS = -1, KM_BETTER_NEITHER, KM_BETTER_MORE } km_better;

/* A figure of one of the compared things. */
typedef struct km_compared_figure {
  const char *name; /* "largest acceleration of C" */
  const char *unit; /* "" : none */
  double value;     /* NaN: none */
  km_better better;
  const char *column; /* column of the table whose curve it belongs to; NULL: none */
  bool secondary;     /* listed after the others: a reaction of one of many joints */
} km_compared_figure;

enum { KM_MOST_COMPARED = 96 };
typedef struct km_compared_figures {
  km_compared_figure items[KM_MOST_COMPARED];
  size_t count;
} km_compared_figures;

/* Adds a figure; those past KM_MOST_COMPARED are left out. */
void km_compared_add(km_compared_figures *out, km_compared_figure figure);
/* Lists the figures of an answer: swings, velocities, accelerations and paths of a motion; advantage and transmission
 * angles; forces of actuators and reactions; driving forces, energies and bearing loads over time. */
void km_compared_list(km_document_maker *maker, const km_answered *answer, km_compared_figures *out);

/* A figure of all compared things. */
typedef struct km_compared_row {
  const km_compared_figure *figure; /* its name, unit and column */
  double *values;                   /* [things], NaN: none */
  double low, high;                 /* least and greatest value */
  double spread;                    /* (high − low) / max(|high|, |low|); 1 where only some have a finite value */
  int best;                         /* thing with the best value; -1: neither side is better, or all are equal */
} km_compared_row;

/* Figures of all things by name and unit: those that differ, then those that are equal. Those that differ are
 * ordered by spread: first the greatest of each kind ("swing of …"), then the other primary ones, then the secondary ones. */
typedef struct km_compared_rows {
  km_compared_row *items; /* [count] */
  size_t count;
  size_t different; /* the first ones, which differ by more than their digits */
} km_compared_rows;

/* Merges the figures of `count` things. Figures that are 0 by nature, beside others of their unit, are left out. Empty
 * when out of memory (arena.failed). */
km_compared_rows km_compared_merge(km_document_maker *maker, const km_compared_figures *figures, int count);

#endif
