/* Written numbers: their list, and their digits. */
#include "model/written_numbers.h"

#include <stdio.h>
#include <stdlib.h>

void km_model_add_written(km_model *m, const km_written_number *number) {
  if (km_arena_grow(&m->arena, (void **)&m->written, &m->written_room, (size_t)m->written_count + 1,
                    sizeof *m->written))
    m->written[m->written_count++] = *number;
}

/* True if x is the number that its first `digits` digits give; *exponent: decimal exponent of the first. */
static bool is_given_by(double x, int digits, int *exponent) {
  char text[40];
  snprintf(text, sizeof text, "%.*e", digits - 1, x);
  char *mark = strchr(text, 'e');
  *exponent = mark ? (int)strtol(mark + 1, NULL, 10) : 0;
  return km_number_read(text, NULL) == x;
}

double km_half_digit(double x, int *digits) {
  enum { MOST_DIGITS = 17 }; /* any double has as many */
  int few = 0, enough = MOST_DIGITS, exponent = 0;
  *digits = 0;
  if (x == 0.0 || !isfinite(x))
    return 0.5;
  while (enough - few > 1) {
    int middle = (few + enough) / 2;
    if (is_given_by(x, middle, &exponent))
      enough = middle;
    else
      few = middle;
  }
  is_given_by(x, enough, &exponent);
  *digits = enough;
  return 0.5 * pow(10.0, exponent - enough + 1);
}
