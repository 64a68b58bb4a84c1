/* Running several methods, and delivering what they give. */
#ifndef KREDUND_TRACKS_H
#define KREDUND_TRACKS_H

#include "kmech/report.h"
#include "kredund/kredund.h"

typedef struct kredund_tracks {
  const kredund_request *request;
  const kredund_open *open;
  kt_formats formats;
  km_track **items;
  int count, complete;
  bool map;      /* true: map of self-motions instead of a drawing of the arm */
  km_tracks all; /* name for the reports */
} kredund_tracks;

/* Runs every method of the study; KT_PARTIAL: none comes to the path's end. The caller frees it in any case. */
kt_exit kredund_tracks_run(kredund_tracks *tracks);
void kredund_tracks_free(kredund_tracks *tracks);
typedef km_status (*kredund_draw)(const km_tracks *, km_picture_format, km_text *, km_error *);
kt_exit kredund_tracks_picture(const kredund_tracks *tracks, const char *base, const char *word, kt_format format,
                               kredund_draw draw);
/* Writes a table as BASE.WORD.csv and BASE.WORD.xlsx, as the formats say. */
kt_exit kredund_write_table(const kredund_request *request, const kt_formats *formats, const char *base,
                            const char *word, const km_table *table);
/* Tables and pictures by the formats; the summary on the standard output. */
kt_exit kredund_tracks_deliver(kredund_tracks *tracks, const char *base);

/* Opens the study of the request, runs its methods and delivers what they give; `map` as in kredund_tracks. */
kt_exit kredund_tracks_command(const kredund_request *request, kt_formats formats, bool map);

/* Options of the commands that run methods, for --help and for reading; `all` includes those that a command adds.
 * False: a usage error, reported. */
bool kredund_tracks_read(kt_options *all, const char *about, int argc, char **argv, kredund_request *request,
                         kt_formats *formats);
#endif
