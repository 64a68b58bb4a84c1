/* Builds the tree of nodes and clusters of a mechanism (docs/theory.md 11.2). */
#include "dynamics/cluster_tree.h"

#include "base/number/union_find.h"
#include "topology/chain.h"

#include <string.h>

/* Work data of the construction: nodes numbered by level, clusters as union-find sets. */
typedef struct tree_builder {
  const km_mechanism *m;
  km_tree *tree;
  int *level;  /* [node] primitive motions from the inertial frame */
  int *leader; /* [node] union-find parent */
  int *number; /* [node] final number */
  int *depth;  /* [node] for the leader of a cluster: number of clusters between it and the inertial frame; then a
                * work array */
} tree_builder;

/* Adds a body and its inertia to a node. */
static void add_body(tree_builder *w, int body, int node, const km_pose *in_node) {
  km_tree *tree = w->tree;
  const km_model_body *def = &w->m->model->bodies[body];
  tree->node_of_body[body] = node;
  tree->body_in_node[body] = *in_node;
  km_inertia own = km_inertia_of_body(def->mass, def->center_of_mass, def->inertia);
  km_inertia there = km_inertia_transform(in_node, &own);
  double factor = km_inertial_factor(w->m->model);
  there.m *= factor;
  there.mc = km_vec3_scale(factor, there.mc);
  there.I = km_symmetric_axpy(factor, there.I, (km_symmetric){0});
  tree->nodes[node].inertia = km_inertia_add(tree->nodes[node].inertia, there);
  for (int i = 0; i < 6; ++i)
    tree->nodes[node].has_mass = tree->nodes[node].has_mass || def->inertia[i] != 0.0;
  tree->nodes[node].has_mass = tree->nodes[node].has_mass || def->mass != 0.0;
}

static bool contains_rotation(const km_rotation *R) {
  const km_rotation one = km_rotation_identity();
  return memcmp(R, &one, sizeof one) != 0;
}

/* Adds the nodes of one body's arc; the body belongs to the last one. */
static void add_arc(tree_builder *w, const km_arc *arc) {
  const km_mechanism *m = w->m;
  km_tree *tree = w->tree;
  km_joint_traversal p;
  km_joint_traverse(m->model, arc->joint, arc->is_reversed, &p);
  int node = tree->node_of_body[arc->parent];
  km_pose X = km_pose_product(&tree->body_in_node[arc->parent], &arc->before);
  for (int i = 0; i < p.count; ++i) {
    int next = tree->node_count++, c = p.coordinate[i];
    tree->nodes[next] = (km_node){.primitive = p.motion[i].primitive,
                                  .axis = p.motion[i].axis,
                                  .coordinate = c,
                                  .freedom = km_primitive_freedom(p.motion[i].primitive),
                                  .ball = m->ball_of[c],
                                  .sign = p.sign,
                                  .pitch = km_pitch_per_radian(m->model, arc->joint, 1.0),
                                  .parent = node,
                                  .before = X,
                                  .has_rotation = contains_rotation(&X.R)};
    w->level[next] = w->level[node] + 1;
    X = km_pose_identity();
    node = next;
  }
  X = km_pose_product(&X, &arc->after);
  add_body(w, arc->body, node, &X);
}

static int substructure_of(const tree_builder *w, int node) {
  int joint = w->m->model->coordinates[w->tree->nodes[node].coordinate].joint;
  return w->m->topology.substructure_of_joint[joint];
}

/* Merges the nodes of each substructure. */
static void join_substructures(tree_builder *w, int *first /* [substructure], -1 */) {
  for (int n = 1; n < w->tree->node_count; ++n) {
    int s = substructure_of(w, n);
    if (s >= 0 && first[s] >= 0)
      w->leader[km_set_root(w->leader, n)] = km_set_root(w->leader, first[s]);
    else if (s >= 0)
      first[s] = n;
  }
}

enum { NONE = -1, SEVERAL = -2 };

/* Merges the parent of the deepest root into the cluster until all roots of every cluster have one parent,
 * base[leader]. Each pass merges at least two clusters or is the last. */
