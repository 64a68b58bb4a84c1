/* What the files of kmob draw share. */
#ifndef KMOB_DRAW_H
#define KMOB_DRAW_H

#include "common/asked.h"
#include "kmob/kmob.h"
#include "report/drawing/drawing.h"

typedef struct kmob_draw_options {
  kt_common common;
  kt_texts models, holds, sets, at, traces;
  const char *path, *poses, *view, *size, *format, *base;
  kt_asked asked; /* the motion, where it isn't analysis.sweep */
  kt_formats formats;
  const char *scale, *link_width;
  double drawn_scale; /* of --scale; 0: none */
  double width;       /* of --link-width; 0: as drawn */
  bool bodies, meshes, animate;
} kmob_draw_options;

/* The poses and paths of a picture. */
typedef struct kmob_shots {
  const kmob_draw_options *options;
  int asked; /* poses along the sweep; 0: none */
  kt_pose pose;
  km_pose *poses; /* [count · bodies] */
  size_t count;
  km_drawing_trace *traces;
  km_vec3 **paths; /* [trace] what the traces' points borrow */
  size_t trace_count;
  km_mesh **meshes; /* [body], NULL: not asked for */
  km_text title;
  char name[256];
} kmob_shots;

/* Loads the model and moves it through everything that is asked. KT_PARTIAL: some of it is out of
 * reach. Says what went wrong. Free in any case. */
kt_exit kmob_shots_take(kmob_shots *shots);
/* The motion that the options ask for. Says what is wrong with it. */
kt_exit kmob_shots_plan(const kmob_shots *shots, km_sweep_plan *plan);
/* Makes the paths that the options ask for, empty, with room for so many points. Says what went wrong. */
kt_exit kmob_shots_traces(kmob_shots *shots, size_t points);
/* Moves the model through its motion and writes what plays it: a page, an animated picture. The view is the
 * drawing's. Says what went wrong. */
kt_exit kmob_animate(kmob_shots *shots, const km_drawing *drawing);
/* Writes the outlines of the links that the formats ask for. Says what went wrong. */
kt_exit kmob_write_outlines(const kmob_draw_options *options, const km_drawing *drawing, const char *base);
/* Puts them into the drawing, which borrows them. */
void kmob_shots_show(const kmob_shots *shots, km_drawing *drawing);
void kmob_shots_free(kmob_shots *shots);

#endif
