/* Colours and dash patterns of lines. */
#include "report/plot/palette.h"

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

km_colour km_palette_colour(int index) {
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
