/* Null vectors of the sparse factor by their entries: triangular solution by those columns of U that the right side
 * reaches (J. Gilbert and T. Peierls 1988; docs/theory.md 3.6). */
#include "linalg/sparse/sparse_lu.h"

/* Depth-first search in the graph of U: steps that a right side reaches, in topological order. */
int km_sparse_reach_upper(const km_partition *p, const km_entry_range *column_of_u) {
  const km_sparse *s = p->sparse;
  int top = p->rows;
  for (int i = column_of_u->start; i < column_of_u->end; ++i) {
    int depth = s->upper_store.value[i] != 0.0 ? 0 : -1;
    s->stack[0] = s->upper_store.index[i];
    s->stack_position[0] = -1;
    while (depth >= 0 && (s->stack_position[depth] >= 0 || !s->visited[s->stack[depth]])) {
      int step = s->stack[depth];
      const km_entry_range *above = &s->upper[p->column[step]];
      if (s->stack_position[depth] < 0)
        s->stack_position[depth] = above->start;
      s->visited[step] = true;
      while (s->stack_position[depth] < above->end && (s->visited[s->upper_store.index[s->stack_position[depth]]] ||
                                                       s->upper_store.value[s->stack_position[depth]] == 0.0))
        s->stack_position[depth]++;
      if (s->stack_position[depth] < above->end) {
        int child = s->upper_store.index[s->stack_position[depth]++];
        s->stack[++depth] = child;
        s->stack_position[depth] = -1;
      } else {
        s->reach_list[--top] = step;
        --depth;
      }
    }
  }
  return top;
}

/* Null vector −U⁻¹ u of one independent column, by the steps that it reaches. */
int km_partition_null_entries(const km_partition *p, int k, int *column, double *value) {
  const km_sparse *s = p->sparse;
  const km_entry_range *column_of_u = &s->upper[p->column[p->rank + k]];
  int count = 0;
  column[count] = p->column[p->rank + k];
  value[count++] = 1.0;
  int top = km_sparse_reach_upper(p, column_of_u);
  for (int i = column_of_u->start; i < column_of_u->end; ++i)
    s->x[s->upper_store.index[i]] = s->upper_store.value[i];
  for (int i = top; i < p->rows; ++i) {
    int step = s->reach_list[i];
    double b = s->x[step] * p->inverse[step];
    const km_entry_range *above = &s->upper[p->column[step]];
    s->visited[step] = false;
    s->x[step] = 0.0;
    if (b == 0.0)
      continue;
    for (int n = above->start; n < above->end; ++n)
      s->x[s->upper_store.index[n]] -= s->upper_store.value[n] * b;
    column[count] = p->column[step];
    value[count++] = -b;
  }
  return count;
}
