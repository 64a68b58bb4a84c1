/* A plot with the memory that it is made in. */
#ifndef KM_REPORT_CHARTS_CHART_H
#define KM_REPORT_CHARTS_CHART_H

#include "kmech/report.h"
#include "report/plot/plot.h"

struct km_chart {
  km_arena arena;
  km_plot plot;
};

/* KM_USAGE unless there is a place for the bytes and the format is one. */
km_status km_check_picture(const km_text *out, km_picture_format format, km_error *error);

#endif
