/* Finite mobility (docs/theory.md 6.4): the dimension of the set of closed configurations through a configuration.
 *
 *   1 regular                 full row rank, or all tangents confirmed: their number          (theory 5.4)
 *   2 passive freedoms        separated, then 1 again                                         (6.6)
 *   3 constant-rank tangents  their number; all others are shaky                              (5.6)
 *   4 branches                confirmed tangents of the tangent cone; the largest dimension   (5.2, 5.3)
 *   5 half-branches           branches with a common tangent, cusps                           (5.7)
 *   6 none                    shaky: 0
 *
 * `undecided` if a tangent that could raise the dimension was neither confirmed nor refuted. Steps 1 to 3 also give the
 * dimension of a branch, a short way along it. */
#include "local/local_private.h"

#include "kinematics/loop_closing.h"

#include <string.h>

static int min_int(int a, int b) {
  return a < b ? a : b;
}

/* Adds a motion with the scaled direction x to the list. */
static void add_direction(const km_local *l, const double *x, km_motion_kind kind, double length,
                          km_finite_mobility *out) {
  if (!out || out->motion_count == KM_MAX_FINITE_MOTIONS) {
    if (out)
      out->truncated = true;
    return;
  }
  double *rates = out->store + (size_t)out->motion_count * (size_t)l->m->coordinate_count;
  for (int k = 0; k < l->sub->columns; ++k)
    rates[l->m->column_coordinate[l->sub->column_start + k]] = x[k] * l->weight[k];
  out->motions[out->motion_count++] = (km_finite_motion){kind, l->index, rates, length};
}

/* Adds the tangent `a`. A negative length is found by following it, or 0 for a shaky motion. */
static void add_tangent(km_local *l, const double *a, km_motion_kind kind, double length, km_finite_mobility *out) {
  km_local_direction(l, a, l->direction);
  if (length < 0.0 && out->motion_count < KM_MAX_FINITE_MOTIONS)
    length = fmin(km_local_follow(l, l->direction, -1.0).length, km_local_follow(l, l->direction, 1.0).length);
  add_direction(l, l->direction, kind, length, out);
}

/* Adds all tangents of a basis; without one, a random tangent of a family. */
static void add_all_tangents(km_local *l, km_motion_kind kind, km_finite_mobility *out) {
  double length = kind == KM_MOTION_SHAKY ? 0.0 : -1.0;
  if (!out)
    return;
  for (int i = 0; i < l->freedom && l->has_basis; ++i) {
    for (int r = 0; r < l->freedom; ++r)
      l->a[r] = r == i;
    add_tangent(l, l->a, kind, length, out);
  }
  if (l->has_basis)
    return;
  out->truncated = true;
  if (kind == KM_MOTION_REGULAR && km_local_draw(l, &l->random, l->a))
    add_tangent(l, l->a, kind, length, out);
}

/* Separates the passive freedoms from the tangents and adds them to the list; returns their number. */
static int separate_passive_freedoms(km_local *l, km_finite_mobility *out) {
  size_t n = (size_t)l->sub->columns;
  double *directions = KM_ARENA_NEW(l->arena, double, (size_t)l->freedom *n);
  int count = directions ? km_local_remove_passive(l, l->passive, directions) : 0;
  for (int i = 0; i < count && out; ++i) {
    const double *x = directions + (size_t)i * n;
    double back = km_local_follow(l, x, -1.0).length;
    add_direction(l, x, KM_MOTION_REGULAR, fmin(back, km_local_follow(l, x, 1.0).length), out);
  }
  return count;
}

/* Finds a permanently shaky mechanism: adds the constant-rank tangents as regular and the others as shaky motions.
 * False if it is not one. */
