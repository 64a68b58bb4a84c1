/* kview's commands. */
#ifndef KVIEW_KVIEW_H
#define KVIEW_KVIEW_H

#include "common/common.h"

kt_exit kview_open(int argc, char **argv);
kt_exit kview_export(int argc, char **argv);

#endif
