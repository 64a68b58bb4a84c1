/* Counts the multiplications of one solution of the equations of motion: by clusters, and as one dense system. */
#include "dynamics/dynamics.h"

/* Multiplications: inertia times twist of a body, of an articulated body; product of wrench and twist, multiple of a
 * twist; square of a wrench. */
enum { OF_BODY = 24, OF_ARTICULATED = 36, OF_SCREW = 6, OF_SQUARE = 21 };

/* Multiplications of km_tree_solve for a cluster (acceleration_solve.c). */
static double of_cluster(const km_dynamics *d, int index) {
  const km_cluster *cluster = &d->tree.clusters[index];
  double k = d->cluster[index].freedom, n = cluster->coordinate_count, nodes = cluster->node_count, loaded = 0.0;
  double sum = OF_SCREW * nodes * (k + 1.0) + n * k;
  for (int i = cluster->node_start; i < cluster->node_start + cluster->node_count; ++i) {
    const km_node *node = &d->tree.nodes[i];
    sum += (k + 1.0) * (OF_BODY * node->has_mass + OF_ARTICULATED * node->is_base) + OF_SCREW * k;
    loaded += node->has_mass || node->is_base;
  }
  sum += OF_SCREW * loaded * 0.5 * k * (k + 1.0); /* D */
  sum += k * (k + 1.0) * (k + 2.0) / 6.0 + k * k; /* L Δ Lᵀ and both substitutions */
  sum += OF_SCREW * nodes * k + n * k + n;        /* outward */
  if (cluster->base > 0)
    sum += OF_SCREW * (0.5 * k * (k + 1.0) + k) + (OF_SQUARE + OF_SCREW) * k;
  return sum;
}

/* Multiplications of the dense system: L Δ Lᵀ of the bordered matrix with the primary rows of all loops, both
 * substitutions, and the mass matrix. */
static double of_dense(const km_dynamics *d, const km_state *s) {
  const km_tree *tree = &d->tree;
  double size = 0.0, sum = 0.0;
  for (int i = 0; i < d->mechanism->coordinate_count; ++i)
    size += !d->mechanism->held[i];
  for (int i = 0; i < d->mechanism->topology.substructure_count; ++i)
    size += km_factor_rank(s->factor[i]);
  for (int n = 1; n < tree->node_count; ++n)
    for (int up = n, freedom = tree->nodes[n].freedom; up > 0; up = tree->nodes[up].parent)
      sum += freedom * OF_SCREW * tree->nodes[up].freedom + (up == n ? freedom * OF_BODY : 0.0);
  return sum + size * (size + 1.0) * (size + 2.0) / 6.0 + size * size;
}

km_effort km_dynamics_effort(const km_dynamics *d, const km_state *s) {
  km_effort out = {nan(""), nan("")};
  if (!d || !km_state_belongs_to(d->mechanism, s))
    return out;
  out.multiplications = 0.0;
  for (int i = 0; i < d->mechanism->topology.substructure_count; ++i)
    out.multiplications += km_factor_multiplications(s->factor[i]);
  for (int i = 0; i < d->tree.cluster_count; ++i)
    out.multiplications += of_cluster(d, i);
  out.dense = of_dense(d, s);
  return out;
}
