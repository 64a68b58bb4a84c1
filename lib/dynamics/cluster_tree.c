/* Building the tree of nodes and clusters from a mechanism. */
#include "dynamics/cluster_tree.h"

#include "topology/chain.h"

#include <string.h>

/* While clusters are found: nodes are numbered by level, and each knows a representative of its cluster. */
typedef struct build {
  const km_mechanism *m;
  km_tree *tree;
  int *level;  /* [node] primitive motions from the inertial frame */
  int *leader; /* [node] union-find */
  int *number; /* [node] its final number */
  int *depth;  /* [node] of a leader: clusters between its own and the inertial frame. Workspace afterwards */
} build;

double km_inertial_factor(const km_model *model) {
  static const km_dimension inertial = {.length = 1, .mass = 1, .time = -2, .force = -1};
  return km_units_factor(&model->units, inertial);
}

static void carry_body(build *w, int body, int node, const km_pose *in_node) {
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
    tree->nodes[node].massive = tree->nodes[node].massive || def->inertia[i] != 0.0;
  tree->nodes[node].massive = tree->nodes[node].massive || def->mass != 0.0;
}

static bool turns(const km_rotation *R) {
  const km_rotation one = km_rotation_identity();
  return memcmp(R, &one, sizeof one) != 0;
}

/* The nodes of one body's arc; the body is carried by the last one. */
static void add_arc(build *w, const km_arc *arc) {
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
                                  .turned = turns(&X.R)};
    w->level[next] = w->level[node] + 1;
    X = km_pose_identity();
    node = next;
  }
  X = km_pose_product(&X, &arc->after);
  carry_body(w, arc->body, node, &X);
}

static int leader_of(const build *w, int node) {
  while (w->leader[node] != node)
    node = w->leader[node] = w->leader[w->leader[node]];
  return node;
}

static int substructure_of(const build *w, int node) {
  int joint = w->m->model->coordinates[w->tree->nodes[node].coordinate].joint;
  return w->m->topology.substructure_of_joint[joint];
}

static void join_substructures(build *w, int *first /* [substructure], -1 */) {
  for (int n = 1; n < w->tree->node_count; ++n) {
    int s = substructure_of(w, n);
    if (s >= 0 && first[s] >= 0)
      w->leader[leader_of(w, n)] = leader_of(w, first[s]);
    else if (s >= 0)
      first[s] = n;
  }
}

enum { NONE = -1, SEVERAL = -2 };

/* Takes the deepest root's parent into the cluster until all roots of every cluster hang on one node. Each pass joins at
 * least two clusters or is the last. base[leader]: that node. */
static void join_between(build *w, int *base, int *deepest) {
  const km_node *nodes = w->tree->nodes;
  for (bool joined = true; joined;) {
    joined = false;
    for (int n = 0; n < w->tree->node_count; ++n)
      base[n] = deepest[n] = NONE;
    for (int n = 1; n < w->tree->node_count; ++n) {
      int own = leader_of(w, n), parent = nodes[n].parent;
      if (parent > 0 && leader_of(w, parent) == own)
        continue;
      if (deepest[own] == NONE || w->level[parent] > w->level[deepest[own]])
        deepest[own] = parent;
      base[own] = base[own] == NONE || base[own] == parent ? parent : SEVERAL;
      joined = joined || base[own] == SEVERAL;
    }
    for (int n = 1; joined && n < w->tree->node_count; ++n)
      if (base[n] == SEVERAL)
        w->leader[leader_of(w, deepest[n])] = leader_of(w, n);
  }
}

/* Depth of a cluster: bases come before what hangs on them. */
static int depth_of(build *w, const int *base, int leader) {
  int depth = 0;
  while (base[leader] > 0) {
    leader = leader_of(w, base[leader]);
    ++depth;
  }
  return depth;
}

