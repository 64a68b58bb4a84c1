/* Real solutions of the closed loops (real_endpoints.h). */
#include "space/complex/real_endpoints.h"

#include "kinematics/loop_equations.h"

#include <string.h>

/* Imaginary part of a pose that is rounding, over its largest part; that of a singular end, where a double solution has
 * the root of the rounding; and of one that may belong to a curve of solutions. */
static const double real_part = 1e-6, real_coordinate = 1e-5, singular_real_part = 1e-3;
/* Parts of poses, in sizes, beyond which a solution goes to infinity. */
static const double infinite_extent = 1e4;
enum { DETOURS = 3, STARTS = 40 };

typedef struct endpoint_search {
  km_fibre_search *search;
  const km_complex_closure *closure;
  km_mode_workspace *work;
  km_arena *arena;
  bool is_overconstrained;   /* rows are left out of the system */
  km_fibre closed;           /* solutions of the closed loops, to see paths that meet */
  km_wide *x, *start, *real; /* [length] */
  km_complex *detour;        /* [parameters] */
  km_real_endpoints *out;
} endpoint_search;

/* Follows one solution: straight, else by way of random errors. */
static km_path_outcome follow(endpoint_search *w, int i) {
  km_monodromy *g = &w->search->graph;
  size_t bytes = (size_t)g->h->length * sizeof(km_wide);
  km_path_outcome outcome = KM_PATH_SINGULAR;
  for (int k = 0; k <= DETOURS; ++k) {
    memcpy(w->x, g->node[0].points + (size_t)i * (size_t)g->h->length, bytes);
    const km_complex *from = g->node[0].parameters;
    if (k > 0) {
      km_homotopy_draw(g->h, g->random, w->detour);
      if (km_monodromy_track(g, from, w->detour, w->x) != KM_PATH_ARRIVED)
        continue;
      from = w->detour;
    }
    outcome = km_monodromy_track(g, from, w->closed.parameters, w->x);
    if (outcome == KM_PATH_INFINITE || (outcome == KM_PATH_ARRIVED && km_fibre_find(g, &w->closed, w->x) < 0))
      return outcome;
    if (outcome == KM_PATH_SINGULAR && k == 0)
      memcpy(w->start, w->x, bytes); /* the straight path's end */
    else if (outcome == KM_PATH_ARRIVED)
      outcome = KM_PATH_SINGULAR;
  }
  memcpy(w->x, w->start, bytes);
  return outcome;
}

/* Largest imaginary part of a column's number, or of its ball's quaternion. */
static double imaginary_part(const endpoint_search *w, int column) {
  const km_complex_closure *c = w->closure;
  int ball = c->m->ball_of[c->m->column_coordinate[c->sub->column_start + column]];
  int first = ball < 0 ? column : c->m->column_of[c->m->ball_coordinate[ball]];
  double largest = 0.0;
  for (int i = 0; i < (ball < 0 ? 1 : 4); ++i)
    largest = fmax(largest, fabs((double)cimagl(w->x[c->start_of[first] + i])));
  return largest;
}

/* True if the coordinates are real. Real poses of all bodies are not enough: a universal joint may not reach them. If
 * passive bodies move, their coordinates may be complex at a real mode. */
static bool has_real_coordinates(const endpoint_search *w) {
  double largest = 0.0;
  for (int i = 0; i < w->closure->size; ++i)
    largest = fmax(largest, imaginary_part(w, w->closure->column_of[i]));
  return largest <= real_coordinate || w->closure->passive > 0;
}

/* Locks the coordinates whose numbers are real, so that passive ones alone are closed again. */
static void lock_real(endpoint_search *w) {
  const km_complex_closure *c = w->closure;
  for (int k = 0; k < c->sub->columns; ++k) {
    int coordinate = c->m->column_coordinate[c->sub->column_start + k], ball = c->m->ball_of[coordinate];
    int first = ball < 0 ? k : c->m->column_of[c->m->ball_coordinate[ball]];
    bool is_unknown = false;
    for (int i = 0; i < (ball < 0 ? 1 : 3); ++i)
      is_unknown = is_unknown || c->unknown_of[first + i] >= 0;
    if (imaginary_part(w, k) <= real_part && is_unknown)
      km_state_lock(w->work->s, coordinate);
  }
}

