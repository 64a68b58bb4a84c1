/* Whole files in and out, and their fingerprint. */
#ifndef KM_BASE_FILE_H
#define KM_BASE_FILE_H

#include "base/text.h"
#include "kmech/status.h"

/* Appends the file's bytes; "-" is the standard input. KM_IO with the system's reason. */
km_status km_file_read(const char *path, km_text *out, km_error *error);

/* Writes the file whole or not at all: a temporary beside it, then a rename. "-" is the standard output. */
km_status km_file_write(const char *path, const km_text *bytes, km_error *error);

enum { KM_SHA256_TEXT = 65 };
void km_sha256(const void *bytes, size_t size, char out[KM_SHA256_TEXT]);

#endif
