/* The arm along its path as a film beside the curves of its joints, and as a strip of configurations. */
#ifndef KM_REPORT_DOCUMENT_TRACK_FILM_H
#define KM_REPORT_DOCUMENT_TRACK_FILM_H

#include "report/charts/track_plot.h"
#include "report/document/film_page.h"

/* Its films share the memory of an arena. */
typedef struct km_track_film {
  km_film_page page; /* its title, subtitle and footer are NULL */
  km_film arm, curves;
  const km_film *films[2];
  const char *alt[2];
  km_drawing_def drawing; /* frame by frame */
} km_track_film;

/* Makes the film of the best track: at most 100 of its rows. `stops` (borrowed, by row of the track) are marked on the
 * slider. The caller closes it in any case. KM_MEMORY, KM_IO. */
km_status km_track_film_make(const km_tracks *tracks, const km_motion_stop *stops, size_t stop_count, km_arena *arena,
                             km_track_film *out, km_error *error);
void km_track_film_close(km_track_film *film);
/* Draws a row of six configurations with their places: the context is a km_track_film. */
km_status km_track_film_strip(void *context, km_canvas *canvas, double width, double height, km_error *error);

#endif
