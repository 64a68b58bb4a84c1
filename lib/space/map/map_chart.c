/* The chart of a sphere on which a map's point moves (docs/theory.md 4.22).
 *
 *   end of the chart : the direction n, of a spiral's, with the largest d_g(n) d_c(n): chords from n to the places of
 *                      grid points and of curves
 *   reached          : d_g < d_c: no curve is between the end and the nearest grid point */
#include "space/map/map_workspace.h"

#include "base/table.h"

enum { DIRECTIONS = 500, MOST_PLACES = 20000 /* per table */ };
static const double off_surface = 1e-8; /* distance of a place on the surface, by the part's size */

/* Distance of the nearest place of a table, over the radius; infinite without rows. */
static double nearest_chord(const km_point_surface *s, const km_table *t, km_vec3 direction) {
  size_t rows = km_table_rows(t), column = km_table_span(t, "point.").first, stride = 1 + rows / MOST_PLACES;
  km_vec3 place = km_vec3_axpy(s->radius, direction, km_vec3_from_array(s->origin));
  double nearest = HUGE_VAL;
  for (size_t i = 0; i < rows; i += stride)
    nearest = fmin(nearest, km_vec3_norm(km_vec3_sub(km_vec3_from_array(km_table_row(t, i) + column), place)));
  return nearest / s->radius;
}

/* Direction i of a spiral. */
static km_vec3 direction_at(int i) {
  double z = 1.0 - (2.0 * i + 1.0) / DIRECTIONS, angle = i * M_PI * (3.0 - sqrt(5.0)), across = sqrt(1.0 - z * z);
  return (km_vec3){across * cos(angle), across * sin(angle), z};
}

/* Fills the chart's columns. False: a place is off the surface. */
static bool fill_chart(const km_driver_surface *f, km_table *t) {
  size_t place = km_table_span(t, "point.").first, chart = km_table_span(t, "chart.").first;
  bool is_on = true;
  for (size_t i = 0; is_on && i < km_table_rows(t); ++i) {
    km_vec3 at = km_vec3_from_array(km_table_row(t, i) + place);
    is_on = km_point_surface_distance(&f->point_surface, at) <= off_surface * f->size;
    if (f->point_surface.radius > 0.0)
      km_point_surface_chart(&f->point_surface, at, km_table_cells(t, i) + chart);
  }
  return is_on;
}

km_status km_map_choose_chart(km_map_search *g, bool *is_end_reached, km_error *error) {
  km_point_surface *s = &g->f.point_surface;
  km_vec3 end = {0.0, 0.0, 0.0};
  double largest = 0.0;
  *is_end_reached = false;
  for (int i = 0; s->radius > 0.0 && i < DIRECTIONS; ++i) {
    km_vec3 direction = direction_at(i);
    double from_grid = nearest_chord(s, g->out->cells, direction);
    double from_curves = fmin(nearest_chord(s, g->out->curves, direction), 2.0);
    if (from_grid * from_curves <= largest)
      continue;
    largest = from_grid * from_curves;
    end = direction;
    *is_end_reached = from_grid < from_curves;
  }
  if (largest > 0.0)
    km_point_surface_turn(s, km_vec3_scale(-1.0, end));
  g->out->surface = *s;
  return fill_chart(&g->f, g->out->cells) && fill_chart(&g->f, g->out->curves)
             ? KM_OK
             : km_fail(error, KM_USAGE, "point %s leaves its %s in another assembly mode", g->def->point_name,
                       s->radius > 0.0 ? "sphere" : "plane");
}
