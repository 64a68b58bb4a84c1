/* The workspace of a map's point while it is searched (docs/theory.md 4.22). */
#ifndef KM_SPACE_MAP_WORKSPACE_H
#define KM_SPACE_MAP_WORKSPACE_H

#include "space/map/map_search.h"
#include "space/outline/outline.h"

/* One side of a piece. */
typedef struct km_piece_side {
  int jump;     /* change of N by the side on the left of the curve's image: 1, −1; 0: outside the ranges */
  int aspect;   /* 0: not found */
  int signs[2]; /* signs of det A and det (J; G); 0: not found */
} km_piece_side;

typedef struct km_workspace_search {
  km_map_search *g;
  const km_curve_point *points;
  size_t point_count;
  km_outline_point *places;
  km_outline_piece *pieces;
  size_t *source;            /* [places] the curve's point */
  km_piece_side (*sides)[2]; /* [piece] on the left and right of the curve, in the configurations */
  int piece_count;
  int *representative; /* [aspect of the grid] the least of those that are one with it */
  km_curve_net net;
  km_curve_point sample;          /* workspace: a configuration of a piece */
  int *jump;                      /* [piece] workspace */
  double *chord;                  /* [columns × 4] workspace: an interpolant */
  double *M, *K, *nu, *b, *x, *N; /* [columns²] the first two, [columns], [2 · columns] N: workspace */
  int *row;                       /* [columns] workspace */
  bool is_end_reached;            /* grid points are near the end of a sphere's chart */
} km_workspace_search;

/* Finds the workspace of the map's point, with the sheets and curves. */
km_status km_map_find_workspace(km_map_search *g, km_error *error);
/* Turns a sphere's chart so that its end is far from grid points and curves, and fills the tables' chart columns.
 * *is_end_reached: a grid point is nearer to it than any curve. KM_USAGE: the point leaves its surface. O(candidates ·
 * points). */
km_status km_map_choose_chart(km_map_search *g, bool *is_end_reached, km_error *error);
/* Finds both sides of every piece. False when out of memory. */
bool km_piece_sides_find(km_workspace_search *w);
/* Finds ν at a point of a curve (piece_sides.c), in w->nu. */
bool km_piece_find_across(km_workspace_search *w, const km_curve_point *p);
/* True if det A and det (J; G) have these signs at the state's configuration. */
bool km_piece_has_signs(km_workspace_search *w, const int *signs);
/* Makes two aspects one, with the smaller number, in the sides and representatives. */
void km_aspects_join(km_workspace_search *w, int a, int b);
/* Gives aspects without a side that of the side that faces them. False when out of memory. O(their grid points · curve
 * points). */
bool km_facing_sides_join(km_workspace_search *w);
/* Finds the largest cone in a sphere's region N > 0 of w->jump. False when out of memory. O(squares · segments). */
bool km_map_find_largest_cone(km_workspace_search *w, km_aspect_workspace *out);

#endif
