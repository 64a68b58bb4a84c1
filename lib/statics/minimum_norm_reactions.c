/* Which of the reactions that balance the loads are least: a joint carries what the tree and the chords' wrenches μ do in
 * it, and self-stresses N may be added to μ. With the joints' arms M is the matrix of Σ |force|² + |torque / L|² in μ;
 * ν of μ + N ν makes it least where Nᵀ M N ν = −Nᵀ (g + M μ), g from what the tree does. */
#include "statics/statics.h"

#include <string.h>

/* Every self-stress acts in the joints of its own loops, whose parts in Nᵀ M N leave pivots of about (length / arm)²: one
 * below this share of its own square, or so small beside the others', lies in couplings alone and stresses no joint. */
static const double no_stress = 1e-12, no_square = 1e-18;

/* What the chords' wrenches μ do in a joint, along the inertial axes and about its reaction's place. */
static km_wrench in_joint(const km_reaction_workspace *c, int j, const double *mu) {
  km_wrench sum = {{0, 0, 0}, {0, 0, 0}};
  for (int i = c->first[j]; i < c->first[j + 1]; ++i) {
    const double *chord = mu + 6 * c->passing[i].loop, sense = c->passing[i].sense;
    sum.f = km_vec3_axpy(sense, km_vec3_from_array(chord), sum.f);
    sum.t = km_vec3_axpy(sense, km_vec3_from_array(chord + 3), sum.t);
  }
  sum.f = km_vec3_scale(1.0 / c->size, sum.f);
  return km_wrench_about(sum, c->arm[j]);
}

static void add_chords(const km_reaction_workspace *c, km_wrench *carried) {
  for (int j = 0; j < c->joints; ++j)
    carried[c->joint[j]] = km_wrench_axpy(1.0, in_joint(c, j, c->mu), carried[c->joint[j]]);
}

/* Σ over the joints that two loops share: how they add up there, times 1, d and the products of d's components. */
static void gather_moments(km_reaction_workspace *c) {
  memset(c->moments, 0, (size_t)c->loops * (size_t)c->loops * sizeof *c->moments);
  for (int j = 0; j < c->joints; ++j) {
    km_vec3 d = c->arm[j], squares = {d.x * d.x, d.y * d.y, d.z * d.z}, products = {d.y * d.z, d.z * d.x, d.x * d.y};
    for (int a = c->first[j]; a < c->first[j + 1]; ++a)
      for (int b = c->first[j]; b <= a; ++b) {
        km_arm_moments *sum = &c->moments[c->passing[a].loop * c->loops + c->passing[b].loop];
        double sense = c->passing[a].sense * c->passing[b].sense;
        sum->count += sense;
        sum->first = km_vec3_axpy(sense, d, sum->first);
        sum->squares = km_vec3_axpy(sense, squares, sum->squares);
        sum->products = km_vec3_axpy(sense, products, sum->products);
      }
  }
}

/* What a chord's wrench (F · size; T) does in a joint is F and T − d × F: their Σ as a matrix, symmetric. */
static void fill_block(const km_arm_moments *sum, double size, double length, double *out, size_t rows) {
  double turn = 1.0 / (length * length), push = 1.0 / (size * size), far = push * turn, alone = push * sum->count;
  km_vec3 d = km_vec3_scale(turn / size, sum->first), xx = km_vec3_scale(far, sum->squares);
  km_vec3 xy = km_vec3_scale(-far, sum->products);
  const double block[6][6] = {
      {alone + xx.y + xx.z, xy.z, xy.y, 0.0, -d.z, d.y}, {xy.z, alone + xx.z + xx.x, xy.x, d.z, 0.0, -d.x},
      {xy.y, xy.x, alone + xx.x + xx.y, -d.y, d.x, 0.0}, {0.0, d.z, -d.y, turn * sum->count, 0.0, 0.0},
      {-d.z, 0.0, d.x, 0.0, turn * sum->count, 0.0},     {d.y, -d.x, 0.0, 0.0, 0.0, turn * sum->count}};
  for (size_t k = 0; k < 6; ++k)
    memcpy(out + k * rows, block[k], sizeof block[k]);
}

