/* The functions of libxlsxwriter, loaded with the first workbook. Private to exchange/xlsx. */
#ifndef KM_EXCHANGE_XLSX_XLSX_LIBRARY_H
#define KM_EXCHANGE_XLSX_XLSX_LIBRARY_H

#include "kmech/base.h"

#include <xlsxwriter.h>

/* clang-format off */
#define KM_XLSX_FUNCTIONS(X)                                                                                           \
  X(chart_add_series) X(chart_axis_set_name) X(chart_series_set_categories)                                            \
  X(chart_series_set_name_range) X(chart_series_set_values) X(chart_title_set_name) X(chartsheet_set_chart)            \
  X(format_set_bold) X(lxw_strerror) X(workbook_add_chart) X(workbook_add_chartsheet) X(workbook_add_format)           \
  X(workbook_add_worksheet) X(workbook_close) X(workbook_new_opt) X(workbook_set_properties)                           \
  X(worksheet_freeze_panes) X(worksheet_set_column) X(worksheet_write_number) X(worksheet_write_string)
/* clang-format on */

/* A pointer to each of them, under its own name. */
#define X(name) __typeof__(&(name)) name;
typedef struct km_xlsx_functions {
  KM_XLSX_FUNCTIONS(X)
} km_xlsx_functions;
#undef X

/* Loads the library once; thread-safe. NULL with KM_IO if it isn't installed. Never unloaded. */
const km_xlsx_functions *km_xlsx_load(km_error *error);

#endif
