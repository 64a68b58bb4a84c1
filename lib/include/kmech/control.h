/* Path-control and pose-control columns of a Jacobian that is given as it is. */
#ifndef KMECH_CONTROL_H
#define KMECH_CONTROL_H

#include "kmech/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Evidence of the rank. */
typedef struct km_control {
  int rank, freedom;                /* of the matrix; columns − rank */
  double last_pivot, first_dropped; /* magnitudes; 0 dropped: nothing was left */
  double tolerance;                 /* below which a pivot counts as 0 */
  double path_entry;                /* z = |the null space's last row| */
} km_control;

/* Z′ of the null space of matrix[rows × columns] (column-major, its last column the path's): first the path-control
 * column Zzᵀ/|z|, z the last row of an orthonormal basis Z, its own last entry positive; then the pose-control columns,
 * an orthonormal complement whose last entries are 0 (theory 6). Z[columns × freedom], room for columns². No scaling.
 * KM_USAGE: an entry isn't finite; KM_NO_RESULT: no null space, or |z| < 1e-9: the path is impossible here; KM_MEMORY.
 */
KM_API km_status km_control_of_matrix(const double *matrix, int rows, int columns, double *Z, km_control *out,
                                      km_error *error);

#ifdef __cplusplus
}
#endif
#endif
