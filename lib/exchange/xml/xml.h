/* XML text to trees of elements that know their place in the file. */
#ifndef KM_EXCHANGE_XML_XML_H
#define KM_EXCHANGE_XML_XML_H

#include "base/text.h"
#include "kmech/base.h"

typedef struct km_xml_attribute {
  const char *name, *value;
} km_xml_attribute;

/* An element. Blanks around its text are cut off, and the texts between its children are joined. */
typedef struct km_xml {
  const char *name, *text; /* text: "" if it has none */
  int line, column;        /* line and column of its start, from 1 */
  const char *file;        /* name of a file other than the main one; NULL: the main one */
  int attribute_count;
  const km_xml_attribute *attributes;
  struct km_xml *parent, *first, *last, *next; /* members, and the next sibling */
} km_xml;

enum { KM_XML_DEPTH = 2048 }; /* the deepest nesting */

/* Parses `size` bytes into a tree that lives in `arena`. Blanks before the text, and blanks and NULs behind it, are
 * skipped, except in UTF-16; prefixes are parts of names. External entities are never fetched. `file` is kept in the
 * elements. KM_MODEL with line and column: text that is not XML, an entity from another file, entities that grow beyond
 * measure, nesting past KM_XML_DEPTH, a name or value longer than a million bytes. */
km_status km_xml_parse(const char *bytes, size_t size, const char *file, km_arena *arena, km_xml **root,
                       km_error *error);

/* The attribute's value; NULL if the element (or NULL) has none. */
const char *km_xml_attribute_of(const km_xml *element, const char *name);
/* The first child of that name, and the next sibling of the same name as an element; NULL if there is none. */
const km_xml *km_xml_child(const km_xml *element, const char *name);
const km_xml *km_xml_next(const km_xml *element);

#endif
