/* Minimum-norm reactions of a small substructure (theory 9.4).
 *
 *   a joint transmits the tree's part and the chords' wrenches μ; self-stresses N (Jᵀ N = 0) can be added
 *   norm  : Σ |force|² + |torque/L|² over the joints = μᵀ M μ + 2 gᵀ μ + const,   g from the tree's part
 *   min   : Nᵀ M N ν = -Nᵀ (g + M μ),   μ <- μ + N ν;   Cholesky factorisation, corrected once */
#include "base/number/tolerances.h"
#include "statics/statics.h"

#include <string.h>

/* Returns the wrench of the chords' μ in a joint, along the inertial axes about its reaction's point. */
static km_wrench wrench_in_joint(const km_reaction_workspace *c, int j, const double *mu) {
  km_wrench sum = {{0, 0, 0}, {0, 0, 0}};
  int joint = c->joint[j];
  for (int i = c->first[joint]; i < c->first[joint + 1]; ++i) {
    const double *chord = mu + 6 * c->joint_loops[i].loop, sign = c->joint_loops[i].sign;
    sum.f = km_vec3_axpy(sign, km_vec3_from_array(chord), sum.f);
    sum.t = km_vec3_axpy(sign, km_vec3_from_array(chord + 3), sum.t);
  }
  sum.f = km_vec3_scale(1.0 / c->size, sum.f);
  return km_wrench_about(sum, c->arm[j]);
}

static void add_chords(const km_reaction_workspace *c, km_wrench *carried) {
  for (int j = 0; j < c->joints; ++j)
    carried[c->joint[j]] = km_wrench_axpy(1.0, wrench_in_joint(c, j, c->mu), carried[c->joint[j]]);
}

/* Computes, for every pair of loops, the sums over their common joints of the signs' product times 1, d, d dᵀ. */
static void compute_arm_moments(km_reaction_workspace *c) {
  memset(c->moments, 0, (size_t)c->loops * (size_t)c->loops * sizeof *c->moments);
  for (int j = 0; j < c->joints; ++j) {
    km_vec3 d = c->arm[j], squares = {d.x * d.x, d.y * d.y, d.z * d.z}, products = {d.y * d.z, d.z * d.x, d.x * d.y};
    int joint = c->joint[j];
    for (int a = c->first[joint]; a < c->first[joint + 1]; ++a)
      for (int b = c->first[joint]; b <= a; ++b) {
        km_arm_moments *sum = &c->moments[c->joint_loops[a].loop * c->loops + c->joint_loops[b].loop];
        double sign = c->joint_loops[a].sign * c->joint_loops[b].sign;
        sum->count += sign;
        sum->first = km_vec3_axpy(sign, d, sum->first);
        sum->squares = km_vec3_axpy(sign, squares, sum->squares);
        sum->products = km_vec3_axpy(sign, products, sum->products);
      }
  }
}

/* Fills the 6 × 6 block of M for two loops: a chord's wrench (F · size; T) acts in a joint as F and T − d × F. */
static void fill_block(const km_arm_moments *sum, double size, double length, double *out, size_t rows) {
  double rotation = 1.0 / (length * length), force_weight = 1.0 / (size * size), cross_weight = force_weight * rotation,
         tree_joint = force_weight * sum->count;
  km_vec3 d = km_vec3_scale(rotation / size, sum->first), xx = km_vec3_scale(cross_weight, sum->squares);
  km_vec3 xy = km_vec3_scale(-cross_weight, sum->products);
  const double block[6][6] = {
      {tree_joint + xx.y + xx.z, xy.z, xy.y, 0.0, -d.z, d.y}, {xy.z, tree_joint + xx.z + xx.x, xy.x, d.z, 0.0, -d.x},
      {xy.y, xy.x, tree_joint + xx.x + xx.y, -d.y, d.x, 0.0}, {0.0, d.z, -d.y, rotation * sum->count, 0.0, 0.0},
      {-d.z, 0.0, d.x, 0.0, rotation * sum->count, 0.0},      {d.y, -d.x, 0.0, 0.0, 0.0, rotation * sum->count}};
  for (size_t k = 0; k < 6; ++k)
    memcpy(out + k * rows, block[k], sizeof block[k]);
}

/* Fills M; 0 for couplings, which load no joint. */
static void fill_metric(km_reaction_workspace *c, double length) {
  size_t rows = (size_t)c->rows;
  compute_arm_moments(c);
  memset(c->metric, 0, rows * rows * sizeof *c->metric);
  for (size_t a = 0; a < (size_t)c->loops; ++a)
    for (size_t b = 0; b <= a; ++b) {
      const km_arm_moments *sum = &c->moments[a * (size_t)c->loops + b];
      fill_block(sum, c->size, length, c->metric + 6 * a * rows + 6 * b, rows);
      if (b < a)
        fill_block(sum, c->size, length, c->metric + 6 * b * rows + 6 * a, rows);
    }
}

/* Computes g, half the gradient of the norm at μ = 0. */
static void fill_gradient(km_reaction_workspace *c, const km_wrench *carried, double length) {
  double inverse = 1.0 / c->size, rotation = 1.0 / (length * length);
  memset(c->gradient, 0, (size_t)c->rows * sizeof *c->gradient);
  for (int j = 0; j < c->joints; ++j) {
    int joint = c->joint[j];
    const km_wrench *w = &carried[joint];
    km_vec3 t = km_vec3_scale(rotation, w->t),
            f = km_vec3_scale(inverse, km_vec3_add(w->f, km_vec3_cross(c->arm[j], t)));
    const double slope[6] = {f.x, f.y, f.z, t.x, t.y, t.z};
    for (int i = c->first[joint]; i < c->first[joint + 1]; ++i)
      for (int k = 0; k < 6; ++k)
        c->gradient[6 * c->joint_loops[i].loop + k] += c->joint_loops[i].sign * slope[k];
  }
}

