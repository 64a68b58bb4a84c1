/* Greatest ratio of two support functions: a step a ← H⁻¹ g from any a,
 *
 *   g = ∇h(a)                       h(x) ≥ gᵀ x        h is convex, h(s x) = s h(x) for s > 0
 *   H = Σ c_k W_kᵀ W_k / |W_k a|    c(x) ≤ ½ (xᵀ H x + c(a)),   equal at x = a
 *
 * doesn't lower h/c: H⁻¹ g minimises the bound of c among the x with gᵀ x = h(a). A step is prolonged, twice as far
 * each time, as long as that raises the ratio further. */
#include "allowance/support_ratio.h"
#include "base/number/tolerances.h"
#include "base/number/vectors.h"
#include "base/random.h"

#include <math.h>
#include <string.h>

/* Root of the rounding of a sum: smaller parts of a length, whose square is a sum, are rounding. */
static double root_of_sum_rounding(void) {
  return sqrt(km_sum_rounding);
}
enum { MOST_STEPS = 300 };
/* Random starts: 60 found the largest maximum of 1 000 starts at each row of twelve sweeps, 20 all but one (1.4 %). */
enum { FIRST_STARTS = 60, LATER_STARTS = 2 };

/* W a. */
static void multiply(const km_support_terms *t, const double *a, double *Wa) {
  for (int r = 0; r < t->rows; ++r)
    Wa[r] = t->length[r] > 0.0 ? km_dot(t->W + r * t->dimension, a, t->dimension) : 0.0;
}

static double support_of(const km_support_term *list, int count, const double *Wa, bool squared, const bool *counts) {
  double sum = 0.0;
  for (int k = 0; k < count; ++k) {
    if (counts && !counts[list[k].owner])
      continue;
    double part = list[k].size * km_norm(Wa + list[k].first, list[k].rows);
    sum += squared ? part * part : part;
  }
  return squared ? sqrt(sum) : sum;
}

double km_support(const km_support_terms *t, const km_support_term *list, int count, const double *a, bool squared,
                  int owner) {
  double sum = 0.0;
  for (int k = 0; k < count; ++k) {
    double part[3] = {0};
    for (int r = 0; r < list[k].rows && (owner < 0 || list[k].owner == owner); ++r)
      part[r] = list[k].size * km_dot(t->W + (list[k].first + r) * t->dimension, a, t->dimension);
    sum += squared ? km_dot(part, part, 3) : km_norm(part, 3);
  }
  return squared ? sqrt(sum) : sum;
}

typedef struct ascent {
  const km_support_terms *t;
  bool squared;
  const bool *counts;
  double *Wa, *weight; /* [rows] */
  double *x, *far, *H; /* [dimension], [dimension²] */
} ascent;

static double ratio_at(const ascent *q, const double *a) {
  multiply(q->t, a, q->Wa);
  double h = support_of(q->t->error, q->t->error_count, q->Wa, q->squared, NULL);
  return h == 0.0 ? 0.0 : h / support_of(q->t->play, q->t->play_count, q->Wa, false, q->counts);
}

/* Gradient of h at a, up to a positive factor, from W a. */
static void gradient(const ascent *q, double *g) {
  const int n = q->t->dimension;
  memset(g, 0, (size_t)n * sizeof *g);
  memset(q->weight, 0, (size_t)q->t->rows * sizeof *q->weight);
  for (int k = 0; k < q->t->error_count; ++k) {
    const km_support_term *t = &q->t->error[k];
    double length = km_norm(q->Wa + t->first, t->rows), weight = q->squared ? t->size * t->size : t->size / length;
    for (int r = t->first; r < t->first + t->rows && length > 0.0; ++r)
      q->weight[r] += weight;
  }
  for (int r = 0; r < q->t->rows; ++r) {
    const double *row = q->t->W + r * n, weight = q->weight[r] * q->Wa[r];
    for (int i = 0; i < n && weight != 0.0; ++i)
      g[i] += weight * row[i];
  }
}

