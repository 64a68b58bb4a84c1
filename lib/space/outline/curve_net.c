/* Curves in a plane, cut where they cross or join (space/outline/outline.h).
 *
 *   crossing : p_a(u) = p_b(v) by Newton's method from the middles of parts that cross at most once
 *   joint    : an end of one curve on another
 *   N(p)     : on the ray y = p_y, x > p_x, at each root of y(u): + jump where y grows, − jump where it falls */
#include "space/outline/outline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NEWTON = 12, MOST_HALVINGS = 3 /* halvings of segments that run along each other */, NO_TURN = 2 };
static const double converged = 1e-8;   /* last correction of u: its square is rounding */
static const double beyond_end = 1e-6;  /* points so far beyond an end of a segment count for both, in u and extents */
static const double root_width = 1e-14; /* a root's last bracket, in u: some roundings */
static const double parallel = 1e-5;    /* sine of the angle of curves that run along each other */
static const double same_place = 3e-8;  /* part of the extent: ends on another curve, whose error is 1e-9 */

typedef struct cut {
  int piece;
  double at;
} cut;

typedef struct cut_list {
  cut *items;
  size_t count, capacity;
  bool is_ok;
} cut_list;

static void add_cut(cut_list *list, int piece, double at) {
  void *items = list->items;
  list->is_ok = list->is_ok && km_reserve(&items, &list->capacity, list->count + 1, sizeof *list->items);
  if (!list->is_ok)
    return;
  list->items = items;
  list->items[list->count++] = (cut){piece, at};
}

/* Roots of the cubic's derivative within 0 … 1, ascending; NO_TURN for those that are missing. */
static void find_turns(const double *c, double *turn) {
  double a = 3.0 * c[3], b = c[2], square = b * b - a * c[1];
  turn[0] = turn[1] = NO_TURN;
  if (!(square > 0.0))
    return;
  double q = -(b + copysign(sqrt(square), b));
  double root[2] = {q != 0.0 ? c[1] / q : NO_TURN, a != 0.0 ? q / a : NO_TURN};
  for (int i = 0; i < 2; ++i)
    if (!(root[i] > 0.0 && root[i] < 1.0))
      root[i] = NO_TURN;
  turn[0] = fmin(root[0], root[1]);
  turn[1] = fmax(root[0], root[1]);
}

/* Extends low and high by the cubic's values at the ends and turns. */
static void extend(const double *c, double *low, double *high) {
  double turn[2];
  find_turns(c, turn);
  const double at[4] = {0.0, 1.0, turn[0] < 1.0 ? turn[0] : 0.0, turn[1] < 1.0 ? turn[1] : 0.0};
  *low = HUGE_VAL;
  *high = -HUGE_VAL;
  for (int i = 0; i < 4; ++i) {
    *low = fmin(*low, km_cubic(c, at[i]));
    *high = fmax(*high, km_cubic(c, at[i]));
  }
}

static void fill_segment(const km_outline_point *p, int piece, km_outline_segment *s) {
  double h = p[0].length;
  km_cubic_hermite(p[0].place[0], h * p[0].rate[0], p[1].place[0], h * p[1].rate[0], s->c[0]);
  km_cubic_hermite(p[0].place[1], h * p[0].rate[1], p[1].place[1], h * p[1].rate[1], s->c[1]);
  extend(s->c[0], &s->low[0], &s->high[0]);
  extend(s->c[1], &s->low[1], &s->high[1]);
  s->end_y = p[1].place[1];
  s->low[1] = fmin(s->low[1], s->end_y);
  s->high[1] = fmax(s->high[1], s->end_y);
  find_turns(s->c[1], s->turn);
  s->piece = piece;
}

static double parameter(const km_curve_net *net, const km_outline_segment *s, double u) {
  return (double)(s - net->segments) - net->first_segment[s->piece] + u;
}

/* A part of a segment, by the parameter. */
typedef struct segment_part {
  const km_outline_segment *segment;
  double from, to;
} segment_part;

