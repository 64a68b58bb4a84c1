/* The workspace of a map's point (docs/theory.md 4.22).
 *
 *   piece  : a part of a curve between crossings; its sides and their jumps are in piece_sides.c
 *   length : between two points |Δq| (θ/2) / sin(θ/2), θ the angle of their tangents
 *   N(p)   : configurations with the point at p of the chart, of all aspects or of one (space/outline/outline.h) */
#include "space/map/map_workspace.h"

#include "base/number/vectors.h"
#include "base/table.h"

#include <string.h>

enum { MOST_CHECKED = 2000 };
static const double edge_share = 1e-5; /* part of the extent: nearer grid points are on the outline */

static km_status no_memory(km_error *error) {
  return km_fail(error, KM_MEMORY, "out of memory for the workspace");
}

/* ---- Curves in the plane. */

static double curve_length(km_driver_surface *f, const km_curve_point *from, const km_curve_point *to) {
  km_driver_surface_restore(f, to->saved);
  double chord = km_driver_surface_difference(f, from->saved, f->step);
  double cosine = km_dot(from->tangent, to->tangent, f->columns);
  double half = 0.5 * acos(fmin(fmax(cosine, -1.0), 1.0));
  return half > 1e-6 ? chord * half / sin(half) : chord;
}

/* Chart of the point's place, and its derivative along the curve. */
static void fill_place(km_workspace_search *w, const km_curve_point *p, km_outline_point *out) {
  km_driver_surface *f = &w->g->f;
  km_vec3 tangent[2], rate = {0.0, 0.0, 0.0};
  km_driver_surface_restore(f, p->saved);
  km_driver_surface_update_output(f);
  km_vec3 place = km_driver_surface_place(f);
  km_point_surface_tangents(&f->point_surface, place, tangent);
  for (int i = 0; i < 2; ++i)
    rate = km_vec3_axpy(f->size * km_dot(f->G + i * f->columns, p->tangent, f->columns), tangent[i], rate);
  km_point_surface_chart(&f->point_surface, place, out->place);
  km_point_surface_chart_rate(&f->point_surface, place, rate, out->rate);
}

/* Divides the curves at crossings; the point of a crossing ends one piece and begins the next. */
static void divide(km_workspace_search *w) {
  size_t count = 0;
  for (size_t i = 0; i < w->point_count; ++i) {
    const km_curve_point *p = &w->points[i];
    bool is_first = i == 0 || p[-1].curve != p->curve, is_last = i + 1 == w->point_count || p[1].curve != p->curve;
    if (is_first)
      w->pieces[w->piece_count++] = (km_outline_piece){count, 0, (int)p->of.kind, p->curve};
    km_outline_piece *piece = &w->pieces[w->piece_count - 1];
    fill_place(w, p, &w->places[count]);
    w->places[count].length = is_last ? 0.0 : curve_length(&w->g->f, p, p + 1);
    w->source[count++] = i;
    ++piece->count;
    if (p->is_crossing && !is_last && !is_first) {
      w->pieces[w->piece_count++] = (km_outline_piece){count, 1, piece->kind, piece->curve};
      w->places[count] = w->places[count - 1];
      w->source[count++] = i;
    }
    if (is_last && piece->count < 2) {
      --w->piece_count;
      count = piece->first;
    }
  }
}

/* ---- Regions. */

/* Jumps of all sides, or of one aspect's. */
static void fill_jumps(km_workspace_search *w, int aspect) {
  for (int k = 0; k < w->piece_count; ++k) {
    w->jump[k] = 0;
    for (int side = 0; side < 2; ++side) {
      const km_piece_side *s = &w->sides[k][side];
      if (aspect > 0 ? s->aspect == aspect : !w->g->def->own_sheet || s->aspect > 0)
        w->jump[k] += s->jump;
    }
  }
}

static void place_in_space(const km_workspace_search *w, const double *chart, double *out) {
  km_vec3 at = km_point_surface_place(&w->g->f.point_surface, chart);
  km_vec3_write(at, out);
}

