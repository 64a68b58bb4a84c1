/* A path study of a mechanism: arm, path, start and the methods to compare. */
#ifndef KM_ARM_STUDY_PATH_STUDY_H
#define KM_ARM_STUDY_PATH_STUDY_H

#include "arm/path/path.h"
#include "kmech/arm.h"

struct km_study {
  km_arena arena;
  km_arm *arm;
  km_path *path;      /* NULL: the definition has no path and needs none */
  double *start;      /* [n] model's units, base first: start that reaches the first pose; NaN: none */
  double start_moved; /* largest change of a coordinate by inverse kinematics */
  km_status start_status;
  km_error start_error;
  km_method *methods;
  int method_count;
  km_objective objective;
  km_clearance *clearance; /* pairs of bodies for the objective; NULL: it isn't requested */
};

#endif
