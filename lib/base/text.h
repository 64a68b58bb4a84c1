/* Texts inside of the library: kmech/base.h, and what formats into arenas and messages. */
#ifndef KM_BASE_TEXT_H
#define KM_BASE_TEXT_H

#include "base/memory.h"
#include "kmech/base.h"

#include <stdarg.h>

/* Formatted text in an arena. NULL when out of memory. */
char *km_arena_format_list(km_arena *arena, const char *format, va_list arguments);

/* A number for a message, where it is asked for. */
#define KM_SHOWN(x) km_number_shown((char[KM_NUMBER_TEXT]){0}, x)
const char *km_number_shown(char out[KM_NUMBER_TEXT], double value); /* returns `out` */

/* As strtod, but in the C locale whatever the process's locale is, of decimals and words alone: no number begins with a blank or 0x. */
double km_number_read(const char *text, char **end);

#endif