/* The lower half of H = Σ_r weight_r W_rᵀ W_r. */
static void weighted_squares(const ascent *q) {
  const int n = q->t->dimension;
  memset(q->H, 0, (size_t)n * (size_t)n * sizeof *q->H);
  for (int r = 0; r < q->t->rows; ++r) {
    const double *row = q->t->W + r * n;
    for (int i = 0; i < n && q->weight[r] != 0.0; ++i) {
      double factor = q->weight[r] * row[i];
      for (int j = 0; j <= i; ++j)
        q->H[i * n + j] += factor * row[j];
    }
  }
}

/* H of the play that counts, at a, from W a. Rows at rounding level keep its length, so that the weight 1/|W_k a| stays
 * finite. */
static void bound_of(const ascent *q, const double *a) {
  const int n = q->t->dimension;
  double size = km_norm(a, n);
  memset(q->weight, 0, (size_t)q->t->rows * sizeof *q->weight);
  for (int k = 0; k < q->t->play_count; ++k) {
    const km_support_term *t = &q->t->play[k];
    double least = root_of_sum_rounding() * size * km_norm(q->t->length + t->first, t->rows);
    for (int r = t->first; r < t->first + t->rows && (!q->counts || q->counts[t->owner]) && least > 0.0; ++r)
      q->weight[r] = q->t->length[r] > 0.0 ? t->size / fmax(km_norm(q->Wa + t->first, t->rows), least) : 0.0;
  }
  weighted_squares(q);
}

/* Solves H x = g, H semidefinite, by LDLᵀ; the lower half of H is replaced. Components of x that H doesn't determine
 * are 0. False if g isn't in the range of H. */
static bool solve(double *H, int n, double *x) {
  double size = km_norm(x, n);
  for (int i = 0; i < n; ++i) {
    double diagonal = H[i * n + i];
    for (int j = 0; j < i; ++j) {
      for (int k = 0; k < j; ++k)
        H[i * n + j] -= H[i * n + k] * H[j * n + k] * H[k * n + k];
      H[i * n + j] = H[j * n + j] > 0.0 ? H[i * n + j] / H[j * n + j] : 0.0;
    }
    for (int j = 0; j < i; ++j)
      H[i * n + i] -= H[i * n + j] * H[i * n + j] * H[j * n + j];
    if (!(H[i * n + i] > km_solved_rounding * diagonal)) /* c has a null vector */
      H[i * n + i] = 0.0;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j)
      x[i] -= H[i * n + j] * x[j];
    if (H[i * n + i] == 0.0 && fabs(x[i]) > root_of_sum_rounding() * size)
      return false;
  }
  for (int i = 0; i < n; ++i)
    x[i] = H[i * n + i] > 0.0 ? x[i] / H[i * n + i] : 0.0;
  for (int i = n - 1; i >= 0; --i)
    for (int j = i + 1; j < n; ++j)
      x[i] -= H[j * n + i] * x[j];
  return true;
}

static void normalise(double *a, int n) {
  double length = km_norm(a, n);
  for (int i = 0; i < n; ++i)
    a[i] /= length;
}

/* Prolongs the step from a to q->x by `reach` times its length if that raises the ratio, and doubles `reach`. */
static double prolong(const ascent *q, const double *a, double value, double *reach) {
  const int n = q->t->dimension;
  double sense = km_dot(q->x, a, n) < 0.0 ? -1.0 : 1.0;
  for (int i = 0; i < n; ++i)
    q->far[i] = q->x[i] + *reach * (q->x[i] - sense * a[i]);
  double far = ratio_at(q, q->far);
  bool is_better = far > value && isfinite(far);
  *reach = is_better ? 2.0 * *reach : 1.0;
  if (!is_better)
    return value;
  memcpy(q->x, q->far, (size_t)n * sizeof *q->x);
  normalise(q->x, n);
  return far;
}

