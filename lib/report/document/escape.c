/* Writes text into markup. */
#include "report/document/escape.h"

#include <string.h>

void km_html_escape(const char *text, km_text *out) {
  const char *from = text, *c = text;
  for (; *c; ++c) {
    if (!strchr("&<>\"", *c))
      continue;
    km_text_visible(out, from, (size_t)(c - from));
    from = c + 1;
    if (*c == '&')
      km_text_add(out, "&amp;");
    else if (*c == '<')
      km_text_add(out, "&lt;");
    else if (*c == '>')
      km_text_add(out, "&gt;");
    else
      km_text_add(out, "&quot;");
  }
  km_text_visible(out, from, (size_t)(c - from));
}