static bool add_boundary_row(km_workspace_search *w, const km_outline_part *part, double at) {
  double *row = km_table_add_row(w->g->out->boundary), place[2], rate[2];
  if (!row)
    return false;
  row[0] = part->loop;
  row[1] = w->pieces[part->piece].kind;
  row[2] = w->pieces[part->piece].curve;
  km_curve_net_place(&w->net, part->piece, at, place, rate);
  place_in_space(w, place, row + 3);
  if (w->g->f.point_surface.radius > 0.0)
    memcpy(row + 6, place, sizeof place);
  return true;
}

/* Writes a part from its start up to its end, which is the next one's start; `is_last`: with its end. */
static bool write_part(km_workspace_search *w, const km_outline_part *part, bool is_last) {
  double sense = part->to > part->from ? 1.0 : -1.0;
  bool is_ok = add_boundary_row(w, part, part->from);
  double at = sense > 0.0 ? floor(part->from) + 1.0 : ceil(part->from) - 1.0;
  for (; is_ok && sense * at < sense * part->to; at += sense)
    is_ok = add_boundary_row(w, part, at);
  return is_ok && (!is_last || add_boundary_row(w, part, part->to));
}

/* Least N of grid points that aren't on the outline, at most 1: of at most MOST_CHECKED, all or those of one aspect.
 * *outside: how many have N <= 0. */
static int least_count(km_workspace_search *w, int aspect, int *checked, int *outside) {
  const km_table *t = w->g->out->cells;
  size_t rows = km_table_rows(t), column = km_table_span(t, "point.").first, stride = 1 + rows / MOST_CHECKED;
  int least = 1;
  *checked = *outside = 0;
  for (size_t i = 0; i < rows; i += stride) {
    double place[2];
    if (aspect > 0 && km_table_row(t, i)[3] != aspect)
      continue;
    km_point_surface_chart(&w->g->f.point_surface, km_vec3_from_array(km_table_row(t, i) + column), place);
    ++*checked;
    int count = km_curve_net_count(&w->net, w->jump, place);
    if (count > 0 || km_curve_net_distance(&w->net, w->jump, place) <= edge_share * w->net.size)
      continue;
    least = count < least ? count : least;
    ++*outside;
  }
  return least;
}

/* Finds N at the chart's end: 0 where no grid point is; else the least with which all grid points have N > 0. */
static void find_count_at_end(km_workspace_search *w, int aspect) {
  int checked, outside;
  w->net.at_end = 0;
  if (w->is_end_reached)
    w->net.at_end = 1 - least_count(w, aspect, &checked, &outside);
}

static km_status find_whole(km_workspace_search *w, km_error *error) {
  km_space_map *out = w->g->out;
  km_outline outline;
  fill_jumps(w, 0);
  find_count_at_end(w, 0);
  if (!km_outline_find(&w->net, w->jump, &w->g->arena, &outline))
    return no_memory(error);
  out->workspace_area =
      isfinite(outline.gap) && (outline.area > 0.0 || km_table_rows(out->cells) == 0) ? outline.area : nan("");
  out->gap = outline.gap;
  out->hole_count = outline.hole_count;
  least_count(w, 0, &out->checked, &out->unbounded);
  for (int i = 0; i < outline.part_count; ++i) {
    bool is_last = i + 1 == outline.part_count || outline.parts[i + 1].loop != outline.parts[i].loop;
    if (!write_part(w, &outline.parts[i], is_last))
      return no_memory(error);
  }
  return KM_OK;
}

static km_status find_in_aspect(km_workspace_search *w, km_aspect_workspace *out, km_error *error) {
  km_outline outline;
  double centre[2] = {0.0}, low[2], high[2];
  fill_jumps(w, out->aspect);
  find_count_at_end(w, out->aspect);
  if (!km_outline_find(&w->net, w->jump, &w->g->arena, &outline))
    return no_memory(error);
  out->area = isfinite(outline.gap) && outline.area > 0.0 ? outline.area : nan("");
  if (outline.gap == 0.0 && w->g->f.point_surface.radius > 0.0)
    return km_map_find_largest_cone(w, out) ? KM_OK : no_memory(error);
  if (outline.gap > 0.0 || outline.part_count == 0)
    return KM_OK;
  if (!km_largest_rectangle(&w->net, w->jump, &w->g->arena, low, high))
    return no_memory(error);
  km_largest_circle(&w->net, w->jump, centre, &out->radius);
  if (out->radius > 0.0)
    place_in_space(w, centre, out->circle);
  for (int d = 0; d < 2; ++d)
    centre[d] = 0.5 * (low[d] + high[d]);
  if (high[0] > low[0])
    place_in_space(w, centre, out->rectangle);
  out->width = high[0] - low[0];
  out->height = high[1] - low[1];
  return KM_OK;
}

