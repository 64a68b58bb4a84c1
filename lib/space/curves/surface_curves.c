/* Curves on a surface of configurations (space/curves/surface_curves.h): which are known, and their rows.
 *
 *   known : a point of a known curve is near, or the interpolant of two of its points is nearer than 1e-5 */
#include "base/number/cubic.h"
#include "base/number/vectors.h"
#include "base/table.h"
#include "space/curves/curve_search.h"

#include <string.h>

static const double least_length = 1e-4; /* a shorter curve without ends is a crossing of others: one q for all z */
/* exceeds the longest step of a curve with its correction, 0.0203 */
static const double max_point_distance = 0.03;
static const double same_curve = 1e-5; /* distance from a curve's interpolant, whose error is 1e-9 */

static km_followed_point new_point(km_arena *a, const km_driver_surface *f) {
  size_t order = (size_t)km_driver_surface_joints(f);
  return (km_followed_point){.saved = KM_ARENA_NEW(a, double, f->saved_size),
                             .z = KM_ARENA_NEW(a, double, order),
                             .t = KM_ARENA_NEW(a, double, (size_t)f->columns + order)};
}

km_surface_curves *km_surface_curves_create(km_driver_surface *surface, km_table *table) {
  km_surface_curves *v = KM_NEW(km_surface_curves, 1);
  if (!v)
    return NULL;
  *v = (km_surface_curves){.table = table};
  km_arena *a = &v->arena;
  v->from = new_point(a, surface);
  v->start = new_point(a, surface);
  v->chord = KM_ARENA_NEW(a, double, 4 * (size_t)surface->columns);
  if (!km_curve_system_create(&v->system, surface, a)) {
    km_surface_curves_free(v);
    return NULL;
  }
  return v;
}

void km_surface_curves_free(km_surface_curves *v) {
  if (!v)
    return;
  km_free(v->points);
  km_free(v->found);
  km_free(v->critical);
  km_free(v->rows);
  km_arena_free(&v->arena);
  km_free(v);
}

int km_surface_curves_count(const km_surface_curves *v) {
  return v ? v->count : 0;
}

const km_turning_point *km_surface_curves_critical(const km_surface_curves *v, int *count) {
  *count = v->critical_count;
  return v->critical;
}

const km_curve_point *km_surface_curves_points(const km_surface_curves *v, size_t *count) {
  *count = v->point_count;
  return v->points;
}

static bool is_same_curve(const km_surface_curve *a, const km_surface_curve *b) {
  return a->kind == b->kind && a->column == b->column && a->bound == b->bound && a->is_signed == b->is_signed;
}

void km_curve_interpolate(int columns, const km_curve_point *p, const km_curve_point *next, const double *step,
                          double length, double *c) {
  for (int k = 0; k < columns; ++k)
    km_cubic_hermite(0.0, length * p->tangent[k], step[k], length * next->tangent[k], c + 4 * k);
}

/* Distance of the state from the interpolant between two points of a curve; infinite beyond the ends. */
static double distance_from_chord(km_surface_curves *v, const km_curve_point *p, const km_curve_point *next) {
  km_driver_surface *f = v->system.f;
  double *from = v->system.x, *step = v->system.R, u;
  km_driver_surface_difference(f, next->saved, step);
  km_driver_surface_difference(f, p->saved, from);
  for (int k = 0; k < f->columns; ++k)
    step[k] = from[k] - step[k];
  km_curve_interpolate(f->columns, p, next, step, km_norm(step, f->columns), v->chord);
  return km_cubic_distance(v->chord, f->columns, from, &u);
}

/* First point from number i on, of a known curve of this kind, that is nearer to the state than `distance`; the number
 * of points if there is none. Consecutive points of a curve are closer than max_point_distance. So, if one is at
 * distance d, the next (d − distance) / max_point_distance points of its curve are no nearer than `distance`. */
static size_t find_near(const km_surface_curves *v, size_t i, double distance) {
  while (i < v->point_count) {
    const km_curve_point *p = &v->points[i];
    double excess = HUGE_VAL; /* curves of other kinds are passed as a whole */
    if (is_same_curve(&p->of, &v->system.of))
      excess = km_driver_surface_difference(v->system.f, p->saved, v->system.f->step) - distance;
    if (excess < 0.0)
      break;
    double along = max_point_distance;
    for (++i; i < v->point_count && v->points[i].curve == p->curve && along <= excess; ++i)
      along += max_point_distance;
  }
  return i;
}

/* True if the state is on a known curve of this kind. */
static bool is_on_known(km_surface_curves *v) {
  size_t i = find_near(v, 0, max_point_distance);
  for (; i + 1 < v->point_count; i = find_near(v, i + 1, max_point_distance))
    if (v->points[i + 1].curve == v->points[i].curve &&
        distance_from_chord(v, &v->points[i], &v->points[i + 1]) < same_curve)
      return true;
  return false;
}

/* True if a point of a known curve of this kind is nearer to the state than `distance`. */
static bool is_known(const km_surface_curves *v, double distance) {
  return find_near(v, 0, distance) < v->point_count;
}

