/* Libraries that are loaded when they are first needed, so that no other start of a tool pays for them. */
#ifndef KM_BASE_LIBRARY_H
#define KM_BASE_LIBRARY_H

#include <stdbool.h>

/* Puts the address of the library's function `name` into the function pointer at `function`; false if there is none. */
bool km_library_function(void *handle, const char *name, void *function);

#endif
