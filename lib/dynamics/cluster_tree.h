/* The mechanism as the equations of motion see it: a tree of nodes, one a primitive motion, in clusters.
 *
 * A node carries the bodies that are rigid with it. A cluster is what is eliminated at once: the nodes of a kinematic
 * substructure, or one node in none. Where couplings tie joints that don't hang on one body, everything between them
 * joins the cluster. So every cluster hangs on one node, its base, and clusters form a tree again. */
#ifndef KM_DYNAMICS_CLUSTER_TREE_H
#define KM_DYNAMICS_CLUSTER_TREE_H

#include "kinematics/state.h"
#include "spatial/inertia.h"

typedef struct km_node {
  km_primitive primitive;
  int axis, coordinate, freedom;
  int ball;           /* index among the ball motions, for KM_BALL */
  double sign;        /* -1: the motion is passed against its sense */
  double pitch;       /* travel per radian of a helical motion */
  int parent;         /* node; 0 is the inertial frame */
  int local;          /* its first coordinate's place in the cluster; -1: held */
  bool turned;        /* `before` turns, not only shifts */
  bool massive;       /* `inertia` isn't 0 */
  bool bears;         /* clusters hang on it */
  km_pose before;     /* from the parent node's frame to the frame of the motion; the model's length unit */
  km_inertia inertia; /* of what it carries, in its own frame; force · time² / length, … in the model's units */
} km_node;

typedef struct km_cluster {
  int base;                                   /* node */
  int node_start, node_count;                 /* nodes are numbered by cluster, clusters base first */
  int substructure_start, substructure_count; /* into substructure_order */
  int coordinate_start, coordinate_count;     /* into coordinate_order: those that aren't held */
} km_cluster;

typedef struct km_tree {
  int node_count, cluster_count;
  km_node *nodes;          /* [node_count]; 0 is the inertial frame */
  km_cluster *clusters;    /* [cluster_count] */
  int *substructure_order; /* by cluster */
  int *coordinate_order;   /* by cluster */
  int *node_of_body;       /* [body] */
  int *node_of_coordinate; /* [coordinate]; -1: a chord's */
  km_pose *body_in_node;   /* [body] from its node's frame */
} km_tree;

/* Force units in a mass times an acceleration of the model's units. */
double km_inertial_factor(const km_model *model);

/* Reads the mechanism's topology, dimensions and masses. False (and arena->failed) when out of memory. O(joints). */
bool km_tree_build(const km_mechanism *mechanism, km_arena *arena, km_tree *out);

#endif
