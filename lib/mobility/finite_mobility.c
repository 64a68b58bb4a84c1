/* Finite mobility of a configuration (theory 6.4): the dimension of the set of closed configurations through it.
 *
 *   1 full row rank           instantaneous mobility                       (implicit function theorem)
 *   2 all tangents confirmed  regular: their number                        (theory 5.4)
 *   3 passive freedoms        separated, then 2 again                      (6.6)
 *   4 constant-rank tangents  their number; all others are shaky           (5.6)
 *   5 branches                confirmed tangents of the tangent cone; the largest dimension of a branch (5.2, 5.3)
 *   6 half-branches           branches with a common tangent, cusps        (5.7)
 *   7 none                    shaky: 0
 *
 * Tangents are shares a[k] of the basis of first-order motions, k its freedom; `undecided` if a tangent that could
 * raise the dimension was neither confirmed nor refuted. */
#include "kmech/mobility.h"

#include "local/passive_tangents.h"
#include "mobility/substructure_loop.h"

#include "base/arguments.h"
#include "base/random.h"
#include "kinematics/loop_closing.h"
#include "kinematics/loop_equations.h"
#include "local/constant_rank_motion.h"
#include "local/half_branches.h"
#include "local/sampled_tangents.h"

#include <string.h>

/* Returns the largest number of independent confirmed tangents whose random combinations are confirmed too: the
 * dimension of their common family. basis[k × k]: orthonormal shares. */
static int find_family_dimension(km_tangents *f, double *basis) {
  int k = f->conditions.freedom, found = 0;
  for (int start = 0; start < KM_STARTS_PER_FREEDOM * k && found < k; ++start) {
    if (!km_tangents_find_random(f))
      continue;
    memcpy(basis + (size_t)found * (size_t)k, f->a, (size_t)k * sizeof *basis);
    bool all_finite = true;
    for (int trial = 0; trial < 3 && all_finite && found > 0; ++trial) {
      memset(f->a, 0, (size_t)k * sizeof *f->a);
      for (int i = 0; i <= found; ++i) {
        double coefficient = km_uniform(&f->random);
        for (int r = 0; r < k; ++r)
          f->a[r] += coefficient * basis[(size_t)i * (size_t)k + (size_t)r];
      }
      km_tangents_normalise(f->a, k);
      all_finite = km_tangents_is_finite(f, f->a);
    }
    memcpy(f->previous, basis + (size_t)found * (size_t)k, (size_t)k * sizeof *basis);
    found += all_finite &&
             km_tangents_append_orthonormal(basis, found, k, f->previous); /* a tangent in their span adds nothing */
  }
  return found;
}

/* True if second-order conditions refute some tangents. False too where the conditions cost more than following a few
 * tangents. */
static bool refutes_by_second_order(km_tangents *f) {
  return km_constant_rank_is_small(f->sub) && km_tangents_update_conditions(f) &&
         km_second_order_is_significant(&f->conditions);
}

/* True if the mechanism is permanently shaky: the rank at the configuration persists along the motion. It does not
 * where branches touch with a common tangent. */
static bool is_permanently_shaky(km_tangents *f) {
  km_constant_rank constant_rank = {0};
  km_arena scratch = {0};
  km_state_restore(f->s, f->sub, f->origin);
  km_update_and_search_pivots(f->m, f->s, f->index, KM_NO_DRIVER, f->residual);
  if (!km_constant_rank_begin(&constant_rank, f->m, f->s, f->index, KM_NO_DRIVER, &scratch))
    f->arena->failed = true;
  km_arena_free(&scratch);
  return constant_rank.is_active;
}

/* True if exactly the constant-rank tangents are finite motions. Then the basis is restricted to them, and
 * directions[freedom × columns] (may be NULL) are the others; else the basis is unchanged. */
static bool restrict_to_constant_rank(km_tangents *f, double *directions) {
  const bool undecided = f->has_undecided;
  if (!km_tangents_update_conditions(f))
    return false;
  const km_second_order all_conditions = f->conditions;
  if (km_tangents_restrict_to_constant_rank(f, directions) > 0 && km_tangents_all_finite(f) && is_permanently_shaky(f))
    return true;
  f->conditions = all_conditions;
  f->has_undecided = undecided;
  for (int i = 0; i < all_conditions.freedom; ++i)
    f->length[i] = -1.0;
  return false;
}

