/* Outlines of plane regions, the largest circle and rectangle in them (space/outline.h).
 *
 *   part   : between two cuts; on the outline if N at its middle is positive on one side only
 *   loop   : each part continues with the leftmost one that begins at its end
 *   area   : ∮ x dy by three points of Gauss, exact for cubics */
#include "space/outline.h"

#include <math.h>
#include <string.h>

static const double side_distance = 1e-7; /* distance of a part from its sides, by the extent: curves agree to 1e-8 */
static const double least_side_distance = 9e-9; /* smallest one, beside a near curve: copies of a curve are nearer */
static const double least_length = 1e-6;        /* shorter parts are between a crossing and an end that are one */
static const double same_end =
    1e-4; /* distance of ends of parts that join, of the extent: thinner wedges between curves are lost */
static const double most_gap = 0.02;   /* longest one that a straight line closes, of the extent */
static const double coincident = 3e-8; /* distance of curves that are one, of the extent */

/* Unit vector along a part's middle, and its place. False where the curve has no direction. */
static bool middle_of(const km_curve_net *net, const km_outline_part *part, double *place, double *along) {
  km_curve_net_place(net, part->piece, 0.5 * (part->from + part->to), place, along);
  double size = hypot(along[0], along[1]);
  along[0] /= size;
  along[1] /= size;
  return isfinite(along[0] + along[1]);
}

/* Distance of a place from a segment, and whether it lies beside it. */
static bool is_on_segment(const km_outline_segment *s, const double *place, double tolerance) {
  for (int i = 0; i < 2; ++i)
    if (place[i] < s->low[i] - tolerance || place[i] > s->high[i] + tolerance)
      return false;
  double u = 0.5;
  for (int i = 0; i < 12; ++i) {
    double x = km_cubic(s->x, u), y = km_cubic(s->y, u), dx = km_cubic_rate(s->x, u), dy = km_cubic_rate(s->y, u);
    double along = ((place[0] - x) * dx + (place[1] - y) * dy) / (dx * dx + dy * dy);
    if (fabs(along) < 1e-9)
      return u > -1e-6 && u < 1.0 + 1e-6 && hypot(place[0] - x, place[1] - y) < tolerance;
    u = fmin(fmax(u + along, -0.5), 1.5);
  }
  return false;
}

/* True if an earlier curve with a jump runs through the same place: the part is then that curve's. */
static bool is_earlier(const km_curve_net *net, const int *jump, int piece, const double *place) {
  for (int i = 0; i < net->first_segment[piece]; ++i)
    if (jump[net->segments[i].piece] && is_on_segment(&net->segments[i], place, coincident * net->size))
      return true;
  return false;
}

/* N on both sides of a place. Where it doesn't differ by the jump, another curve is nearer than the sides: they are
 * taken nearer too, unless that curve is the same one. */
static void count_sides(const km_curve_net *net, const int *jump, int piece, const double *place, const double *along,
                        int *left, int *right) {
  for (double e = side_distance; e >= least_side_distance; e *= 0.1) {
    double x = e * net->size * along[0], y = e * net->size * along[1];
    int at_left = km_curve_net_count(net, jump, (const double[]){place[0] - y, place[1] + x});
    int at_right = km_curve_net_count(net, jump, (const double[]){place[0] + y, place[1] - x});
    bool is_exact = at_left - at_right == jump[piece];
    if (is_exact || e == side_distance) {
      *left = at_left;
      *right = at_right;
    }
    if (is_exact)
      return;
  }
}

/* Turns the part so that the region is on its left. False: it isn't on the outline. */
static bool is_on_outline(const km_curve_net *net, const int *jump, km_outline_part *part) {
  double place[2], along[2];
  if (!jump[part->piece] || !middle_of(net, part, place, along))
    return false;
  int left = 0, right = 0;
  count_sides(net, jump, part->piece, place, along, &left, &right);
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

/* A part shorter than the distance of its sides has no middle that has a count. */
static bool is_short(const km_curve_net *net, const km_outline_part *part) {
  double from[2], to[2], middle[2], rate[2];
  km_curve_net_place(net, part->piece, part->from, from, rate);
  km_curve_net_place(net, part->piece, part->to, to, rate);
  km_curve_net_place(net, part->piece, 0.5 * (part->from + part->to), middle, rate);
  return hypot(middle[0] - from[0], middle[1] - from[1]) + hypot(to[0] - middle[0], to[1] - middle[1]) <
         least_length * net->size;
}

static void end_of(const km_curve_net *net, const km_outline_part *part, bool is_start, double *place, double *along) {
  double sense = part->to > part->from ? 1.0 : -1.0;
  km_curve_net_place(net, part->piece, is_start ? part->from : part->to, place, along);
  along[0] *= sense;
  along[1] *= sense;
}

/* The part that continues another: among those that begin at its end the leftmost one, else the one that begins
 * nearest; −1: none. *gap: distance of its start, 0 in the first case. */
static int successor(const km_curve_net *net, const km_outline_part *parts, int count, const km_outline_part *part,
                     int first, double *gap) {
  double end[2], along[2], start[2], next[2], largest = -HUGE_VAL;
  int best = -1;
  *gap = most_gap * net->size;
  end_of(net, part, false, end, along);
  for (int i = 0; i < count; ++i) {
    if (parts[i].loop != 0 && i != first)
      continue;
    end_of(net, &parts[i], true, start, next);
    double distance = hypot(start[0] - end[0], start[1] - end[1]);
    bool is_same = distance <= same_end * net->size;
    double turn = atan2(along[0] * next[1] - along[1] * next[0], along[0] * next[0] + along[1] * next[1]);
    if (is_same ? turn <= largest : distance >= *gap)
      continue;
    *gap = is_same ? 0.0 : distance;
    largest = is_same ? turn : largest;
    best = i;
  }
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
    out->hole_count += area < 0.0;
    out->area += area;
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
      if (part.to > part.from && !is_short(net, &part) && is_on_outline(net, jump, &part))
        parts[count++] = part;
    }
  join(net, parts, count, out);
  return true;
}
