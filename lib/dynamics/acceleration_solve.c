/* Inward and outward pass over the clusters: accelerations from forces and velocity products, by articulated
 * inertias (R. Featherstone 2008; K. Wehage 2016, sections 6.2-6.4; docs/theory.md 11.2).
 *
 *   inward  : D = Σ PᵀI P,  U = Σ I P,  b = Nᵀτ − Σ Pᵀ(p + I ζ);   D = L Δ Lᵀ
 *             base: inertia Σ I − U D⁻¹ Uᵀ,  force Σ(p + I ζ) + U D⁻¹ b
 *   outward : D u̇ = b − Uᵀ A_base,  q̈ = N u̇ + γ,  A = A_base + ζ + Σ P_k u̇_k */
#include "dynamics/dynamics.h"

/* A pivot of D below this part of its diagonal entry is rounding: the motion moves no mass. */
static const double massless_pivot = 1e-13;

/* Wrench I a of a node's bodies and eliminated clusters at the acceleration a. */
km_wrench km_node_inertia_force(const km_dynamics *d, int n, km_twist a) {
  const km_node *node = &d->tree.nodes[n];
  km_wrench w = node->has_mass ? km_inertia_times(&d->node[n].inertia, a) : (km_wrench){{0, 0, 0}, {0, 0, 0}};
  return node->is_base ? km_wrench_axpy(1.0, km_articulated_times(&d->articulated[n], a), w) : w;
}

static bool has_inertia(const km_dynamics *d, int n) {
  return d->tree.nodes[n].has_mass || d->tree.nodes[n].is_base;
}

/* Computes ζ and the partial velocities P_k of the cluster's nodes. */
static void partial_velocities(km_dynamics *d, const km_cluster *cluster, const km_cluster_motion *c) {
  int coordinates = cluster->coordinate_count, count = c->freedom;
  for (int i = 0; i < cluster->node_count; ++i) {
    int n = cluster->node_start + i;
    const km_node *node = &d->tree.nodes[n];
    const km_twist *h = &d->column[node->coordinate];
    km_node_motion *own = &d->node[n];
    bool inside = node->parent >= cluster->node_start;
    km_twist *P = c->P + (size_t)i * (size_t)count;
    const km_twist *from = inside ? c->P + (size_t)(node->parent - cluster->node_start) * (size_t)count : P;
    if (inside)
      own->zeta = km_twist_axpy(1.0, d->node[node->parent].zeta, own->zeta);
    else if (cluster->base == 0)
      own->zeta = km_twist_axpy(1.0, d->node[0].A, own->zeta);
    for (int k = 0; k < count; ++k)
      P[k] = inside ? from[k] : (km_twist){{0, 0, 0}, {0, 0, 0}};
    for (int f = 0; f < node->freedom && node->local >= 0; ++f) {
      const double *N = c->N + node->local + f;
      own->zeta = km_twist_axpy(c->gamma[node->local + f], h[f], own->zeta);
      for (int k = 0; k < count; ++k)
        P[k] = km_twist_axpy(N[(size_t)k * (size_t)coordinates], h[f], P[k]);
    }
  }
}

/* Adds armature inertias: a rotor contributes a q̇²/2 to the kinetic energy and nothing to the base. */
static void add_armatures(const km_dynamics *d, const km_cluster *cluster, const km_cluster_motion *c) {
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  size_t n = (size_t)cluster->coordinate_count;
  int count = c->freedom;
  for (size_t i = 0; i < n; ++i) {
    double a = d->armature[coordinates[i]];
    for (int k = 0; k < count && a != 0.0; ++k) {
      double part = a * c->N[(size_t)k * n + i];
      c->b[k] -= part * c->gamma[i];
      for (int l = 0; l <= k; ++l)
        c->D[k * count + l] += part * c->N[(size_t)l * n + i];
    }
  }
}

