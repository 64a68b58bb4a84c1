/* The plane regions that oriented curves bound (docs/theory.md 4.22).
 *
 *   segment    : cubic of Hermite between two points of a curve, p(u), u = 0 … 1
 *   N(p)       = N far away + Σ jump of each curve that a ray from p crosses, against the sense of the crossing
 *   region     = { p : N(p) > 0 },   outline: parts of the curves with N > 0 on one side only
 *   area       = ∮ x dy over the outline, the region on its left;   holes: loops of negative area
 *                N > 0 far away: the whole chart's area more, and one loop is the outer one */
#ifndef KM_SPACE_OUTLINE_H
#define KM_SPACE_OUTLINE_H

#include "base/memory.h"
#include "base/number/cubic.h"

#include <stdbool.h>
#include <stddef.h>

/* A point of a curve. */
typedef struct km_outline_point {
  double place[2];
  double rate[2]; /* derivative of the place by the length of the curve in the configuration space */
  double length;  /* length of the curve from this point to the next; not used at the last one of a piece */
} km_outline_point;

/* A part of a curve whose sides don't change. */
typedef struct km_outline_piece {
  size_t first, count; /* its points */
  int kind, curve;     /* numbers of the caller */
} km_outline_piece;

typedef struct km_outline_segment {
  double c[2][4]; /* coefficients of u^0 to u^3, of x and y */
  double low[2], high[2];
  double turn[2]; /* parameters with y' = 0, ascending; above 1: none */
  double end_y;   /* y(1) without rounding */
  int piece;
} km_outline_segment;

/* Curves cut where they cross or join. */
typedef struct km_curve_net {
  const km_outline_point *points;
  const km_outline_piece *pieces;
  int piece_count;
  int segment_count, *first_segment; /* [piece_count + 1] */
  km_outline_segment *segments;
  double **cuts; /* [piece] parameters of its cuts, ascending: segment of the piece + u; both ends are cuts */
  int *cut_count;
  double size;  /* extent of the points */
  int at_end;   /* N far from all curves: 0 in a plane */
  double whole; /* area of the whole chart, if N > 0 there */
} km_curve_net;

/* A part of the outline, from cut to cut; `from` > `to` where the region is on the curve's right. */
typedef struct km_outline_part {
  int piece, loop;
  double from, to;
} km_outline_part;

typedef struct km_outline {
  km_outline_part *parts; /* [part_count] loop by loop */
  int part_count, loop_count, hole_count;
  double area; /* gaps closed by straight lines */
  double gap;  /* longest gap, where a curve is missing; 0: none; infinity: a loop doesn't close */
} km_outline;

/* Cuts the curves. False when out of memory. O(segments²) where all overlap. */
bool km_curve_net_create(km_curve_net *net, const km_outline_point *points, const km_outline_piece *pieces,
                         int piece_count, km_arena *arena);
/* Place and derivative by u at a parameter of a piece. */
void km_curve_net_place(const km_curve_net *net, int piece, double at, double *place, double *rate);
/* N(p) with jump[piece], what N is on the left of the curve more than on its right. O(segments). */
int km_curve_net_count(const km_curve_net *net, const int *jump, const double *place);
/* Distance of a place from a segment, at the foot u of the perpendicular; infinity where that is beyond the ends, or
 * the place not `within` this distance of the segment's box. */
double km_segment_distance(const km_outline_segment *s, const double *place, double within, double *u);
/* Distance of a place from the curves with a jump, to 1e-6 of the extent. O(segments). */
double km_curve_net_distance(const km_curve_net *net, const int *jump, const double *place);
enum { KM_SEGMENT_CHORDS = 4 };
/* Place of a segment at the start of chord k; KM_SEGMENT_CHORDS: its end. */
void km_segment_chord_point(const km_outline_segment *s, int k, double *place);
/* Least and largest coordinates of the curves with a jump. False: there are none. */
bool km_curve_net_extent(const km_curve_net *net, const int *jump, double *low, double *high);
/* Finds the outline of N > 0. False when out of memory. O(parts · segments + parts²). */
bool km_outline_find(const km_curve_net *net, const int *jump, km_arena *arena, km_outline *out);

/* A square of a chart, or of one of several. */
typedef struct km_square {
  double centre[2], half; /* half: of its side */
  int face;               /* number of the chart */
  double bound;           /* set by the search: no place in it is farther from the boundary */
} km_square;
/* A region in which the place farthest from its boundary is sought. */
typedef struct km_free_region {
  const void *context;
  /* Distance of the square's centre from the boundary, also from outside. Places of a chart whose distance there is x
   * have values that differ by x at most. */
  double (*distance)(const void *context, const km_square *square);
  bool (*is_inside)(const void *context, const km_square *square); /* its centre */
  double accuracy;
} km_free_region;
/* Largest distance from the boundary within the squares and the region, to `accuracy`; a lower bound where that needs
 * more than 20 000 squares, as in a long corridor. 0: none, *best is then kept. O(squares). */
double km_largest_distance(const km_free_region *region, const km_square *first, int first_count, km_square *best);
/* Largest circle in N > 0 that no curve with a jump meets, to 1e-5 of the extent; radius 0: none. A lower bound
 * where that needs more than 20 000 squares, as in a long corridor. O(squares · segments). */
void km_largest_circle(const km_curve_net *net, const int *jump, double *centre, double *radius);
/* Largest rectangle with sides along the axes in N > 0 that no curve with a jump meets, to 1/100 of the extent; width
 * 0: none. False when out of memory. O(100² · segments). */
bool km_largest_rectangle(const km_curve_net *net, const int *jump, km_arena *arena, double *low, double *high);

#endif