/* Newton's method for p_a(u) = p_b(v) from the middles. */
static bool find_crossing(const segment_part *a, const segment_part *b, double *u, double *v) {
  const km_outline_segment *p = a->segment, *q = b->segment;
  *u = 0.5 * (a->from + a->to);
  *v = 0.5 * (b->from + b->to);
  for (int i = 0; i < MOST_NEWTON; ++i) {
    double ax = km_cubic_rate(p->c[0], *u), ay = km_cubic_rate(p->c[1], *u), bx = km_cubic_rate(q->c[0], *v),
           by = km_cubic_rate(q->c[1], *v);
    double dx = km_cubic(q->c[0], *v) - km_cubic(p->c[0], *u), dy = km_cubic(q->c[1], *v) - km_cubic(p->c[1], *u);
    double determinant = ax * by - ay * bx;
    if (!(fabs(determinant) > parallel * hypot(ax, ay) * hypot(bx, by)))
      return false;
    double du = (dx * by - dy * bx) / determinant, dv = (dx * ay - dy * ax) / determinant;
    *u += du;
    *v += dv;
    if (!(fabs(*u - 0.5) < 2.0 && fabs(*v - 0.5) < 2.0))
      return false;
    if (fabs(du) + fabs(dv) < converged)
      return true;
  }
  return false;
}

/* Bernstein coefficients of a cubic over a part, and of its derivative by u. */
static void bernstein(const double *c, double from, double to, double *values, double *rates) {
  double h = to - from, r0 = km_cubic_rate(c, from), r1 = km_cubic_rate(c, to);
  values[0] = km_cubic(c, from);
  values[3] = km_cubic(c, to);
  values[1] = values[0] + h * r0 / 3.0;
  values[2] = values[3] - h * r1 / 3.0;
  rates[0] = r0;
  rates[1] = 3.0 * (values[2] - values[1]) / h;
  rates[2] = r1;
}

static bool boxes_meet(double values[2][4], double tolerance) {
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < 4; ++i) {
      low[side] = fmin(low[side], values[side][i]);
      high[side] = fmax(high[side], values[side][i]);
    }
  return low[0] <= high[1] + tolerance && low[1] <= high[0] + tolerance;
}

/* True if no direction of one part is one of the other: they cross at most once. */
static bool cross_once(double x[2][3], double y[2][3]) {
  int sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      sum += x[0][i] * y[1][j] - y[0][i] * x[1][j] > 0.0 ? 1 : -1;
  return abs(sum) == 9;
}

static double within_unit(double u) {
  return fmin(fmax(u, 0.0), 1.0);
}

static bool is_within(const segment_part *part, double u) {
  return u >= part->from - beyond_end && u <= part->to + beyond_end;
}

/* Adds the cuts where two parts of segments cross; parts that may cross more than once are halved. */
static void cut_parts(const km_curve_net *net, segment_part a, segment_part b, int halvings, cut_list *list) {
  double x[2][4], y[2][4], dx[2][3], dy[2][3], u, v;
  bernstein(a.segment->c[0], a.from, a.to, x[0], dx[0]);
  bernstein(a.segment->c[1], a.from, a.to, y[0], dy[0]);
  bernstein(b.segment->c[0], b.from, b.to, x[1], dx[1]);
  bernstein(b.segment->c[1], b.from, b.to, y[1], dy[1]);
  if (!boxes_meet(x, beyond_end * net->size) || !boxes_meet(y, beyond_end * net->size))
    return;
  bool is_found = cross_once(dx, dy) && find_crossing(&a, &b, &u, &v) && is_within(&a, u) && is_within(&b, v);
  if (is_found) {
    add_cut(list, a.segment->piece, parameter(net, a.segment, within_unit(u)));
    add_cut(list, b.segment->piece, parameter(net, b.segment, within_unit(v)));
  }
  for (int part = 0; part < 4 && !is_found && halvings > 0; ++part) {
    double half_a = 0.5 * (a.to - a.from), half_b = 0.5 * (b.to - b.from);
    segment_part of_a = {a.segment, a.from + part % 2 * half_a, a.from + (part % 2 + 1) * half_a};
    segment_part of_b = {b.segment, b.from + part / 2 * half_b, b.from + (part / 2 + 1) * half_b};
    cut_parts(net, of_a, of_b, halvings - 1, list);
  }
}

