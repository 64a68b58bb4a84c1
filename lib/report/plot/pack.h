/* Pixels packed as PNG asks for. Private to report/plot/. */
#ifndef KM_REPORT_PLOT_PACK_H
#define KM_REPORT_PLOT_PACK_H

#include "report/plot/png.h"

/* Appends a zlib stream (RFC 1950 and 1951) of all lines, each a 0 (no filter) and then red, green and blue of its pixels.
 * Only the pixel before, the one above and the last pair like this one are looked at: of drawings that is half of the time
 * that zlib takes, and no more bytes. False when out of memory. O(pixels). */
bool km_pack_pixels(const km_pixels *pixels, km_text *out);

#endif