/* Returns the dimension of the motion through the state's configuration, assumed to lie on a single branch. */
static int find_branch_dimension(const km_mechanism *m, km_state *s, int index, const km_passive_freedoms *passive,
                                 km_arena *arena, bool *undecided) {
  km_tangents f;
  if (!km_tangents_create(&f, m, s, index, arena) || !km_tangents_create_basis(&f))
    return 0;
  int k = f.conditions.freedom, dimension = k, passive_count = 0;
  if (k > 1 && (refutes_by_second_order(&f) || !km_tangents_are_regular(&f)) && !km_tangents_all_finite(&f)) {
    passive_count = km_passive_tangents_remove(&f, passive, NULL);
    k = dimension = f.conditions.freedom;
    bool is_resolved = k <= 1 || (passive_count > 0 && km_tangents_all_finite(&f));
    if (!is_resolved && restrict_to_constant_rank(&f, NULL)) {
      k = dimension = f.conditions.freedom;
      is_resolved = true;
    }
    if (!is_resolved) {
      double *basis = KM_ARENA_NEW(arena, double, (size_t)((k + 1) * k));
      dimension = basis ? find_family_dimension(&f, basis) : 0;
    }
  }
  *undecided = *undecided || (f.has_undecided && dimension < k);
  km_state_restore(s, f.sub, f.origin);
  return dimension + passive_count;
}

/* Adds a motion with the scaled direction x to the list. */
static void add_direction(const km_tangents *f, const double *x, km_motion_kind kind, double length,
                          km_finite_mobility *out) {
  if (out->motion_count == KM_MAX_FINITE_MOTIONS) {
    out->truncated = true;
    return;
  }
  int coordinates = f->m->coordinate_count;
  double *rates = out->store + (size_t)out->motion_count * (size_t)coordinates;
  for (int k = 0; k < f->sub->columns; ++k)
    rates[f->m->column_coordinate[f->sub->column_start + k]] = x[k] * f->m->column_weight[f->sub->column_start + k];
  out->motions[out->motion_count++] = (km_finite_motion){kind, f->index, rates, length};
}

static void add_tangent(km_tangents *f, const double *a, km_motion_kind kind, double length, km_finite_mobility *out) {
  km_tangents_direction(f, a, f->direction);
  add_direction(f, f->direction, kind, length, out);
}

/* Adds a branch with direction x unless it is in the list from `first` on. */
static void add_if_new(const km_tangents *f, const double *x, int first, double length, km_finite_mobility *out) {
  const int *coordinate = f->m->column_coordinate + f->sub->column_start;
  const double *weight = f->m->column_weight + f->sub->column_start;
  for (int i = first; i < out->motion_count; ++i) {
    double along = 0.0;
    for (int c = 0; c < f->sub->columns; ++c)
      along += weight[c] * x[c] * out->motions[i].direction[coordinate[c]];
    if (km_is_same_tangent(along))
      return;
  }
  add_direction(f, x, KM_MOTION_BRANCH, length, out);
}

/* Returns the shorter of the arc lengths confirmed ahead and back along a direction. */
static double confirmed_length(km_tangents *f, const double *direction) {
  double length_back = km_tangents_follow(f, direction, -1.0).length; /* the state ends ahead */
  return fmin(length_back, km_tangents_follow(f, direction, 1.0).length);
}

/* Adds all tangents of the basis; those beyond the capacity of the list are not followed. */
static void add_basis(km_tangents *f, km_motion_kind kind, km_finite_mobility *out) {
  int k = f->conditions.freedom;
  int capacity = KM_MAX_FINITE_MOTIONS - out->motion_count;
  out->truncated = out->truncated || k > capacity;
  for (int i = 0; i < k && i < capacity; ++i) {
    for (int r = 0; r < k; ++r)
      f->a[r] = r == i;
    km_tangents_direction(f, f->a, f->direction);
    double length = kind == KM_MOTION_SHAKY ? 0.0
                    : f->length[i] >= 0.0   ? f->length[i]
                                            : confirmed_length(f, f->direction);
    add_direction(f, f->direction, kind, length, out);
  }
}

