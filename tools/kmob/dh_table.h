/* Arms from a table of Denavit and Hartenberg's parameters. */
#ifndef KMOB_DH_TABLE_H
#define KMOB_DH_TABLE_H

#include "common/common.h"
#include "kmech/model.h"

/* Model of the arm in a CSV table with the columns a, alpha, d, theta, and optionally name, type (R, P or F), min, max,
 * mass, in the given units. Says what is wrong. */
kt_exit kmob_dh_write(const kt_common *common, const char *file, bool modified, const km_units *units, km_text *out);

#endif
