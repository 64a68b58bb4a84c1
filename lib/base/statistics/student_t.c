#include "base/statistics/student_t.h"

#include <gsl/gsl_cdf.h>

#include <math.h>

double km_student(double freedoms) {
  return gsl_cdf_tdist_Pinv(0.975, fmax(1.0, freedoms));
}
