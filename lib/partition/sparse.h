/* The sparse engine of a partition, for large substructures: LU of one column after the other (J. Gilbert, T. Peierls,
 * Sparse partial pivoting in time proportional to arithmetic operations, 1988) in an order that keeps L sparse
 * (COLAMD). A column that those before it make nearly dependent becomes an independent coordinate. Which columns these
 * are is then chosen again by complete pivoting of the null space, so that |B| is as small as with complete pivoting of
 * the whole matrix. Private to partition/. */
#ifndef KM_PARTITION_SPARSE_H
#define KM_PARTITION_SPARSE_H

#include "partition/partition.h"

/* A run of entries in the store. */
typedef struct km_run {
  int start, end;
} km_run;

struct km_sparse {
  const int *start, *row; /* pattern: rows of column c are row[start[c] … start[c+1]-1] */
  const int *order;       /* [columns] that keeps L sparse */
  int *lead;              /* [columns] the order of this factorisation */
  int *dropped;           /* [columns] those that became independent, in that order */
  bool *late;             /* [columns] is to come last, since it should stay independent */
  km_run *upper,
      *lower; /* [columns] of each: its entries of U, by step in an order that replays it, and of L, by row */
  int *upper_step, *lower_row;
  double *upper_value, *lower_value; /* lower: multiples, of the independent columns too, where they mean nothing */
  int *step_of;                      /* [rows] that used the row, -1: none yet */
  double *x;                         /* [rows] accumulators, 0 between columns */
  int *list, *stack, *next;          /* [rows] rows that a column reaches; walking them */
  bool *seen;                        /* [rows] */
  double *null;                      /* [columns × freedom] to choose independent columns by */
};

void km_sparse_factor(km_partition *partition, const double *matrix, const bool *forced, double tolerance);
/* False where a value is not finite. */
bool km_sparse_refactor(km_partition *partition, const double *matrix);
void km_sparse_solve(const km_partition *partition, const double *rhs, double *x);
void km_sparse_copy(km_partition *to, const km_partition *from);

#endif