/* Leaders by depth, those of one depth by number: a counting sort. Returns how many. */
static int order_leaders(build *w, const int *base, int *order, int *count) {
  int nodes = w->tree->node_count;
  memset(count, 0, (size_t)nodes * sizeof *count);
  for (int n = 1; n < nodes; ++n) {
    if (leader_of(w, n) != n)
      continue;
    w->depth[n] = depth_of(w, base, n);
    count[w->depth[n] + 1]++;
  }
  for (int d = 1; d < nodes; ++d)
    count[d] += count[d - 1];
  for (int n = 1; n < nodes; ++n)
    if (leader_of(w, n) == n)
      order[count[w->depth[n]]++] = n;
  return nodes > 1 ? count[nodes - 2] : 0;
}

/* Numbers clusters by depth and then by their first node, and nodes by cluster. */
static void number_nodes(build *w, const int *base, int *order, int *next) {
  km_tree *tree = w->tree;
  tree->cluster_count = order_leaders(w, base, order, next);
  int *size = w->depth; /* of a leader's cluster, from here on */
  memset(size, 0, (size_t)tree->node_count * sizeof *size);
  for (int n = 1; n < tree->node_count; ++n)
    size[leader_of(w, n)]++;
  for (int i = 0, start = 1; i < tree->cluster_count; ++i) {
    tree->clusters[i] = (km_cluster){.node_start = start, .node_count = size[order[i]]};
    next[order[i]] = start;
    start += size[order[i]];
  }
  w->number[0] = 0;
  for (int n = 1; n < tree->node_count; ++n)
    w->number[n] = next[leader_of(w, n)]++;
  for (int i = 0; i < tree->cluster_count; ++i)
    tree->clusters[i].base = w->number[base[order[i]]];
}

static void move_nodes(build *w, km_node *old) {
  km_tree *tree = w->tree;
  memcpy(old, tree->nodes, (size_t)tree->node_count * sizeof *old);
  for (int n = 1; n < tree->node_count; ++n) {
    tree->nodes[w->number[n]] = old[n];
    tree->nodes[w->number[n]].parent = w->number[old[n].parent];
  }
  for (int b = 0; b < w->m->topology.body_count; ++b)
    tree->node_of_body[b] = w->number[tree->node_of_body[b]];
}

/* A cluster's substructures, and its coordinates: those of substructures in the order of their columns, then those in
 * none. place[coordinate] is its place in the cluster. */
static void list_coordinates(build *w, int *place, bool *listed) {
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
        place[c] = coordinates - cluster->coordinate_start;
        tree->coordinate_order[coordinates++] = c;
      }
    }
    for (int n = cluster->node_start; n < cluster->node_start + cluster->node_count; ++n) {
      const km_node *node = &tree->nodes[n];
      for (int k = 0; k < node->freedom && substructure_of(w, n) < 0 && !m->held[node->coordinate]; ++k) {
        place[node->coordinate + k] = coordinates - cluster->coordinate_start;
        tree->coordinate_order[coordinates++] = node->coordinate + k;
      }
    }
    cluster->substructure_count = substructures - cluster->substructure_start;
    cluster->coordinate_count = coordinates - cluster->coordinate_start;
  }
}

static void mark_nodes(build *w, const int *place) {
  km_tree *tree = w->tree;
  for (int c = 0; c < w->m->coordinate_count; ++c)
    tree->node_of_coordinate[c] = -1;
  for (int n = 1; n < tree->node_count; ++n) {
    km_node *node = &tree->nodes[n];
    node->local = w->m->held[node->coordinate] ? -1 : place[node->coordinate];
    for (int k = 0; k < node->freedom; ++k)
      tree->node_of_coordinate[node->coordinate + k] = n;
  }
  for (int i = 0; i < tree->cluster_count; ++i)
    tree->nodes[tree->clusters[i].base].bears = true;
}

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
  build w = {.m = m,
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
    for (int n = 0; n < tree->node_count; ++n)
      w.leader[n] = n;
    for (size_t s = 0; s < subs; ++s)
      first[s] = -1;
    join_substructures(&w, first);
    join_between(&w, base, work);
    number_nodes(&w, base, work, next);
    move_nodes(&w, old);
    list_coordinates(&w, work, listed);
    mark_nodes(&w, work);
  }
  km_arena_free(&scratch);
  return !arena->failed;
}
