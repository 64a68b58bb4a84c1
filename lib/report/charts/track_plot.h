/* Pictures of tracks. */
#ifndef KM_REPORT_CHARTS_TRACK_PLOT_H
#define KM_REPORT_CHARTS_TRACK_PLOT_H

#include "report/drawing/drawing.h"
#include "report/plot/plot.h"
#include "report/record/track_record.h"

/* KM_USAGE unless these are tracks that can be drawn, in a picture of this format. `some`: at least one with rows. */
km_status km_check_tracks(const km_tracks *tracks, bool some, km_picture_format format, const km_text *out,
                          km_error *error);
/* The page's plots before they are rendered, in the arena; `diagnostics`: also entries of the path-control column and
 * tracking errors. Returns their number, 0 when out of memory. */
enum { KM_TRACK_PLOTS = 8 };
size_t km_tracks_plots_make(const km_tracks *tracks, bool diagnostics, km_arena *arena, km_plot *out);
/* Drawing of the arm along the best track with the effector's path, in the arena, in at most `poses` poses: pose i is
 * that of row km_track_row. KM_MEMORY. */
enum { KM_TRACK_POSES = 6 };
km_status km_tracks_drawing_make(const km_tracks *tracks, size_t poses, km_arena *arena, km_drawing_def *out,
                                 km_error *error);
/* The row of one of several evenly spaced poses; the last one is the last row's. */
size_t km_track_row(const km_track *track, size_t pose, size_t poses);

#endif
