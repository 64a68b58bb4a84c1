/* Paths in the making: lines and curves on a page, in points. */
#ifndef KM_REPORT_CANVAS_CANVAS_PATH_H
#define KM_REPORT_CANVAS_CANVAS_PATH_H

#include "report/canvas/canvas.h"

/* Commands as those of SVG, absolute: 'M' and 'L' take one point, 'Q' two, 'C' three, 'Z' none. Start from {0}. */
typedef struct km_canvas_path {
  char *commands;
  km_canvas_point *points;
  size_t command_count, point_count, command_room, point_room;
  bool failed; /* memory ran out */
} km_canvas_path;

void km_canvas_path_free(km_canvas_path *path);
/* Nothing is in it any more; its memory stays. */
void km_canvas_path_clear(km_canvas_path *path);
void km_canvas_path_add(km_canvas_path *path, char command, const km_canvas_point *points);
void km_canvas_path_rectangle(km_canvas_path *path, double x, double y, double width, double height);
void km_canvas_path_circle(km_canvas_path *path, km_canvas_point centre, double radius);
/* Points that the command takes. */
int km_canvas_path_takes(char command);

#endif
