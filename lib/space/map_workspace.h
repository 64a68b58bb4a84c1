/* The workspace of a map's point while it is searched (docs/theory.md 4.22). */
#ifndef KM_SPACE_MAP_WORKSPACE_H
#define KM_SPACE_MAP_WORKSPACE_H

#include "space/map_search.h"
#include "space/outline.h"

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
  double *M, *K, *nu, *b, *x, *N; /* [columns²] the first two, [columns], [2 · columns] N: workspace */
  int *row;                       /* [columns] workspace */
  km_vec3 normal;
  double height; /* place of the plane along its normal */
} km_workspace_search;

/* Finds the workspace of the map's point, with the sheets and curves. */
km_status km_map_find_workspace(km_map_search *g, km_error *error);
/* Finds both sides of every piece. False when out of memory. */
bool km_piece_sides_find(km_workspace_search *w);

#endif