double km_segment_distance(const km_outline_segment *s, const double *place, double within, double *u) {
  *u = 0.5;
  for (int i = 0; i < 2; ++i)
    if (place[i] < s->low[i] - within || place[i] > s->high[i] + within)
      return HUGE_VAL;
  return km_cubic_distance(s->c[0], 2, place, u);
}

/* A segment by its least x. */
typedef struct left_end {
  double low;
  int segment;
} left_end;

static int by_low(const void *a, const void *b) {
  double x = ((const left_end *)a)->low, y = ((const left_end *)b)->low;
  return (x > y) - (x < y);
}

/* Cuts all pairs of segments whose boxes meet. */
static void cut_crossings(const km_curve_net *net, const left_end *order, cut_list *list) {
  for (int i = 0; i < net->segment_count; ++i)
    for (int j = i + 1; j < net->segment_count; ++j) {
      const km_outline_segment *a = &net->segments[order[i].segment], *b = &net->segments[order[j].segment];
      if (b->low[0] > a->high[0])
        break;
      bool is_next = a->piece == b->piece && abs(order[i].segment - order[j].segment) < 2;
      if (!is_next && b->low[1] <= a->high[1] && b->high[1] >= a->low[1])
        cut_parts(net, (segment_part){a, 0.0, 1.0}, (segment_part){b, 0.0, 1.0}, MOST_HALVINGS, list);
    }
}

/* Cuts every curve at the ends of the others that are on it. */
static void cut_joints(const km_curve_net *net, cut_list *list) {
  double within = same_place * net->size, u;
  for (int k = 0; k < net->piece_count; ++k)
    for (int end = 0; end < 2; ++end) {
      const km_outline_piece *piece = &net->pieces[k];
      const double *place = net->points[piece->first + (end == 0 ? 0 : piece->count - 1)].place;
      for (int i = 0; i < net->segment_count; ++i) {
        const km_outline_segment *s = &net->segments[i];
        if (s->piece != k && km_segment_distance(s, place, within, &u) < within)
          add_cut(list, s->piece, parameter(net, s, u));
      }
    }
}

static int by_piece(const void *a, const void *b) {
  const cut *x = a, *y = b;
  return x->piece != y->piece ? x->piece - y->piece : (x->at > y->at) - (x->at < y->at);
}

static bool fill_segments(km_curve_net *net, km_arena *arena) {
  size_t count = 0;
  for (int k = 0; k < net->piece_count; ++k)
    count += net->pieces[k].count - 1;
  net->first_segment = KM_ARENA_NEW(arena, int, (size_t)net->piece_count + 1);
  net->segments = KM_ARENA_NEW(arena, km_outline_segment, count + 1);
  if (arena->failed)
    return false;
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (int k = 0; k < net->piece_count; ++k) {
    const km_outline_piece *piece = &net->pieces[k];
    net->first_segment[k] = net->segment_count;
    for (size_t i = 0; i + 1 < piece->count; ++i) {
      km_outline_segment *s = &net->segments[net->segment_count++];
      fill_segment(net->points + piece->first + i, k, s);
      for (int d = 0; d < 2; ++d) {
        low[d] = fmin(low[d], s->low[d]);
        high[d] = fmax(high[d], s->high[d]);
      }
    }
  }
  net->first_segment[net->piece_count] = net->segment_count;
  net->size = count > 0 ? hypot(high[0] - low[0], high[1] - low[1]) : 0.0;
  return true;
}

/* Distributes the cuts to the pieces, both ends among them. */
static bool keep_cuts(km_curve_net *net, cut_list *list, km_arena *arena) {
  for (int k = 0; k < net->piece_count; ++k) {
    add_cut(list, k, 0.0);
    add_cut(list, k, (double)(net->pieces[k].count - 1));
  }
  net->cuts = KM_ARENA_NEW(arena, double *, (size_t)net->piece_count + 1);
  net->cut_count = KM_ARENA_NEW(arena, int, (size_t)net->piece_count + 1);
  double *all = KM_ARENA_NEW(arena, double, list->count + 1);
  if (!list->is_ok || arena->failed)
    return false;
  if (list->count > 0)
    qsort(list->items, list->count, sizeof *list->items, by_piece);
  for (size_t i = 0; i < list->count; ++i) {
    int k = list->items[i].piece;
    if (net->cut_count[k] == 0)
      net->cuts[k] = all + i;
    all[i] = list->items[i].at;
    ++net->cut_count[k];
  }
  return true;
}

