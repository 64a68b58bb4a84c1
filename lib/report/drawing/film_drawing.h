/* Drawings that move: the poses of a drawing as the frames of a film. */
#ifndef KM_REPORT_DRAWING_FILM_DRAWING_H
#define KM_REPORT_DRAWING_FILM_DRAWING_H

#include "report/canvas/film.h"
#include "report/drawing/drawing.h"

/* Every pose of the drawing is a frame, seen from one place at one scale. In a plane each body is a mover (body b the
 * one of index b − 1) that carries what is drawn of it; rods that slide, and everything in space, are drawn anew. Names
 * and the ends of paths follow their points. Meshes aren't drawn. The drawing's width and height are the film's; 0:
 * chosen from the shape. The film's memory is the arena's; the caller closes the film. KM_MEMORY. */
km_status km_drawing_film(const km_drawing_def *drawing, km_arena *arena, km_film *film, km_error *error);

#endif
