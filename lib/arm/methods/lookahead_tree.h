/* Tree of look-ahead: nodes, levels, their distribution over threads. Private to arm/methods. */
#ifndef KM_ARM_METHODS_LOOKAHEAD_TREE_H
#define KM_ARM_METHODS_LOOKAHEAD_TREE_H

#include "arm/methods/method.h"

typedef struct km_look_node {
  km_path_node end;  /* node at the end of the level */
  double least, sum; /* minimum and sum of the objective from the root (excluded) */
  int samples;       /* samples reached since the root */
  bool alive;
  unsigned long evaluations; /* Jacobians computed in its level */
} km_look_node;

/* Largest number of speculative next trees. */
enum { KM_LOOK_GUESSES = 2 };

/* Root and first level of a tree. */
typedef struct km_look_root_level {
  km_path_node root;
  km_look_node *nodes; /* [branches] nodes of the first level */
  km_path_node *first; /* [branches] nodes one sample after the root */
  km_step_end middle;  /* outcome of the first step of the middle branch (φ = 0) */
  int sample;          /* sample of the root */
  int branch_guess;    /* speculative tree: the branch whose first step ends at its root */
} km_look_root_level;

/* Distribution of a level over workers: nodes per worker, of this level and of the speculative trees, and the size
 * of a batch. The last worker can have fewer. */
typedef struct km_look_share {
  int count, next_count; /* nodes of the level; nodes of the speculative trees */
  int workers_used, nodes_per_worker, next_each, group;
} km_look_share;

typedef struct km_look_tree {
  km_tracking_run *run;
  int branches, levels, stride, workers;
  km_look_node *nodes;        /* nodes by level from the second one on; the children of node i begin at i · branches */
  int *level_start;           /* [levels + 1] index of each level's first node, from the second level on */
  double *tan_phis;           /* [branches × freedom] */
  km_tracker_space *spaces;   /* [workers] */
  km_path_node *branch_nodes; /* [workers × KM_STEP_BATCH × 2] */
  km_look_root_level *now, *next[KM_LOOK_GUESSES]; /* first levels of the current tree and of the speculative next
                                                    * trees */
  km_look_share *shares;                           /* [levels] */
  int first, end;                                  /* levels that grow in this round, without a barrier */
  bool eased;                                      /* steps are eased to satisfy the rates */
  int branch;                                      /* branch that was executed last */
  int other;                                       /* the last different branch */
  int guesses;                                     /* number of speculative trees that are grown */
  bool is_grown;                                   /* the first level of `now` was grown speculatively */
} km_look_tree;

/* Node of a level (from 0) of the current tree, or of level 0 of a speculative one. */
static inline km_look_node *km_look_node_at(const km_look_tree *t, const km_look_root_level *of, int level, int index) {
  return level == 0 ? &of->nodes[index] : &t->nodes[t->level_start[level] + index];
}

static inline int km_look_count_at(const km_look_tree *t, int level) {
  return level == 0 ? t->branches : t->level_start[level + 1] - t->level_start[level];
}

/* Creates the tree of a run. False: out of memory. Destroy it in any case; that adds its Jacobians to the run's
 * count. */
bool km_look_tree_create(km_look_tree *tree, km_tracking_run *run);
void km_look_tree_destroy(km_look_tree *tree);
/* Grows the tree from its root. Returns its number of levels, which is less than `levels` near the end of the path. */
int km_look_tree_grow(km_look_tree *tree);
/* Makes the first sample of a branch the root of the next tree (receding horizon). */
void km_look_tree_recede(km_look_tree *tree, int branch);

#endif
