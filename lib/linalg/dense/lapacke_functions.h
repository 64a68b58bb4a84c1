/* Functions of LAPACKE, which is loaded at the first use. Private to linalg/dense. */
#ifndef KM_LINALG_DENSE_LAPACKE_FUNCTIONS_H
#define KM_LINALG_DENSE_LAPACKE_FUNCTIONS_H

#include "kmech/base.h"

#include <lapacke.h>

/* The variants with workspace of the caller. */
typedef struct km_lapacke_functions {
  __typeof__(LAPACKE_dgeev_work) *dgeev;
  __typeof__(LAPACKE_dgesdd_work) *dgesdd;
} km_lapacke_functions;

/* Loads the functions. `what`: computation that needs them, for the message. KM_IO: LAPACKE is not installed. */
km_status km_lapacke_load(const char *what, km_lapacke_functions *out, km_error *error);

#endif
