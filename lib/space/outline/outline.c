/* Outlines of plane regions (space/outline/outline.h).
 *
 *   part   : between two cuts; on the outline if N at its middle is positive on one side only
 *   loop   : each part continues with the leftmost one that begins at its end
 *   area   : ∮ x dy by three points of Gauss, exact for cubics */
#include "space/outline/outline.h"

#include <math.h>
#include <string.h>

static const double side_distance = 1e-7; /* distance of a part from its sides, by the extent: curves agree to 1e-8 */
static const double least_length = 1e-6;  /* shorter parts are between a crossing and an end that are one */
static const double end_chord = 1e-4;     /* chord for the direction at an end, in segments */
static const double same_place = 1e-7;    /* distance of ends of parts that begin at one cut, of the extent */
static const double same_end = 1e-4;      /* longest gap that isn't one, of the extent: curves end beside a vertex */
static const double most_gap = 0.02;      /* longest one that a straight line closes, of the extent */
static const double coincident = 3e-8;    /* distance of curves that are one, of the extent */

/* Parameter of the next point of a part after `at`, or of its end. */
static double next_point(const km_outline_part *part, double at) {
  return fmin(floor(at) + 1.0, part->to);
}

/* Length of the chord between two parameters of a piece. */
static double chord(const km_curve_net *net, int piece, double from, double to) {
  double a[2], b[2], rate[2];
  km_curve_net_place(net, piece, from, a, rate);
  km_curve_net_place(net, piece, to, b, rate);
  return hypot(b[0] - a[0], b[1] - a[1]);
}

/* Parameter at half of a part's length: there its curve is farthest from others that touch it at the ends. */
static double middle_parameter(const km_curve_net *net, const km_outline_part *part) {
  double length = 0.0, half;
  for (double at = part->from; at < part->to; at = next_point(part, at))
    length += chord(net, part->piece, at, next_point(part, at));
  half = 0.5 * length;
  for (double at = part->from; at < part->to; at = next_point(part, at)) {
    double next = next_point(part, at), own = chord(net, part->piece, at, next);
    if (own >= half && own > 0.0)
      return at + (next - at) * half / own;
    half -= own;
  }
  return 0.5 * (part->from + part->to);
}

/* Unit vector along a part's middle, and its place. False where the curve has no direction. */
static bool middle_of(const km_curve_net *net, const km_outline_part *part, double *place, double *along) {
  km_curve_net_place(net, part->piece, middle_parameter(net, part), place, along);
  double size = hypot(along[0], along[1]);
  along[0] /= size;
  along[1] /= size;
  return isfinite(along[0] + along[1]);
}

/* True if an earlier curve with a jump runs through the same place: the part is then that curve's. */
static bool is_earlier(const km_curve_net *net, const int *jump, int piece, const double *place) {
  double within = coincident * net->size, u;
  for (int i = 0; i < net->first_segment[piece]; ++i)
    if (jump[net->segments[i].piece] && km_segment_distance(&net->segments[i], place, within, &u) < within)
      return true;
  return false;
}

/* Distance of a place from the nearest curve with a jump that doesn't run through it; at most 2 · side_distance. */
static double other_distance(const km_curve_net *net, const int *jump, const double *place) {
  double nearest = 2.0 * side_distance * net->size, u;
  for (int i = 0; i < net->segment_count; ++i) {
    double d = jump[net->segments[i].piece] ? km_segment_distance(&net->segments[i], place, nearest, &u) : HUGE_VAL;
    if (d > coincident * net->size)
      nearest = fmin(nearest, d);
  }
  return nearest;
}

/* N on both sides of a place, half as far as the next curve. */
static void count_sides(const km_curve_net *net, const int *jump, const double *place, const double *along, int *left,
                        int *right) {
  double e = 0.5 * other_distance(net, jump, place), x = e * along[0], y = e * along[1];
  *left = km_curve_net_count(net, jump, (const double[]){place[0] - y, place[1] + x});
  *right = km_curve_net_count(net, jump, (const double[]){place[0] + y, place[1] - x});
}

/* Turns the part so that the region is on its left. False: it isn't on the outline. */
static bool is_on_outline(const km_curve_net *net, const int *jump, km_outline_part *part) {
  double place[2], along[2];
  if (!jump[part->piece] || !middle_of(net, part, place, along))
    return false;
  int left = 0, right = 0;
  count_sides(net, jump, place, along, &left, &right);
  bool has_left = left > 0, has_right = right > 0;
  if (has_left == has_right || is_earlier(net, jump, part->piece, place))
    return false;
  if (has_right) {
    double from = part->from;
    part->from = part->to;
    part->to = from;
  }
  return true;
}

/* Length of a part by two chords. */
static double length_of(const km_curve_net *net, const km_outline_part *part) {
  double middle = 0.5 * (part->from + part->to);
  return chord(net, part->piece, part->from, middle) + chord(net, part->piece, middle, part->to);
}

