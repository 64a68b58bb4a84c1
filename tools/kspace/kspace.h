/* Commands of kspace. */
#ifndef KSPACE_H
#define KSPACE_H

#include "common/pose.h"

#include "kmech/data.h"

kt_exit kspace_clearance(int argc, char **argv);
kt_exit kspace_map(int argc, char **argv);
kt_exit kspace_modes(int argc, char **argv);
kt_exit kspace_path(int argc, char **argv);
kt_exit kspace_turning(int argc, char **argv);

/* Writes BASE.RESULT.csv. */
kt_exit kspace_write_csv(const kt_common *common, const char *base, const km_table *table, const char *result);

#endif
