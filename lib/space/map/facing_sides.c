/* Aspects of grid points that no side of a curve leads to: those that grid steps cannot leave, such as one grid point
 * in the corner between two curves (docs/theory.md 4.22).
 *
 *   nearest point of a curve : least |Δq|; no other curve is between it and the grid point
 *   aspect                   : of that curve's side that faces the grid point, + ν if Δq·ν > 0; where it has other
 *                              signs, as near the end of a piece, of the next nearest piece's */
#include "space/map/map_workspace.h"

#include "base/number/vectors.h"

/* The inner point of a piece that is nearest to the state's configuration; *distance: infinite if there is none. */
static size_t nearest_point(const km_workspace_search *w, int piece, double *distance) {
  km_driver_surface *f = &w->g->f;
  const km_outline_piece *at = &w->pieces[piece];
  size_t best = 0;
  *distance = HUGE_VAL;
  for (size_t i = at->first + 1; i + 1 < at->first + at->count; ++i) {
    double d = km_driver_surface_difference(f, w->points[w->source[i]].saved, f->step);
    if (d >= *distance)
      continue;
    *distance = d;
    best = w->source[i];
  }
  return best;
}

/* Aspect of a piece's side that faces a configuration; 0: the side has none, or other signs. */
static int facing_aspect(km_workspace_search *w, int piece, const km_curve_point *p, const double *saved) {
  km_driver_surface *f = &w->g->f;
  if (!km_piece_find_across(w, p))
    return 0;
  km_driver_surface_restore(f, saved);
  km_driver_surface_difference(f, p->saved, f->step);
  const km_piece_side *side = &w->sides[piece][km_dot(f->step, w->nu, f->columns) < 0.0];
  return km_piece_has_signs(w, side->signs) ? side->aspect : 0;
}

/* The nearest piece of those with a finite distance; −1: none. */
static int nearest_piece(const km_workspace_search *w, const double *distance) {
  int nearest = -1;
  for (int k = 0; k < w->piece_count; ++k)
    if (isfinite(distance[k]) && (nearest < 0 || distance[k] < distance[nearest]))
      nearest = k;
  return nearest;
}

/* Aspect of the nearest side that faces a configuration and has its signs; 0: none. */
static int nearest_aspect(km_workspace_search *w, const double *saved, double *distance, size_t *point) {
  int aspect = 0;
  km_driver_surface_restore(&w->g->f, saved);
  for (int k = 0; k < w->piece_count; ++k)
    point[k] = nearest_point(w, k, &distance[k]);
  for (int k = nearest_piece(w, distance); aspect == 0 && k >= 0; k = nearest_piece(w, distance)) {
    aspect = facing_aspect(w, k, &w->points[point[k]], saved);
    distance[k] = HUGE_VAL;
  }
  return aspect;
}

bool km_facing_sides_join(km_workspace_search *w) {
  int cells = w->g->across * w->g->down;
  bool *has_side = KM_ARENA_NEW(&w->g->arena, bool, (size_t)w->g->aspect_count + 1);
  double *distance = KM_ARENA_NEW(&w->g->arena, double, (size_t)w->piece_count + 1);
  size_t *point = KM_ARENA_NEW(&w->g->arena, size_t, (size_t)w->piece_count + 1);
  if (w->g->arena.failed)
    return false;
  for (int k = 0; k < w->piece_count; ++k)
    for (int side = 0; side < 2; ++side)
      has_side[w->sides[k][side].aspect] = true;
  for (int i = 0; i <= w->g->aspect_count; ++i)
    has_side[i] = i == 0 || has_side[w->representative[i]];
  for (int cell = 0; cell < cells; ++cell)
    for (const km_known_configuration *at = w->g->known[cell]; at; at = at->next) {
      int aspect = has_side[at->aspect] ? 0 : nearest_aspect(w, at->saved, distance, point);
      if (aspect == 0)
        continue;
      km_aspects_join(w, at->aspect, aspect);
      has_side[at->aspect] = true;
    }
  return true;
}
