/* Drawings that move: the poses of a drawing as the frames of a film. */
#ifndef KM_REPORT_DRAWING_FILM_DRAWING_H
#define KM_REPORT_DRAWING_FILM_DRAWING_H

#include "report/canvas/film.h"
#include "report/drawing/drawing.h"

/* Makes a film whose frames are the poses of the drawing, in one view at one scale. Each body of a planar mechanism
 * is a mover (body b has index b − 1) that moves its shapes; sliding rods, and everything in space, are redrawn.
 * Names and ends of paths follow their points. Meshes aren't drawn. The film has the drawing's width and height; 0:
 * by the shape. The film's memory is the arena's; the caller closes the film. KM_MEMORY. */
km_status km_drawing_film(const km_drawing_def *drawing, km_arena *arena, km_film *film, km_error *error);

#endif
