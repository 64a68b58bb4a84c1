/* Data of kmob draw. */
#ifndef KMOB_DRAW_H
#define KMOB_DRAW_H

#include "common/command_line/question_options.h"
#include "kmech/report.h"
#include "kmob/kmob.h"

typedef struct kmob_draw_options {
  kt_common common;
  kt_texts models, holds, sets, at, traces;
  const char *path, *poses, *view, *size, *format, *base;
  kt_question asked; /* the motion, where it isn't analysis.sweep */
  kt_formats formats;
  const char *scale, *link_width;
  double drawn_scale;   /* --scale; 0: none */
  double width;         /* --link-width; 0: as drawn */
  km_drawing_look look; /* view, size, names of bodies */
  bool meshes, animate;
} kmob_draw_options;

/* The poses and paths of a picture. */
typedef struct kmob_shots {
  const kmob_draw_options *options;
  int asked; /* poses along the sweep; 0: none */
  kt_pose pose;
  km_drawing *drawing;
  km_meshes *meshes; /* NULL: not requested */
  km_text title;
  char name[256];
} kmob_shots;

/* Reads the model and computes all requested configurations and paths. KT_PARTIAL: some can't be reached. Reports
 * errors. Free in any case. */
kt_exit kmob_shots_compute(kmob_shots *shots);
/* Creates the question for the requested motion, which the caller frees, and its plan. Reports errors. */
kt_exit kmob_shots_question(const kmob_shots *shots, km_question **question, km_sweep_plan *plan);
/* Begins the requested paths. Reports errors. */
kt_exit kmob_shots_paths(kmob_shots *shots);
/* Moves the model through its motion and writes what plays it: a page, an animated picture. Says what went wrong. */
kt_exit kmob_animate(kmob_shots *shots);
/* Writes the outlines of the links in the requested formats. Reports errors. */
kt_exit kmob_write_outlines(const kmob_draw_options *options, const km_drawing *drawing, const char *base);
/* Style of the drawing; borrowed. */
km_drawing_look kmob_shots_style(const kmob_shots *shots);
void kmob_shots_free(kmob_shots *shots);

#endif
