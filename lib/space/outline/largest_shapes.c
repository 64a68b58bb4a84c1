/* The largest circle and rectangle that no curve meets (space/outline/outline.h).
 *
 *   circle   : max of the distance d(p) from the curves, negative outside, by branch and bound: in a square of half
 *              side h around c, d(p) <= d(c) + h √2
 *   rectangle: the largest one of free cells of a raster, then each side moved out to the next curve */
#include "space/outline/outline.h"

#include <math.h>
#include <string.h>

enum { CHORDS = 4 /* chords of a segment */, RASTER = 100, MOST_SQUARES = 20000, ROUNDS = 4 };
static const double accuracy = 1e-5; /* error of the radius, by the extent */

/* A square of the plane. */
typedef struct plane_square {
  double centre[2], half, bound;
} plane_square;

/* Place of a segment at chord point k, 0 to CHORDS. */
static void chord_point(const km_outline_segment *s, int k, double *place) {
  double u = (double)k / CHORDS;
  place[0] = km_cubic(s->c[0], u);
  place[1] = km_cubic(s->c[1], u);
}

static double square(double x) {
  return x * x;
}

/* Square of the distance from a chord. */
static double square_to_chord(const double *a, const double *b, const double *p) {
  double dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
  double u = length > 0.0 ? ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length : 0.0;
  u = u < 0.0 ? 0.0 : u > 1.0 ? 1.0 : u;
  return square(p[0] - a[0] - u * dx) + square(p[1] - a[1] - u * dy);
}

/* Square of the distance from a segment's box. */
static double square_to_box(const km_outline_segment *s, const double *p) {
  double sum = 0.0;
  for (int d = 0; d < 2; ++d)
    sum += p[d] < s->low[d] ? square(s->low[d] - p[d]) : p[d] > s->high[d] ? square(p[d] - s->high[d]) : 0.0;
  return sum;
}

double km_curve_net_distance(const km_curve_net *net, const int *jump, const double *place) {
  double least = HUGE_VAL;
  for (int i = 0; i < net->segment_count; ++i) {
    const km_outline_segment *s = &net->segments[i];
    double a[2], b[2];
    if (!jump[s->piece] || square_to_box(s, place) >= least)
      continue;
    chord_point(s, 0, a);
    for (int k = 1; k <= CHORDS; ++k) {
      chord_point(s, k, b);
      least = fmin(least, square_to_chord(a, b, place));
      memcpy(a, b, sizeof a);
    }
  }
  return sqrt(least);
}

/* Extent of the curves with a jump. */
static bool extent(const km_curve_net *net, const int *jump, double *low, double *high) {
  low[0] = low[1] = HUGE_VAL;
  high[0] = high[1] = -HUGE_VAL;
  for (int i = 0; i < net->segment_count; ++i)
    for (int d = 0; d < 2 && jump[net->segments[i].piece]; ++d) {
      low[d] = fmin(low[d], net->segments[i].low[d]);
      high[d] = fmax(high[d], net->segments[i].high[d]);
    }
  return low[0] < high[0] && low[1] < high[1];
}

/* Bounds a square, and notes the circle around its centre if it is the largest so far. */
static void visit(const km_curve_net *net, const int *jump, plane_square *s, double *centre, double *radius) {
  double d = km_curve_net_distance(net, jump, s->centre);
  s->bound = d + sqrt(2.0) * s->half;
  if (s->bound <= *radius)
    return;
  bool is_inside = km_curve_net_count(net, jump, s->centre) > 0;
  if (!is_inside)
    s->bound -= 2.0 * d;
  if (!is_inside || d <= *radius)
    return;
  *radius = d;
  memcpy(centre, s->centre, 2 * sizeof *centre);
}

void km_largest_circle(const km_curve_net *net, const int *jump, double *centre, double *radius) {
  static const int side[4][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  plane_square stack[256];
  double low[2], high[2];
  int count = 0;
  *radius = 0.0;
  if (!extent(net, jump, low, high))
    return;
  stack[count] = (plane_square){.centre = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])},
                                .half = 0.5 * fmax(high[0] - low[0], high[1] - low[1])};
  visit(net, jump, &stack[count++], centre, radius);
  for (int visited = 0; count > 0 && visited < MOST_SQUARES;) {
    plane_square s = stack[--count];
    if (s.bound <= *radius + accuracy * net->size)
      continue;
    for (int k = 0; k < 4; ++k, ++visited) {
      plane_square part = {.half = 0.5 * s.half};
      for (int d = 0; d < 2; ++d)
        part.centre[d] = s.centre[d] + side[k][d] * part.half;
      visit(net, jump, &part, centre, radius);
      int at = count++; /* the square with the largest bound of the four comes next */
      for (; at > count - 1 - k && stack[at - 1].bound > part.bound; --at)
        stack[at] = stack[at - 1];
      stack[at] = part;
    }
  }
}