/* M: 0 for couplings, which stress no joint. */
static void fill_metric(km_reaction_workspace *c, double length) {
  size_t rows = (size_t)c->rows;
  gather_moments(c);
  memset(c->metric, 0, rows * rows * sizeof *c->metric);
  for (size_t a = 0; a < (size_t)c->loops; ++a)
    for (size_t b = 0; b <= a; ++b) {
      const km_arm_moments *sum = &c->moments[a * (size_t)c->loops + b];
      fill_block(sum, c->size, length, c->metric + 6 * a * rows + 6 * b, rows);
      if (b < a)
        fill_block(sum, c->size, length, c->metric + 6 * b * rows + 6 * a, rows);
    }
}

/* g: half the slope of Σ in μ at μ = 0. */
static void fill_gradient(km_reaction_workspace *c, const km_wrench *carried, double length) {
  double inverse = 1.0 / c->size, turn = 1.0 / (length * length);
  memset(c->gradient, 0, (size_t)c->rows * sizeof *c->gradient);
  for (int j = 0; j < c->joints; ++j) {
    const km_wrench *w = &carried[c->joint[j]];
    km_vec3 t = km_vec3_scale(turn, w->t), f = km_vec3_scale(inverse, km_vec3_add(w->f, km_vec3_cross(c->arm[j], t)));
    const double slope[6] = {f.x, f.y, f.z, t.x, t.y, t.z};
    for (int i = c->first[j]; i < c->first[j + 1]; ++i)
      for (int k = 0; k < 6; ++k)
        c->gradient[6 * c->passing[i].loop + k] += c->passing[i].sense * slope[k];
  }
}

/* The entries of N that aren't 0: of the partition's null vectors [-B; I], and 1 for what no motion feels. Returns how many
 * self-stresses there are. */
static int list_stresses(km_reaction_workspace *c) {
  const km_partition *p = &c->partition;
  int count = 0, degree = 0;
  for (int k = p->rank; k < c->rows; ++k) {
    c->stress_start[degree++] = count;
    c->stress[count++] = (km_stress_entry){c->felt[k < c->felt_count ? p->column[k] : k], 1.0};
    const double *b = k < c->felt_count ? km_partition_b(p, k - p->rank) : NULL;
    for (int i = 0; i < p->rank && b; ++i)
      if (b[i] != 0.0)
        c->stress[count++] = (km_stress_entry){c->felt[p->column[i]], -b[i]};
  }
  c->stress_start[degree] = count;
  return degree;
}

static inline double along_stress(const km_reaction_workspace *c, int k, const double *v) {
  double sum = 0.0;
  for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
    sum += c->stress[i].value * v[c->stress[i].row];
  return sum;
}

static inline void add_stress(const km_reaction_workspace *c, int k, double share, double *mu) {
  for (int i = c->stress_start[k]; i < c->stress_start[k + 1]; ++i)
    mu[c->stress[i].row] += share * c->stress[i].value;
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
      c->gram[(size_t)o * (size_t)degree + (size_t)k] = along_stress(c, o, image);
  }
}

/* Nᵀ M N = L Lᵀ, L in the lower triangle of `gram`, without the self-stresses that stress no joint: their columns are 0. */
static void factor_gram(km_reaction_workspace *c, int degree) {
  size_t n = (size_t)degree;
  double largest = 0.0;
  for (size_t k = 0; k < n; ++k)
    largest = c->gram[k * n + k] > largest ? c->gram[k * n + k] : largest;
  for (size_t k = 0; k < n; ++k) {
    double *own = c->gram + k * n, whole = own[k];
    for (size_t o = 0; o < k; ++o) {
      const double *before = c->gram + o * n;
      for (size_t r = k; r < n; ++r)
        own[r] -= before[k] * before[r];
    }
    own[k] = own[k] > no_stress * whole && own[k] > no_square * largest ? 1.0 / sqrt(own[k]) : 0.0;
    for (size_t r = k + 1; r < n; ++r)
      own[r] *= own[k];
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

/* Both halves of the sum at a time. */
static double dot(const double *a, const double *b, int count) {
  km_pair sum = {0.0, 0.0};
  int i = 0;
  for (; i + 1 < count; i += 2)
    sum += km_pair_load(a + i) * km_pair_load(b + i);
  return sum[0] + sum[1] + (i < count ? a[i] * b[i] : 0.0);
}

/* Adds self-stresses to μ until Nᵀ (g + M μ) = 0. The second pass takes away what the first has left by rounding. */
static void correct_chords(km_reaction_workspace *c, int degree) {
  for (int k = 0; k < degree; ++k)
    c->slope[k] = along_stress(c, k, c->gradient);
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
