/* JSON text to trees of values that may be changed; the rest is in kmech/data.h. */
#ifndef KM_EXCHANGE_JSON_JSON_H
#define KM_EXCHANGE_JSON_JSON_H

#include "base/value.h"

/* As km_json_parse. */
km_status km_json_parse_open(const char *bytes, size_t size, km_arena *arena, km_value **root, km_error *error);

#endif
