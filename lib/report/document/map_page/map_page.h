/* Page of a map over two drivers: sheets as surfaces that turn, in one HTML file that needs no other. */
#ifndef KM_REPORT_DOCUMENT_MAP_PAGE_H
#define KM_REPORT_DOCUMENT_MAP_PAGE_H

#include "kmech/report.h"

/* Rules of the page beside those of km_film_page_sheet, and the script, which draws what the data say. */
extern const char km_map_page_sheet[], km_map_page_script[];

#endif
