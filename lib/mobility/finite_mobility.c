/* Finite mobility: which of the motions that first order allows are real. */
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

/* The largest number of independent motions whose random combinations are real too. basis[k × k]. */
static int common_span(km_tangents *f, double *basis) {
  int k = f->conditions.freedom, found = 0;
  for (int start = 0; start < KM_STARTS_PER_FREEDOM * k && found < k; ++start) {
    if (!km_tangents_find_random(f))
      continue;
    memcpy(basis + (size_t)found * (size_t)k, f->a, (size_t)k * sizeof *basis);
    bool together = true;
    for (int mix = 0; mix < 3 && together && found > 0; ++mix) {
      memset(f->a, 0, (size_t)k * sizeof *f->a);
      for (int i = 0; i <= found; ++i) {
        double share = km_uniform(&f->random);
        for (int r = 0; r < k; ++r)
          f->a[r] += share * basis[(size_t)i * (size_t)k + (size_t)r];
      }
      km_tangents_normalise(f->a, k);
      together = km_tangents_is_finite(f, f->a);
    }
    memcpy(f->previous, basis + (size_t)found * (size_t)k, (size_t)k * sizeof *basis);
    found += together && km_tangents_append_orthonormal(basis, found, k,
                                                        f->previous); /* what the others span already adds nothing */
  }
  return found;
}

/* True if conditions of second order show that not all tangents are finite motions. False too where the conditions take
 * longer than following a few tangents. */
static bool rank_changes(km_tangents *f) {
  return km_constant_rank_is_small(f->sub) && km_tangents_update_conditions(f) &&
         km_second_order_is_significant(&f->conditions);
}

/* True if the mechanism has as many idle tangents all along its motion as at the pose. Where branches touch with the
 * same tangent it hasn't. */
static bool keeps_rank(km_tangents *f) {
  km_constant_rank steady = {0};
  km_arena scratch = {0};
  km_state_restore(f->s, f->sub, f->origin);
  km_update_and_search_pivots(f->m, f->s, f->index, KM_NO_DRIVER, f->residual);
  if (!km_constant_rank_begin(&steady, f->m, f->s, f->index, KM_NO_DRIVER, &scratch))
    f->arena->failed = true;
  km_arena_free(&scratch);
  return steady.is_active;
}

/* True if the constant-rank tangents are all finite motions, and no others. Then they alone are left, and
 * directions[freedom × columns] (may be NULL) are those of the others. */
static bool are_steady(km_tangents *f, double *directions) {
  const bool doubtful = f->has_undecided;
  if (!km_tangents_update_conditions(f))
    return false;
  const km_second_order whole = f->conditions;
  if (km_tangents_restrict_to_constant_rank(f, directions) > 0 && km_tangents_all_finite(f) && keeps_rank(f))
    return true;
  f->conditions = whole;
  f->has_undecided = doubtful;
  for (int i = 0; i < whole.freedom; ++i)
    f->length[i] = -1.0;
  return false;
}

/* The dimension of the motion through the state's present pose, assumed to be one where just one family passes. */
static int dimension_here(const km_mechanism *m, km_state *s, int index, const km_passive_freedoms *idle,
                          km_arena *arena, bool *doubtful) {
  km_tangents f;
  if (!km_tangents_create(&f, m, s, index, arena) || !km_tangents_create_basis(&f))
    return 0;
  int k = f.conditions.freedom, dimension = k, apart = 0;
  if (k > 1 && (rank_changes(&f) || !km_tangents_are_regular(&f)) && !km_tangents_all_finite(&f)) {
    apart = km_passive_tangents_remove(&f, idle, NULL);
    k = dimension = f.conditions.freedom;
    bool real = k <= 1 || (apart > 0 && km_tangents_all_finite(&f));
    if (!real && are_steady(&f, NULL)) {
      k = dimension = f.conditions.freedom;
      real = true;
    }
    if (!real) {
      double *basis = KM_ARENA_NEW(arena, double, (size_t)((k + 1) * k));
      dimension = basis ? common_span(&f, basis) : 0;
    }
  }
  *doubtful = *doubtful || (f.has_undecided && dimension < k);
  km_state_restore(s, f.sub, f.origin);
  return dimension + apart;
}