/* Numbers the aspects again from 1, in the cells and sides: each representative in its order, the others as it. */
static void number_again(km_workspace_search *w) {
  km_table *cells = w->g->out->cells;
  int count = 0, *number = w->representative; /* number[i] <= i */
  for (int i = 1; i <= w->g->aspect_count; ++i)
    number[i] = number[i] == i ? ++count : number[number[i]];
  for (size_t i = 0; i < km_table_rows(cells); ++i) {
    double *aspect = &km_table_cells(cells, i)[3];
    *aspect = number[(int)*aspect];
  }
  for (int k = 0; k < w->piece_count; ++k)
    for (int side = 0; side < 2; ++side)
      w->sides[k][side].aspect = number[w->sides[k][side].aspect];
  w->g->aspect_count = w->g->out->aspect_count = w->g->out->workspace_count = count;
}

static bool allocate(km_workspace_search *w) {
  km_arena *a = &w->g->arena;
  size_t n = (size_t)w->g->f.columns, most = 2 * w->point_count + 1;
  w->places = KM_ARENA_NEW(a, km_outline_point, most);
  w->pieces = KM_ARENA_NEW(a, km_outline_piece, most);
  w->source = KM_ARENA_NEW(a, size_t, most);
  w->sample.saved = KM_ARENA_NEW(a, double, w->g->f.saved_size);
  w->sample.tangent = KM_ARENA_NEW(a, double, n);
  w->M = KM_ARENA_NEW(a, double, n *n);
  w->K = KM_ARENA_NEW(a, double, n *n);
  w->nu = KM_ARENA_NEW(a, double, n);
  w->b = KM_ARENA_NEW(a, double, n);
  w->x = KM_ARENA_NEW(a, double, n);
  w->N = KM_ARENA_NEW(a, double, 2 * n);
  w->chord = KM_ARENA_NEW(a, double, 4 * n);
  w->row = KM_ARENA_NEW(a, int, n);
  return !a->failed;
}

static bool allocate_pieces(km_workspace_search *w) {
  km_arena *a = &w->g->arena;
  size_t count = (size_t)w->piece_count + 1;
  void *sides = km_arena_alloc(a, count, sizeof *w->sides);
  w->sides = sides;
  w->jump = KM_ARENA_NEW(a, int, count);
  w->g->out->workspaces = KM_NEW(km_aspect_workspace, (size_t)w->g->aspect_count + 1);
  return !a->failed && w->g->out->workspaces;
}

km_status km_map_find_workspace(km_map_search *g, km_error *error) {
  km_workspace_search w = {.g = g};
  w.points = km_surface_curves_points(g->curves, &w.point_count);
  if (!allocate(&w))
    return no_memory(error);
  km_status status = km_map_choose_chart(g, &w.is_end_reached, error);
  if (status)
    return status;
  divide(&w);
  if (!allocate_pieces(&w) || !km_curve_net_create(&w.net, w.places, w.pieces, w.piece_count, &g->arena))
    return no_memory(error);
  if (!km_piece_sides_find(&w) || !km_facing_sides_join(&w))
    return no_memory(error);
  number_again(&w);
  w.net.whole = km_point_surface_area(&g->f.point_surface);
  status = find_whole(&w, error);
  for (int i = 0; !status && i < g->out->workspace_count; ++i) {
    g->out->workspaces[i] = (km_aspect_workspace){.aspect = i + 1};
    km_map_begin_part(g, KM_MAP_SHARE_WORKSPACE, (size_t)i, (size_t)g->out->workspace_count);
    status = km_map_report(g, 0.0, error);
    if (!status)
      status = find_in_aspect(&w, &g->out->workspaces[i], error);
  }
  return status;
}