/* Computes D, b and U of the cluster; returns Σ(p + I ζ) over its nodes. */
static km_wrench cluster_equations(km_dynamics *d, const km_cluster *cluster, const km_cluster_motion *c) {
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  km_wrench sum = {{0, 0, 0}, {0, 0, 0}};
  int count = c->freedom;
  for (int k = 0; k < count; ++k) {
    const double *N = c->N + (size_t)k * (size_t)cluster->coordinate_count;
    double b = 0.0;
    for (int i = 0; i < cluster->coordinate_count; ++i)
      b += N[i] * d->forces->joint[coordinates[i]];
    c->b[k] = b;
    c->U[k] = (km_wrench){{0, 0, 0}, {0, 0, 0}};
    for (int l = 0; l <= k; ++l)
      c->D[k * count + l] = 0.0;
  }
  for (int i = 0; i < cluster->node_count; ++i) {
    int n = cluster->node_start + i;
    const km_twist *P = c->P + (size_t)i * (size_t)count;
    km_wrench r = d->node[n].p;
    if (has_inertia(d, n))
      r = km_wrench_axpy(1.0, km_node_inertia_force(d, n, d->node[n].zeta), r);
    sum = km_wrench_axpy(1.0, r, sum);
    for (int k = 0; k < count; ++k) {
      c->b[k] -= km_wrench_power(r, P[k]);
      if (!has_inertia(d, n))
        continue;
      km_wrench g = km_node_inertia_force(d, n, P[k]);
      c->U[k] = km_wrench_axpy(1.0, g, c->U[k]);
      for (int l = 0; l <= k; ++l)
        c->D[k * count + l] += km_wrench_power(g, P[l]);
    }
  }
  return sum;
}

enum { NONE = -1 };

/* Factors D = L Δ Lᵀ in place, by rows. Returns NONE, or the row of a vanishing pivot. */
static int factor_ldlt(double *D, int count) {
  for (int k = 0; k < count; ++k) {
    double *row = D + k * count, diagonal = row[k];
    for (int l = 0; l < k; ++l) {
      double sum = row[l];
      for (int o = 0; o < l; ++o)
        sum -= row[o] * D[l * count + o];
      row[l] = sum;
    }
    for (int l = 0; l < k; ++l) {
      double scaled = row[l] / D[l * count + l];
      row[k] -= scaled * row[l];
      row[l] = scaled;
    }
    if (!(row[k] > massless_pivot * diagonal))
      return k;
  }
  return NONE;
}

/* Forward substitution b ← L⁻¹ b. */
static void substitute(const double *D, int count, double *b) {
  for (int k = 0; k < count; ++k)
    for (int l = 0; l < k; ++l)
      b[k] -= D[k * count + l] * b[l];
}

/* Adds the cluster to its base as a body of inertia Σ I − U D⁻¹ Uᵀ with the force sum + U D⁻¹ b (reverse Schur
 * complement). With D = L Δ Lᵀ and W = U L⁻ᵀ, which replaces U, these are Σ I − W Δ⁻¹ Wᵀ and sum + W Δ⁻¹ (L⁻¹ b). */
static void add_to_base(km_dynamics *d, const km_cluster *cluster, const km_cluster_motion *c, km_wrench sum) {
  km_articulated *base = &d->articulated[cluster->base];
  int count = c->freedom;
  for (int i = 0; i < cluster->node_count; ++i) {
    int n = cluster->node_start + i;
    if (d->tree.nodes[n].has_mass)
      km_articulated_add_body(base, &d->node[n].inertia);
    if (d->tree.nodes[n].is_base)
      km_articulated_add(base, &d->articulated[n]);
  }
  for (int k = 0; k < count; ++k) {
    double pivot = c->D[k * count + k];
    for (int l = 0; l < k; ++l)
      c->U[k] = km_wrench_axpy(-c->D[k * count + l], c->U[l], c->U[k]);
    km_articulated_add_outer_product(base, -1.0 / pivot, c->U[k]);
    sum = km_wrench_axpy(c->b[k] / pivot, c->U[k], sum);
  }
  d->node[cluster->base].p = km_wrench_axpy(1.0, sum, d->node[cluster->base].p);
}

