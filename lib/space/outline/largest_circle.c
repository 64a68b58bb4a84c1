/* The largest circle that no curve meets (space/outline/outline.h).
 *
 *   d(p)   : distance from the curves, negative outside;  |d(p) − d(c)| <= |p − c|
 *   maximum: by branch and bound; in a square of half side h around c, d(p) <= d(c) + h √2 */
#include "space/outline/outline.h"

#include <math.h>
#include <string.h>

enum { MOST_SQUARES = 20000, STACK = 256 /* three squares are left of each size */ };
static const double accuracy = 1e-5; /* error of the radius, by the extent */

/* Bounds a square, and notes it if its centre is the farthest from the curves so far. */
static void visit(const km_free_region *region, km_square *s, km_square *best, double *largest) {
  double d = region->distance(region->context, s);
  s->bound = d + sqrt(2.0) * s->half;
  if (s->bound <= *largest)
    return;
  bool is_inside = region->is_inside(region->context, s);
  if (!is_inside)
    s->bound -= 2.0 * d;
  if (!is_inside || d <= *largest)
    return;
  *largest = d;
  *best = *s;
}

/* Adds a square, in the order of the bounds of the last `of`, the largest of which comes next. */
static void add_square(km_square *stack, int *count, int of, const km_square *s) {
  int at = (*count)++;
  for (; at > *count - 1 - of && stack[at - 1].bound > s->bound; --at)
    stack[at] = stack[at - 1];
  stack[at] = *s;
}

double km_largest_distance(const km_free_region *region, const km_square *first, int first_count, km_square *best) {
  static const int side[4][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
  km_square stack[STACK];
  double largest = 0.0;
  int count = 0;
  for (int k = 0; k < first_count; ++k) {
    km_square s = first[k];
    visit(region, &s, best, &largest);
    add_square(stack, &count, k, &s);
  }
  for (int visited = 0; count > 0 && count <= STACK - 4 && visited < MOST_SQUARES;) {
    km_square s = stack[--count];
    if (s.bound <= largest + region->accuracy)
      continue;
    for (int k = 0; k < 4; ++k, ++visited) {
      km_square part = {.half = 0.5 * s.half, .face = s.face};
      for (int d = 0; d < 2; ++d)
        part.centre[d] = s.centre[d] + side[k][d] * part.half;
      visit(region, &part, best, &largest);
      add_square(stack, &count, k, &part);
    }
  }
  return largest;
}

/* ---- Of a plane. */

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
    km_segment_chord_point(s, 0, a);
    for (int k = 1; k <= KM_SEGMENT_CHORDS; ++k) {
      km_segment_chord_point(s, k, b);
      least = fmin(least, square_to_chord(a, b, place));
      memcpy(a, b, sizeof a);
    }
  }
  return sqrt(least);
}

typedef struct plane_region {
  const km_curve_net *net;
  const int *jump;
} plane_region;

static double plane_distance(const void *context, const km_square *s) {
  const plane_region *r = context;
  return km_curve_net_distance(r->net, r->jump, s->centre);
}

static bool is_inside_plane(const void *context, const km_square *s) {
  const plane_region *r = context;
  return km_curve_net_count(r->net, r->jump, s->centre) > 0;
}

void km_largest_circle(const km_curve_net *net, const int *jump, double *centre, double *radius) {
  const plane_region plane = {net, jump};
  const km_free_region region = {&plane, plane_distance, is_inside_plane, accuracy * net->size};
  double low[2], high[2];
  *radius = 0.0;
  if (!km_curve_net_extent(net, jump, low, high))
    return;
  const km_square first = {.centre = {0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])},
                           .half = 0.5 * fmax(high[0] - low[0], high[1] - low[1])};
  km_square best = first;
  *radius = km_largest_distance(&region, &first, 1, &best);
  memcpy(centre, best.centre, sizeof best.centre);
}