static int min_int(int a, int b) {
  return a < b ? a : b;
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
static void add_tangent_space(branch_spaces *spaces, km_tangents *f, km_arena *arena) {
  const int n = f->sub->columns, k = spaces->freedom;
  const double *weight = f->m->column_weight + f->sub->column_start;
  km_closure evidence;
  km_state_restore(f->s, f->sub, f->origin);
  km_state_move(f->m, f->s, f->sub, f->chord);
  bool closed = km_close_fully(km_loops_close, f->m, f->s, f->index, KM_NO_DRIVER, &evidence) == KM_CLOSED;
  const km_partition *p = &f->s->partition[f->index];
  int freedom = km_partition_freedom(p) - f->conditions.passive_count;
  if (!closed || spaces->count == MOST_SPACES || freedom < 2 || freedom >= k || f->conditions.passive_count > 0)
    return;
  double *Z = KM_ARENA_NEW(arena, double, (size_t)freedom *(size_t)n);
  double *coefficient = KM_ARENA_NEW(arena, double, (size_t)k), *V = tangent_space(spaces, spaces->count);
  int rows = 0;
  if (!Z || !coefficient)
    return;
  km_partition_null_space(p, weight, freedom, Z);
  for (int i = 0; i < freedom; ++i) {
    for (int r = 0; r < k; ++r) {
      coefficient[r] = 0.0;
      for (int c = 0; c < n; ++c)
        coefficient[r] += f->conditions.Z[(size_t)r * (size_t)n + (size_t)c] * Z[(size_t)i * (size_t)n + (size_t)c];
    }
    rows += km_tangents_append_orthonormal(V, rows, k, coefficient);
  }
  spaces->dimension[spaces->count++] = rows;
}

/* Collects the branches by confirmed tangents; returns the largest dimension of a branch, at most `most`. */
static int find_branches(km_tangents *f, const km_passive_freedoms *passive, int most, km_arena *arena,
                         km_finite_mobility *out) {
  int k = f->conditions.freedom, best = 0, found = 0;
  double *tangents = KM_ARENA_NEW(arena, double, (size_t)(KM_MAX_FINITE_MOTIONS * k));
  double length;
  branch_spaces spaces = {.freedom = k, .V = KM_ARENA_NEW(arena, double, (size_t)(MOST_SPACES * k * k))};
  while (tangents && spaces.V && found < KM_MAX_FINITE_MOTIONS && km_tangents_find_next(f, tangents, found, &length)) {
    if (lies_in_known_space(&spaces, f->a))
      continue;
    memcpy(tangents + (size_t)found++ * (size_t)k, f->a, (size_t)k * sizeof *tangents);
    int bound = min_int(km_second_order_dimension(&f->conditions, f->a), most);
    if (bound > best) {
      km_arena scratch = {0};
      bool undecided = false;
      km_state_restore(f->s, f->sub, f->end_ahead);
      int dimension =
          find_branch_dimension(f->m, f->s, f->index, passive, &scratch, &undecided) - f->conditions.passive_count;
      km_arena_free(&scratch);
      dimension = min_int(dimension, bound);
      f->undecided_dimension = undecided && bound > f->undecided_dimension ? bound : f->undecided_dimension;
      best = dimension > best ? dimension : best;
    }
    add_tangent(f, f->a, KM_MOTION_BRANCH, length, out);
    add_tangent_space(&spaces, f, arena);
  }
  out->truncated = out->truncated || found == KM_MAX_FINITE_MOTIONS;
  return best;
}

/* Returns a lower bound of the dimension at the state's configuration: the number of tangents if all are confirmed,
 * else 1, the motion that led there. */
static int dimension_lower_bound(const km_mechanism *m, km_state *s, int index) {
  km_arena arena = {0};
  km_tangents f;
  km_sampled_tangents sampled = {0};
  double length;
  int dimension = 1;
  if (km_tangents_create(&f, m, s, index, &arena) && km_sampled_tangents_create(&sampled, &f) &&
      (f.conditions.freedom <= 1 || !f.conditions.has_redundant_rows ||
       km_sampled_tangents_all_finite(&sampled, &length)))
    dimension = f.conditions.freedom;
  km_sampled_tangents_free(&sampled);
  km_arena_free(&arena);
  return dimension;
}

/* Adds the confirmed motions found from sampled directions, each once; returns the largest lower bound of their
 * dimensions. */
static int find_sampled_branches(km_sampled_tangents *sampled, km_finite_mobility *out) {
  km_tangents *f = sampled->f;
  int best = 0, first = out->motion_count;
  double length;
  while (km_sampled_tangents_find_next(sampled, &length)) {
    int dimension = dimension_lower_bound(f->m, f->s, f->index);
    best = dimension > best ? dimension : best;
    add_if_new(f, sampled->x, first, length, out);
  }
  return best;
}

/* Finds the mobility of a substructure with many freedoms by a bounded number of random directions. */
static int find_by_sampling(km_tangents *f, km_finite_mobility *out) {
  km_sampled_tangents sampled;
  double length;
  int k = f->conditions.freedom, mobility = k;
  bool is_created = km_sampled_tangents_create(&sampled, f);
  out->truncated = true;
  if (is_created && km_sampled_tangents_all_finite(&sampled, &length)) {
    add_direction(f, sampled.x, KM_MOTION_REGULAR, length, out);
  } else if (is_created && f->conditions.has_redundant_rows) {
    bool refuted = !f->has_undecided; /* some tangent is refuted: the mobility is at most k − 1 */
    mobility = find_sampled_branches(&sampled, out);
    out->undecided = out->undecided || !(refuted && mobility == k - 1);
  }
  km_sampled_tangents_free(&sampled);
  return mobility;
}

/* Separates the passive freedoms from the basis and adds them to the list; returns their number. */
static int add_passive_freedoms(km_tangents *f, const km_passive_freedoms *passive, km_arena *arena,
                                km_finite_mobility *out) {
  double *directions = KM_ARENA_NEW(arena, double, (size_t)f->conditions.freedom *(size_t)f->sub->columns);
  int count = directions ? km_passive_tangents_remove(f, passive, directions) : 0;
  for (int i = 0; i < count; ++i) {
    const double *direction = directions + (size_t)i * (size_t)f->sub->columns;
    add_direction(f, direction, KM_MOTION_REGULAR, confirmed_length(f, direction), out);
  }
  return count;
}

/* Finds a permanently shaky mechanism: adds the constant-rank tangents as regular and the others as shaky motions.
 * Returns the number of the former; -1 if it is not one. */
static int find_constant_rank_motions(km_tangents *f, km_arena *arena, km_finite_mobility *out) {
  int k = f->conditions.freedom, n = f->sub->columns;
  double *directions = KM_ARENA_NEW(arena, double, (size_t)k *(size_t)n);
  if (!directions || k < 2 || !restrict_to_constant_rank(f, directions))
    return -1;
  for (int i = 0; i < k - f->conditions.freedom; ++i)
    add_direction(f, directions + (size_t)i * (size_t)n, KM_MOTION_SHAKY, 0.0, out);
  add_basis(f, KM_MOTION_REGULAR, out);
  return f->conditions.freedom;
}

/* True if second-order conditions exceed the effect of rounded data, so that not all tangents are finite motions. */
static bool are_refuted_beyond_rounding(km_tangents *f) {
  static const double rounding_factor = 100.0; /* times the closure tolerance */
  double tolerance = f->m->closure_tolerance_given ? rounding_factor * f->m->closure_tolerance : 0.0;
  return km_tangents_update_conditions(f) && km_second_order_is_significant(&f->conditions) &&
         f->conditions.size > tolerance;
}

/* True if branches may meet at an order above the second: in a cusp, or with a common tangent. */
static bool may_have_touching_branches(const km_tangents *f, int mobility) {
  return f->conditions.freedom > 1 && km_tangents_are_exact(f) && km_constant_rank_is_small(f->sub) && mobility <= 1;
}

/* Returns the half-branch that continues half-branch i: the most nearly opposite one, else, in a cusp, the most
 * nearly parallel one; -1: none. */
static int find_continuation(const km_half_branches *h, int freedom, int i, const bool *is_used) {
  /* within 60 degrees, since half-branches are curved up to the sphere where they are sampled */
  static const double min_cosine = 0.5;
  int best = -1;
  double most = 0.0;
  for (int pass = 0; pass < 2 && best < 0; ++pass)
    for (int j = 0; j < h->count; ++j) {
      double cosine = 0.0;
      for (int r = 0; r < freedom; ++r)
        cosine += h->shares[i * freedom + r] * h->shares[j * freedom + r];
      double alignment = pass ? cosine : -cosine;
      if (j != i && !is_used[j] && alignment > fmax(most, min_cosine)) {
        most = alignment;
        best = j;
      }
    }
  return best;
}

/* Replaces the list from `first` on by the motions that the half-branches form; false, without effect, unless these
 * are more. */
static bool add_half_branches(km_tangents *f, const km_half_branches *h, int first, km_finite_mobility *out) {
  bool is_used[KM_MAX_HALF_BRANCHES] = {false};
  int freedom = f->conditions.freedom, motions = (h->count + 1) / 2;
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
    add_tangent(f, h->shares + (size_t)i * (size_t)freedom, KM_MOTION_BRANCH, h->length, out);
  }
  out->truncated = out->truncated || h->truncated;
  return true;
}

