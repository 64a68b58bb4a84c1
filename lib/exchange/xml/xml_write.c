/* Elements of XML as text. */
#include "exchange/xml/xml_write.h"

#include <math.h>
#include <string.h>

static void add_escaped(km_text *out, const char *text) {
  for (; *text; ++text)
    switch (*text) {
    case '&':
      km_text_add(out, "&amp;");
      break;
    case '<':
      km_text_add(out, "&lt;");
      break;
    case '>':
      km_text_add(out, "&gt;");
      break;
    case '"':
      km_text_add(out, "&quot;");
      break;
    case '\n':
    case '\t':
    case '\r':
      km_text_format(out, "&#%d;", *text);
      break;
    default:
      km_text_bytes(out, (unsigned char)*text < ' ' ? "_" : text, 1);
    }
}

static void close_tag(km_xml_writer *w) {
  if (w->open)
    km_text_add(w->out, ">\n");
  w->open = false;
}

static void indent(km_xml_writer *w) {
  for (int i = 0; i < w->depth; ++i)
    km_text_add(w->out, "  ");
}

void km_xml_begin(km_xml_writer *w, const char *name) {
  close_tag(w);
  indent(w);
  km_text_format(w->out, "<%s", name);
  w->depth++;
  w->open = true;
}

void km_xml_end(km_xml_writer *w, const char *name) {
  w->depth--;
  if (w->open) {
    km_text_add(w->out, "/>\n");
    w->open = false;
    return;
  }
  indent(w);
  km_text_format(w->out, "</%s>\n", name);
}

void km_xml_set(km_xml_writer *w, const char *name, const char *value) {
  km_text_format(w->out, " %s=\"", name);
  add_escaped(w->out, value);
  km_text_add(w->out, "\"");
}

void km_xml_add_numbers(km_text *out, const double *values, int count, bool exact) {
  char digits[KM_NUMBER_TEXT];
  for (int i = 0; i < count; ++i) {
    bool whole = values[i] == floor(values[i]);
    if (i)
      km_text_add(out, " ");
    if (!exact || whole) {
      km_text_number(out, values[i] == 0.0 ? 0.0 : values[i]);
      continue;
    }
    /* The shortest exact form, filled up to more digits than a reader counts as rounded. */
    size_t length = km_number_format(digits, values[i]);
    const char *exponent = strpbrk(digits, "eE"), *point = strchr(digits, '.');
    size_t mantissa = exponent ? (size_t)(exponent - digits) : length;
    km_text_bytes(out, digits, mantissa);
    if (!point || (size_t)(point - digits) > mantissa)
      km_text_add(out, ".");
    for (size_t k = mantissa; k < 20; ++k)
      km_text_add(out, "0");
    km_text_bytes(out, digits + mantissa, length - mantissa);
  }
}

void km_xml_set_numbers(km_xml_writer *w, const char *name, const double *values, int count, bool exact) {
  km_text_format(w->out, " %s=\"", name);
  km_xml_add_numbers(w->out, values, count, exact);
  km_text_add(w->out, "\"");
}

void km_xml_text(km_xml_writer *w, const char *name, const char *value) {
  close_tag(w);
  indent(w);
  km_text_format(w->out, "<%s>", name);
  add_escaped(w->out, value);
  km_text_format(w->out, "</%s>\n", name);
}

void km_xml_numbers(km_xml_writer *w, const char *name, const double *values, int count, bool exact) {
  close_tag(w);
  indent(w);
  km_text_format(w->out, "<%s>", name);
  km_xml_add_numbers(w->out, values, count, exact);
  km_text_format(w->out, "</%s>\n", name);
}