static bool is_permanently_shaky(km_local *l, km_finite_mobility *out) {
  int k = l->freedom, n = l->sub->columns;
  double *directions = KM_ARENA_NEW(l->arena, double, (size_t)k *(size_t)n);
  int others = directions && k > 1 && l->has_basis ? km_local_restrict_to_constant_rank(l, directions) : 0;
  for (int i = 0; i < others; ++i)
    add_direction(l, directions + (size_t)i * (size_t)n, KM_MOTION_SHAKY, 0.0, out);
  if (others > 0)
    add_all_tangents(l, KM_MOTION_REGULAR, out);
  return others > 0;
}

/* Steps 1 to 3. True if they decide; the dimension is then that of the remaining and the passive tangents. */
static bool is_single_family(km_local *l, km_finite_mobility *out) {
  bool is_regular = km_local_is_regular(l);
  if (!is_regular && l->has_basis)
    is_regular = separate_passive_freedoms(l, out) > 0 && (l->freedom == 0 || km_local_is_regular(l));
  if (is_regular)
    add_all_tangents(l, KM_MOTION_REGULAR, out);
  return is_regular || is_permanently_shaky(l, out);
}

/* Returns the dimension of the branch on which the state lies; 1, undecided, if it is not one family of tangents. */
static int find_branch_dimension(const km_local *from, bool *undecided) {
  km_arena arena = {0};
  km_local *l = km_local_create(from->m, from->s, from->index, from->passive, 0.0, &arena);
  int dimension = 1;
  if (l && l->freedom > 1 && km_local_reserve_tangents(l, from->has_basis)) {
    bool is_known = is_single_family(l, NULL);
    dimension = (is_known ? l->freedom : 1) + l->passive_count;
    *undecided = !is_known && l->has_basis && dimension < l->freedom + l->passive_count;
  }
  km_local_free(l);
  km_arena_free(&arena);
  return dimension - from->passive_count;
}

/* Tangent spaces of branches with several freedoms: each direction in one of them is a tangent of the same branch. */
enum { MOST_SPACES = 16 };
typedef struct branch_spaces {
  int count, freedom;
  int dimension[MOST_SPACES];
  double *V; /* [MOST_SPACES × freedom × freedom] orthonormal rows, as shares of the basis */
} branch_spaces;

static double *tangent_space(const branch_spaces *spaces, int i) {
  return spaces->V + (size_t)i * (size_t)(spaces->freedom * spaces->freedom);
}

static bool lies_in_known_space(const branch_spaces *spaces, const double *a) {
  static const double max_sine = 0.1; /* sine of the angle: the spaces are computed a short way along the branches */
  for (int i = 0; i < spaces->count; ++i) {
    double outside = 1.0;
    for (int r = 0; r < spaces->dimension[i]; ++r) {
      double along = 0.0;
      for (int k = 0; k < spaces->freedom; ++k)
        along += tangent_space(spaces, i)[r * spaces->freedom + k] * a[k];
      outside -= along * along;
    }
    if (outside <= max_sine * max_sine)
      return true;
  }
  return false;
}

/* Adds the tangent space of the branch followed last, computed a short way along it, if that configuration is regular
 * and the branch has several freedoms. The state moves. */
static void add_tangent_space(branch_spaces *spaces, km_local *l) {
  const int n = l->sub->columns, k = spaces->freedom;
  km_closure evidence;
  if (!l->has_basis || l->passive_count > 0 || k < 3 || spaces->count == MOST_SPACES)
    return;
  km_state_restore(l->s, l->sub, l->origin);
  km_state_move(l->m, l->s, l->sub, l->chord);
  bool closed =
      km_loops_close_fully(l->m, l->s, l->index, &(km_pivoting){.driver = KM_NO_DRIVER}, &evidence) == KM_CLOSED;
  km_factor *p = l->s->factor[l->index];
  int freedom = km_factor_freedom(p) - l->passive_count;
  if (!closed || freedom < 2 || freedom >= k)
    return;
  const double *Z = km_factor_null_space(p, freedom);
  double *coefficient = KM_ARENA_NEW(l->arena, double, (size_t)k), *V = tangent_space(spaces, spaces->count);
  int rows = 0;
  if (!Z || !coefficient)
    return;
  for (int i = 0; i < freedom; ++i) {
    for (int r = 0; r < k; ++r) {
      coefficient[r] = 0.0;
      for (int c = 0; c < n; ++c)
        coefficient[r] += l->Z[(size_t)r * (size_t)n + (size_t)c] * Z[(size_t)i * (size_t)n + (size_t)c];
    }
    rows += km_append_orthonormal(V, rows, k, coefficient);
  }
  spaces->dimension[spaces->count++] = rows;
}

