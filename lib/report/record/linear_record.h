/* Linearised equations of motion as a table for people, a record and MATLAB's file. */
#ifndef KM_REPORT_RECORD_LINEAR_RECORD_H
#define KM_REPORT_RECORD_LINEAR_RECORD_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/linear.h"

/* Frequencies, damping and the joints that move most, mode by mode. */
void km_linear_print(const km_mechanism *mechanism, const km_linear *linear, km_text *out);
/* kmech, tool … freedom, independent, A, B, N, eigenvalues, stability, configuration. NULL when out of memory. */
const km_value *km_linear_record(const km_mechanism *mechanism, const km_state *state, const km_linear *linear,
                                 const char *tool, const char *name, km_arena *arena);
/* A, B, N and the eigenvalues (real and imaginary parts as columns) as a MAT-file of level 4, for little-endian
 * machines. */
void km_linear_mat(const km_linear *linear, km_text *out);
/* A matrix without header, row by row. */
void km_matrix_csv(const double *matrix, int rows, int columns, km_text *out);

#endif
