/* The map of self-motions as a picture. */
#ifndef KM_REPORT_PLOT_MOTION_MAP_PLOT_H
#define KM_REPORT_PLOT_MOTION_MAP_PLOT_H

#include "report/plot/canvas.h"
#include "report/record/track_record.h"

/* Self-motion over path length, coloured by the objective, hatched where a joint is outside its limits, the tracks
 * drawn over it. KM_USAGE (not one spare freedom), KM_MEMORY, KM_INTERNAL. */
km_status km_motion_map_plot(const km_tracks *tracks, km_canvas_format format, km_text *out, km_error *error);

#endif
