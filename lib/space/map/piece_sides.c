/* Both sides of the pieces of a map's curves (docs/theory.md 4.22).
 *
 *   across : τ unit tangent, ν ⊥ τ with J ν = 0, det (J; τ; ν) > 0;   left side: + ν, right side: − ν
 *   jump   : the side's configurations are on the left of the curve's image if ± det (J; G) > 0
 *   aspect : of the grid point to which drivers lead from there without a change of det A and det (J; G);
 *            else, of the neighbouring side around a vertex: the ends of pieces there in the order of their angles;
 *            neighbouring sides join aspects that the grid has parted */
#include "space/map/map_workspace.h"

#include "base/number/cubic.h"
#include "base/number/vectors.h"
#include "base/random.h"
#include "space/real_solve.h"

#include <stdlib.h>
#include <string.h>

enum { PARTS = 3 /* steps to a distance */, MOST_NEWTON = 8 };
static const double beside = 1e-3;      /* distance at which the signs of a side are taken */
static const double most_beside = 0.05; /* its largest part of the piece's length: other curves are beyond */
/* Distances from a curve at which a side's grid point is looked for: that of starts of sheets, and twice as far, since
 * the grid point may have another sign (test_space_joints, a head's zone). */
static const double distances[] = {0.05, 0.1};
static const double converged = 1e-12;
static const double same_vertex = 1e-5; /* distance of ends that are one vertex: located to 1e-8 */

/* Fills M with the rows J, τ and `last`. */
static void fill_matrix(km_workspace_search *w, const double *tangent, const double *last) {
  const km_driver_surface *f = &w->g->f;
  int n = f->columns, r = f->rows;
  km_driver_surface_rows(f, w->M, n);
  memcpy(w->M + r * n, tangent, (size_t)n * sizeof *tangent);
  memcpy(w->M + (r + 1) * n, last, (size_t)n * sizeof *last);
}

bool km_piece_find_across(km_workspace_search *w, const km_curve_point *p) {
  km_driver_surface *f = &w->g->f;
  uint64_t random = 3;
  int sign;
  for (int k = 0; k < f->columns; ++k)
    w->nu[k] = km_uniform(&random);
  km_driver_surface_restore(f, p->saved);
  km_driver_surface_update(f);
  fill_matrix(w, p->tangent, w->nu);
  memset(w->b, 0, (size_t)f->columns * sizeof *w->b);
  w->b[f->columns - 1] = 1.0;
  if (!km_real_factor(w->M, f->columns, w->row, &sign))
    return false;
  km_real_solve(w->M, f->columns, w->row, w->b, w->nu);
  double size = km_norm(w->nu, f->columns);
  for (int k = 0; k < f->columns; ++k)
    w->nu[k] *= sign / size;
  return true;
}

/* Moves to the configuration at `distance` ν from a point of a curve. */
static bool move_across(km_workspace_search *w, const km_curve_point *p, double distance) {
  km_driver_surface *f = &w->g->f;
  int n = f->columns, sign;
  km_driver_surface_restore(f, p->saved);
  for (int k = 0; k < n; ++k)
    f->step[k] = distance * w->nu[k];
  for (int i = 0; i < MOST_NEWTON; ++i) {
    km_driver_surface_move(f, f->step);
    km_driver_surface_update(f);
    fill_matrix(w, p->tangent, w->nu);
    memset(w->b, 0, (size_t)n * sizeof *w->b);
    for (int k = 0; k < f->rows; ++k)
      w->b[k] = -f->e[k];
    if (!km_real_factor(w->M, n, w->row, &sign))
      return false;
    km_real_solve(w->M, n, w->row, w->b, f->step);
    if (km_norm(f->step, n) < converged)
      return km_driver_surface_is_closed(f);
  }
  return false;
}

/* Signs of det A and det (J; G) at the state's configuration. */
static void find_signs(km_workspace_search *w, int *signs) {
  for (int i = 0; i < 2; ++i) {
    km_curve_kind kind = i == 0 ? KM_CURVE_INPUT : KM_CURVE_OUTPUT;
    signs[i] = km_driver_surface_determinant(&w->g->f, kind, w->K, w->row) < 0.0 ? -1 : 1;
  }
}

