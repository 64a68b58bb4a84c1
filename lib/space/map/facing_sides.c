/* Aspects of grid points that no side of a curve leads to: those that grid steps cannot leave, such as one grid point
 * in the corner between two curves (docs/theory.md 4.22).
 *
 *   nearest point of a curve : least |Δq|; no other curve is between it and the grid point
 *   aspect                   : of that curve's side that faces the grid point, + ν if Δq·ν > 0 */
#include "space/map/map_workspace.h"

#include "base/number/vectors.h"

/* Nearest inner point of a piece to the state's configuration; −1: none. *piece: its piece. */
static long nearest_point(const km_workspace_search *w, int *piece) {
  km_driver_surface *f = &w->g->f;
  double nearest = HUGE_VAL;
  long best = -1;
  for (int k = 0; k < w->piece_count; ++k)
    for (size_t i = w->pieces[k].first + 1; i + 1 < w->pieces[k].first + w->pieces[k].count; ++i) {
      double distance = km_driver_surface_difference(f, w->points[w->source[i]].saved, f->step);
      if (distance >= nearest)
        continue;
      nearest = distance;
      *piece = k;
      best = (long)w->source[i];
    }
  return best;
}

/* Aspect of the side that faces a configuration; 0: the side has none, or other signs. */
static int facing_aspect(km_workspace_search *w, const double *saved) {
  km_driver_surface *f = &w->g->f;
  int piece;
  km_driver_surface_restore(f, saved);
  long nearest = nearest_point(w, &piece);
  if (nearest < 0 || !km_piece_find_across(w, &w->points[nearest]))
    return 0;
  km_driver_surface_restore(f, saved);
  km_driver_surface_difference(f, w->points[nearest].saved, f->step);
  const km_piece_side *side = &w->sides[piece][km_dot(f->step, w->nu, f->columns) < 0.0];
  return km_piece_has_signs(w, side->signs) ? side->aspect : 0;
}

bool km_facing_sides_join(km_workspace_search *w) {
  int cells = w->g->across * w->g->down;
  bool *has_side = KM_ARENA_NEW(&w->g->arena, bool, (size_t)w->g->aspect_count + 1);
  if (!has_side)
    return false;
  for (int k = 0; k < w->piece_count; ++k)
    for (int side = 0; side < 2; ++side)
      has_side[w->sides[k][side].aspect] = true;
  for (int i = 0; i <= w->g->aspect_count; ++i)
    has_side[i] = i == 0 || has_side[w->representative[i]];
  for (int cell = 0; cell < cells; ++cell)
    for (const km_known_configuration *at = w->g->known[cell]; at; at = at->next) {
      int aspect = has_side[at->aspect] ? 0 : facing_aspect(w, at->saved);
      if (aspect == 0)
        continue;
      km_aspects_join(w, at->aspect, aspect);
      has_side[at->aspect] = true;
    }
  return true;
}
