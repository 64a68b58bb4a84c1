/* Plots with marks that move along their curves. */
#ifndef KM_REPORT_PLOT_FILM_PLOT_H
#define KM_REPORT_PLOT_FILM_PLOT_H

#include "report/canvas/film.h"
#include "report/plot/plot.h"

/* A film of the plot, without its strip, in which frame f marks row f of every series: a line across each panel at its
 * x, and a dot on each coloured curve (a mover each, panel by panel, line first). A dot whose number isn't drawn in a
 * frame is outside the page there. All series have a row for each frame. The caller closes the film. KM_MEMORY,
 * KM_USAGE. */
km_status km_plot_film(const km_plot *plot, double width, double height, size_t frame_count, km_arena *arena,
                       km_film *film, km_error *error);

#endif