/* Returns the largest dimension of the motions through the half-branches. */
static int dimension_of_half_branches(km_tangents *f, const km_half_branches *h, const km_passive_freedoms *passive) {
  int best = 0;
  for (int i = 0; i < h->count; ++i) {
    km_arena scratch = {0};
    bool undecided = false;
    km_state_restore(f->s, f->sub, h->saved + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)f->sub->columns);
    int dimension =
        find_branch_dimension(f->m, f->s, f->index, passive, &scratch, &undecided) - f->conditions.passive_count;
    km_arena_free(&scratch);
    best = dimension > best ? dimension : best;
  }
  return best;
}

/* Finds branches with a common tangent and cusps, which second order cannot separate. *mobility is that of the
 * motions listed from `first` on. If it stays 0 although tangents satisfy the second order, the result is undecided. */
static void find_touching_branches(km_tangents *f, const km_passive_freedoms *passive, int first, int *mobility,
                                   bool *undecided, km_finite_mobility *out) {
  km_half_branches halves;
  if (!may_have_touching_branches(f, *mobility) || (*mobility == 0 && !km_tangents_satisfy_second_order(f)) ||
      !km_half_branches_find(f, &halves))
    return;
  if (*mobility == 0 && halves.count > 0) {
    *mobility = dimension_of_half_branches(f, &halves, passive);
    *undecided = halves.truncated && *mobility <= 1; /* a family of motions meets a small sphere in a continuum */
  }
  *undecided = *undecided || *mobility == 0;
  if (*mobility > 0)
    add_half_branches(f, &halves, first, out);
  out->truncated = out->truncated || *mobility > 1;
}

