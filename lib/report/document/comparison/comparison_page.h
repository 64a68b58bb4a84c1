/* The first page of a report about several models, variants or studies: which figures differ and by how much. */
#ifndef KM_REPORT_DOCUMENT_COMPARISON_COMPARISON_PAGE_H
#define KM_REPORT_DOCUMENT_COMPARISON_COMPARISON_PAGE_H

#include "report/document/comparison/compared_figures.h"

/* Adds the answer in a few sentences and a table of the figures that differ, the best value of each marked.
 * `kind`, `kinds`: "variant" and "variants", or other words for one and for several. */
void km_comparison_page_add(km_document_maker *maker, const char *const *names, int count, const char *kind,
                            const char *kinds, const km_compared_rows *rows);
/* One of the tables whose curves are compared. */
typedef struct km_compared_table {
  const char *name;
  const km_table *table;
  int x; /* column across; -1: none */
} km_compared_table;
/* Adds a picture of the columns whose figures differ most, with the curves of all tables. `ordered`: variants,
 * whose order the colours show. */
void km_comparison_curves_add(km_document_maker *maker, const km_compared_table *tables, int count, bool ordered,
                              const km_compared_rows *rows, const char *x_label);
/* Columns of the figures that differ most, each once; at most `most`. Returns their number. */
size_t km_comparison_columns(const km_compared_rows *rows, const char **columns, size_t most);

#endif
