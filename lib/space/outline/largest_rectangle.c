/* The largest rectangle that no curve meets (space/outline/outline.h): the largest one of free cells of a raster, then
 * each side moved out to the next curve. */
#include "space/outline/outline.h"

#include <math.h>
#include <string.h>

enum { RASTER = 100, ROUNDS = 4 };

/* Marks the cells of the raster that a curve meets: those in the boxes of its chords. */
static void mark_curves(const km_curve_net *net, const int *jump, const double *low, const double *cell, bool *taken) {
  for (int i = 0; i < net->segment_count; ++i) {
    double p[2][2];
    if (!jump[net->segments[i].piece])
      continue;
    km_segment_chord_point(&net->segments[i], 0, p[0]);
    for (int k = 1; k <= KM_SEGMENT_CHORDS; ++k) {
      int from[2], to[2];
      km_segment_chord_point(&net->segments[i], k, p[1]);
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
    km_segment_chord_point(s, 0, p[0]);
    for (int k = 1; k <= KM_SEGMENT_CHORDS; ++k, memcpy(p[0], p[1], sizeof p[0])) {
      km_segment_chord_point(s, k, p[1]);
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
  if (!km_curve_net_extent(net, jump, first, last))
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
