/* The first page of a report about several models, variants or studies: which figures differ and by how much. */
#ifndef KM_REPORT_DOCUMENT_COMPARISON_PAGE_H
#define KM_REPORT_DOCUMENT_COMPARISON_PAGE_H

#include "report/document/compared_figures.h"

/* Adds the answer in a few sentences and a table of the figures that differ, the best value of each marked.
 * `kind`: "variant" or "model", as one of them is called. */
void km_comparison_page_add(km_document_maker *maker, const char *const *names, int count, const char *kind,
                            const km_compared_rows *rows);
/* Columns of the figures that differ most, each once; at most `most`. Returns their number. */
size_t km_comparison_columns(const km_compared_rows *rows, const char **columns, size_t most);

#endif
