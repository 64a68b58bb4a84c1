/* Reads numbers with a decimal point in every locale. */
#include "base/text.h"

#include <ctype.h>
#include <locale.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static locale_t plain;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_plain(void) {
  plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

double km_number_read(const char *text, char **end) {
  const char *digits = text + strspn(text, "+-");
  if (isspace((unsigned char)*text) || (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X'))) {
    if (end)
      *end = (char *)(uintptr_t)text; /* like strtod if there is no number */
    return 0.0;
  }
  pthread_once(&once, make_plain);
  return plain ? strtod_l(text, end, plain) : strtod(text, end); /* the C locale itself takes no memory */
}
