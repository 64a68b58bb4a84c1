/* Drawings of a mechanism: joints by the symbols of textbooks, links as bars and plates, in one pose or several; the same
 * as moving pictures, as outlines of links, and its graph.
 *
 *   km_drawing_create(mechanism, &drawing, &error);
 *   km_poses_update(mechanism, state);
 *   km_drawing_add_pose(drawing, mechanism, state, &error);
 *   km_drawing_picture(drawing, &(km_drawing_look){.title = "Brake"}, KM_PICTURE_SVG, &text, &error);
 *   km_drawing_free(drawing);
 */
#ifndef KMECH_DRAWING_H
#define KMECH_DRAWING_H

#include "kmech/mechanism.h"
#include "kmech/picture_format.h"
#include "kmech/pictures.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The poses that a drawing shows, and the paths of points. */
typedef struct km_drawing km_drawing;

/* Of a mechanism, which must outlive it; without a pose yet. The caller frees `*out`. KM_USAGE, KM_MEMORY. */
KM_API km_status km_drawing_create(const km_mechanism *mechanism, km_drawing **out, km_error *error);
KM_API void km_drawing_free(km_drawing *drawing);
/* Adds the pose of a state, after km_poses_update. The state's mechanism may be another one of the same model, with other
 * holds. KM_USAGE, KM_MEMORY. O(bodies). */
KM_API km_status km_drawing_add_pose(km_drawing *drawing, const km_mechanism *mechanism, const km_state *state,
                                     km_error *error);
/* Adds the poses of all rows of a table with the columns q. of every coordinate, such as a sweep's or a history's, and
 * leads the paths through them. KM_USAGE: it has other columns; KM_MEMORY. O(rows · bodies). */
KM_API km_status km_drawing_add_rows(km_drawing *drawing, const km_table *table, km_error *error);
/* Draws the path of a frame's origin, too; empty until it is led on. `name` is borrowed. KM_USAGE, KM_MEMORY. */
KM_API km_status km_drawing_add_path(km_drawing *drawing, int frame, const char *name, km_error *error);
/* Leads every path on to where its frame is, after km_poses_update; else as km_drawing_add_pose. */
KM_API km_status km_drawing_lead_paths(km_drawing *drawing, const km_mechanism *mechanism, const km_state *state,
                                       km_error *error);
/* How many poses there are; 0 without a drawing. */
KM_API int km_drawing_poses(const km_drawing *drawing);
/* Does every body end where it began, in poses that went elsewhere between? False with fewer than three. */
KM_API bool km_drawing_comes_round(const km_drawing *drawing);

/* From where it is seen. AUTO is the plane in which the mechanism moves, or ISO where it moves in none. */
typedef enum km_view {
  KM_VIEW_AUTO, /* chosen */
  KM_VIEW_XY,   /* along z */
  KM_VIEW_XZ,   /* along y */
  KM_VIEW_YZ,   /* along x */
  KM_VIEW_ISO   /* from x, y and z alike */
} km_view;
/* "xy", "iso", "auto" …; false if the word is no view. */
KM_API bool km_view_find(const char *word, km_view *view);
/* Does the view look along the axes of a mechanism that moves in a plane? False without a pose. */
KM_API bool km_drawing_is_planar(const km_drawing *drawing, km_view view);

/* The meshes and shapes of a model's bodies. */
typedef struct km_meshes km_meshes;
/* KM_USAGE: no body has one; KM_IO: a file can't be found or read; KM_MEMORY. The caller frees `*out`. */
KM_API km_status km_model_read_meshes(const km_model *model, km_meshes **out, km_error *error);
KM_API void km_meshes_free(km_meshes *meshes);

/* How a drawing looks. Everything is borrowed; start from {0}. */
typedef struct km_drawing_look {
  km_view view;             /* from where it is seen */
  const km_meshes *meshes;  /* of the mechanism's model, drawn instead of bars and plates; NULL: none */
  bool bodies;              /* names them, too */
  bool loads;               /* the model's loads as arrows */
  const char *title, *name; /* what is shown; the model's name. May be NULL */
  double width, height;     /* points (1/72 inch); 0: chosen from the shape */
} km_drawing_look;

/* Each of these appends a file's bytes to `out`, which stays as it was with any status but KM_OK. KM_USAGE: there is no
 * pose, or a page would be too small or too large; KM_MEMORY; KM_INTERNAL. */
/* A page with the first pose in full and the others pale, the paths, title, scale bar and axes. */
KM_API km_status km_drawing_picture(const km_drawing *drawing, const km_drawing_look *look, km_picture_format format,
                                    km_text *out, km_error *error);
/* An animated PNG of at most 73 of the poses: round and round where they come round, else forth and back, in `seconds` from
 * the first to the last. Names of joints are left out. */
KM_API km_status km_drawing_apng(const km_drawing *drawing, const km_drawing_look *look, double seconds, km_text *out,
                                 km_error *error);

/* The links of a mechanism that moves in a plane as they could be cut, in the first pose: each body as wide as `width` about
 * its points (model's length unit; 0: as drawn, two digits of it), with a hole of half that at every hinge; the inertial
 * frame has holes alone. A page on which a length is `scale` times as long as it is; and the same in AutoCAD's exchange
 * format (release 12) as lines, arcs and circles in the model's length unit, a layer for each body. KM_USAGE: also where
 * the mechanism moves in no plane of this view. */
KM_API km_status km_drawing_outlines(const km_drawing *drawing, km_view view, double width, double scale,
                                     km_picture_format format, km_text *out, km_error *error);
KM_API km_status km_drawing_dxf(const km_drawing *drawing, km_view view, double width, km_text *out, km_error *error);

/* A named place on a motion's slider. */
typedef struct km_motion_stop {
  double pose;      /* between poses, too */
  const char *name; /* what stands there */
} km_motion_stop;

/* A page that plays the poses, with a slider. Everything is borrowed; start from {0}. */
typedef struct km_motion_page {
  const char *title, *subtitle, *footer; /* its headings and its last line; may be NULL */
  const char *quantity, *unit;           /* what the slider moves; unit may be "" */
  const double *values;                  /* [poses] of it */
  const km_motion_stop *stops;           /* marked on the slider */
  size_t stop_count;
  bool closed;           /* the last pose is followed by the first; else it goes forth and back */
  double seconds;        /* from the first pose to the last */
  const km_chart *chart; /* played beside it: every curve has a row for each pose; NULL: none */
  const char *chart_alt; /* what the chart shows, for those who can't see it */
} km_motion_page;
/* One HTML file that needs no other. Meshes aren't drawn. Of the look, view, bodies and size count. KM_USAGE: also without
 * values. */
KM_API km_status km_drawing_page(const km_drawing *drawing, const km_drawing_look *look, const km_motion_page *page,
                                 km_text *out, km_error *error);

/* The graph behind a mechanism in the DOT language, for graphviz, appended: bodies by level of the spanning tree, its joints
 * solid, chords dashed. A chord ends at its virtual body, the copy of the body that its loop was cut from. Arrows run from
 * the model's parent to its child, colours tell the substructures. `title` begins the caption. Of more than 300 joints with
 * places, as a tidy tree: graphviz' own take times that grow faster than their number. */
KM_API void km_graph_write(const km_mechanism *mechanism, const char *title, km_text *out);

#ifdef __cplusplus
}
#endif
#endif
