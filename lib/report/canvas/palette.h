/* Colours that colour-blind readers distinguish, with dash patterns for grey prints. */
#ifndef KM_REPORT_CANVAS_PALETTE_H
#define KM_REPORT_CANVAS_PALETTE_H

#include "report/canvas/canvas.h"

#include <stdbool.h>

/* Okabe and Ito's eight colours, in an order that puts the weakest on white last; indices past the
 * end begin again, but for those of km_palette_ordered. -1: the grey of context lines. */
km_colour km_palette_colour(int index);
/* The index of the colour of item i among `count` that have an order: from dark blue over red to orange. */
int km_palette_ordered(int i, int count);
/* The index of the colour of one of several things that are compared. */
int km_palette_compared(int i, int count, bool ordered);
/* Darker colour of the same hue for names, whose strokes are thinner than lines. */
km_colour km_palette_text(int index);
/* `dash` 0 is solid; patterns past the last begin again. `width` in points. */
km_pen km_palette_pen(int colour, int dash, double width);

#endif