/* Lists the nonzero entries of N: the factor's null vectors [-B; I], and unit vectors for zero rows. Returns the
 * number of self-stresses. */
static int list_stresses(km_reaction_workspace *c) {
  const km_factor *p = c->factor;
  const int rank = km_factor_rank(p), *column = km_factor_column_order(p);
  int count = 0, degree = 0;
  for (int k = rank; k < c->rows; ++k) {
    c->stress_start[degree++] = count;
    c->stress[count++] = (km_stress_entry){c->nonzero_row[k < c->nonzero_row_count ? column[k] : k], 1.0};
    const double *b = k < c->nonzero_row_count ? km_factor_b(p, k - rank) : NULL;
    for (int i = 0; i < rank && b; ++i)
      if (b[i] != 0.0)
        c->stress[count++] = (km_stress_entry){c->nonzero_row[column[i]], -b[i]};
  }
  c->stress_start[degree] = count;
  return degree;
}

static inline double dot_stress(const km_reaction_workspace *c, int k, const double *v) {
  double sum = 0.0;
  for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
    sum += c->stress[i].value * v[c->stress[i].row];
  return sum;
}

static inline void add_stress(const km_reaction_workspace *c, int k, double coefficient, double *mu) {
  for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
    mu[c->stress[i].row] += coefficient * c->stress[i].value;
}

static void add_column(const km_reaction_workspace *c, double factor, int column, double *out) {
  const double *from = c->metric + (size_t)column * (size_t)c->rows;
  for (int r = 0; r < c->rows; ++r)
    out[r] += factor * from[r];
}

static void fill_gram(km_reaction_workspace *c, int degree) {
  memset(c->image, 0, (size_t)degree * (size_t)c->rows * sizeof *c->image);
  for (int k = 0; k < degree; ++k) {
    double *image = c->image + (size_t)k * (size_t)c->rows;
    for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
      add_column(c, c->stress[i].value, c->stress[i].row, image);
    for (int o = 0; o <= k; ++o)
      c->gram[(size_t)o * (size_t)degree + (size_t)k] = dot_stress(c, o, image);
  }
}

/* Cholesky factorisation Nᵀ M N = L Lᵀ, L in the lower triangle of `gram`. Self-stresses that load no joint, in
 * couplings only, have zero columns: their pivots are rounding, or a square of rounding over the largest pivot. The
 * others are about (length / arm)², since every self-stress acts in the joints of its loops. */
static void factor_gram(km_reaction_workspace *c, int degree) {
  size_t n = (size_t)degree;
  double largest = 0.0;
  for (size_t k = 0; k < n; ++k)
    largest = c->gram[k * n + k] > largest ? c->gram[k * n + k] : largest;
  for (size_t k = 0; k < n; ++k) {
    double *column = c->gram + k * n, diagonal = column[k];
    for (size_t o = 0; o < k; ++o) {
      const double *before = c->gram + o * n;
      for (size_t r = k; r < n; ++r)
        column[r] -= before[k] * before[r];
    }
    column[k] = column[k] > km_solved_rounding * diagonal && column[k] > km_relative_zero * km_relative_zero * largest
                    ? 1.0 / sqrt(column[k])
                    : 0.0;
    for (size_t r = k + 1; r < n; ++r)
      column[r] *= column[k];
  }
}

static void solve_gram(const km_reaction_workspace *c, int degree, double *x) {
  size_t n = (size_t)degree;
  for (size_t k = 0; k < n; ++k) {
    const double *l = c->gram + k * n;
    x[k] *= l[k];
    for (size_t r = k + 1; r < n; ++r)
      x[r] -= l[r] * x[k];
  }
  for (size_t k = n; k-- > 0;) {
    const double *l = c->gram + k * n;
    for (size_t r = k + 1; r < n; ++r)
      x[k] -= l[r] * x[r];
    x[k] *= l[k];
  }
}

/* Dot product with two partial sums (SIMD pair). */
static double dot(const double *a, const double *b, int count) {
  km_pair sum = {0.0, 0.0};
  int i = 0;
  for (; i + 1 < count; i += 2)
    sum += km_pair_load(a + i) * km_pair_load(b + i);
  return sum[0] + sum[1] + (i < count ? a[i] * b[i] : 0.0);
}

/* Adds self-stresses to μ so that Nᵀ (g + M μ) = 0; the second pass corrects the rounding of the first. */
static void correct_chords(km_reaction_workspace *c, int degree) {
  for (int k = 0; k < degree; ++k)
    c->slope[k] = dot_stress(c, k, c->gradient);
  for (int pass = 0; pass < 2; ++pass) {
    const double *image = c->image;
    for (int k = 0; k < degree; ++k, image += c->rows)
      c->share[k] = -(c->slope[k] + dot(image, c->mu, c->rows));
    solve_gram(c, degree, c->share);
    for (int k = 0; k < degree; ++k)
      add_stress(c, k, c->share[k], c->mu);
  }
}

void km_reactions_minimise_norm(km_reaction_workspace *c, km_statics_workspace *w, double length) {
  c->degree = list_stresses(c);
  if (c->degree > 0) {
    fill_metric(c, length);
    fill_gram(c, c->degree);
    factor_gram(c, c->degree);
    fill_gradient(c, w->carried, length);
    correct_chords(c, c->degree);
  }
  add_chords(c, w->carried);
}
