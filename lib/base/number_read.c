/* Numbers from text with a decimal point, whatever the process's locale is. */
#include "base/text.h"

#include <locale.h>
#include <pthread.h>
#include <stdlib.h>

static locale_t plain;
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void make_plain(void) {
  plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
}

double km_number_read(const char *text, char **end) {
  pthread_once(&once, make_plain);
  return plain ? strtod_l(text, end, plain) : strtod(text, end); /* the C locale itself takes no memory */
}