/* Place of an end of a part, and the chord of the part there in its sense: the rate is 0 at a cusp. */
static void end_of(const km_curve_net *net, const km_outline_part *part, bool is_start, double *place, double *along) {
  double beside[2], rate[2], at = is_start ? part->from : part->to, change = part->to - part->from;
  double step = copysign(end_chord * fmin(fabs(change), 1.0), is_start ? change : -change);
  km_curve_net_place(net, part->piece, at, place, rate);
  km_curve_net_place(net, part->piece, at + step, beside, rate);
  for (int d = 0; d < 2; ++d)
    along[d] = is_start ? beside[d] - place[d] : place[d] - beside[d];
}

/* The part that continues another: the one that begins nearest to its end, of several there the leftmost; −1: none.
 * *gap: distance of its start, 0 for ends that are one. */
static int successor(const km_curve_net *net, const km_outline_part *parts, int count, const km_outline_part *part,
                     int first, double *gap) {
  double end[2], along[2], start[2], next[2], largest = -HUGE_VAL, nearest = most_gap * net->size;
  int best = -1;
  end_of(net, part, false, end, along);
  for (int i = 0; i < count; ++i) {
    if (parts[i].loop != 0 && i != first)
      continue;
    end_of(net, &parts[i], true, start, next);
    double distance = hypot(start[0] - end[0], start[1] - end[1]);
    double turn = atan2(along[0] * next[1] - along[1] * next[0], along[0] * next[0] + along[1] * next[1]);
    bool is_there = fabs(distance - nearest) <= same_place * net->size;
    if (is_there ? turn <= largest : distance >= nearest)
      continue;
    nearest = is_there ? fmin(nearest, distance) : distance;
    largest = turn;
    best = i;
  }
  *gap = nearest <= same_end * net->size ? 0.0 : nearest;
  return best;
}

/* ∫ x dy over a part, three points of Gauss in each segment. */
static double area_of(const km_curve_net *net, const km_outline_part *part) {
  static const double node[3] = {0.1127016653792583, 0.5, 0.8872983346207417},
                      weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  double low = fmin(part->from, part->to), high = fmax(part->from, part->to), sum = 0.0;
  for (double a = low; a < high;) {
    double b = fmin(floor(a) + 1.0, high);
    for (int i = 0; i < 3; ++i) {
      double place[2], rate[2];
      km_curve_net_place(net, part->piece, a + node[i] * (b - a), place, rate);
      sum += weight[i] * (b - a) * place[0] * rate[1];
    }
    a = b;
  }
  return part->to > part->from ? sum : -sum;
}

/* ∫ x dy along the straight line from the end of a part to the start of the next. */
static double area_of_gap(const km_curve_net *net, const km_outline_part *part, const km_outline_part *next) {
  double end[2], start[2], along[2];
  end_of(net, part, false, end, along);
  end_of(net, next, true, start, along);
  return 0.5 * (end[0] + start[0]) * (start[1] - end[1]);
}

/* Joins the parts to loops, in whose order `out` has them. */
static void join(const km_curve_net *net, km_outline_part *parts, int count, km_outline *out) {
  for (int first = 0; first < count; ++first) {
    if (parts[first].loop != 0)
      continue;
    double area = 0.0, gap;
    int at = first, next;
    ++out->loop_count;
    do {
      parts[at].loop = out->loop_count;
      out->parts[out->part_count++] = parts[at];
      next = successor(net, parts, count, &parts[at], first, &gap);
      area += area_of(net, &parts[at]) + (next >= 0 ? area_of_gap(net, &parts[at], &parts[next]) : 0.0);
      out->gap = fmax(out->gap, next >= 0 ? gap : HUGE_VAL);
      at = next;
    } while (at >= 0 && at != first);
    out->hole_count += area < -(same_end * net->size) * (same_end * net->size);
    out->area += area;
  }
  if (net->at_end > 0) {
    out->area += net->whole;
    out->hole_count -= out->hole_count > 0;
  }
}

bool km_outline_find(const km_curve_net *net, const int *jump, km_arena *arena, km_outline *out) {
  size_t most = 0;
  int count = 0;
  *out = (km_outline){0};
  for (int k = 0; k < net->piece_count; ++k)
    most += (size_t)net->cut_count[k];
  km_outline_part *parts = KM_ARENA_NEW(arena, km_outline_part, most + 1);
  out->parts = KM_ARENA_NEW(arena, km_outline_part, most + 1);
  if (arena->failed)
    return false;
  for (int k = 0; k < net->piece_count; ++k)
    for (int i = 0; i + 1 < net->cut_count[k]; ++i) {
      km_outline_part part = {.piece = k, .from = net->cuts[k][i], .to = net->cuts[k][i + 1]};
      if (part.to > part.from && length_of(net, &part) >= least_length * net->size && is_on_outline(net, jump, &part))
        parts[count++] = part;
    }
  join(net, parts, count, out);
  return true;
}
