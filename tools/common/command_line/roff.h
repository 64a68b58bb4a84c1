/* Text for manual pages. */
#ifndef KT_COMMON_COMMAND_LINE_ROFF_H
#define KT_COMMON_COMMAND_LINE_ROFF_H

#include "kmech/base.h"

/* Appends text in which nothing is a request or an escape, and every character is what it is. */
void kt_roff(const char *text, size_t length, km_text *out);
/* Appends the tables of keys that km_schema_markdown writes: a heading for each object, a paragraph for each key. */
void kt_roff_keys(const char *markdown, km_text *out);

#endif
