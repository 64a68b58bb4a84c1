/* Aspects of a sheet on the grid of a map (docs/theory.md 4.19): parts that steps join without a root of det (J; G). */
#include "space/map/map_search.h"

#include <stdlib.h>

/* The cell across the seam of an axis that is a full turn of a hinge: the same configuration; −1: there is none. */
static int across_seam(km_map_search *g, int cell, int axis) {
  int i = cell % g->across, j = cell / g->across, last = axis == 0 ? g->across - 1 : g->down - 1;
  int at = axis == 0 ? i : j, other = last - at;
  if ((at != 0 && at != last) || km_map_axis_ends(g, axis))
    return -1;
  int next = axis == 0 ? j * g->across + other : other * g->across + i;
  if (!g->sign[next] || !g->is_written[next])
    return -1;
  km_driver_surface_restore(&g->f, g->saved + (size_t)cell * g->f.saved_size);
  return km_map_is_at(g, g->saved + (size_t)next * g->f.saved_size) ? next : -1;
}

/* True if the step between two neighbours leads from one configuration to the other without a root of det (J; G). The
 * tangents and the cubic of det (J; G) show that, or the step is followed: two curves may cross the step near the place
 * where they cross each other. */
static bool is_one_aspect(km_map_search *g, int cell, int next) {
  km_driver_surface *f = &g->f;
  if (!g->is_written[next] || g->output_sign[next] != g->output_sign[cell])
    return false;
  bool has_point = f->frame >= 0;
  int axis = abs(next - cell) == 1 ? 0 : 1;
  double sense = next > cell ? 1.0 : -1.0,
         step = sense * (km_map_axis_value(g, axis, 1) - km_map_axis_value(g, axis, 0));
  const double du[2] = {axis == 0 ? step : 0.0, axis == 1 ? step : 0.0};
  size_t columns = 2 * (size_t)f->columns;
  const double *saved = g->saved + (size_t)cell * f->saved_size, *there = g->saved + (size_t)next * f->saved_size;
  const double *D = g->output + (has_point ? 3 * (size_t)cell : 0),
               *D_there = g->output + (has_point ? 3 * (size_t)next : 0);
  double sign = D[0] < 0.0 ? -1.0 : 1.0;
  km_driver_surface_restore(f, there);
  if (km_map_is_smooth(g, saved, g->N + (size_t)cell * columns, g->N + (size_t)next * columns, du) &&
      (!has_point || (km_map_has_sign(sign, D[0], sense * D[1 + axis]) &&
                      km_map_has_sign(sign, D_there[0], -sense * D_there[1 + axis]))))
    return true;
  g->kept_sign = has_point ? (int)sign : 0;
  bool is_kept = km_map_reach(g, cell, next, g->edge_N) && km_map_is_at(g, there);
  g->kept_sign = 0;
  return is_kept;
}

void km_map_number_aspect(km_map_search *g, int first, int *stack) {
  int size = 0;
  g->aspect[first] = ++g->aspect_count;
  stack[size++] = first;
  while (size > 0) {
    int cell = stack[--size];
    for (int k = 0; k < 4; ++k) {
      int next = km_map_neighbour(g, cell, k);
      if (next < 0 || g->aspect[next] || !is_one_aspect(g, cell, next))
        continue;
      g->aspect[next] = g->aspect_count;
      stack[size++] = next;
    }
    for (int d = 0; d < 2; ++d) {
      int next = across_seam(g, cell, d);
      if (next < 0 || g->aspect[next])
        continue;
      g->aspect[next] = g->aspect_count;
      stack[size++] = next;
    }
  }
}