/* Writes the found points and their rows from `first` in steps of ±1 until `end`. False when out of memory. */
static bool write_points(km_surface_curves *v, size_t first, size_t end, int by) {
  size_t width = km_table_columns(v->table);
  void *points = v->points;
  if (!km_reserve(&points, &v->capacity, v->point_count + v->row_count + 1, sizeof *v->points))
    return false;
  v->points = points;
  for (size_t i = first; i != end; i += (size_t)by) {
    double *row = km_table_add_row(v->table);
    if (!row)
      return false;
    memcpy(row, v->rows + i * width, width * sizeof *row);
    km_curve_point *point = &v->points[v->point_count++];
    *point = v->found[i];
    for (int k = 0; k < v->system.f->columns; ++k)
      point->tangent[k] *= by;
  }
  return true;
}

bool km_surface_curves_add(km_surface_curves *v, const km_surface_curve *of, const double *saved, double distance) {
  km_driver_surface *f = v->system.f;
  km_curve_system_choose(&v->system, of);
  km_driver_surface_restore(f, saved);
  if (is_known(v, distance + km_longest_curve_step) || !km_curve_system_enter(&v->system) ||
      km_curve_margin(v) < -km_at_curve_end || is_on_known(v))
    return true;
  ++v->count;
  v->row_count = 0;
  km_followed_point_save(v, &v->start);
  bool is_closed = false;
  double length, other_length;
  int critical_count = v->critical_count;
  if (!km_curve_add_point(v, KM_TURNING_NONE) || !km_curve_follow(v, &is_closed, &length))
    return false;
  size_t first = v->row_count;
  if (is_closed && length > least_length)
    return write_points(v, 0, first, 1) && write_points(v, 0, 1, 1);
  km_followed_point_restore(v, &v->start);
  for (int i = 0; i < v->system.unknowns; ++i)
    v->system.t[i] = -v->system.t[i];
  if (!km_curve_follow(v, &is_closed, &other_length))
    return false;
  if (length + other_length < least_length) {
    --v->count;
    v->critical_count = critical_count;
    return true;
  }
  return write_points(v, first - 1, (size_t)-1, -1) && write_points(v, first, v->row_count, 1);
}

bool km_surface_curves_leave(km_surface_curves *v, size_t i, double distance, bool *is_point) {
  km_driver_surface *f = v->system.f;
  *is_point = i < v->point_count;
  if (!*is_point || v->points[i].of.kind != KM_CURVE_INPUT)
    return false;
  km_curve_system_choose(&v->system, &v->points[i].of);
  km_driver_surface_restore(f, v->points[i].saved);
  if (!km_curve_system_start_vector(&v->system))
    return false;
  memset(f->step, 0, (size_t)f->columns * sizeof *f->step);
  for (int k = 0; k < v->system.order; ++k)
    f->step[k] = distance * v->system.z[k];
  return km_driver_surface_move(f, f->step);
}

/* Allocates the points from `first` up to `count`, and their rows. False when out of memory. */
static bool add_raw_points(km_surface_curves *v, size_t first, size_t count) {
  const km_driver_surface *f = v->system.f;
  void *points = v->points;
  if (!km_reserve(&points, &v->capacity, count + 1, sizeof *v->points))
    return false;
  v->points = points;
  for (size_t i = first; i < count; ++i)
    v->points[i] = (km_curve_point){.saved = KM_ARENA_NEW(&v->arena, double, f->saved_size),
                                    .tangent = KM_ARENA_NEW(&v->arena, double, (size_t)f->columns)};
  v->point_count = count;
  return !v->arena.failed && (count == first || km_table_add_raw_rows(v->table, count - first));
}

bool km_surface_curves_pass(km_surface_curves *v, size_t first, km_piece *piece) {
  const km_driver_surface *f = v->system.f;
  size_t count = v->point_count, width = km_table_columns(v->table);
  km_piece_pass(piece, &v->count, sizeof v->count);
  km_piece_pass(piece, &count, sizeof count);
  if (piece->is_read && !piece->failed && !add_raw_points(v, first, count))
    return false;
  for (size_t i = first; i < v->point_count; ++i) {
    km_curve_point *p = &v->points[i];
    km_piece_pass(piece, p->saved, f->saved_size * sizeof *p->saved);
    km_piece_pass(piece, p->tangent, (size_t)f->columns * sizeof *p->tangent);
    km_piece_pass(piece, &p->of.kind, sizeof p->of.kind);
    km_piece_pass(piece, &p->of.column, sizeof p->of.column);
    km_piece_pass(piece, &p->of.bound, sizeof p->of.bound);
    km_piece_pass(piece, &p->of.is_signed, sizeof p->of.is_signed);
    km_piece_pass(piece, &p->curve, sizeof p->curve);
    km_piece_pass(piece, &p->is_crossing, sizeof p->is_crossing);
    km_piece_pass(piece, &p->crossing, sizeof p->crossing);
    km_piece_pass(piece, km_table_cells(v->table, i), width * sizeof(double));
  }
  return true;
}
