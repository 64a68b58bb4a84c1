/* Two trees of configurations that grow towards each other, and the path between their roots (docs/theory.md 4.21).
 *
 * One tree steps towards a random configuration, the other towards what the first has reached (J. Kuffner, S. LaValle
 * 2000). Shortening: the path between two of its configurations becomes the steps that lead straight from one to the
 * other, where they do. */
#ifndef KM_SPACE_PATH_TREES_H
#define KM_SPACE_PATH_TREES_H

#include "space/path/path_steps.h"

enum { KM_MOST_PATH_CHAIN = 400 }; /* steps of one chain of a tree */

/* Configurations reached from one end. */
typedef struct km_path_tree {
  double **saved; /* [count] as km_driver_surface_save */
  int *parent;    /* [count] −1: the end */
  int count;
  size_t saved_capacity, parent_capacity;
} km_path_tree;

typedef struct km_path_trees {
  km_path_steps *steps;
  km_arena *arena; /* saved configurations are allocated here */
  double *sample;  /* [saved size] */
  uint64_t random;
  km_path_tree tree[2]; /* one from the start, one from the end */
} km_path_trees;

void km_path_trees_free(km_path_trees *trees);
/* Adds the state's configuration to a tree. Returns its index; −1 when out of memory, and the arena has failed. */
int km_path_trees_add(km_path_trees *trees, km_path_tree *tree, int parent);
/* Steps from the state, node `from` of a tree, towards a saved configuration as long as that comes nearer, `most` steps
 * at most. Returns the last node; −1 when out of memory. *is_there: the configuration was reached. */
int km_path_trees_chain(km_path_trees *trees, km_path_tree *tree, int from, const double *saved, int most,
                        bool *is_there);
/* Moves the state to a random configuration, open, within limits, between and around both ends. */
void km_path_trees_sample(km_path_trees *trees);
/* Grows both trees until they meet. *node: where, in each tree; −1: they don't. False when out of memory. */
bool km_path_trees_grow(km_path_trees *trees, km_progress progress, void *context, bool *is_cancelled, int node[2]);
/* Joins the branches to both nodes: saved configurations [count] from one end to the other. NULL when out of memory. */
double **km_path_trees_join(km_path_trees *trees, const int node[2], int *count);
/* Shortens path[count] in place. Returns the new count; −1 when out of memory. O(200 · steps). */
int km_path_trees_shorten(km_path_trees *trees, double **path, int count);

#endif
