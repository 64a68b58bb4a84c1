/* How many multiplications a solution of the equations of motion takes, by clusters and as one dense system. */
#include "dynamics/dynamics.h"

/* A wrench of a body, of an articulated one; the product of a wrench and a twist, a twist's multiple. */
enum { OF_BODY = 24, OF_ARTICULATED = 36, OF_SCREW = 6, OF_SQUARE = 21 };

/* What km_tree_solve does for a cluster (acceleration_solve.c), pass by pass. */
static double of_cluster(const km_dynamics *d, int index) {
  const km_cluster *cluster = &d->tree.clusters[index];
  double k = d->cluster[index].freedom, n = cluster->coordinate_count, nodes = cluster->node_count, loaded = 0.0;
  double sum = OF_SCREW * nodes * (k + 1.0) + n * k;
  for (int i = cluster->node_start; i < cluster->node_start + cluster->node_count; ++i) {
    const km_node *node = &d->tree.nodes[i];
    sum += (k + 1.0) * (OF_BODY * node->massive + OF_ARTICULATED * node->bears) + OF_SCREW * k;
    loaded += node->massive || node->bears;
  }
  sum += OF_SCREW * loaded * 0.5 * k * (k + 1.0); /* D */
  sum += k * (k + 1.0) * (k + 2.0) / 6.0 + k * k; /* its factors, and both substitutions */
  sum += OF_SCREW * nodes * k + n * k + n;        /* outward */
  if (cluster->base > 0)
    sum += OF_SCREW * (0.5 * k * (k + 1.0) + k) + (OF_SQUARE + OF_SCREW) * k;
  return sum;
}

/* LDLᵀ of the bordered matrix with the primary rows of all loops, both substitutions, and the masses in it: a body's
 * inertia times a coordinate's column, times the columns of all that carry it. */
static double of_dense(const km_dynamics *d, const km_state *s) {
  const km_tree *tree = &d->tree;
  double size = 0.0, sum = 0.0;
  for (int i = 0; i < d->mechanism->coordinate_count; ++i)
    size += !d->mechanism->held[i];
  for (int i = 0; i < d->mechanism->topology.substructure_count; ++i)
    size += s->partition[i].rank;
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
    out.multiplications += km_partition_multiplications(&s->partition[i]);
  for (int i = 0; i < d->tree.cluster_count; ++i)
    out.multiplications += of_cluster(d, i);
  out.dense = of_dense(d, s);
  return out;
}