/* Computes u̇ from the base's acceleration A (NULL: 0) by Lᵀ u̇ = Δ⁻¹ (L⁻¹ b − Wᵀ A), with L⁻¹ b and W of the inward
 * pass. */
static void solve_udot(const km_cluster_motion *c, const km_twist *base, double *x) {
  int count = c->freedom;
  for (int k = 0; k < count; ++k) {
    double rhs = base ? c->b[k] - km_wrench_power(c->U[k], *base) : c->b[k];
    x[k] = rhs / c->D[k * count + k];
  }
  for (int k = count - 1; k >= 0; --k)
    for (int l = k + 1; l < count; ++l)
      x[k] -= c->D[l * count + k] * x[l];
}

/* Eliminates one cluster: forms and factors D, b, U and adds the cluster to its base. */
static km_dynamics_outcome inward_pass(km_dynamics *d, int index) {
  const km_cluster *cluster = &d->tree.clusters[index];
  km_cluster_motion *c = &d->cluster[index];
  partial_velocities(d, cluster, c);
  km_wrench sum = cluster_equations(d, cluster, c);
  if (d->armature)
    add_armatures(d, cluster, c);
  int vanishing_pivot = factor_ldlt(c->D, c->freedom);
  if (vanishing_pivot != NONE && isfinite(c->D[vanishing_pivot * c->freedom + vanishing_pivot])) {
    d->massless = d->tree.coordinate_order[cluster->coordinate_start + c->independent[vanishing_pivot]];
    return KM_DYNAMICS_MASSLESS;
  }
  if (vanishing_pivot != NONE)
    return KM_DYNAMICS_INFINITE;
  substitute(c->D, c->freedom, c->b);
  if (cluster->base > 0)
    add_to_base(d, cluster, c, sum);
  return KM_DYNAMICS_DONE;
}

/* Accelerations of one cluster and its nodes from the acceleration of its base. */
static void outward_pass(km_dynamics *d, km_state *s, int index) {
  const km_cluster *cluster = &d->tree.clusters[index];
  const km_cluster_motion *c = &d->cluster[index];
  const int *coordinates = d->tree.coordinate_order + cluster->coordinate_start;
  const km_twist *base = cluster->base ? &d->node[cluster->base].A : NULL;
  int count = c->freedom, n = cluster->coordinate_count;
  solve_udot(c, base, c->udot);
  for (int i = 0; i < n; ++i) {
    double sum = c->gamma[i];
    for (int k = 0; k < count; ++k)
      sum += c->N[(size_t)k * (size_t)n + (size_t)i] * c->udot[k];
    s->acceleration[coordinates[i]] = sum;
  }
  for (int i = 0; i < cluster->node_count; ++i) {
    km_node_motion *node = &d->node[cluster->node_start + i];
    const km_twist *P = c->P + (size_t)i * (size_t)count;
    node->A = base ? km_twist_axpy(1.0, node->zeta, *base) : node->zeta;
    for (int k = 0; k < count; ++k)
      node->A = km_twist_axpy(c->udot[k], P[k], node->A);
  }
}

/* Inward pass over the clusters from the tips, outward pass from the base; gravity is an acceleration of the
 * inertial frame. */
km_dynamics_outcome km_tree_solve(km_dynamics *d, km_state *s) {
  km_dynamics_outcome outcome = KM_DYNAMICS_DONE;
  d->node[0].A = (km_twist){km_vec3_scale(-1.0, d->forces->stated_gravity), {0, 0, 0}};
  for (int n = 1; n < d->tree.node_count; ++n)
    if (d->tree.nodes[n].is_base)
      d->articulated[n] = (km_articulated){0};
  for (int i = d->tree.cluster_count - 1; i >= 0 && outcome == KM_DYNAMICS_DONE; --i)
    outcome = inward_pass(d, i);
  for (int i = 0; i < d->tree.cluster_count && outcome == KM_DYNAMICS_DONE; ++i)
    outward_pass(d, s, i);
  return outcome;
}