bool km_piece_has_signs(km_workspace_search *w, const int *signs) {
  int there[2];
  find_signs(w, there);
  return there[0] == signs[0] && there[1] == signs[1];
}

/* Aspect of the configurations at this side with these signs; 0: not found. */
static int find_aspect(km_workspace_search *w, const km_curve_point *p, int side, const int *signs) {
  for (size_t i = 0; i < sizeof distances / sizeof *distances; ++i) {
    bool is_same = true;
    int sign;
    for (int part = 1; is_same && part <= PARTS; ++part)
      is_same = move_across(w, p, side * distances[i] * part / PARTS) && km_piece_has_signs(w, signs);
    if (!is_same || km_driver_surface_margin(&w->g->f, -1, -1) < 0.0)
      continue;
    w->g->kept_sign = signs[1];
    int cell = km_map_enter_grid(w->g, &sign, w->N);
    w->g->kept_sign = 0;
    const km_known_configuration *known = cell >= 0 ? km_map_find_known(w->g, cell) : NULL;
    if (!known || known->aspect == 0)
      continue;
    if (km_piece_has_signs(w, signs))
      return known->aspect;
  }
  return 0;
}

/* Fills w->sample with the configuration at a part of a piece, between two of its points. */
static void sample_piece(km_workspace_search *w, const km_outline_piece *piece, double part) {
  km_driver_surface *f = &w->g->f;
  double at = part * (double)(piece->count - 1), u = at - floor(at), rate;
  size_t i = piece->first + (size_t)at;
  const km_curve_point *p = &w->points[w->source[i]], *next = &w->points[w->source[i + 1]];
  double *tangent = w->sample.tangent;
  km_driver_surface_restore(f, next->saved);
  km_driver_surface_difference(f, p->saved, w->x);
  km_curve_interpolate(f->columns, p, next, w->x, w->places[i].length, w->chord);
  for (int k = 0; k < f->columns; ++k) {
    f->step[k] = km_cubic(w->chord + 4 * k, u);
    tangent[k] = km_cubic_rate(w->chord + 4 * k, u);
  }
  rate = km_norm(tangent, f->columns);
  for (int k = 0; k < f->columns; ++k)
    tangent[k] /= rate;
  km_driver_surface_restore(f, p->saved);
  km_driver_surface_move(f, f->step);
  km_driver_surface_save(f, w->sample.saved);
}

/* Finds a side at the sample: its signs and jump, unless they are known, and its aspect. */
static void find_side(km_workspace_search *w, km_piece_side *side, int sense, double distance) {
  if (side->signs[0] == 0) {
    if (!move_across(w, &w->sample, sense * distance))
      return;
    bool is_inside = km_driver_surface_margin(&w->g->f, -1, -1) >= 0.0;
    find_signs(w, side->signs);
    side->jump = is_inside ? side->signs[1] * sense : 0;
  }
  if (side->jump != 0)
    side->aspect = find_aspect(w, &w->sample, sense, side->signs);
}

/* Finds both sides of a piece, from its middle outwards. */
static void find_sides(km_workspace_search *w, int piece) {
  static const double parts[] = {0.5, 0.375, 0.625, 0.25, 0.75, 0.125, 0.875};
  const km_outline_piece *at = &w->pieces[piece];
  double length = 0.0;
  for (size_t i = at->first; i + 1 < at->first + at->count; ++i)
    length += w->places[i].length;
  for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i) {
    sample_piece(w, at, parts[i]);
    if (!km_piece_find_across(w, &w->sample))
      continue;
    for (int k = 0; k < 2; ++k)
      if (w->sides[piece][k].aspect == 0)
        find_side(w, &w->sides[piece][k], k == 0 ? 1 : -1, fmin(beside, most_beside * length));
  }
}

/* ---- Vertices. */

/* An end of a piece at a vertex. */
typedef struct piece_end {
  int piece;
  bool is_last;
  double angle; /* direction away from the vertex, in the tangent plane (τ, ν) of the first end; NaN: singular */
} piece_end;

static const km_curve_point *end_point(const km_workspace_search *w, const piece_end *e) {
  const km_outline_piece *piece = &w->pieces[e->piece];
  return &w->points[w->source[piece->first + (e->is_last ? piece->count - 1 : 0)]];
}

