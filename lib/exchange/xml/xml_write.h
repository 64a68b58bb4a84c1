/* Elements of XML as text. */
#ifndef KM_EXCHANGE_XML_XML_WRITE_H
#define KM_EXCHANGE_XML_XML_WRITE_H

#include "base/text.h"

typedef struct km_xml_writer {
  km_text *out;
  int depth;
  bool open; /* the last element's tag isn't closed yet */
} km_xml_writer;

void km_xml_begin(km_xml_writer *w, const char *name);
void km_xml_end(km_xml_writer *w, const char *name);
/* An attribute of the element that was begun last. Characters that XML can't hold become underscores. */
void km_xml_set(km_xml_writer *w, const char *name, const char *value);
/* Numbers between blanks. `exact`: with all digits, so that no reader takes them for rounded ones. */
void km_xml_set_numbers(km_xml_writer *w, const char *name, const double *values, int count, bool exact);
/* A whole element that holds a text, or numbers. */
void km_xml_text(km_xml_writer *w, const char *name, const char *value);
void km_xml_numbers(km_xml_writer *w, const char *name, const double *values, int count, bool exact);
/* The numbers alone. */
void km_xml_add_numbers(km_text *out, const double *values, int count, bool exact);

#endif
