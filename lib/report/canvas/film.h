/* Film: an animated picture of groups of shapes that are fixed, moved rigidly, or redrawn in every frame. Code that
 * draws on pages draws films through a recording canvas. Memory failures are recorded in the arena. */
#ifndef KM_REPORT_CANVAS_FILM_H
#define KM_REPORT_CANVAS_FILM_H

#include "base/memory.h"
#include "report/canvas/canvas.h"

typedef struct km_film_shape {
  int style;        /* index into the film's */
  const char *path; /* data of an SVG path, or the text of a line */
  bool text;
  double x, y, length, angle; /* text: start of its baseline, points; angle, radians */
} km_film_shape;

typedef struct km_film_shapes {
  km_film_shape *items;
  size_t count, capacity;
} km_film_shapes;

/* Carries a group along, frame by frame: turned about its own origin, then moved. */
typedef struct km_film_mover {
  double *x, *y; /* [frame] points */
  double *angle; /* [frame] degrees, clockwise on the page; NULL: it doesn't turn */
} km_film_mover;

enum { KM_FILM_STANDS = -1, KM_FILM_DRAWN = -2 };

typedef struct km_film_group {
  int mover;              /* mover of the group, or KM_FILM_STANDS or KM_FILM_DRAWN */
  bool names;             /* text that may be switched off */
  km_film_shapes *shapes; /* [frame] of what is drawn anew; else one */
} km_film_group;

/* Style of a shape: CSS declarations for light and for dark background. */
typedef struct km_film_style {
  const char *light, *dark;
} km_film_style;

typedef struct km_film {
  km_arena *arena;
  double width, height; /* points */
  size_t frame_count;
  km_film_mover *movers;
  size_t mover_count, mover_capacity;
  km_film_group *groups; /* groups in painting order */
  size_t group_count, group_capacity;
  km_film_style *styles;
  size_t style_count, style_capacity;
  km_canvas_recorder recorder;
  km_canvas *canvas;    /* records into `into`; freed by km_film_close */
  km_film_shapes *into; /* index of the current group */
} km_film;

/* Creates an empty film of `frame_count` frames and its canvas. KM_MEMORY. */
km_status km_film_open(km_film *film, km_arena *arena, double width, double height, size_t frame_count,
                       km_error *error);
/* Returns the first failure of drawing. KM_MEMORY, KM_IO (a text needs Pango, which isn't installed). */
km_status km_film_end(km_film *film, km_error *error);
/* Frees the canvas; the film stays with its arena. */
void km_film_close(km_film *film);

/* Adds a mover, whose arrays the caller fills; NULL when out of memory. Valid until the next. */
km_film_mover *km_film_add_mover(km_film *film, bool turns);
/* Begins the next group: what is drawn on the canvas from now on belongs to it, or to its first frame. */
km_film_group *km_film_begin(km_film *film, int mover);
/* Starts a frame of the current group. */
void km_film_frame(km_film *film, size_t frame);

#endif
