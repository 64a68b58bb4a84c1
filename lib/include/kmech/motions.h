/* The matrices behind the mobility: J, N and Z of substructures, and all free motions together. */
#ifndef KMECH_MOTIONS_H
#define KMECH_MOTIONS_H

#include "kmech/mobility.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Rows of a substructure's J: Σ λ of its loops and its couplings. Its columns are those of km_substructure_evidence. 0
 * for a substructure that doesn't exist. */
KM_API int km_substructure_rows(const km_mechanism *mechanism, int substructure);
/* The coordinate of a column, free ones only; -1 for a column that doesn't exist. A ball's three columns are the
 * angular velocity along the parent frame's axes. */
KM_API int km_substructure_coordinate(const km_mechanism *mechanism, int substructure, int column);
/* What a scaled rate of the column is multiplied by for radians and the model's length unit: 1, or the substructure's
 * size. D of theory 4 times this is what Z is orthonormal in. NaN for a column that doesn't exist. */
KM_API double km_substructure_unit(const km_mechanism *mechanism, int substructure, int column);

/* All matrices are dense, column-major, into the caller's memory, in scaled coordinates (angles as they are, lengths
 * over the substructure's size), at the state's pose after km_mobility_update. Each: KM_USAGE where something is
 * missing or the mobility isn't known; KM_MEMORY. */

/* J[rows × columns]: the rates of the loops' errors per scaled rate, each loop's independent rows in its own motion
 * space (231). O(rows · columns). */
KM_API km_status km_substructure_jacobian(const km_mechanism *mechanism, const km_state *state, int substructure,
                                          double *J, km_error *error);
/* N[columns × mobility] with J N = 0: column k moves the k-th independent coordinate by 1, the other independent ones
 * not at all (275). Room for columns × mobility of km_substructure_evidence. O(columns · mobility · rank). */
KM_API km_status km_substructure_null(const km_mechanism *mechanism, const km_state *state, int substructure, double *N,
                                      km_error *error);
/* Z[columns × mobility], an orthonormal basis of D·range(N); m_j = Σ_k Z_jk² (278)-(279). O(columns · mobility). */
KM_API km_status km_substructure_basis(const km_mechanism *mechanism, const km_state *state, int substructure,
                                       double *Z, km_error *error);

/* Every free motion of the whole mechanism as rates of all coordinates, in radians and the model's length unit:
 * N[coordinate count × *freedom], room for coordinate count squared: per substructure D⁻¹ Z, and each coordinate
 * outside loops and couplings by itself. After km_mobility_update. KM_USAGE: the mobility isn't known. */
KM_API km_status km_motions_basis(const km_mechanism *mechanism, const km_state *state, double *N, int *freedom,
                                  km_error *error);

#ifdef __cplusplus
}
#endif
#endif
