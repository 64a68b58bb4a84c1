/* The page that tools/kview/page is bundled into: one HTML file with its script and style. */
#ifndef KVIEW_PAGE_H
#define KVIEW_PAGE_H

#include <stddef.h>

extern const unsigned char kv_page[];
extern const size_t kv_page_size;

#endif