/* True if second-order conditions exceed the effect of rounded data, so that not all tangents are finite motions. */
static bool are_refuted_beyond_rounding(km_local *l) {
  double tolerance = l->m->closure_tolerance_given ? km_significant_ratio * l->m->closure_tolerance : 0.0;
  return km_local_update_conditions(l) && km_local_is_significant(l) && l->scale > tolerance;
}

/* Collects the branches by confirmed tangents; returns the largest dimension of a branch, at most `most`. */
static int find_crossing_branches(km_local *l, int most, km_finite_mobility *out) {
  int k = l->freedom, best = 0, found = 0;
  size_t size = (size_t)l->size;
  double *tangents = KM_ARENA_NEW(l->arena, double, KM_MAX_FINITE_MOTIONS *size), length;
  branch_spaces spaces = {.freedom = k};
  if (l->has_basis)
    spaces.V = KM_ARENA_NEW(l->arena, double, (size_t)(MOST_SPACES * k * k));
  while (!l->arena->failed && found < KM_MAX_FINITE_MOTIONS && km_local_find_next(l, tangents, found, &length)) {
    if (lies_in_known_space(&spaces, l->a))
      continue;
    memcpy(tangents + (size_t)found++ * size, l->a, size * sizeof *tangents);
    int bound = min_int(km_local_dimension_bound(l, l->a), most);
    if (bound > best) {
      bool undecided = false;
      km_state_restore(l->s, l->sub, l->end_ahead);
      int dimension = min_int(find_branch_dimension(l, &undecided), bound);
      l->undecided_dimension = undecided && bound > l->undecided_dimension ? bound : l->undecided_dimension;
      best = dimension > best ? dimension : best;
    }
    add_tangent(l, l->a, KM_MOTION_BRANCH, length, out);
    add_tangent_space(&spaces, l);
  }
  out->truncated = out->truncated || found == KM_MAX_FINITE_MOTIONS || !l->has_basis;
  return best;
}

/* Returns the half-branch that continues half-branch i: the most nearly opposite one, else, in a cusp, the most
 * nearly parallel one; -1: none. */
static int find_continuation(const km_half_branches *h, int freedom, int i, const bool *is_used) {
  int best = -1;
  double most = 0.0;
  for (int pass = 0; pass < 2 && best < 0; ++pass)
    for (int j = 0; j < h->count; ++j) {
      double cosine = 0.0;
      for (int r = 0; r < freedom; ++r)
        cosine += h->coefficients[i * freedom + r] * h->coefficients[j * freedom + r];
      double alignment = pass ? cosine : -cosine;
      if (j != i && !is_used[j] && alignment > fmax(most, km_min_direction_cosine)) {
        most = alignment;
        best = j;
      }
    }
  return best;
}

/* Replaces the list from `first` on by the motions that the half-branches form; false, without effect, unless these
 * are more. */
static bool add_half_branches(km_local *l, const km_half_branches *h, int first, km_finite_mobility *out) {
  bool is_used[KM_MAX_HALF_BRANCHES] = {false};
  int freedom = l->freedom, motions = (h->count + 1) / 2;
  if (motions <= out->motion_count - first)
    return false;
  out->motion_count = first;
  for (int i = 0; i < h->count; ++i) {
    if (is_used[i])
      continue;
    is_used[i] = true;
    int other = find_continuation(h, freedom, i, is_used);
    if (other >= 0)
      is_used[other] = true;
    add_tangent(l, h->coefficients + (size_t)i * (size_t)freedom, KM_MOTION_BRANCH, h->length, out);
  }
  out->truncated = out->truncated || h->truncated;
  return true;
}

