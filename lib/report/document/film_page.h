/* A page on which films play: one HTML file that needs no other. */
#ifndef KM_REPORT_DOCUMENT_FILM_PAGE_H
#define KM_REPORT_DOCUMENT_FILM_PAGE_H

#include "kmech/report.h"
#include "report/canvas/film.h"

/* Everything is borrowed. */
typedef struct km_film_page {
  const char *title, *subtitle, *footer;
  const km_film *const *films; /* played together: the same number of frames */
  const char *const *alt;      /* [film] alternative text */
  size_t film_count;
  const char *quantity, *unit; /* name and unit of the slider's variable; unit may be "" */
  const double *values;        /* [frame] of it */
  const km_motion_stop *stops;
  size_t stop_count;
  bool closed;    /* the last frame looks as the first: the film goes round; else forth and back */
  double seconds; /* [frame] values of the slider */
} km_film_page;

/* Appends the page. Equal films give equal bytes. KM_MEMORY. */
km_status km_film_page_write(const km_film_page *page, km_text *out, km_error *error);

/* The parts of such a page for a document with films: rules of its style sheet, the films with their controls, and
 * behind these the data with the script. A document holds them once. */
void km_film_styles_write(const km_film_page *page, km_text *out);
void km_film_write(const km_film_page *page, km_text *out);
void km_film_script_write(const km_film_page *page, km_text *out);

/* Style sheets of a page and of the films on it, and the script, which plays what the data say. */
extern const char km_film_page_sheet[], km_film_sheet[], km_film_script[];

#endif
