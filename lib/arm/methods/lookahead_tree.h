/* The trees of look-ahead: how they are made, and how several threads grow them. Private to arm/methods. */
#ifndef KM_ARM_METHODS_LOOKAHEAD_TREE_H
#define KM_ARM_METHODS_LOOKAHEAD_TREE_H

#include "arm/methods/method.h"

typedef struct km_look_node {
  km_node end;       /* where its level ends */
  double least, sum; /* of the objective, from the root (excluded) */
  int samples;       /* reached since the root */
  bool alive;
  unsigned long evaluations; /* Jacobians that its level took */
} km_look_node;

/* How many branches the next tree may begin with. */
enum { KM_LOOK_GUESSES = 2 };

/* The root of a tree, and what depends on nothing else. */
typedef struct km_look_beginning {
  km_node root;
  km_look_node *nodes; /* [branches] the first level */
  km_node *first;      /* [branches] one sample after the root */
  km_step_end middle;  /* how the untilted branch ended, if on its first step */
  int sample;          /* of the root */
  int guess;           /* of a next tree: its root is the end of this branch's first step */
} km_look_beginning;

/* How a level is shared: by so many workers, each of which grows so many of its nodes, and of those of `next` that are grown beside
 * it, in groups of so many abreast. The last worker may have fewer. */
typedef struct km_look_share {
  int count, ahead; /* nodes of the level, and of `next` */
  int sharing, nodes_each, ahead_each, group;
} km_look_share;

typedef struct km_look_tree {
  km_entry_range *run;
  int branches, levels, stride, workers;
  km_look_node *nodes; /* by level, behind the first one; the children of node i of a level are i · branches … */
  int *level_start;    /* [levels + 1] from the second level on */
  double *tilts;       /* [branches × freedom] */
  km_tracker_space *spaces;                       /* [workers] */
  km_node *places;                                /* [workers × KM_WALK_ABREAST × 2] */
  km_look_beginning *now, *next[KM_LOOK_GUESSES]; /* this tree's beginning, and the guesses at the next one's */
  km_look_share *shares;                          /* [levels] */
  int first, end;                                 /* levels that are grown in this round */
  bool eased;                                     /* branches turn back as far as the rates ask */
  int branch;                                     /* executed last */
  int other;                                      /* the last different one */
  int guesses;                                    /* how many of `next` are grown */
  bool grown;                                     /* the first level of `now` was grown as a guess */
} km_look_tree;

/* Nodes of a level, from 0 on, of this tree or (level 0 alone) of the next one; and how many there are. */
static inline km_look_node *km_look_node_at(const km_look_tree *t, const km_look_beginning *of, int level, int index) {
  return level == 0 ? &of->nodes[index] : &t->nodes[t->level_start[level] + index];
}

static inline int km_look_count_at(const km_look_tree *t, int level) {
  return level == 0 ? t->branches : t->level_start[level + 1] - t->level_start[level];
}

/* False when out of memory; destroy it in any case, which counts its Jacobians. */
bool km_look_tree_create(km_look_tree *tree, km_entry_range *run);
void km_look_tree_destroy(km_look_tree *tree);
/* Grows the tree from `now`. Returns how many levels it has: fewer than `levels` near the end of the path. */
int km_look_tree_grow(km_look_tree *tree);
/* Takes the first sample of a branch as the root of the next tree. */
void km_look_tree_go_on(km_look_tree *tree, int branch);

#endif
