/* kstatic's commands. */
#ifndef KSTATIC_H
#define KSTATIC_H

#include "common/common.h"

kt_exit kstatic_at(int argc, char **argv);
kt_exit kstatic_sweep(int argc, char **argv);
kt_exit kstatic_report(int argc, char **argv);

#endif