static void merge_clusters(tree_builder *w, int *base, int *golden_section) {
  const km_node *nodes = w->tree->nodes;
  for (bool joined = true; joined;) {
    joined = false;
    for (int n = 0; n < w->tree->node_count; ++n)
      base[n] = golden_section[n] = NONE;
    for (int n = 1; n < w->tree->node_count; ++n) {
      int own = km_set_root(w->leader, n), parent = nodes[n].parent;
      if (parent > 0 && km_set_root(w->leader, parent) == own)
        continue;
      if (golden_section[own] == NONE || w->level[parent] > w->level[golden_section[own]])
        golden_section[own] = parent;
      base[own] = base[own] == NONE || base[own] == parent ? parent : SEVERAL;
      joined = joined || base[own] == SEVERAL;
    }
    for (int n = 1; joined && n < w->tree->node_count; ++n)
      if (base[n] == SEVERAL)
        w->leader[km_set_root(w->leader, golden_section[n])] = km_set_root(w->leader, n);
  }
}

/* Depth of a cluster in the tree of clusters; a base precedes the clusters that are attached to it. */
static int depth_of(tree_builder *w, const int *base, int leader) {
  int depth = 0;
  while (base[leader] > 0) {
    leader = km_set_root(w->leader, base[leader]);
    ++depth;
  }
  return depth;
}

/* Sorts leaders by depth, then by number (counting sort). Returns their number. */
static int order_leaders(tree_builder *w, const int *base, int *order, int *count) {
  int nodes = w->tree->node_count;
  memset(count, 0, (size_t)nodes * sizeof *count);
  for (int n = 1; n < nodes; ++n) {
    if (km_set_root(w->leader, n) != n)
      continue;
    w->depth[n] = depth_of(w, base, n);
    count[w->depth[n] + 1]++;
  }
  for (int d = 1; d < nodes; ++d)
    count[d] += count[d - 1];
  for (int n = 1; n < nodes; ++n)
    if (km_set_root(w->leader, n) == n)
      order[count[w->depth[n]]++] = n;
  return nodes > 1 ? count[nodes - 2] : 0;
}

/* Numbers clusters by depth, then by their first node, and nodes by cluster. */
static void number_nodes(tree_builder *w, const int *base, int *order, int *next) {
  km_tree *tree = w->tree;
  tree->cluster_count = order_leaders(w, base, order, next);
  int *size = w->depth; /* size of a leader's cluster */
  memset(size, 0, (size_t)tree->node_count * sizeof *size);
  for (int n = 1; n < tree->node_count; ++n)
    size[km_set_root(w->leader, n)]++;
  for (int i = 0, start = 1; i < tree->cluster_count; ++i) {
    tree->clusters[i] = (km_cluster){.node_start = start, .node_count = size[order[i]]};
    next[order[i]] = start;
    start += size[order[i]];
  }
  w->number[0] = 0;
  for (int n = 1; n < tree->node_count; ++n)
    w->number[n] = next[km_set_root(w->leader, n)]++;
  for (int i = 0; i < tree->cluster_count; ++i)
    tree->clusters[i].base = w->number[base[order[i]]];
}

/* Moves the nodes to their final numbers. */
static void reorder_nodes(tree_builder *w, km_node *old) {
  km_tree *tree = w->tree;
  memcpy(old, tree->nodes, (size_t)tree->node_count * sizeof *old);
  for (int n = 1; n < tree->node_count; ++n) {
    tree->nodes[w->number[n]] = old[n];
    tree->nodes[w->number[n]].parent = w->number[old[n].parent];
  }
  for (int b = 0; b < w->m->topology.body_count; ++b)
    tree->node_of_body[b] = w->number[tree->node_of_body[b]];
}

/* Lists the substructures and the coordinates of each cluster: coordinates of substructures in the order of their
 * columns, then the others. place[coordinate] is the index within the cluster. */
