/* Tree of a mechanism for the equations of motion: nodes (one primitive motion each) in clusters (docs/theory.md
 * 11.2).
 *
 * A node contains the bodies that are rigid with it. A cluster is eliminated at once: the nodes of a kinematic
 * substructure, or one node in none. If couplings connect joints that aren't attached to one body, all nodes
 * between them join the cluster. So every cluster is attached to one node, its base, and clusters form a tree. */
#ifndef KM_DYNAMICS_CLUSTER_TREE_H
#define KM_DYNAMICS_CLUSTER_TREE_H

#include "kinematics/state.h"
#include "spatial/inertia.h"

typedef struct km_node {
  km_primitive primitive;
  int axis, coordinate, freedom;
  int ball;          /* KM_BALL: index among the ball motions */
  double sign;       /* −1: reversed joint */
  double pitch;      /* travel per radian of a helical motion */
  int parent;        /* parent node; 0 is the inertial frame */
  int local;         /* index of the first coordinate in the cluster; −1: held */
  bool has_rotation; /* `before` contains a rotation */
  bool has_mass;     /* `inertia` is not 0 */
  bool is_base;      /* it is the base of a cluster */
  km_pose before;    /* pose in the parent node's frame of the frame of the motion; the model's length unit */
  km_inertia inertia; /* inertia of its bodies in its own frame; force · time²/length and so on, in the model's units */
} km_node;

typedef struct km_cluster {
  int base;                                   /* base node */
  int node_start, node_count;                 /* range of nodes; nodes are numbered by cluster, bases first */
  int substructure_start, substructure_count; /* range in substructure_order */
  int coordinate_start, coordinate_count;     /* range in coordinate_order: coordinates that aren't held */
} km_cluster;

typedef struct km_tree {
  int node_count, cluster_count;
  km_node *nodes;          /* [node_count]; 0 is the inertial frame */
  km_cluster *clusters;    /* [cluster_count] */
  int *substructure_order; /* sorted by cluster */
  int *coordinate_order;   /* sorted by cluster */
  int *node_of_body;       /* [body] */
  int *node_of_coordinate; /* [coordinate] node; −1: coordinate of a chord */
  km_pose *body_in_node;   /* [body] pose in the node's frame */
} km_tree;

/* Builds the tree from a mechanism's topology, dimensions and masses. False, with arena->failed: out of memory.
 * O(joints). */
bool km_tree_build(const km_mechanism *mechanism, km_arena *arena, km_tree *out);

#endif
