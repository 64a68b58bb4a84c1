/* Writes text into markup. */
#include "report/document/escape.h"

void km_html_escape(const char *text, km_text *out) {
  for (const char *c = text; *c; ++c) {
    if (*c == '&')
      km_text_add(out, "&amp;");
    else if (*c == '<')
      km_text_add(out, "&lt;");
    else if (*c == '>')
      km_text_add(out, "&gt;");
    else if (*c == '"')
      km_text_add(out, "&quot;");
    else
      km_text_bytes(out, c, 1);
  }
}
