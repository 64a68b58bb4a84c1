/* Graph of a mechanism: spanning tree, loops, kinematic substructures (docs/theory.md 2.2). Bodies and joints are
 * numbers here. Sources: K. Wehage 2016, chapter 5; substructures are biconnected components (J. Hopcroft and R. Tarjan
 * 1973). */
#ifndef KM_TOPOLOGY_SPANNING_TREE_H
#define KM_TOPOLOGY_SPANNING_TREE_H

#include "base/memory.h"
#include "kmech/base.h"

typedef struct km_edge {
  int tail, head; /* the user's parent and child body */
} km_edge;

/* Joints whose coordinates are coupled, so that they belong to one substructure. */
typedef struct km_coupled_joints {
  const int *joints;
  int count;
} km_coupled_joints;

typedef struct km_graph {
  int body_count, joint_count, coupled_count;
  const km_edge *edges;             /* [joint_count]; body 0 is the inertial frame, to which every body is connected */
  const bool *is_cut;               /* [joint_count] joints at which loops shall be cut; NULL: none */
  const km_coupled_joints *coupled; /* [coupled_count] */
} km_graph;

/* A joint of a loop, with its side of the loop. */
typedef struct km_member {
  int joint;
  int side; /* +1: on the path to the virtual body (the chord too), −1: on the path to the body from which that is cut
             * off */
  bool is_reversed; /* the path from the base traverses it from child to parent */
} km_member;

/* +1 if the circulation of the loop (out along the virtual side, back along the other) follows the user's sense of the
 * joint, else −1. */
static inline double km_member_sign(const km_member *member) {
  return member->side * (member->is_reversed ? -1.0 : 1.0);
}

/* A loop through a joint. */
typedef struct km_joint_loop {
  int loop;    /* index in its substructure */
  double sign; /* km_member_sign of the joint in it */
} km_joint_loop;

typedef struct km_topology {
  int body_count, joint_count, loop_count, substructure_count;
  int *order;                 /* [body] bodies in level order; order[0] = 0 */
  int *level;                 /* [body] number of joints from the inertial frame */
  int *parent;                /* [body] next body towards the inertial frame; −1 for body 0 */
  int *arc;                   /* [body] the joint to `parent`; -1 for body 0 */
  bool *is_reversed;          /* [joint] a tree joint whose user sense runs towards the inertial frame */
  int *chord;                 /* [loop] the joint that closes it */
  int *base;                  /* [loop] base body: the body of the loop nearest to the inertial frame */
  int *member_start;          /* [loop + 1] into `member` */
  km_member *member;          /* base to virtual body in order, then base to embedding body in order */
  int *substructure_of_joint; /* [joint] -1: in no loop and no coupling */
  int *substructure_of_loop;  /* [loop] */
  int *joint_start;           /* [substructure + 1] into `joint`, which is in file order within a substructure */
  int *joint;
  int *loop_start; /* [substructure + 1] into `loop` */
  int *loop;
  int *incident_start; /* [body + 1] into `incident`: the joints at each body, in file order */
  int *incident;
  int *joint_loop_start; /* [joint + 1] into `joint_loop`: the loops through each joint, ascending */
  km_joint_loop *joint_loop;
  int *body_start; /* [substructure + 1] into `body`: bodies whose tree joint lies in the substructure, in level
                    * order */
  int *body;
} km_topology;

/* Builds the breadth-first spanning tree (ties in file order: widest tree, shortest loops), chords, loops and
 * substructures, numbered by their first joint in file order. The tree has as few joints with is_cut as possible. A
 * loop is its chord with the tree's path between the chord's ends; in large substructures a shorter cycle through its
 * chord if there is one (topology/short_loops.h). Time and memory are linear in the graph plus the loops' lengths.
 * KM_MEMORY only. */
km_status km_topology_build(const km_graph *graph, km_arena *arena, km_topology *out, km_error *error);

#endif
