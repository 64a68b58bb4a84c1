/* Pictures of tracks. */
#ifndef KM_REPORT_PLOT_TRACK_PLOT_H
#define KM_REPORT_PLOT_TRACK_PLOT_H

#include "report/plot/plot.h"
#include "report/record/track_record.h"

/* Joint angles with their limits, path-control entries, objectives, limit margin and tracking error over the path,
 * on one page; of several methods side by side. KM_USAGE, KM_MEMORY, KM_INTERNAL. */
km_status km_tracks_plot(const km_tracks *tracks, km_canvas_format format, km_text *out, km_error *error);
/* The page's plots before they are rendered, in the arena. Returns their number, 0 when out of memory. */
enum { KM_TRACK_PLOTS = 8 };
size_t km_tracks_plots_make(const km_tracks *tracks, km_arena *arena, km_plot *out);
/* The arm along the first complete track (or the longest), with the effector's path. */
km_status km_tracks_draw(const km_tracks *tracks, km_canvas_format format, km_text *out, km_error *error);

#endif
