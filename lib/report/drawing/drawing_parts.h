/* Projection, shapes of bodies, and the scene of one configuration, whose items are painted in order. Private to
 * report/drawing. */
#ifndef KM_REPORT_DRAWING_DRAWING_PARTS_H
#define KM_REPORT_DRAWING_DRAWING_PARTS_H

#include "report/drawing/drawing.h"

/* A place on the page; depth grows towards the viewer. All in points. */
typedef struct km_spot {
  double x, y, depth;
} km_spot;

/* Projection of the inertial frame to the page. */
typedef struct km_projection {
  km_vec3 right, up, toward;
  bool planar;      /* the view is along the axes of a planar mechanism */
  const char *name; /* name of the view */
  km_vec3 centre;   /* shown at `middle` */
  km_canvas_point middle;
  double scale; /* points per length unit */
} km_projection;

typedef struct km_extent {
  double low[2], high[2]; /* extent along right and up, about the first point: see km_extent_of */
  km_vec3 origin;
} km_extent;

/* A body by the points that its joints and frames have on it, in its own frame. */
typedef struct km_shape {
  km_vec3 *points; /* no two in one place */
  int count;
  int joints; /* attached to it */
  int colour; /* colour index of the palette */
} km_shape;

typedef enum km_look {
  KM_LOOK_PIN,
  KM_LOOK_ACTUATOR, /* cylinder and rod */
  KM_LOOK_SLIDER,   /* a box on the guide of another body */
  KM_LOOK_WELD,
  KM_LOOK_BALL,
  KM_LOOK_FREE,
  KM_LOOK_SLEEVE,
  KM_LOOK_CROSS,
  KM_LOOK_TABLE,
  KM_LOOK_SCREW
} km_look;

/* Symbol of a joint, the same in all configurations. */
typedef struct km_mark {
  km_look look;
  int guide;     /* 0 or 1: the end whose body guides the other, for what slides */
  double barrel; /* ACTUATOR: length of the cylinder, model's unit */
} km_mark;

typedef enum km_item_kind {
  KM_ITEM_BASE,  /* the ground between three joints or more of a spatial mechanism */
  KM_ITEM_MOUNT, /* ground under a joint: a triangle with hatching */
  KM_ITEM_RAIL,  /* ground along a slide */
  KM_ITEM_PLATE,
  KM_ITEM_BAR,
  KM_ITEM_ROD,
  KM_ITEM_BARREL,
  KM_ITEM_SYMBOL
} km_item_kind;

typedef struct km_item {
  km_item_kind kind;
  int layer;       /* painted first: the lowest */
  int joint, body; /* -1: none */
  km_spot *spots;  /* ends of a bar or rail, corners of a plate, place of a symbol */
  int count;
  double reach;    /* half its width on the page */
  double depth;    /* mean */
  km_spot axis[2]; /* SYMBOL, RAIL: the joint's unit axes on the page; MOUNT: direction of the ground */
} km_item;

/* A body's mesh, prepared for drawing. */
typedef struct km_surface {
  const km_mesh *mesh;  /* NULL: none */
  bool closed;          /* faces that look away are hidden by others */
  bool inwards;         /* the file's faces look inwards */
  unsigned char *shown; /* [triangle] bit k: the edge from corner k on shows */
} km_surface;

/* A flat convex piece of a surface that the viewer sees. */
typedef struct km_face {
  struct km_face *next;
  km_spot *spots;
  int count;
  unsigned shown; /* bit k: the edge from corner k on */
  int body;
  unsigned color; /* that the mesh states, as km_triangle; 0: none */
  km_spot normal; /* unit vector towards the viewer */
  double shade;   /* 0 dark … 1 light */
} km_face;

typedef struct km_scene {
  const km_mechanism *mechanism;
  const km_pose *pose;  /* [body] */
  const km_pose *poses; /* [pose_count · bodies] all poses that are shown: rails reach along them */
  size_t pose_count;
  const km_shape *shapes;
  const km_mark *marks;
  const km_surface *surfaces;
  const km_projection *view;
  km_arena *arena;
  double radius;  /* radius of a pin */
  double fade;    /* 0 full colour, 1 white */
  bool steady;    /* the ground symbol is placed clear of all configurations */
  bool halo;      /* items in front have a white outline */
  km_face *faces; /* faces of the meshes, the farthest first; painted below all items */
  km_item *items;
  size_t count, capacity;
} km_scene;

typedef struct km_label {
  const char *text;
  km_spot at;    /* named element */
  double radius; /* size of the label */
  int colour;    /* colour index of the palette; −2 black */
  km_canvas_point size;
  km_canvas_point box; /* left top corner, once placed */
  bool inside;         /* may lie over its spot */
  bool arrow;          /* its spot is the tail of an arrow to `tip`, which no name may touch */
  km_spot tip;
  bool placed;
  bool veiled; /* lies over a part of the picture: a veil sets it off */
} km_label;

enum { KM_BLACK = -2 };

