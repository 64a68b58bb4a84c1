/* Real solutions of the closed loops (real_endpoints.h). */
#include "space/complex/real_endpoints.h"

#include "kinematics/loop_equations.h"

#include <string.h>

/* Imaginary part of a pose that is rounding, over its largest part; that of a singular end, where a double solution has
 * the root of the rounding; and of one that may belong to a curve of solutions. */
static const double real_part = 1e-6, real_coordinate = 1e-5, singular_real_part = 1e-3;
/* Parts of poses, in sizes, beyond which a solution goes to infinity. */
static const double infinite_extent = 1e4;
/* Paths to infinity were lost behind 0.994 of their parameter (stewart.json); others can be lost anywhere. */
static const double end_of_path = 0.98;
enum { MOST_NODES = 4, STARTS = 40 };

typedef struct endpoint_search {
  km_fibre_search *search;
  const km_complex_closure *closure;
  km_mode_workspace *work;
  km_arena *arena;
  bool is_overconstrained; /* rows are left out of the system */
  km_fibre closed;         /* solutions of the closed loops, to see paths that meet */
  km_wide *x, *real;       /* [length] */
  km_wide *lost;           /* [solutions at node 0 × length] */
  int lost_count;
  km_real_endpoints *out;
} endpoint_search;

/* True if a path to the closed loops, which ended at w->x, leads to infinity: it arrives there, or is lost at its end,
 * where parts of the poses grow without bound. */
static bool is_at_infinity(const endpoint_search *w, km_path_outcome outcome) {
  bool is_far = !(km_complex_pose_extent(w->closure, w->x).largest <= infinite_extent);
  return outcome == KM_PATH_INFINITE ||
         (is_far && (outcome == KM_PATH_ARRIVED || w->search->graph.h->reached >= end_of_path));
}

/* Tracks all solutions at a node to the closed loops: solutions there enter w->closed, last points of paths that
 * are lost w->lost. Returns how many ends are missing: those of lost paths, and one of two that met. */
static int follow_all(endpoint_search *w, const km_fibre *node, bool is_first) {
  km_monodromy *g = &w->search->graph;
  size_t length = (size_t)g->h->length, bytes = length * sizeof(km_wide);
  int infinite = 0;
  w->lost_count = 0;
  for (int i = 0; i < node->count && !g->failed && !g->cancelled; ++i) {
    memcpy(w->x, node->points + (size_t)i * length, bytes);
    km_path_outcome outcome = km_monodromy_track(g, node->parameters, w->closed.parameters, w->x);
    if (is_at_infinity(w, outcome))
      ++infinite;
    else if (outcome == KM_PATH_ARRIVED)
      km_fibre_add(g, &w->closed, w->x);
    else
      memcpy(w->lost + (size_t)w->lost_count++ * length, w->x, bytes);
    g->cancelled = g->progress && !g->progress(g->context, is_first ? (double)i / node->count : 1.0);
  }
  w->out->infinite = infinite > w->out->infinite ? infinite : w->out->infinite;
  return g->node[0].count - w->closed.count - w->out->infinite;
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
  km_complex_to_state(w->closure, w->x, w->work->s);
  km_loops_recompute(w->closure->m, w->work->s, w->closure->sub);
  return km_loops_residual(w->closure->m, w->work->s, w->closure->sub) <=
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

/* Judges the solution w->x of the closed loops. */
static void judge_solution(endpoint_search *w) {
  km_complex_extent extent = km_complex_pose_extent(w->closure, w->x);
  if (extent.imaginary > real_part * (1.0 + extent.largest) || !has_real_coordinates(w) ||
      (w->is_overconstrained && !closes_all_rows(w)))
    return;
  if (realise(w, real_part))
    add_endpoint(w);
  else
    ++w->out->lost;
}

/* Judges all ends. Those that are missing are singular where paths were lost there, else two paths met. */
static void judge(endpoint_search *w, int missing) {
  size_t length = (size_t)w->closure->length, bytes = length * sizeof(km_wide);
  int found = w->closed.count;
  for (int i = 0; i < found && !w->arena->failed; ++i) {
    memcpy(w->x, w->closed.points + (size_t)i * length, bytes);
    judge_solution(w);
  }
  if (missing <= 0)
    return;
  *(w->lost_count > 0 ? &w->out->singular : &w->out->lost) += missing;
  for (int i = 0; i < w->lost_count && !w->arena->failed; ++i) {
    memcpy(w->x, w->lost + (size_t)i * length, bytes);
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
  w.lost = KM_ARENA_NEW(arena, km_wide, length * (size_t)g->node[0].count);
  w.real = KM_ARENA_NEW(arena, km_wide, length);
  w.closed.parameters = KM_ARENA_NEW(arena, km_complex, parameters);
  if (arena->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  km_homotopy_close(g->h, w.closed.parameters);
  /* The ends of all solutions at one node are all ends. A path that passes a pole is lost: another node has others. */
  int missing = follow_all(&w, &g->node[0], true);
  for (int k = 1; k < g->node_count && k < MOST_NODES && missing > 0 && !g->failed && !g->cancelled; ++k)
    missing = follow_all(&w, &g->node[k], false);
  if (!g->failed)
    judge(&w, g->cancelled ? 0 : missing);
  km_free(w.closed.points);
  km_free(w.closed.marks);
  if (arena->failed || work->failed || g->failed)
    return km_fail(error, KM_MEMORY, "out of memory for the assembly modes");
  return g->cancelled ? km_fail(error, KM_CANCELLED, "the search for assembly modes was cancelled") : KM_OK;
}