/* Ascends from a; the ratio at the end, infinite if c vanishes in a direction in which h doesn't. */
static double ascend(const ascent *q, double *a) {
  const int n = q->t->dimension;
  normalise(a, n);
  double value = ratio_at(q, a), reach = 1.0;
  for (int step = 0; step < MOST_STEPS && value > 0.0; ++step) {
    multiply(q->t, a, q->Wa);
    gradient(q, q->x);
    bound_of(q, a);
    if (!solve(q->H, n, q->x))
      return HUGE_VAL;
    normalise(q->x, n);
    double next = prolong(q, a, ratio_at(q, q->x), &reach);
    if (!(next > value * (1.0 + km_root_rounding)))
      break;
    value = next;
    memcpy(a, q->x, (size_t)n * sizeof *a);
  }
  return value;
}

/* Random start a = H⁻¹ Σ c_k W_kᵀ z_k, H = Σ c_k² W_kᵀ W_k: nearly isotropic in the metric H. Where H is singular, any
 * random vector, so that it has a part in the null space. */
static void random_start(const ascent *q, uint64_t *state, double *a) {
  const int n = q->t->dimension;
  memset(a, 0, (size_t)n * sizeof *a);
  memset(q->weight, 0, (size_t)q->t->rows * sizeof *q->weight);
  for (int k = 0; k < q->t->play_count; ++k) {
    const km_support_term *t = &q->t->play[k];
    for (int r = t->first; r < t->first + t->rows && (!q->counts || q->counts[t->owner]); ++r) {
      double z = t->size * km_splitmix(state, -1.0, 1.0);
      q->weight[r] = t->size * t->size;
      for (int i = 0; i < n; ++i)
        a[i] += z * q->t->W[r * n + i];
    }
  }
  weighted_squares(q);
  bool is_regular = solve(q->H, n, a);
  for (int i = 0; i < n; ++i)
    is_regular = is_regular && q->H[i * n + i] > 0.0;
  for (int i = 0; i < n && !is_regular; ++i)
    a[i] = km_splitmix(state, -1.0, 1.0);
}

bool km_ratio_search_create(int dimension, int most, km_arena *arena, km_ratio_search *out) {
  *out = (km_ratio_search){
      .dimension = dimension, .most = most, .track = KM_ARENA_NEW(arena, double, (size_t)most *(size_t)dimension)};
  return out->track != NULL;
}

/* Stores a local maximum in order; one that equals a stored one is dropped. */
static void keep(km_ratio_search *s, double *values, double value, const double *a) {
  const size_t n = (size_t)s->dimension;
  int place = 0;
  while (place < s->count && values[place] > value * (1.0 + km_root_rounding))
    ++place;
  if (place == s->most || (place < s->count && value <= values[place] * (1.0 + km_root_rounding)))
    return;
  s->count += s->count < s->most;
  for (int k = s->count - 1; k > place; --k) {
    values[k] = values[k - 1];
    memcpy(s->track + (size_t)k * n, s->track + (size_t)(k - 1) * n, n * sizeof *a);
  }
  values[place] = value;
  memcpy(s->track + (size_t)place * n, a, n * sizeof *a);
}

double km_ratio_search_next(km_ratio_search *s, const km_support_terms *t, bool squared, const bool *counts) {
  const size_t n = (size_t)s->dimension, rows = (size_t)t->rows, most = (size_t)s->most;
  const int followed = s->count, starts = followed > 0 ? followed + LATER_STARTS : FIRST_STARTS;
  km_arena scratch = {0};
  double *work = KM_ARENA_NEW(&scratch, double, 2 * rows + n * (n + 3) + most * (n + 1)), best = 0.0;
  if (!work)
    return nan("");
  const ascent q = {
      t, squared, counts, work, work + rows, work + 2 * rows, work + 2 * rows + n, work + 2 * rows + 3 * n};
  double *a = work + 2 * rows + 2 * n, *values = q.H + n * n, *old = values + most;
  memcpy(old, s->track, (size_t)followed * n * sizeof *old);
  s->count = 0;
  for (int i = 0; i < starts && best < HUGE_VAL; ++i) {
    if (i < followed)
      memcpy(a, old + (size_t)i * n, n * sizeof *a);
    else
      random_start(&q, &s->draw, a);
    double value = ascend(&q, a);
    best = fmax(best, value);
    keep(s, values, value, a);
  }
  km_arena_free(&scratch);
  return best;
}
