/* Commands of kspace. */
#ifndef KSPACE_H
#define KSPACE_H

#include "common/pose.h"

kt_exit kspace_map(int argc, char **argv);
kt_exit kspace_modes(int argc, char **argv);

#endif