/* The side that the next end in the order of angles follows, or the one before. */
static km_piece_side *side_of(km_workspace_search *w, const piece_end *e, bool is_next) {
  return &w->sides[e->piece][is_next == e->is_last];
}

static int by_angle(const void *a, const void *b) {
  double x = ((const piece_end *)a)->angle, y = ((const piece_end *)b)->angle;
  return (x > y) - (x < y);
}

/* Moves the ends at the vertex of ends[first] behind it, in the order of their angles. Returns the end of them. */
static int gather_vertex(km_workspace_search *w, piece_end *ends, int count, int first) {
  km_driver_surface *f = &w->g->f;
  const km_curve_point *p = end_point(w, &ends[first]);
  int end = first;
  bool is_regular = km_piece_find_across(w, p);
  km_driver_surface_restore(f, p->saved);
  for (int i = first; i < count; ++i) {
    const km_curve_point *other = end_point(w, &ends[i]);
    if (km_driver_surface_difference(f, other->saved, f->step) > same_vertex)
      continue;
    piece_end at = ends[i];
    double sense = at.is_last ? -1.0 : 1.0;
    at.angle = is_regular ? atan2(sense * km_dot(other->tangent, w->nu, f->columns),
                                  sense * km_dot(other->tangent, p->tangent, f->columns))
                          : nan("");
    ends[i] = ends[end];
    ends[end++] = at;
  }
  qsort(ends + first, (size_t)(end - first), sizeof *ends, by_angle);
  return end;
}

void km_aspects_join(km_workspace_search *w, int a, int b) {
  int high = a > b ? a : b, low = a + b - high;
  for (int k = 0; k < w->piece_count; ++k)
    for (int side = 0; side < 2; ++side)
      if (w->sides[k][side].aspect == high)
        w->sides[k][side].aspect = low;
  for (int i = 1; i <= w->g->aspect_count; ++i)
    if (w->representative[i] == high)
      w->representative[i] = low;
}

/* Gives two neighbouring sides one aspect, if that of one is known. */
static bool join_sides(km_workspace_search *w, km_piece_side *a, km_piece_side *b) {
  if (a->aspect == b->aspect || a->jump == 0 || b->jump == 0 || a->signs[0] != b->signs[0] ||
      a->signs[1] != b->signs[1])
    return false;
  if (a->aspect == 0 || b->aspect == 0)
    a->aspect = b->aspect = a->aspect + b->aspect;
  else
    km_aspects_join(w, a->aspect, b->aspect);
  return true;
}

/* Joins the sides around the vertex of ends[first] to ends[end − 1]. */
static bool join_around(km_workspace_search *w, const piece_end *ends, int first, int end) {
  bool is_changed = false;
  for (int i = first; i < end && !isnan(ends[first].angle); ++i) {
    const piece_end *next = &ends[i + 1 < end ? i + 1 : first];
    is_changed = join_sides(w, side_of(w, &ends[i], true), side_of(w, next, false)) || is_changed;
  }
  return is_changed;
}

bool km_piece_sides_find(km_workspace_search *w) {
  int count = 0, vertices = 0;
  piece_end *ends = KM_ARENA_NEW(&w->g->arena, piece_end, 2 * (size_t)w->piece_count + 1);
  int *start = KM_ARENA_NEW(&w->g->arena, int, 2 * (size_t)w->piece_count + 2);
  w->representative = KM_ARENA_NEW(&w->g->arena, int, (size_t)w->g->aspect_count + 1);
  if (w->g->arena.failed)
    return false;
  for (int i = 0; i <= w->g->aspect_count; ++i)
    w->representative[i] = i;
  for (int k = 0; k < w->piece_count; ++k) {
    find_sides(w, k);
    ends[count++] = (piece_end){.piece = k};
    ends[count++] = (piece_end){.piece = k, .is_last = true};
  }
  for (int first = 0; first < count; first = start[vertices])
    start[++vertices] = gather_vertex(w, ends, count, first);
  for (bool is_changed = true; is_changed;) {
    is_changed = false;
    for (int v = 0; v < vertices; ++v)
      is_changed = join_around(w, ends, start[v], start[v + 1]) || is_changed;
  }
  return true;
}