/* Finds the mobility of a substructure with few freedoms; see the head of this file. */
static int find_by_tangent_cone(km_tangents *f, const km_passive_freedoms *passive, km_arena *arena,
                                km_finite_mobility *out) {
  if (f->conditions.freedom == 0 || !km_tangents_create_basis(f))
    return 0;
  bool regular = !f->conditions.has_redundant_rows || km_tangents_all_finite(f);
  int passive_count = regular ? 0 : add_passive_freedoms(f, passive, arena, out);
  regular = regular || f->conditions.freedom == 0 || (passive_count > 0 && km_tangents_all_finite(f));
  int k = f->conditions.freedom, constant_rank = regular ? -1 : find_constant_rank_motions(f, arena, out);
  if (constant_rank >= 0)
    return passive_count + constant_rank;
  if (regular) {
    add_basis(f, KM_MOTION_REGULAR, out);
    return passive_count + k;
  }
  bool only_tangent = f->has_undecided && k == 1; /* most of several directions need not be finite motions */
  /* If some tangents are refuted, not all are finite motions nearby either: the misfit is analytic on the manifold of
   * the primary equations. */
  int first = out->motion_count, most = k > 1 && (!f->has_undecided || are_refuted_beyond_rounding(f)) ? k - 1 : k;
  int mobility = find_branches(f, passive, most, arena, out);
  bool undecided = (only_tangent && mobility < k) || mobility < min_int(f->undecided_dimension, most);
  find_touching_branches(f, passive, first, &mobility, &undecided, out);
  if (mobility == 0)
    add_basis(f, undecided ? KM_MOTION_UNDECIDED : KM_MOTION_SHAKY, out);
  out->undecided = out->undecided || undecided;
  return passive_count + mobility;
}

/* Returns the passive freedoms of the substructure. */
static int count_passive(const km_tangents *f, const km_passive_freedoms *passive) {
  int count = 0;
  for (int i = 0; i < passive->count; ++i)
    count += passive->items[i].substructure == f->index ? passive->items[i].freedoms : 0;
  return count;
}

