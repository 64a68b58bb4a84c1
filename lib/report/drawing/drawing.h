/* Pictures of a mechanism: joints by the symbols of textbooks, links as bars and plates, in one or
 * more poses. */
#ifndef KM_REPORT_DRAWING_DRAWING_H
#define KM_REPORT_DRAWING_DRAWING_H

#include "kinematics/state.h"
#include "kmech/report.h"
#include "model/geometry/mesh.h"
#include "report/canvas/canvas.h"

/* The path of a point, in the inertial frame. */
typedef struct km_drawing_trace {
  int frame; /* body of the model; its position in the full configuration has the name */
  const char *name;
  const km_vec3 *points;
  size_t count;
} km_drawing_trace;

typedef struct km_rectangle {
  double left, top, width, height; /* points */
} km_rectangle;

/* Definition of a drawing. Everything is borrowed; 0 is the default of the members after pose_count. */
typedef struct km_drawing_def {
  const km_mechanism *mechanism;
  const km_pose *poses; /* [pose_count · bodies] bodies in the inertial frame, pose by pose */
  size_t pose_count;    /* all of them fit into the picture */
  size_t full;          /* the pose that is drawn in full */
  bool alone;           /* the others aren't drawn at all, not even as ghosts */
  bool steady;          /* the ground has one shape for all poses: for pictures that follow each other */
  const km_drawing_trace *traces;
  size_t trace_count;
  const km_mesh *const *meshes; /* [body] drawn instead of its bars and plates; NULL: none of it, or of any */
  km_view view;
  bool bodies;              /* names them too */
  bool loads;               /* the model's loads as arrows, in the full pose */
  bool bare;                /* true: without names */
  const char *title, *name; /* title; the model's name. km_drawing_render only */
  double width, height;     /* size in points; 0: by the shape. km_drawing_render only */
} km_drawing_def;

/* Appends a page with the drawing, its title, scale bar and axes to `out`. Equal drawings give equal bytes. KM_USAGE
 * (a page too small or too large), KM_MEMORY, KM_INTERNAL. */
km_status km_drawing_render(const km_drawing_def *drawing, km_picture_format format, km_text *out, km_error *error);

/* Draws into a rectangle of a page, nothing around it. Drawings that differ only in `full` share
 * scale and view: with `alone`, a row of them shows a motion. KM_MEMORY. */
km_status km_drawing_place(const km_drawing_def *drawing, km_canvas *canvas, km_rectangle place, km_error *error);
/* Several mechanisms over each other, each as drawings[k].full has it, in one view and at one scale: their links as
 * lines of the palette's colours[k], the ground of the first. They fit into the place in all their poses. KM_MEMORY. */
km_status km_drawing_overlay(const km_drawing_def *drawings, const int *colours, int count, km_canvas *canvas,
                             km_rectangle place, km_error *error);

/* True if the view is along the axes of a mechanism that moves in a plane. */
bool km_drawing_def_is_planar(const km_drawing_def *drawing);

#endif
