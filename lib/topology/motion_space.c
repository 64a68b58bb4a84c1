/* The Lie algebra that a loop's twists generate, and which of its rows are independent. */
#include "topology/motion_space.h"

#include <stdbool.h>

static double dot(km_twist a, km_twist b) {
  return km_vec3_dot(a.v, b.v) + km_vec3_dot(a.w, b.w);
}

static km_twist scaled(double s, km_twist a) {
  return (km_twist){km_vec3_scale(s, a.v), km_vec3_scale(s, a.w)};
}

/* One pass of Gram-Schmidt. */
static km_twist without_basis(const km_motion_space *g, km_twist t) {
  for (int k = 0; k < g->dimension; ++k)
    t = km_twist_axpy(-dot(g->basis[k], t), g->basis[k], t);
  return t;
}

/* What of a twist lies outside the span. Where that is little, one pass leaves rounding of the size of what it took away. */
static km_twist reduced(const km_motion_space *g, km_twist t) {
  km_twist rest = without_basis(g, t);
  return dot(rest, rest) < 0.5 * dot(t, t) ? without_basis(g, rest) : rest;
}

static void accept(km_motion_space *g, km_twist rest, double size) {
  g->basis[g->dimension++] = scaled(1.0 / size, rest);
}

/* Adds the candidate that stands out most, if any does; candidates are replaced by what is left of them. */
static int add_largest(km_motion_space *g, km_twist *candidates, int count, double tolerance) {
  int best = -1;
  double largest = 0.0;
  for (int i = 0; i < count; ++i) {
    candidates[i] = reduced(g, candidates[i]);
    double size = sqrt(dot(candidates[i], candidates[i]));
    if (size > largest) {
      largest = size;
      best = i;
    }
  }
  if (best < 0 || !(largest > tolerance))
    return 0;
  accept(g, candidates[best], largest);
  return 1;
}

static void close_span(km_motion_space *g, int most, double tolerance) {
  km_twist brackets[15];
  int grown = 1;
  while (grown && g->dimension < most) {
    int count = 0;
    grown = 0;
    for (int i = 0; i < g->dimension; ++i)
      for (int j = 0; j < i; ++j)
        brackets[count++] = km_twist_bracket(g->basis[i], g->basis[j]);
    while (g->dimension < most && add_largest(g, brackets, count, tolerance))
      grown = 1;
  }
}

static double *entry(km_twist *t, int row) {
  double *const entries[6] = {&t->v.x, &t->v.y, &t->v.z, &t->w.x, &t->w.y, &t->w.z};
  return entries[row];
}

static void list_rows(km_motion_space *g, const bool *used) {
  for (int r = 0, n = 0; r < 6; ++r)
    if (used[r])
      g->rows[n++] = r;
}

/* The rows that have entries; returns how many. */
static int find_rows(km_motion_space *g, bool *found) {
  int count = 0;
  for (int r = 0; r < 6; ++r) {
    for (int k = 0; k < g->dimension && !found[r]; ++k)
      found[r] = *entry(&g->basis[k], r) != 0.0;
    count += found[r];
  }
  return count;
}

/* Elimination with complete pivoting on the basis: its pivot rows determine the rest. Near ties go to the
 * lower row, so that equal loops get equal rows. */
static void eliminate_rows(km_motion_space *g) {
  km_twist work[6];
  bool used[6] = {false};
  for (int k = 0; k < g->dimension; ++k)
    work[k] = g->basis[k];
  for (int n = 0; n < g->dimension; ++n) {
    int row = 0, column = n;
    double largest = 0.0;
    for (int r = 0; r < 6; ++r)
      for (int k = n; k < g->dimension && !used[r]; ++k)
        if (fabs(*entry(&work[k], r)) > 1.0001 * largest) {
          largest = fabs(*entry(&work[k], r));
          row = r;
          column = k;
        }
    km_twist pivot = work[column];
    work[column] = work[n];
    work[n] = pivot;
    used[row] = true;
    for (int k = n + 1; k < g->dimension; ++k)
      work[k] = km_twist_axpy(-*entry(&work[k], row) / *entry(&pivot, row), pivot, work[k]);
  }
  list_rows(g, used);
}

/* Where as many rows have entries as there are dimensions, they are these. Those of all twists that there can be are known. */
static void choose_rows(km_motion_space *g, int most) {
  const bool all[6] = {true, true, most == 6, most == 6, most == 6, true};
  bool found[6] = {false};
  if (g->dimension == most)
    list_rows(g, all);
  else if (find_rows(g, found) == g->dimension)
    list_rows(g, found);
  else
    eliminate_rows(g);
}

void km_motion_space_close(const km_twist *twists, int count, int most, double tolerance, km_motion_space *out) {
  out->dimension = 0;
  for (int i = 0; i < count && out->dimension < most; ++i) {
    km_twist rest = reduced(out, twists[i]);
    double square = dot(rest, rest);
    if (square > tolerance * tolerance * dot(twists[i], twists[i]))
      accept(out, rest, sqrt(square));
  }
  close_span(out, most, tolerance);
  if (out->dimension == 5) /* no subalgebra of rigid motions has dimension 5 (theory 5): rounding */
    out->dimension = 6;
  choose_rows(out, most);
}
