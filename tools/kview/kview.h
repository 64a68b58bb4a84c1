/* kview's commands. */
#ifndef KVIEW_KVIEW_H
#define KVIEW_KVIEW_H

#include "common/common.h"

/* Says what is wrong with a model that a session couldn't read. */
void kview_say(const kt_common *common, const char *path, km_status status, const km_error *error);

kt_exit kview_open(int argc, char **argv);
kt_exit kview_export(int argc, char **argv);

#endif
