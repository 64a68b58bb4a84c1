/* A plot with the memory that it is made in. */
#ifndef KM_REPORT_CHARTS_CHART_H
#define KM_REPORT_CHARTS_CHART_H

#include "kmech/report.h"
#include "report/plot/plot.h"

struct km_chart {
  km_arena arena;
  km_plot plot;
};

#endif
