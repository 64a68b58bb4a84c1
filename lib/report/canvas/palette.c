/* Colours and dash patterns of lines. */
#include "report/canvas/palette.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

static const km_colour context = {0.70, 0.70, 0.70, 1};

static const km_colour colours[] = {
    {0.000, 0.447, 0.698, 1}, /* blue */
    {0.835, 0.369, 0.000, 1}, /* vermillion */
    {0.000, 0.620, 0.451, 1}, /* bluish green */
    {0.000, 0.000, 0.000, 1}, /* black */
    {0.800, 0.475, 0.655, 1}, /* reddish purple */
    {0.902, 0.624, 0.000, 1}, /* orange */
    {0.337, 0.706, 0.914, 1}, /* sky blue */
    {0.780, 0.720, 0.080, 1}, /* yellow, darkened: the original can't be seen on white */
};

typedef struct dash_pattern {
  size_t count;
  double lengths[6];
} dash_pattern;

static const dash_pattern dashes[] = {
    {0, {0}}, {2, {4.5, 2}}, {2, {1.2, 1.4}}, {4, {6, 1.8, 1.2, 1.8}}, {2, {9, 2.5}}, {6, {5, 1.6, 1.2, 1.6, 1.2, 1.6}},
};

static size_t wrap(int index, size_t count) {
  return index < 0 ? 0 : (size_t)index % count;
}

/* Steps of the scale of ordered things begin at this index. */
enum { FIRST_ORDERED = 1 << 16, ORDERED_STEPS = 1 << 12 };

/* Colour map Inferno without its ends: lightness increases monotonically, so it is readable with colour blindness. */
static const km_colour scale[] = {
    {0.106, 0.047, 0.255, 1}, {0.342, 0.062, 0.429, 1}, {0.578, 0.148, 0.404, 1},
    {0.780, 0.255, 0.300, 1}, {0.902, 0.400, 0.150, 1}, {0.929, 0.569, 0.035, 1},
};

static km_colour on_scale(double part) {
  double at = part * (double)(COUNT(scale) - 1);
  size_t k = at >= (double)(COUNT(scale) - 1) ? COUNT(scale) - 2 : (size_t)at;
  double t = at - (double)k;
  const km_colour *a = &scale[k], *b = &scale[k + 1];
  return (km_colour){(1 - t) * a->red + t * b->red, (1 - t) * a->green + t * b->green, (1 - t) * a->blue + t * b->blue,
                     1};
}

int km_palette_ordered(int i, int count) {
  return FIRST_ORDERED + (count > 1 ? i * ORDERED_STEPS / (count - 1) : 0);
}

int km_palette_compared(int i, int count, bool ordered) {
  return ordered ? km_palette_ordered(i, count) : i;
}

km_colour km_palette_colour(int index) {
  if (index >= FIRST_ORDERED)
    return on_scale((double)(index - FIRST_ORDERED) / ORDERED_STEPS);
  return index < 0 ? context : colours[wrap(index, COUNT(colours))];
}

km_colour km_palette_text(int index) {
  const double darker = 0.78;
  km_colour colour = km_palette_colour(index);
  return (km_colour){darker * colour.red, darker * colour.green, darker * colour.blue, 1};
}

km_pen km_palette_pen(int colour, int dash, double width) {
  const dash_pattern *pattern = &dashes[wrap(dash, COUNT(dashes))];
  return (km_pen){.colour = km_palette_colour(colour),
                  .width = width,
                  .dash = pattern->count ? pattern->lengths : NULL,
                  .dash_count = pattern->count};
}
