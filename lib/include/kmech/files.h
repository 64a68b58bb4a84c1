/* Whole files in and out. */
#ifndef KMECH_FILES_H
#define KMECH_FILES_H

#include "kmech/text.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Appends the file's bytes; "-" is the standard input. KM_IO with the system's reason. O(bytes). */
KM_API km_status km_file_read(const char *path, km_text *out, km_error *error);
/* Writes the file whole or not at all: a temporary beside it, then a rename. "-" is the standard output. KM_IO. O(bytes). */
KM_API km_status km_file_write(const char *path, const km_text *bytes, km_error *error);

#ifdef __cplusplus
}
#endif
#endif
