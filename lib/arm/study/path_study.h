/* A path study on a mechanism: its arm, its path, a start and the methods to compare. */
#ifndef KM_ARM_STUDY_PATH_STUDY_H
#define KM_ARM_STUDY_PATH_STUDY_H

#include "arm/path/path.h"
#include "kmech/arm.h"

struct km_study {
  km_arena arena;
  km_arm *arm;
  km_path *path;      /* NULL: the definition has none, and may do without */
  double *start;      /* [n] model's units, base first: reaches the first pose; NaN where none does */
  double start_moved; /* how far the start is from what was given (inverse kinematics), largest coordinate */
  km_status start_status;
  km_error start_error;
  km_method *methods;
  int method_count;
  km_objective objective;
};

#endif
