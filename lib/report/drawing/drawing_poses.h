/* The poses and paths of a drawing, as they are gathered. */
#ifndef KM_REPORT_DRAWING_DRAWING_POSES_H
#define KM_REPORT_DRAWING_DRAWING_POSES_H

#include "report/drawing/drawing.h"

struct km_drawing {
  const km_mechanism *mechanism;
  km_pose *poses; /* [capacity · bodies] */
  size_t count, room;
  km_drawing_trace *paths; /* owned arrays: */
  km_vec3 **points;        /* [path][path_room] */
  size_t path_count, path_room;
};

/* Definition of the drawing, borrowed from both. KM_USAGE: no pose, or a look of another drawing. */
km_status km_drawing_define(const km_drawing *drawing, const km_drawing_look *look, km_drawing_def *out,
                            km_error *error);

/* The bodies' poses [body] at a row of a sweep's table; `q` [coordinate] and the state are used on the way. */
void km_row_pose(const km_mechanism *mechanism, const km_table *table, size_t row, km_state *state, double *q,
                 km_pose *poses);

#endif
