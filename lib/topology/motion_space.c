/* Motion space of a loop: the Lie algebra that its twists generate, and its independent rows (docs/theory.md 2.4).
 *
 *   g₀ = span(h_j),  g_{i+1} = g_i + [g_i, g_i],  until the dimension stays;   λ = dim g
 *
 * Gram-Schmidt with the largest remaining candidate first; elimination with complete pivoting chooses the λ rows. */
#include "topology/motion_space.h"

#include <stdbool.h>

static double dot(km_twist a, km_twist b) {
  return km_vec3_dot(a.v, b.v) + km_vec3_dot(a.w, b.w);
}

static km_twist scaled(double s, km_twist a) {
  return (km_twist){km_vec3_scale(s, a.v), km_vec3_scale(s, a.w)};
}

/* One pass of Gram-Schmidt: t minus its projection onto the basis. */
static km_twist subtract_projection(const km_motion_space *g, km_twist t) {
  for (int k = 0; k < g->dimension; ++k)
    t = km_twist_axpy(-dot(g->basis[k], t), g->basis[k], t);
  return t;
}

/* Part of a twist that is orthogonal to the span. A second pass removes the rounding of the first if little remains. */
static km_twist orthogonal_part(const km_motion_space *g, km_twist t) {
  km_twist remainder = subtract_projection(g, t);
  return dot(remainder, remainder) < 0.5 * dot(t, t) ? subtract_projection(g, remainder) : remainder;
}

static void append_basis_vector(km_motion_space *g, km_twist remainder, double size) {
  g->basis[g->dimension++] = scaled(1.0 / size, remainder);
}

/* Appends the candidate with the largest orthogonal part, if it exceeds the tolerance; all candidates are replaced by
 * their orthogonal parts. Returns the number of appended vectors. */
static int append_largest(km_motion_space *g, km_twist *candidates, int count, double tolerance) {
  int best = -1;
  double largest_size = 0.0;
  for (int i = 0; i < count; ++i) {
    candidates[i] = orthogonal_part(g, candidates[i]);
    double size = sqrt(dot(candidates[i], candidates[i]));
    if (size > largest_size) {
      largest_size = size;
      best = i;
    }
  }
  if (best < 0 || !(largest_size > tolerance))
    return 0;
  append_basis_vector(g, candidates[best], largest_size);
  return 1;
}

/* Adds brackets of basis vectors until the dimension stays. */
static void close_under_bracket(km_motion_space *g, int max_dimension, double tolerance) {
  km_twist brackets[15];
  int has_grown = 1;
  while (has_grown && g->dimension < max_dimension) {
    int count = 0;
    has_grown = 0;
    for (int i = 0; i < g->dimension; ++i)
      for (int j = 0; j < i; ++j)
        brackets[count++] = km_twist_bracket(g->basis[i], g->basis[j]);
    while (g->dimension < max_dimension && append_largest(g, brackets, count, tolerance))
      has_grown = 1;
  }
}

static double *component(km_twist *t, int row) {
  double *const entries[6] = {&t->v.x, &t->v.y, &t->v.z, &t->w.x, &t->w.y, &t->w.z};
  return entries[row];
}

static void copy_rows(km_motion_space *g, const bool *used) {
  for (int r = 0, n = 0; r < 6; ++r)
    if (used[r])
      g->rows[n++] = r;
}

/* Marks the rows with non-zero entries. Returns their number. */
static int find_nonzero_rows(km_motion_space *g, bool *is_nonzero) {
  int count = 0;
  for (int r = 0; r < 6; ++r) {
    for (int k = 0; k < g->dimension && !is_nonzero[r]; ++k)
      is_nonzero[r] = *component(&g->basis[k], r) != 0.0;
    count += is_nonzero[r];
  }
  return count;
}

/* Elimination with complete pivoting on the basis: its pivot rows determine the other rows. Near-ties go to the lower
 * row, so that equal loops get equal rows. */
static void eliminate_rows(km_motion_space *g) {
  km_twist work[6];
  bool used[6] = {false};
  for (int k = 0; k < g->dimension; ++k)
    work[k] = g->basis[k];
  for (int n = 0; n < g->dimension; ++n) {
    int row = 0, column = n;
    double largest_size = 0.0;
    for (int r = 0; r < 6; ++r)
      for (int k = n; k < g->dimension && !used[r]; ++k)
        if (fabs(*component(&work[k], r)) > 1.0001 * largest_size) {
          largest_size = fabs(*component(&work[k], r));
          row = r;
          column = k;
        }
    km_twist pivot = work[column];
    work[column] = work[n];
    work[n] = pivot;
    used[row] = true;
    for (int k = n + 1; k < g->dimension; ++k)
      work[k] = km_twist_axpy(-*component(&work[k], row) / *component(&pivot, row), pivot, work[k]);
  }
  copy_rows(g, used);
}

/* Chooses the independent rows: those of all possible twists, the non-zero rows if their number is the dimension, else
 * by elimination. */
static void choose_rows(km_motion_space *g, int max_dimension) {
  const bool all[6] = {true, true, max_dimension == 6, max_dimension == 6, max_dimension == 6, true};
  bool is_nonzero[6] = {false};
  if (g->dimension == max_dimension)
    copy_rows(g, all);
  else if (find_nonzero_rows(g, is_nonzero) == g->dimension)
    copy_rows(g, is_nonzero);
  else
    eliminate_rows(g);
}

/* Lie algebra closure of the twists, and its independent rows. */
void km_motion_space_close(const km_twist *twists, int count, int max_dimension, double tolerance,
                           km_motion_space *out) {
  out->dimension = 0;
  for (int i = 0; i < count && out->dimension < max_dimension; ++i) {
    km_twist remainder = orthogonal_part(out, twists[i]);
    double square = dot(remainder, remainder);
    if (square > tolerance * tolerance * dot(twists[i], twists[i]))
      append_basis_vector(out, remainder, sqrt(square));
  }
  close_under_bracket(out, max_dimension, tolerance);
  if (out->dimension == 5) /* no subalgebra of rigid motions has dimension 5 (docs/theory.md 2.4): rounding */
    out->dimension = 6;
  choose_rows(out, max_dimension);
}
