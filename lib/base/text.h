/* Text functions of the library beyond kmech/base.h: formatting into arenas and messages. */
#ifndef KM_BASE_TEXT_H
#define KM_BASE_TEXT_H

#include "base/memory.h"
#include "kmech/base.h"

#include <stdarg.h>

/* Formatted text in an arena. NULL when out of memory. */
char *km_arena_format_list(km_arena *arena, const char *format, va_list arguments);

/* A number as text in a buffer, for a message. */
#define KM_SHOWN(x) km_number_shown((char[KM_NUMBER_TEXT]){0}, x)
const char *km_number_shown(char out[KM_NUMBER_TEXT], double value); /* returns `out` */

/* strtod in the C locale, for decimals and words (inf, nan) only: a leading blank or 0x isn't accepted. */
double km_number_read(const char *text, char **end);

#endif
