/* Files (kmech/base.h) and their SHA-256. */
#ifndef KM_BASE_FILE_H
#define KM_BASE_FILE_H

#include "base/text.h"
#include "kmech/base.h"

enum { KM_SHA256_TEXT = 65 };
void km_sha256(const void *bytes, size_t size, char out[KM_SHA256_TEXT]);

#endif
