/* Union-find with path halving (R. Tarjan 1975): each set is a tree of parent[i]; its root represents it. */
#ifndef KM_BASE_NUMBER_UNION_FIND_H
#define KM_BASE_NUMBER_UNION_FIND_H

/* Makes each of 0 … count − 1 a set of its own: parent[count]. */
static inline void km_sets_reset(int *parent, int count) {
  for (int i = 0; i < count; ++i)
    parent[i] = i;
}

/* Returns the root of i's set, and halves the path to it. */
static inline int km_set_root(int *parent, int i) {
  while (parent[i] != i)
    i = parent[i] = parent[parent[i]];
  return i;
}

#endif
