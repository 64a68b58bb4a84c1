/* Trees of values (kmech/data.h) and the names of their kinds in messages. */
#ifndef KM_BASE_VALUE_H
#define KM_BASE_VALUE_H

#include "base/text.h"
#include "kmech/data.h"

const char *km_kind_name(km_kind kind); /* "a number", … */

#endif
