/* The workspace of a map's point (docs/theory.md 4.22).
 *
 *   piece  : a part of a curve between crossings; τ its unit tangent, ν ⊥ τ with J ν = 0, det (J; τ; ν) > 0
 *   side   : configurations at ± ν; in the image on the left of the curve if ± det (J; G) > 0
 *   aspect : the grid point to which drivers lead from there without a change of det A and det (J; G)
 *   length : between two points |Δq| (θ/2) / sin(θ/2), θ the angle of their tangents */
#include "space/map_search.h"

#include "base/number/vectors.h"
#include "base/random.h"
#include "base/table.h"
#include "space/outline.h"
#include "space/real_solve.h"

#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 7 /* of a piece */, MOST_NEWTON = 8, MOST_CHECKED = 2000 };
static const double beside = 1e-3;                /* distance at which the signs of a side are taken */
static const double distances[] = {0.05, 0.02, 0.1}; /* from which a side's grid point is reached */
static const double converged = 1e-12;
static const double edge_share = 1e-5; /* part of the extent: nearer grid points are on the outline */

/* One side of a piece. */
typedef struct piece_side {
  int jump;   /* 1: on the left of the image, −1: on the right, 0: outside the ranges */
  int aspect; /* 0: not found */
} piece_side;

typedef struct workspace_search {
  km_map_search *g;
  const km_curve_point *points;
  size_t point_count;
  km_outline_point *places;
  km_outline_piece *pieces;
  size_t *source; /* [places] the curve's point */
  piece_side (*sides)[2];
  int piece_count;
  km_curve_net net;
  int *jump; /* [piece] workspace */
  double *M, *nu, *b, *x, *K, *N;
  int *row;
  km_vec3 normal;
  double height; /* of the plane along its normal */
} workspace_search;

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

/* Place of the point, and its derivative along the curve. */
static void fill_place(workspace_search *w, const km_curve_point *p, km_outline_point *out) {
  km_driver_surface *f = &w->g->f;
  double place[3];
  km_driver_surface_restore(f, p->saved);
  km_driver_surface_update_output(f);
  km_frame_position(f->m, f->s, f->frame, place);
  km_vec3 at = km_vec3_from_array(place);
  w->height = km_vec3_dot(at, w->normal);
  for (int i = 0; i < 2; ++i) {
    out->place[i] = km_vec3_dot(at, f->axis[i]);
    out->rate[i] = f->size * km_dot(f->G + i * f->columns, p->tangent, f->columns);
  }
}

