/* Texts in UTF-16, recognised by their first bytes. */
#ifndef KM_BASE_UTF16_H
#define KM_BASE_UTF16_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* True for a byte order mark of UTF-16, or for a first ASCII character in UTF-16 without a mark. */
static inline bool km_is_wide(const char *bytes, size_t size) {
  return size > 1 && (memcmp(bytes, "\xFF\xFE", 2) == 0 || memcmp(bytes, "\xFE\xFF", 2) == 0 || !bytes[0] != !bytes[1]);
}

#endif
