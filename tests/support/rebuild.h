/* A model that was read from a file, made again by calls. */
#ifndef KM_TESTS_REBUILD_H
#define KM_TESTS_REBUILD_H

#include "kmech/build.h"

/* Fails the test where a call is refused. The caller frees the model. */
km_model *rebuild(const km_model *model);

#endif