/* Data shared by all configurations of a drawing. */
typedef struct km_studio {
  const km_drawing_def *drawing;
  km_canvas *canvas;
  km_rectangle place;
  km_arena arena;
  km_shape *shapes;
  km_mark *marks;
  km_surface *surfaces;
  km_projection view;
  km_extent extent;
  double size;   /* scale of letters and lines: 1 on a page of the default size */
  double radius; /* radius of a pin */
} km_studio;

/* Computes all members except drawing, canvas and rectangle. False when out of memory, which the close reports. */
bool km_studio_open(km_studio *studio);
/* The rectangle without the margin for symbols and names. */
km_rectangle km_studio_inner(const km_studio *studio);
enum { KM_LOAD_COLOUR = 1 }; /* colour index of the palette */
/* Tail and tip of a load's arrow on the page; false where the load is 0 or points at the viewer. */
bool km_load_arrow(const km_studio *studio, const km_scene *scene, int load, km_spot out[2]);
void km_studio_draw_loads(const km_studio *studio, const km_scene *scene);
/* A scene of one pose, to be built. */
km_scene km_studio_scene(km_studio *studio, size_t pose, double fade);
/* Lists the labels of a scene without positions: paths, joints, bodies; at most km_studio_most_labels. Returns their
 * number. */
size_t km_studio_labels(const km_studio *studio, const km_scene *scene, km_label *labels);
size_t km_studio_most_labels(const km_studio *studio);
km_font km_studio_font(const km_studio *studio);
void km_studio_draw_traces(km_studio *studio);
void km_studio_draw_trace_point(const km_studio *studio, const km_drawing_trace *trace, km_spot at);
/* Position of a path's point in a scene. */
km_spot km_trace_spot(const km_scene *scene, const km_drawing_trace *trace);
void km_studio_draw(km_studio *studio);
km_status km_studio_close(km_studio *studio, km_error *error);

/* Views. */
km_projection km_view_make(const km_drawing_def *drawing);
km_extent km_extent_of(const km_drawing_def *drawing, const km_shape *shapes, const km_projection *view);
void km_projection_fit(km_projection *view, const km_extent *extent, km_rectangle inner);
km_spot km_project(const km_projection *view, km_vec3 point);
/* A direction on the page: x right, y down, depth. */
km_spot km_project_direction(const km_projection *view, km_vec3 direction);

/* Shapes, independent of the configuration. NULL when out of memory, which the arena records. */
km_shape *km_shapes_make(const km_model *model, km_arena *arena);
km_mark *km_marks_make(const km_model *model, const km_shape *shapes, km_arena *arena);

km_surface *km_surfaces_make(const km_drawing_def *drawing, km_arena *arena);

/* The scene of a pose, in the order of painting. */
void km_scene_build(km_scene *scene);
/* The faces of the scene's meshes, in the order of painting. */
void km_scene_add_faces(km_scene *scene);
/* Orders faces from back to front, splitting some. Cost: n log n to n². */
km_face *km_faces_order(km_face *faces, km_arena *arena);
/* Convex hull of points on the page, which are sorted; hull[2 * count + 1]. Returns the number of corners; 2 if all
 * are collinear. */
int km_convex_hull(km_spot *spots, int count, km_spot *hull);
/* Orders items from back to front. */
void km_scene_order(km_scene *scene);
/* The base lies under everything, ghosts and paths too; then comes the rest. */
void km_scene_paint_base(const km_scene *scene, km_canvas *canvas);
void km_scene_paint(const km_scene *scene, km_canvas *canvas);
void km_item_paint(const km_scene *scene, km_canvas *canvas, const km_item *item);
/* Position of a joint's symbol. */
km_vec3 km_joint_place(const km_scene *scene, int joint);
/* True if both bodies of a joint have meshes: then no cylinder and rod are drawn. */
bool km_joint_is_solid(const km_scene *scene, int joint);
/* Half the size of a joint's symbol on the page. */
double km_symbol_reach(const km_scene *scene, int joint);
km_pose km_joint_frame(const km_scene *scene, int joint, int end);

/* Painting. */
km_colour km_mix(km_colour colour, km_colour other, double part);
km_colour km_faded(const km_scene *scene, km_colour colour);
void km_face_paint(const km_scene *scene, km_canvas *canvas, const km_face *face);
void km_symbol_paint(const km_scene *scene, km_canvas *canvas, const km_item *item);
/* Unit vector across a rail towards the ground. */
km_spot km_rail_side(const km_item *rail);
void km_ground_paint(const km_scene *scene, km_canvas *canvas, const km_item *item);

/* Places labels without overlaps of each other and, where possible, of the scene. Labels without a place are
 * omitted. */
void km_labels_place(km_canvas *canvas, const km_scene *scene, const km_drawing_trace *traces, size_t trace_count,
                     km_label *labels, size_t count, const km_font *font, km_rectangle place);
/* Draws a placed label, with a leader if it is away from its element. */
void km_label_paint(km_canvas *canvas, const km_label *label, const km_font *font);

static inline double km_spot_distance(km_spot a, km_spot b) {
  return hypot(a.x - b.x, a.y - b.y);
}
/* a + s·b */
static inline km_canvas_point km_page(km_spot a, double s, km_spot b) {
  return (km_canvas_point){a.x + s * b.x, a.y + s * b.y};
}

#endif