/* A direction, scaled. */
static void list_direction(const km_tangents *f, const double *x, km_motion_kind kind, double length,
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

static void list_motion(km_tangents *f, const double *a, km_motion_kind kind, double length, km_finite_mobility *out) {
  km_tangents_direction(f, a, f->direction);
  list_direction(f, f->direction, kind, length, out);
}

/* The same of a branch that isn't listed yet, from the motion `first` on. */
static void list_new(const km_tangents *f, const double *x, int first, double length, km_finite_mobility *out) {
  const int *coordinate = f->m->column_coordinate + f->sub->column_start;
  const double *weight = f->m->column_weight + f->sub->column_start;
  for (int i = first; i < out->motion_count; ++i) {
    double along = 0.0;
    for (int c = 0; c < f->sub->columns; ++c)
      along += weight[c] * x[c] * out->motions[i].direction[coordinate[c]];
    if (km_is_same_tangent(along))
      return;
  }
  list_direction(f, x, KM_MOTION_BRANCH, length, out);
}

static double confirmed(km_tangents *f, const double *direction) {
  double back = km_tangents_follow(f, direction, -1.0).length; /* the state is left at the end of the way ahead */
  return fmin(back, km_tangents_follow(f, direction, 1.0).length);
}

/* What finds no place in the list isn't followed. */
static void list_basis(km_tangents *f, km_motion_kind kind, km_finite_mobility *out) {
  int k = f->conditions.freedom;
  int room = KM_MAX_FINITE_MOTIONS - out->motion_count;
  out->truncated = out->truncated || k > room;
  for (int i = 0; i < k && i < room; ++i) {
    for (int r = 0; r < k; ++r)
      f->a[r] = r == i;
    km_tangents_direction(f, f->a, f->direction);
    double length = kind == KM_MOTION_SHAKY ? 0.0 : f->length[i] >= 0.0 ? f->length[i] : confirmed(f, f->direction);
    list_direction(f, f->direction, kind, length, out);
  }
}

static int smaller(int a, int b) {
  return a < b ? a : b;
}

/* Tangent spaces of the branches that have several freedoms: every direction in one of them is a tangent of the same
 * branch. */
enum { MOST_SPACES = 16 };
typedef struct branch_spaces {
  int count, freedom;
  int dimension[MOST_SPACES];
  double *V; /* [MOST_SPACES × freedom × freedom] orthonormal rows, as shares of the basis */
} branch_spaces;

static double *space_of(const branch_spaces *spaces, int i) {
  return spaces->V + (size_t)i * (size_t)(spaces->freedom * spaces->freedom);
}

static bool is_in_known_space(const branch_spaces *spaces, const double *a) {
  static const double near = 0.1; /* sine: the spaces are those a short way along the branches */
  for (int i = 0; i < spaces->count; ++i) {
    double outside = 1.0;
    for (int r = 0; r < spaces->dimension[i]; ++r) {
      double along = 0.0;
      for (int k = 0; k < spaces->freedom; ++k)
        along += space_of(spaces, i)[r * spaces->freedom + k] * a[k];
      outside -= along * along;
    }
    if (outside <= near * near)
      return true;
  }
  return false;
}

/* Adds the tangent space of the branch that was followed last, a short way along it, if that configuration is regular
 * and the branch has several freedoms. The state is used up. */
static void add_space(branch_spaces *spaces, km_tangents *f, km_arena *arena) {
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
  double *share = KM_ARENA_NEW(arena, double, (size_t)k), *V = space_of(spaces, spaces->count);
  int rows = 0;
  if (!Z || !share)
    return;
  km_partition_null_space(p, weight, freedom, Z);
  for (int i = 0; i < freedom; ++i) {
    for (int r = 0; r < k; ++r) {
      share[r] = 0.0;
      for (int c = 0; c < n; ++c)
        share[r] += f->conditions.Z[(size_t)r * (size_t)n + (size_t)c] * Z[(size_t)i * (size_t)n + (size_t)c];
    }
    rows += km_tangents_append_orthonormal(V, rows, k, share);
  }
  spaces->dimension[spaces->count++] = rows;
}

/* Collects the different real motions; their largest dimension, `most` at most, is the finite mobility. */
static int find_branches(km_tangents *f, const km_passive_freedoms *idle, int most, km_arena *arena,
                         km_finite_mobility *out) {
  int k = f->conditions.freedom, best = 0, found = 0;
  double *lines = KM_ARENA_NEW(arena, double, (size_t)(KM_MAX_FINITE_MOTIONS * k));
  double length;
  branch_spaces spaces = {.freedom = k, .V = KM_ARENA_NEW(arena, double, (size_t)(MOST_SPACES * k * k))};
  while (lines && spaces.V && found < KM_MAX_FINITE_MOTIONS && km_tangents_find_next(f, lines, found, &length)) {
    if (is_in_known_space(&spaces, f->a))
      continue;
    memcpy(lines + (size_t)found++ * (size_t)k, f->a, (size_t)k * sizeof *lines);
    int most_here = smaller(km_second_order_dimension(&f->conditions, f->a), most);
    if (most_here > best) {
      km_arena scratch = {0};
      bool doubtful = false;
      km_state_restore(f->s, f->sub, f->end_ahead);
      int dimension = dimension_here(f->m, f->s, f->index, idle, &scratch, &doubtful) - f->conditions.passive_count;
      km_arena_free(&scratch);
      dimension = smaller(dimension, most_here);
      f->undecided_dimension = doubtful && most_here > f->undecided_dimension ? most_here : f->undecided_dimension;
      best = dimension > best ? dimension : best;
    }
    list_motion(f, f->a, KM_MOTION_BRANCH, length, out);
    add_space(&spaces, f, arena);
  }
  out->truncated = out->truncated || found == KM_MAX_FINITE_MOTIONS;
  return best;
}

/* The dimension there if all tangents are real, as along most motions; else one motion has led there, and there may be
 * more. */
static int least_dimension_here(const km_mechanism *m, km_state *s, int index) {
  km_arena arena = {0};
  km_tangents f;
  km_sampled_tangents many = {0};
  double length;
  int dimension = 1;
  if (km_tangents_create(&f, m, s, index, &arena) && km_sampled_tangents_create(&many, &f) &&
      (f.conditions.freedom <= 1 || !f.conditions.has_redundant_rows || km_sampled_tangents_all_finite(&many, &length)))
    dimension = f.conditions.freedom;
  km_sampled_tangents_free(&many);
  km_arena_free(&arena);
  return dimension;
}

/* The real motions that were found from the starts that are tried, each once; the largest dimension of one. */
static int find_some_branches(km_sampled_tangents *many, km_finite_mobility *out) {
  km_tangents *f = many->f;
  int best = 0, first = out->motion_count;
  double length;
  while (km_sampled_tangents_find_next(many, &length)) {
    int dimension = least_dimension_here(f->m, f->s, f->index);
    best = dimension > best ? dimension : best;
    list_new(f, many->x, first, length, out);
  }
  return best;
}

/* Of many freedoms a bounded number of directions is tried. */
static int find_in_many(km_tangents *f, km_finite_mobility *out) {
  km_sampled_tangents many;
  double length;
  int k = f->conditions.freedom, mobility = k;
  bool made = km_sampled_tangents_create(&many, f);
  out->truncated = true;
  if (made && km_sampled_tangents_all_finite(&many, &length)) {
    list_direction(f, many.x, KM_MOTION_REGULAR, length, out);
  } else if (made && f->conditions.has_redundant_rows) {
    bool refuted = !f->has_undecided; /* not all are real: k − 1 is the most that can be */
    mobility = find_some_branches(&many, out);
    out->undecided = out->undecided || !(refuted && mobility == k - 1);
  }
  km_sampled_tangents_free(&many);
  return mobility;
}

/* Idle motions are listed by themselves; returns how many there are. */
static int list_idle(km_tangents *f, const km_passive_freedoms *idle, km_arena *arena, km_finite_mobility *out) {
  double *directions = KM_ARENA_NEW(arena, double, (size_t)f->conditions.freedom *(size_t)f->sub->columns);
  int count = directions ? km_passive_tangents_remove(f, idle, directions) : 0;
  for (int i = 0; i < count; ++i) {
    const double *direction = directions + (size_t)i * (size_t)f->sub->columns;
    list_direction(f, direction, KM_MOTION_REGULAR, confirmed(f, direction), out);
  }
  return count;
}

/* Where all motions go along tangents that keep the rank, the others shake. Returns how many these are, -1: that isn't
 * so. */
static int find_steady(km_tangents *f, km_arena *arena, km_finite_mobility *out) {
  int k = f->conditions.freedom, n = f->sub->columns;
  double *directions = KM_ARENA_NEW(arena, double, (size_t)k *(size_t)n);
  if (!directions || k < 2 || !are_steady(f, directions))
    return -1;
  for (int i = 0; i < k - f->conditions.freedom; ++i)
    list_direction(f, directions + (size_t)i * (size_t)n, KM_MOTION_SHAKY, 0.0, out);
  list_basis(f, KM_MOTION_REGULAR, out);
  return f->conditions.freedom;
}

/* True if conditions of second order exceed what rounded data make of 0, so that not all tangents are finite motions. */
static bool are_refuted(km_tangents *f) {
  static const double above = 100.0; /* times the closure tolerance */
  double tolerance = f->m->closure_tolerance_given ? above * f->m->closure_tolerance : 0.0;
  return km_tangents_update_conditions(f) && km_second_order_is_significant(&f->conditions) &&
         f->conditions.size > tolerance;
}

/* True if motions may meet at an order that the second one doesn't decide: in a cusp, or with the same tangent. */
static bool may_touch(const km_tangents *f, int mobility) {
  return f->conditions.freedom > 1 && km_tangents_are_exact(f) && km_constant_rank_is_small(f->sub) && mobility <= 1;
}

/* The index of the half-branch that makes up a motion with number i: the one that goes on most nearly opposite, else,
 * in a cusp, in the same direction; -1: there is none. */
static int other_half(const km_half_branches *h, int freedom, int i, const bool *is_used) {
  static const double nearly = 0.5; /* cosine: within 60 degrees, since the ways bend up to the sphere */
  int best = -1;
  double most = 0.0;
  for (int pass = 0; pass < 2 && best < 0; ++pass)
    for (int j = 0; j < h->count; ++j) {
      double cosine = 0.0;
      for (int r = 0; r < freedom; ++r)
        cosine += h->shares[i * freedom + r] * h->shares[j * freedom + r];
      double fit = pass ? cosine : -cosine;
      if (j != i && !is_used[j] && fit > fmax(most, nearly)) {
        most = fit;
        best = j;
      }
    }
  return best;
}

/* Lists the motions that half-branches make up, in place of those from `first` on; false, and nothing changes, unless
 * they are more. */
static bool list_half_branches(km_tangents *f, const km_half_branches *h, int first, km_finite_mobility *out) {
  bool is_used[KM_MAX_HALF_BRANCHES] = {false};
  int freedom = f->conditions.freedom, motions = (h->count + 1) / 2;
  if (motions <= out->motion_count - first)
    return false;
  out->motion_count = first;
  for (int i = 0; i < h->count; ++i) {
    if (is_used[i])
      continue;
    is_used[i] = true;
    int other = other_half(h, freedom, i, is_used);
    if (other >= 0)
      is_used[other] = true;
    list_motion(f, h->shares + (size_t)i * (size_t)freedom, KM_MOTION_BRANCH, h->length, out);
  }
  out->truncated = out->truncated || h->truncated;
  return true;
}

/* The mobility of the motions through the half-branches. */
static int dimension_of_half_branches(km_tangents *f, const km_half_branches *h, const km_passive_freedoms *idle) {
  int best = 0;
  for (int i = 0; i < h->count; ++i) {
    km_arena scratch = {0};
    bool doubtful = false;
    km_state_restore(f->s, f->sub, h->saved + (size_t)i * KM_SAVED_PER_COLUMN * (size_t)f->sub->columns);
    int dimension = dimension_here(f->m, f->s, f->index, idle, &scratch, &doubtful) - f->conditions.passive_count;
    km_arena_free(&scratch);
    best = dimension > best ? dimension : best;
  }
  return best;
}

/* Finds motions that share a tangent or end in a cusp, which the second order can't separate. *mobility is that of
 * those found so far, which begin at `first`; it stays 0 where none is found, and then says nothing if tangents meet
 * the second order. */
static void find_touching(km_tangents *f, const km_passive_freedoms *idle, int first, int *mobility, bool *undecided,
                          km_finite_mobility *out) {
  km_half_branches halves;
  if (!may_touch(f, *mobility) || (*mobility == 0 && !km_tangents_satisfy_second_order(f)) ||
      !km_half_branches_find(f, &halves))
    return;
  if (*mobility == 0 && halves.count > 0) {
    *mobility = dimension_of_half_branches(f, &halves, idle);
    *undecided = halves.truncated && *mobility <= 1; /* a family of motions meets a small sphere everywhere */
  }
  *undecided = *undecided || *mobility == 0;
  if (*mobility > 0)
    list_half_branches(f, &halves, first, out);
  out->truncated = out->truncated || *mobility > 1;
}

static int find_in_few(km_tangents *f, const km_passive_freedoms *idle, km_arena *arena, km_finite_mobility *out) {
  if (f->conditions.freedom == 0 || !km_tangents_create_basis(f))
    return 0;
  bool regular = !f->conditions.has_redundant_rows || km_tangents_all_finite(f);
  int apart = regular ? 0 : list_idle(f, idle, arena, out);
  regular = regular || f->conditions.freedom == 0 || (apart > 0 && km_tangents_all_finite(f));
  int k = f->conditions.freedom, steady = regular ? -1 : find_steady(f, arena, out);
  if (steady >= 0)
    return apart + steady;
  if (regular) {
    list_basis(f, KM_MOTION_REGULAR, out);
    return apart + k;
  }
  bool alone = f->has_undecided && k == 1; /* of several directions tried, most need not be real */
  /* Where some tangents are refuted, not all are real near by either: the misfit is analytic on the manifold of the
   * primary equations. */
  int first = out->motion_count, most = k > 1 && (!f->has_undecided || are_refuted(f)) ? k - 1 : k;
  int mobility = find_branches(f, idle, most, arena, out);
  bool undecided = (alone && mobility < k) || mobility < smaller(f->undecided_dimension, most);
  find_touching(f, idle, first, &mobility, &undecided, out);
  if (mobility == 0)
    list_basis(f, undecided ? KM_MOTION_UNDECIDED : KM_MOTION_SHAKY, out);
  out->undecided = out->undecided || undecided;
  return apart + mobility;
}

/* Of the substructure. */
static int count_idle(const km_tangents *f, const km_passive_freedoms *idle) {
  int count = 0;
  for (int i = 0; i < idle->count; ++i)
    count += idle->items[i].substructure == f->index ? idle->items[i].freedoms : 0;
  return count;
}

/* The same of many, for which a basis is tried for this alone. */
static int find_steady_of_many(km_tangents *f, km_arena *arena, km_finite_mobility *out) {
  bool tried =
      f->conditions.freedom <= KM_MANY_VECTORS && f->conditions.has_redundant_rows && km_constant_rank_is_small(f->sub);
  return tried && km_tangents_create_basis(f) ? find_steady(f, arena, out) : -1;
}

static int find_in_tangents(km_tangents *f, const km_passive_freedoms *idle, km_arena *arena, km_finite_mobility *out) {
  enum { VERY_FEW = 3 }; /* more of them have families of branches, each of which would be followed */
  int freedom = f->conditions.freedom, apart = count_idle(f, idle);
  if (!km_tangents_are_many(f) || (freedom <= KM_MANY_VECTORS && freedom - apart <= VERY_FEW))
    return find_in_few(f, idle, arena, out);
  int mobility = find_steady_of_many(f, arena, out);
  mobility = mobility >= 0 ? mobility : find_in_many(f, out);
  return mobility > apart ? mobility : apart;
}

static int find_in(const km_mechanism *m, km_state *s, int index, const km_passive_freedoms *idle, km_arena *arena,
                   km_finite_mobility *out) {
  km_tangents f;
  if (!km_tangents_create(&f, m, s, index, arena))
    return 0;
  int mobility = find_in_tangents(&f, idle, arena, out);
  km_loops_restore_cached(m, s, index, f.origin);
  return mobility;
}

/* The whole search. */
typedef struct search {
  const km_mechanism *m;
  km_state *s;
  km_passive_freedoms idle;
  km_finite_mobility *out;
} search;

static km_status look(void *self, int index, km_arena *arena, km_error *error) {
  const search *f = self;
  (void)error;
  f->out->mobility += find_in(f->m, f->s, index, &f->idle, arena, f->out);
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
  km_status status = km_passive_freedoms_find(m, s, NULL, NULL, &f.idle, error);
  if (!status)
    status = km_each_substructure(m, look, &f, progress, context, "the finite mobility", error);
  km_passive_freedoms_free(&f.idle);
  return status;
}

int km_finite_mobility_branches(const km_finite_mobility *finite) {
  double product = 1.0;
  for (int i = 0; finite && i < finite->motion_count; ++i) {
    int here = finite->motions[i].substructure, branches = 0;
    bool is_first = true;
    for (int k = 0; k < finite->motion_count; ++k) {
      bool counts = finite->motions[k].substructure == here && finite->motions[k].kind == KM_MOTION_BRANCH;
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