bool km_curve_net_create(km_curve_net *net, const km_outline_point *points, const km_outline_piece *pieces,
                         int piece_count, km_arena *arena) {
  *net = (km_curve_net){.points = points, .pieces = pieces, .piece_count = piece_count};
  if (!fill_segments(net, arena))
    return false;
  left_end *order = KM_ARENA_NEW(arena, left_end, (size_t)net->segment_count + 1);
  if (!order)
    return false;
  for (int i = 0; i < net->segment_count; ++i)
    order[i] = (left_end){net->segments[i].low[0], i};
  qsort(order, (size_t)net->segment_count, sizeof *order, by_low);
  cut_list list = {.is_ok = true};
  cut_crossings(net, order, &list);
  cut_joints(net, &list);
  bool is_ok = keep_cuts(net, &list, arena);
  km_free(list.items);
  return is_ok;
}

void km_curve_net_place(const km_curve_net *net, int piece, double at, double *place, double *rate) {
  int first = net->first_segment[piece], last = net->first_segment[piece + 1] - 1 - first;
  int i = at < last ? (int)at : last;
  const km_outline_segment *s = &net->segments[first + i];
  place[0] = km_cubic(s->c[0], at - i);
  place[1] = km_cubic(s->c[1], at - i);
  rate[0] = km_cubic_rate(s->c[0], at - i);
  rate[1] = km_cubic_rate(s->c[1], at - i);
}

/* y at u; at the end that of the next segment's start, so that a ray meets one of them. */
static double y_at(const km_outline_segment *s, double u) {
  return u < 1.0 ? km_cubic(s->c[1], u) : s->end_y;
}

/* x at the root of y(u) = y within from … to, where y(u) − y changes its sign. */
static double place_of_root(const km_outline_segment *s, double y, double from, double to) {
  bool grows = y_at(s, to) > y_at(s, from);
  while (to - from > root_width) {
    double u = 0.5 * (from + to);
    if (u <= from || u >= to)
      break;
    if ((y_at(s, u) < y) == grows)
      from = u;
    else
      to = u;
  }
  return km_cubic(s->c[0], 0.5 * (from + to));
}

/* Crossings of the ray from a place with a segment, upwards less downwards. */
static int crossings(const km_outline_segment *s, const double *place) {
  if (place[1] < s->low[1] || place[1] >= s->high[1] || place[0] > s->high[0])
    return 0;
  double at[4] = {0.0, fmin(s->turn[0], 1.0), fmin(s->turn[1], 1.0), 1.0};
  int sum = 0;
  for (int i = 0; i < 3; ++i) {
    bool from = y_at(s, at[i]) > place[1], to = y_at(s, at[i + 1]) > place[1];
    if (from != to && (place[0] < s->low[0] || place_of_root(s, place[1], at[i], at[i + 1]) > place[0]))
      sum += to ? 1 : -1;
  }
  return sum;
}

int km_curve_net_count(const km_curve_net *net, const int *jump, const double *place) {
  int sum = net->at_end;
  for (int i = 0; i < net->segment_count; ++i)
    if (jump[net->segments[i].piece])
      sum += jump[net->segments[i].piece] * crossings(&net->segments[i], place);
  return sum;
}

void km_segment_chord_point(const km_outline_segment *s, int k, double *place) {
  double u = (double)k / KM_SEGMENT_CHORDS;
  place[0] = km_cubic(s->c[0], u);
  place[1] = km_cubic(s->c[1], u);
}

bool km_curve_net_extent(const km_curve_net *net, const int *jump, double *low, double *high) {
  low[0] = low[1] = HUGE_VAL;
  high[0] = high[1] = -HUGE_VAL;
  for (int i = 0; i < net->segment_count; ++i)
    for (int d = 0; d < 2 && jump[net->segments[i].piece]; ++d) {
      low[d] = fmin(low[d], net->segments[i].low[d]);
      high[d] = fmax(high[d], net->segments[i].high[d]);
    }
  return low[0] < high[0] && low[1] < high[1];
}