/* Marks the cells of the raster that a curve meets: those in the boxes of its chords. */
static void mark_curves(const km_curve_net *net, const int *jump, const double *low, const double *cell, bool *taken) {
  for (int i = 0; i < net->segment_count; ++i) {
    double p[2][2];
    if (!jump[net->segments[i].piece])
      continue;
    chord_point(&net->segments[i], 0, p[0]);
    for (int k = 1; k <= CHORDS; ++k) {
      int from[2], to[2];
      chord_point(&net->segments[i], k, p[1]);
      for (int d = 0; d < 2; ++d) {
        from[d] = (int)fmax((fmin(p[0][d], p[1][d]) - low[d]) / cell[d], 0.0);
        to[d] = (int)fmin((fmax(p[0][d], p[1][d]) - low[d]) / cell[d], RASTER - 1);
      }
      for (int y = from[1]; y <= to[1]; ++y)
        for (int x = from[0]; x <= to[0]; ++x)
          taken[y * RASTER + x] = true;
      memcpy(p[0], p[1], sizeof p[0]);
    }
  }
}

/* The largest rectangle of free cells: for each row, the heights of the free columns above it. `size`: of a cell. */
static void largest_of_raster(const bool *taken, const double *size, int *from, int *to) {
  int height[RASTER] = {0};
  double largest = 0.0;
  for (int y = 0; y < RASTER; ++y) {
    for (int x = 0; x < RASTER; ++x)
      height[x] = taken[y * RASTER + x] ? 0 : height[x] + 1;
    for (int x = 0; x < RASTER; ++x)
      for (int end = x, least = RASTER; end < RASTER && height[end] > 0; ++end) {
        least = height[end] < least ? height[end] : least;
        double area = (end + 1 - x) * size[0] * least * size[1];
        if (area <= largest)
          continue;
        largest = area;
        from[0] = x;
        to[0] = end + 1;
        from[1] = y + 1 - least;
        to[1] = y + 1;
      }
  }
}

/* Moves one side of the rectangle out to the first curve. */
static void move_side(const km_curve_net *net, const int *jump, int axis, int end, double *low, double *high) {
  int other = 1 - axis;
  double sense = end ? 1.0 : -1.0, middle = 0.5 * (low[axis] + high[axis]), nearest = HUGE_VAL;
  for (int i = 0; i < net->segment_count; ++i) {
    double p[2][2];
    const km_outline_segment *s = &net->segments[i];
    if (!jump[s->piece] || s->low[other] >= high[other] || s->high[other] <= low[other])
      continue;
    chord_point(s, 0, p[0]);
    for (int k = 1; k <= CHORDS; ++k, memcpy(p[0], p[1], sizeof p[0])) {
      chord_point(s, k, p[1]);
      for (int bound = 0; bound < 2; ++bound) { /* the chord within the strip: its ends, cut off at the strip's sides */
        double at = p[bound][other], cut = fmin(fmax(at, low[other]), high[other]);
        double span = p[1 - bound][other] - at, u = span != 0.0 ? (cut - at) / span : 0.0;
        if (fmax(p[0][other], p[1][other]) <= low[other] || fmin(p[0][other], p[1][other]) >= high[other])
          continue;
        double distance = sense * (p[bound][axis] + u * (p[1 - bound][axis] - p[bound][axis]) - middle);
        if (distance > 0.0)
          nearest = fmin(nearest, distance);
      }
    }
  }
  if (isfinite(nearest))
    (end ? high : low)[axis] = middle + sense * nearest;
}

bool km_largest_rectangle(const km_curve_net *net, const int *jump, km_arena *arena, double *low, double *high) {
  double first[2], last[2], cell[2];
  low[0] = low[1] = high[0] = high[1] = 0.0;
  bool *taken = KM_ARENA_NEW(arena, bool, RASTER *RASTER);
  if (!taken)
    return false;
  if (!extent(net, jump, first, last))
    return true;
  for (int d = 0; d < 2; ++d)
    cell[d] = (last[d] - first[d]) / RASTER;
  mark_curves(net, jump, first, cell, taken);
  for (int y = 0; y < RASTER; ++y)
    for (int x = 0; x < RASTER; ++x) {
      const double place[2] = {first[0] + (x + 0.5) * cell[0], first[1] + (y + 0.5) * cell[1]};
      bool *at = &taken[y * RASTER + x];
      bool is_beside_free = x > 0 && !taken[y * RASTER + x - 1]; /* no curve between the two: inside as well */
      *at = *at || (!is_beside_free && km_curve_net_count(net, jump, place) <= 0);
    }
  int from[2] = {0, 0}, to[2] = {0, 0};
  largest_of_raster(taken, cell, from, to);
  if (to[0] == from[0])
    return true;
  for (int d = 0; d < 2; ++d) {
    low[d] = first[d] + from[d] * cell[d];
    high[d] = first[d] + to[d] * cell[d];
  }
  for (int round = 0; round < ROUNDS; ++round)
    for (int side = 0; side < 4; ++side)
      move_side(net, jump, side % 2, side / 2, low, high);
  return true;
}