/* Finds a permanently shaky mechanism with many equations or freedoms, for which a basis is made for this test only. */
static int find_many_constant_rank_motions(km_tangents *f, km_arena *arena, km_finite_mobility *out) {
  bool is_affordable =
      f->conditions.freedom <= KM_MANY_VECTORS && f->conditions.has_redundant_rows && km_constant_rank_is_small(f->sub);
  return is_affordable && km_tangents_create_basis(f) ? find_constant_rank_motions(f, arena, out) : -1;
}

static int find_with_tangents(km_tangents *f, const km_passive_freedoms *passive, km_arena *arena,
                              km_finite_mobility *out) {
  enum { MOST_FOLLOWED_FREEDOMS = 3 }; /* more freedoms have families of branches, of which each would be followed */
  int freedom = f->conditions.freedom, passive_count = count_passive(f, passive);
  if (!km_tangents_are_many(f) || (freedom <= KM_MANY_VECTORS && freedom - passive_count <= MOST_FOLLOWED_FREEDOMS))
    return find_by_tangent_cone(f, passive, arena, out);
  int mobility = find_many_constant_rank_motions(f, arena, out);
  mobility = mobility >= 0 ? mobility : find_by_sampling(f, out);
  return mobility > passive_count ? mobility : passive_count;
}

static int find_in_substructure(const km_mechanism *m, km_state *s, int index, const km_passive_freedoms *passive,
                                km_arena *arena, km_finite_mobility *out) {
  km_tangents f;
  if (!km_tangents_create(&f, m, s, index, arena))
    return 0;
  int mobility = find_with_tangents(&f, passive, arena, out);
  km_loops_restore_cached(m, s, index, f.origin);
  return mobility;
}

/* Data of the search over all substructures. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  km_passive_freedoms passive;
  km_finite_mobility *out;
} search;

static km_status search_substructure(void *self, int index, km_arena *arena, km_error *error) {
  const search *f = self;
  (void)error;
  f->out->mobility += find_in_substructure(f->m, f->s, index, &f->passive, arena, f->out);
  return KM_OK;
}

km_status km_finite_mobility_find(const km_mechanism *m, km_state *s, km_progress progress, void *context,
                                  km_finite_mobility *out, km_error *error) {
  if (!out)
    return km_check_given(false, "place for the result", error);
  *out = (km_finite_mobility){0};
  km_status fits = km_check_state(m, s, error);
  if (fits)
    return fits;
  out->store = KM_NEW(double, (size_t)KM_MAX_FINITE_MOTIONS *(size_t)(m->coordinate_count + 1));
  if (!out->store)
    return km_fail(error, KM_MEMORY, "out of memory for the finite mobility");
  for (int c = 0; c < m->coordinate_count; ++c)
    out->mobility += m->substructure_of[c] < 0 && !m->held[c];
  search f = {m, s, {0}, out};
  km_status status = km_passive_freedoms_find(m, s, NULL, NULL, &f.passive, error);
  if (!status)
    status = km_each_substructure(m, search_substructure, &f, progress, context, "the finite mobility", error);
  km_passive_freedoms_free(&f.passive);
  return status;
}

int km_finite_mobility_branches(const km_finite_mobility *finite) {
  double product = 1.0;
  for (int i = 0; finite && i < finite->motion_count; ++i) {
    int substructure = finite->motions[i].substructure, branches = 0;
    bool is_first = true;
    for (int k = 0; k < finite->motion_count; ++k) {
      bool counts = finite->motions[k].substructure == substructure && finite->motions[k].kind == KM_MOTION_BRANCH;
      is_first = is_first && !(counts && k < i);
      branches += counts;
    }
    product *= is_first && branches ? branches : 1;
  }
  return product < 1e6 ? (int)product : 1000000;
}

void km_finite_mobility_free(km_finite_mobility *mobility) {
  if (!mobility)
    return;
  km_free(mobility->store);
  *mobility = (km_finite_mobility){0};
}

const char *km_motion_kind_name(km_motion_kind kind) {
  static const char *const names[] = {"regular", "branch", "shaky", "undecided"};
  return (size_t)kind < sizeof names / sizeof *names ? names[kind] : "";
}