static void lock_as_given(endpoint_search *w) {
  km_state_unlock(w->work->s);
  for (int i = 0; i < w->closure->m->coordinate_count; ++i)
    if (w->work->locked[i])
      km_state_lock(w->work->s, i);
}

/* Closes the loops over the real numbers at the bodies' poses of w->x, to a tolerance. Coordinates of passive bodies
 * may be complex there: they are closed from random starts. */
static bool realise(endpoint_search *w, double tolerance) {
  const km_complex_closure *c = w->closure;
  bool is_found = false;
  for (int i = 0; i < STARTS && !is_found; ++i) {
    km_complex_to_state(c, w->x, w->work->s);
    if (i > 0) {
      lock_real(w);
      km_mode_randomise(w->work);
    }
    bool is_closed = km_mode_close(w->work);
    lock_as_given(w);
    km_complex_from_state(c, w->work->s, w->real);
    is_found = is_closed && km_complex_is_same_mode(c, w->x, w->real, tolerance);
  }
  return is_found;
}

/* True if the loops close at w->x in all rows, also those that are no equations of the system. */
static bool closes_all_rows(endpoint_search *w) {
  int worst;
  km_complex_to_state(w->closure, w->x, w->work->s);
  km_loops_recompute(w->closure->m, w->work->s, w->closure->sub);
  return km_loops_residual(w->closure->m, w->work->s, w->closure->sub, &worst) <=
         fmax(w->closure->m->closure_tolerance, real_part);
}

/* Adds the state's configuration. */
static void add_endpoint(endpoint_search *w) {
  km_real_endpoints *out = w->out;
  void *items = out->items;
  double *saved = KM_ARENA_NEW(w->arena, double, (size_t)(KM_SAVED_PER_COLUMN * w->closure->sub->columns));
  if (!saved || !km_reserve(&items, &out->capacity, (size_t)out->count + 1, sizeof *out->items)) {
    w->arena->failed = true;
    return;
  }
  out->items = items;
  km_state_save(w->work->s, w->closure->sub, saved);
  out->items[out->count++] = saved;
}

/* Judges the end of one path. */
static void judge(endpoint_search *w, km_path_outcome outcome) {
  km_complex_extent extent = km_complex_pose_extent(w->closure, w->x);
  if (outcome == KM_PATH_INFINITE || !(extent.largest <= infinite_extent)) {
    ++w->out->infinite;
  } else if (outcome == KM_PATH_ARRIVED) {
    km_fibre_add(&w->search->graph, &w->closed, w->x);
    if (extent.imaginary > real_part * (1.0 + extent.largest) || !has_real_coordinates(w))
      return;
    if (w->is_overconstrained && !closes_all_rows(w))
      return;
    if (realise(w, real_part))
      add_endpoint(w);
    else
      ++w->out->lost;
  } else {
    ++w->out->singular;
    if (realise(w, singular_real_part) || km_mode_close(w->work)) /* a curve may have real points elsewhere */
      add_endpoint(w);
  }
}

km_status km_real_endpoints_find(km_fibre_search *search, const km_complex_closure *closure, km_mode_workspace *work,
                                 km_arena *arena, km_real_endpoints *out, km_error *error) {
  km_monodromy *g = &search->graph;
  size_t length = (size_t)closure->length, parameters = (size_t)g->h->parameter_count;
  endpoint_search w = {.search = search,
                       .closure = closure,
                       .work = work,
                       .arena = arena,
                       .out = out,
                       .is_overconstrained = !km_complex_has_all_rows(closure)};
  *out = (km_real_endpoints){0};
  w.x = KM_ARENA_NEW(arena, km_wide, length);
  w.start = KM_ARENA_NEW(arena, km_wide, length);
  w.real = KM_ARENA_NEW(arena, km_wide, length);
  w.detour = KM_ARENA_NEW(arena, km_complex, parameters);
  w.closed.parameters = KM_ARENA_NEW(arena, km_complex, parameters);
  if (!arena->failed)
    km_homotopy_close(g->h, w.closed.parameters);
  for (int i = 0; i < g->node[0].count && !arena->failed && !g->cancelled; ++i) {
    judge(&w, follow(&w, i));
    g->cancelled = g->progress && !g->progress(g->context, (double)i / g->node[0].count);
  }
  km_free(w.closed.points);
  km_free(w.closed.marks);
  if (arena->failed || work->failed || g->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  return g->cancelled ? km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled") : KM_OK;
}