static void list_coordinates(tree_builder *w, int *index_in_cluster, bool *listed) {
  const km_mechanism *m = w->m;
  km_tree *tree = w->tree;
  int substructures = 0, coordinates = 0;
  for (int i = 0; i < tree->cluster_count; ++i) {
    km_cluster *cluster = &tree->clusters[i];
    cluster->substructure_start = substructures;
    cluster->coordinate_start = coordinates;
    for (int n = cluster->node_start; n < cluster->node_start + cluster->node_count; ++n) {
      int s = substructure_of(w, n);
      if (s < 0 || listed[s])
        continue;
      listed[s] = true;
      tree->substructure_order[substructures++] = s;
      for (int k = 0; k < m->substructures[s].columns; ++k) {
        int c = m->column_coordinate[m->substructures[s].column_start + k];
        index_in_cluster[c] = coordinates - cluster->coordinate_start;
        tree->coordinate_order[coordinates++] = c;
      }
    }
    for (int n = cluster->node_start; n < cluster->node_start + cluster->node_count; ++n) {
      const km_node *node = &tree->nodes[n];
      for (int k = 0; k < node->freedom && substructure_of(w, n) < 0 && !m->held[node->coordinate]; ++k) {
        index_in_cluster[node->coordinate + k] = coordinates - cluster->coordinate_start;
        tree->coordinate_order[coordinates++] = node->coordinate + k;
      }
    }
    cluster->substructure_count = substructures - cluster->substructure_start;
    cluster->coordinate_count = coordinates - cluster->coordinate_start;
  }
}

/* Sets the references between nodes, coordinates and bases. */
static void link_nodes(tree_builder *w, const int *index_in_cluster) {
  km_tree *tree = w->tree;
  for (int c = 0; c < w->m->coordinate_count; ++c)
    tree->node_of_coordinate[c] = -1;
  for (int n = 1; n < tree->node_count; ++n) {
    km_node *node = &tree->nodes[n];
    node->local = w->m->held[node->coordinate] ? -1 : index_in_cluster[node->coordinate];
    for (int k = 0; k < node->freedom; ++k)
      tree->node_of_coordinate[node->coordinate + k] = n;
  }
  for (int i = 0; i < tree->cluster_count; ++i)
    tree->nodes[tree->clusters[i].base].is_base = true;
}

/* Builds nodes along the spanning tree, merges them to clusters, and numbers both. */
bool km_tree_build(const km_mechanism *m, km_arena *arena, km_tree *tree) {
  const km_topology *t = &m->topology;
  km_arena scratch = {0};
  size_t nodes = (size_t)m->coordinate_count + 1, bodies = (size_t)t->body_count, subs = (size_t)t->substructure_count;
  *tree = (km_tree){.node_count = 1,
                    .nodes = KM_ARENA_NEW(arena, km_node, nodes),
                    .clusters = KM_ARENA_NEW(arena, km_cluster, nodes),
                    .substructure_order = KM_ARENA_NEW(arena, int, subs),
                    .coordinate_order = KM_ARENA_NEW(arena, int, nodes),
                    .node_of_body = KM_ARENA_NEW(arena, int, bodies),
                    .node_of_coordinate = KM_ARENA_NEW(arena, int, nodes),
                    .body_in_node = KM_ARENA_NEW(arena, km_pose, bodies)};
  tree_builder w = {.m = m,
                    .tree = tree,
                    .level = KM_ARENA_NEW(&scratch, int, nodes),
                    .leader = KM_ARENA_NEW(&scratch, int, nodes),
                    .number = KM_ARENA_NEW(&scratch, int, nodes),
                    .depth = KM_ARENA_NEW(&scratch, int, nodes)};
  int *base = KM_ARENA_NEW(&scratch, int, nodes), *work = KM_ARENA_NEW(&scratch, int, nodes);
  int *next = KM_ARENA_NEW(&scratch, int, nodes + 1);
  int *first = KM_ARENA_NEW(&scratch, int, subs);
  bool *listed = KM_ARENA_NEW(&scratch, bool, subs);
  km_node *old = KM_ARENA_NEW(&scratch, km_node, nodes);
  arena->failed = arena->failed || scratch.failed;
  if (!arena->failed) {
    tree->body_in_node[0] = km_pose_identity();
    for (int i = 0; i < t->body_count - 1; ++i)
      add_arc(&w, &m->arcs[i]);
    km_sets_reset(w.leader, tree->node_count);
    for (size_t s = 0; s < subs; ++s)
      first[s] = -1;
    join_substructures(&w, first);
    merge_clusters(&w, base, work);
    number_nodes(&w, base, work, next);
    reorder_nodes(&w, old);
    list_coordinates(&w, work, listed);
    link_nodes(&w, work);
  }
  km_arena_free(&scratch);
  return !arena->failed;
}