/* Returns the largest dimension of the motions through the half-branches. */
static int dimension_of_half_branches(const km_local *l, const km_half_branches *h) {
  int best = 0;
  for (int i = 0; i < h->count; ++i) {
    bool undecided = false;
    km_state_restore(l->s, l->sub, h->saved + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)l->sub->columns);
    int dimension = find_branch_dimension(l, &undecided);
    best = dimension > best ? dimension : best;
  }
  return best;
}

/* Finds branches with a common tangent and cusps, which second order cannot separate. *mobility is that of the motions
 * listed from `first` on. If it stays 0 although tangents satisfy the second order, the result is undecided. */
static void find_touching_branches(km_local *l, int first, int *mobility, bool *undecided, km_finite_mobility *out) {
  km_half_branches halves;
  if (!l->has_basis || l->freedom < 2 || !km_local_is_exact(l) || !km_local_is_small(l->sub) || *mobility > 1 ||
      (*mobility == 0 && !km_local_satisfies_second_order(l)) || !km_half_branches_find(l, &halves))
    return;
  if (*mobility == 0 && halves.count > 0) {
    *mobility = dimension_of_half_branches(l, &halves);
    *undecided = halves.truncated && *mobility <= 1; /* a family of motions meets a small sphere in a continuum */
  }
  *undecided = *undecided || (*mobility == 0 && !halves.is_isolated);
  if (*mobility > 0)
    add_half_branches(l, &halves, first, out);
  out->truncated = out->truncated || *mobility > 1;
}

/* Steps 4 to 6: returns the largest dimension of a branch. */
static int find_branches(km_local *l, km_finite_mobility *out) {
  int k = l->freedom, first = out->motion_count;
  bool only_tangent = l->has_undecided && k == 1; /* most of several directions need not be finite motions */
  /* If some tangents are refuted, not all are finite motions nearby either: the misfit is analytic on the manifold of
   * the primary equations. */
  int most = k > 1 && (!l->has_undecided || are_refuted_beyond_rounding(l)) ? k - 1 : k;
  int mobility = find_crossing_branches(l, most, out);
  int undecided_dimension = l->has_basis ? l->undecided_dimension : k; /* few of many directions were tried */
  bool undecided = (only_tangent && mobility < k) || mobility < min_int(undecided_dimension, most);
  find_touching_branches(l, first, &mobility, &undecided, out);
  if (mobility == 0)
    add_all_tangents(l, undecided ? KM_MOTION_UNDECIDED : KM_MOTION_SHAKY, out);
  out->undecided = out->undecided || undecided;
  return mobility;
}

/* Tests a substructure with many equations or freedoms for a permanently shaky mechanism, with a basis for this test
 * only. Returns the finite mobility; -1 if it is not one. */
static int find_many_constant_rank_motions(const km_local *l, km_finite_mobility *out) {
  km_local with_basis = *l;
  bool is_affordable = l->freedom <= KM_MANY_VECTORS && l->has_redundant_rows && km_local_is_small(l->sub);
  return is_affordable && km_local_reserve_tangents(&with_basis, true) && is_permanently_shaky(&with_basis, out)
             ? with_basis.freedom
             : -1;
}

int km_local_find_motions(km_local *l, km_finite_mobility *out) {
  int mobility = l->has_basis ? -1 : find_many_constant_rank_motions(l, out);
  if (mobility < 0 && km_local_reserve_tangents(l, l->has_basis))
    mobility = l->freedom == 0            ? 0
               : is_single_family(l, out) ? l->freedom + l->passive_count
                                          : find_branches(l, out) + l->passive_count;
  return mobility > l->known_passive ? mobility : l->known_passive;
}