/* Divides the curves at crossings; the point of a crossing ends one piece and begins the next. */
static void divide(workspace_search *w) {
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

/* ---- Sides of the pieces. */

/* Fills M with the rows J, τ and `last`. */
static void fill_matrix(workspace_search *w, const double *tangent, const double *last) {
  const km_driver_surface *f = &w->g->f;
  int n = f->columns, r = f->rows;
  for (int i = 0; i < r; ++i)
    for (int k = 0; k < n; ++k)
      w->M[i * n + k] = f->J[k * r + i];
  memcpy(w->M + r * n, tangent, (size_t)n * sizeof *tangent);
  memcpy(w->M + (r + 1) * n, last, (size_t)n * sizeof *last);
}

/* Finds ν at a point of a curve. */
static bool find_across(workspace_search *w, const km_curve_point *p) {
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
static bool move_across(workspace_search *w, const km_curve_point *p, double distance) {
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
      return true;
  }
  return false;
}

/* Signs of det A and det (J; G) at the state's configuration. */
static void find_signs(workspace_search *w, int *signs) {
  km_driver_surface *f = &w->g->f;
  km_driver_surface_update(f);
  km_driver_surface_update_output(f);
  for (int kind = 0; kind < 2; ++kind) {
    km_driver_surface_matrix(f, kind == 0 ? KM_CURVE_INPUT : KM_CURVE_OUTPUT, w->K);
    signs[kind] = km_real_determinant(w->K, f->columns, w->row) < 0.0 ? -1 : 1;
  }
}

/* Aspect of the configurations at this side with these signs; 0: not found. */
static int find_aspect(workspace_search *w, const km_curve_point *p, int side, const int *signs) {
  for (size_t i = 0; i < sizeof distances / sizeof *distances; ++i) {
    int there[2], sign;
    if (!move_across(w, p, side * distances[i]) || km_driver_surface_margin(&w->g->f, -1) < 0.0)
      continue;
    find_signs(w, there);
    if (there[0] != signs[0] || there[1] != signs[1])
      continue;
    int cell = km_map_enter_grid(w->g, &sign, w->N);
    const km_known_configuration *known = cell >= 0 ? km_map_find_known(w->g, cell) : NULL;
    if (!known || known->aspect == 0)
      continue;
    find_signs(w, there);
    if (there[0] == signs[0] && there[1] == signs[1])
      return known->aspect;
  }
  return 0;
}

/* Finds both sides of a piece: their signs in its middle, their aspects at some of its points. */
static void find_sides(workspace_search *w, int piece) {
  const km_outline_piece *at = &w->pieces[piece];
  piece_side *sides = w->sides[piece];
  for (int sample = 0; sample < SAMPLES; ++sample) {
    size_t part = (size_t)((sample + 1) / 2), middle = at->count / 2, stride = at->count / (SAMPLES + 1);
    const km_curve_point *p =
        &w->points[w->source[at->first + (sample % 2 ? middle - part * stride : middle + part * stride)]];
    int signs[2];
    bool is_regular = find_across(w, p);
    for (int k = 0; k < 2 && is_regular; ++k) {
      int side = k == 0 ? 1 : -1;
      if (sides[k].aspect != 0 || !move_across(w, p, side * beside))
        continue;
      bool is_inside = km_driver_surface_margin(&w->g->f, -1) >= 0.0;
      find_signs(w, signs);
      if (sample == 0)
        sides[k].jump = is_inside ? signs[1] * side : 0;
      if (sides[k].jump != 0)
        sides[k].aspect = find_aspect(w, p, side, signs);
    }
  }
}

/* ---- Regions. */

/* Jumps of all sides, or of one aspect's. */
static void fill_jumps(workspace_search *w, int aspect) {
  for (int k = 0; k < w->piece_count; ++k) {
    w->jump[k] = 0;
    for (int side = 0; side < 2; ++side) {
      const piece_side *s = &w->sides[k][side];
      if (aspect > 0 ? s->aspect == aspect : !w->g->def->own_sheet || s->aspect > 0)
        w->jump[k] += s->jump;
    }
  }
}

static void place_in_space(const workspace_search *w, const double *place, double *out) {
  const km_driver_surface *f = &w->g->f;
  km_vec3 at = km_vec3_add(km_vec3_scale(place[0], f->axis[0]), km_vec3_scale(place[1], f->axis[1]));
  at = km_vec3_add(at, km_vec3_scale(w->height, w->normal));
  out[0] = at.x;
  out[1] = at.y;
  out[2] = at.z;
}

static bool add_boundary_row(workspace_search *w, const km_outline_part *part, double at) {
  double *row = km_table_add_row(w->g->out->boundary), place[2], rate[2];
  if (!row)
    return false;
  row[0] = part->loop;
  row[1] = w->pieces[part->piece].kind;
  row[2] = w->pieces[part->piece].curve;
  km_curve_net_place(&w->net, part->piece, at, place, rate);
  place_in_space(w, place, row + 3);
  return true;
}

/* Writes a part from its start up to its end, which is the next one's start; `is_last`: with its end. */
static bool write_part(workspace_search *w, const km_outline_part *part, bool is_last) {
  double sense = part->to > part->from ? 1.0 : -1.0;
  bool is_ok = add_boundary_row(w, part, part->from);
  double at = sense > 0.0 ? floor(part->from) + 1.0 : ceil(part->from) - 1.0;
  for (; is_ok && sense * at < sense * part->to; at += sense)
    is_ok = add_boundary_row(w, part, at);
  return is_ok && (!is_last || add_boundary_row(w, part, part->to));
}

/* Grid points, of at most MOST_CHECKED, whose place isn't within the outline, nor on it. */
static int count_unbounded(workspace_search *w) {
  const km_driver_surface *f = &w->g->f;
  const km_table *t = w->g->out->cells;
  size_t rows = km_table_rows(t), column = km_table_span(t, "point.").first, stride = 1 + rows / MOST_CHECKED;
  int count = 0;
  for (size_t i = 0; i < rows; i += stride) {
    km_vec3 at = km_vec3_from_array(km_table_row(t, i) + column);
    double e = edge_share * w->net.size, place[2] = {km_vec3_dot(at, f->axis[0]), km_vec3_dot(at, f->axis[1])};
    bool is_within = false;
    for (int k = 0; k < 5 && !is_within; ++k) {
      const double near[2] = {place[0] + e * ((k == 1) - (k == 2)), place[1] + e * ((k == 3) - (k == 4))};
      is_within = km_curve_net_count(&w->net, w->jump, near) > 0;
    }
    count += !is_within;
  }
  return count;
}

static km_status find_whole(workspace_search *w, km_error *error) {
  km_space_map *out = w->g->out;
  km_outline outline;
  fill_jumps(w, 0);
  if (!km_outline_find(&w->net, w->jump, &w->g->arena, &outline))
    return no_memory(error);
  out->workspace_area = outline.is_closed ? outline.area : nan("");
  out->hole_count = outline.hole_count;
  out->unbounded = count_unbounded(w);
  for (int i = 0; i < outline.part_count; ++i) {
    bool is_last = i + 1 == outline.part_count || outline.parts[i + 1].loop != outline.parts[i].loop;
    if (!write_part(w, &outline.parts[i], is_last))
      return no_memory(error);
  }
  return KM_OK;
}

static km_status find_in_aspect(workspace_search *w, km_aspect_workspace *out, km_error *error) {
  km_outline outline;
  double centre[2], low[2], high[2];
  fill_jumps(w, out->aspect);
  if (!km_outline_find(&w->net, w->jump, &w->g->arena, &outline) ||
      !km_largest_rectangle(&w->net, w->jump, &w->g->arena, low, high))
    return no_memory(error);
  out->area = outline.is_closed && outline.part_count > 0 ? outline.area : nan("");
  if (!isfinite(out->area))
    return KM_OK;
  km_largest_circle(&w->net, w->jump, centre, &out->radius);
  place_in_space(w, centre, out->circle);
  for (int d = 0; d < 2; ++d)
    centre[d] = 0.5 * (low[d] + high[d]);
  place_in_space(w, centre, out->rectangle);
  out->width = high[0] - low[0];
  out->height = high[1] - low[1];
  return KM_OK;
}

static bool allocate(workspace_search *w) {
  km_arena *a = &w->g->arena;
  size_t n = (size_t)w->g->f.columns, most = 2 * w->point_count + 1;
  w->places = KM_ARENA_NEW(a, km_outline_point, most);
  w->pieces = KM_ARENA_NEW(a, km_outline_piece, most);
  w->source = KM_ARENA_NEW(a, size_t, most);
  w->M = KM_ARENA_NEW(a, double, n *n);
  w->K = KM_ARENA_NEW(a, double, n *n);
  w->nu = KM_ARENA_NEW(a, double, n);
  w->b = KM_ARENA_NEW(a, double, n);
  w->x = KM_ARENA_NEW(a, double, n);
  w->N = KM_ARENA_NEW(a, double, 2 * n);
  w->row = KM_ARENA_NEW(a, int, n);
  return !a->failed;
}

static bool allocate_pieces(workspace_search *w) {
  km_arena *a = &w->g->arena;
  size_t count = (size_t)w->piece_count + 1;
  void *sides = km_arena_alloc(a, count, sizeof *w->sides);
  w->sides = sides;
  w->jump = KM_ARENA_NEW(a, int, count);
  w->g->out->workspaces = KM_NEW(km_aspect_workspace, (size_t)w->g->aspect_count + 1);
  return !a->failed && w->g->out->workspaces;
}

km_status km_map_find_workspace(km_map_search *g, const km_surface_curves *curves, km_error *error) {
  workspace_search w = {.g = g, .normal = km_vec3_cross(g->f.axis[0], g->f.axis[1])};
  w.points = km_surface_curves_points(curves, &w.point_count);
  if (!allocate(&w))
    return no_memory(error);
  divide(&w);
  if (!allocate_pieces(&w) || !km_curve_net_create(&w.net, w.places, w.pieces, w.piece_count, &g->arena))
    return no_memory(error);
  for (int k = 0; k < w.piece_count; ++k)
    find_sides(&w, k);
  km_status status = find_whole(&w, error);
  g->out->workspace_count = g->aspect_count;
  for (int i = 0; !status && i < g->aspect_count; ++i) {
    g->out->workspaces[i] = (km_aspect_workspace){.aspect = i + 1};
    status = find_in_aspect(&w, &g->out->workspaces[i], error);
  }
  return status;
}
