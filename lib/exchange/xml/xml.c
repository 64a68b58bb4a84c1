/* XML text to trees of elements. The only user of the XML library. */
#include "exchange/xml/xml.h"

#include "base/utf16.h"

#include <expat.h>
#include <limits.h>
#include <string.h>

enum { LONGEST = 1000000 };

typedef struct parsing {
  XML_Parser parser;
  km_arena *arena;
  const char *file;
  km_xml *root, *open; /* the innermost element that isn't closed */
  km_text *texts;      /* [KM_XML_DEPTH + 1] of the open elements */
  int depth, first_line;
  const char *fault; /* reason and location of an abort of the parser; NULL: none */
  unsigned long line, column;
  bool bad_text; /* the parser found what XML doesn't allow */
} parsing;

static void *allocate(size_t size) {
  return km_alloc(1, size);
}

static void *reallocate(void *block, size_t size) {
  return km_resize(block, 1, size);
}

static void locate(parsing *p) {
  p->line = XML_GetCurrentLineNumber(p->parser) + (unsigned long)p->first_line;
  p->column = XML_GetCurrentColumnNumber(p->parser) + 1;
}

static void stop(parsing *p, const char *fault) {
  if (p->fault)
    return;
  locate(p);
  p->fault = fault;
  XML_StopParser(p->parser, XML_FALSE);
}

/* An element with its attributes and their text in one block. */
static km_xml *new_element(parsing *p, const char *name, const char **attributes) {
  size_t count = 0, bytes = strlen(name) + 1;
  for (const char **a = attributes; *a; a += 2, ++count)
    bytes += strlen(a[0]) + strlen(a[1]) + 2;
  km_xml *e = km_arena_alloc(p->arena, 1, sizeof *e + count * sizeof(km_xml_attribute) + bytes);
  if (!e)
    return NULL;
  km_xml_attribute *list = (km_xml_attribute *)(e + 1);
  char *room = (char *)(list + count);
  *e = (km_xml){.name = room, .text = "", .file = p->file, .attributes = list, .attribute_count = (int)count};
  room = stpcpy(room, name) + 1;
  for (size_t i = 0; i < count; ++i) {
    list[i] = (km_xml_attribute){room, room + strlen(attributes[2 * i]) + 1};
    stpcpy(room, attributes[2 * i]);
    room = stpcpy((char *)list[i].value, attributes[2 * i + 1]) + 1;
  }
  return e;
}

static void on_start(void *context, const char *name, const char **attributes) {
  parsing *p = context;
  if (p->fault)
    return;
  if (p->depth == KM_XML_DEPTH) {
    stop(p, "elements are nested more than 2048 deep; expected fewer");
    return;
  }
  bool longer = strlen(name) > LONGEST;
  for (const char **a = attributes; *a; ++a)
    longer = longer || strlen(*a) > LONGEST;
  if (longer) {
    stop(p, "a name or an attribute is longer than a million bytes; expected less");
    return;
  }
  km_xml *e = new_element(p, name, attributes);
  if (!e) {
    stop(p, "out of memory");
    return;
  }
  locate(p);
  e->line = (int)p->line;
  e->column = (int)p->column;
  e->parent = p->open;
  if (!p->open)
    p->root = e;
  else if (p->open->last)
    p->open->last->next = e;
  else
    p->open->first = e;
  if (p->open)
    p->open->last = e;
  p->open = e;
  p->depth++;
}

static bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

static void on_end(void *context, const char *name) {
  parsing *p = context;
  (void)name;
  if (p->fault)
    return;
  km_text *text = &p->texts[p->depth--];
  size_t first = 0;
  while (first < text->size && is_blank(text->data[first]))
    first++;
  while (text->size > first && is_blank(text->data[text->size - 1]))
    text->data[--text->size] = '\0';
  if (text->size > first)
    p->open->text = km_arena_string(p->arena, text->data + first);
  p->arena->failed = p->arena->failed || text->failed;
  if (p->arena->failed)
    stop(p, "out of memory");
  text->size = 0;
  p->open = p->open->parent;
}

static void on_text(void *context, const char *text, int length) {
  parsing *p = context;
  if (p->fault)
    return;
  km_text_bytes(&p->texts[p->depth], text, (size_t)length);
  p->arena->failed = p->arena->failed || p->texts[p->depth].failed;
  if (p->arena->failed)
    stop(p, "out of memory");
  else if (p->texts[p->depth].size > LONGEST)
    stop(p, "a text is longer than a million bytes; expected less");
}

static const char foreign_entity[] = "an entity from outside of the file; expected all text in the file itself";

static int on_foreign_entity(XML_Parser parser, const char *context, const char *base, const char *system,
                             const char *public) {
  (void)context, (void)base, (void)system, (void)public;
  stop(XML_GetUserData(parser), foreign_entity);
  return XML_STATUS_ERROR;
}

static void on_skipped_entity(void *context, const char *name, int is_parameter) {
  (void)name;
  if (!is_parameter)
    stop(context, foreign_entity);
}

static km_status report(parsing *p, km_error *error) {
  enum XML_Error code = XML_GetErrorCode(p->parser);
  if (p->arena->failed || code == XML_ERROR_NO_MEMORY)
    return km_fail(error, KM_MEMORY, "out of memory while reading XML");
  const char *in = p->file ? p->file : "", *of = p->file ? ": " : "";
  if (p->fault)
    return km_fail(error, KM_MODEL, "%.300s%sline %lu, column %lu: %s", in, of, p->line, p->column, p->fault);
  locate(p);
  return km_fail(error, KM_MODEL, "%.300s%sline %lu, column %lu: %s; expected XML text", in, of, p->line, p->column,
                 XML_ErrorString(code));
}

static km_status parse(parsing *p, const char *bytes, size_t size, km_error *error) {
  XML_SetUserData(p->parser, p);
  XML_SetElementHandler(p->parser, on_start, on_end);
  XML_SetCharacterDataHandler(p->parser, on_text);
  XML_SetExternalEntityRefHandler(p->parser, on_foreign_entity);
  XML_SetSkippedEntityHandler(p->parser, on_skipped_entity);
  enum XML_Status done = XML_Parse(p->parser, bytes, (int)size, 1);
  bool short_of_text = p->arena->failed || p->fault;
  return done == XML_STATUS_OK && !short_of_text ? KM_OK : report(p, error);
}

static km_status parse_once(const char *bytes, size_t size, parsing *p, km_error *error) {
  static const XML_Memory_Handling_Suite memory = {allocate, reallocate, km_free};
  p->parser = XML_ParserCreate_MM(NULL, &memory, NULL);
  p->texts = KM_NEW(km_text, KM_XML_DEPTH + 1);
  km_status status = p->parser && p->texts ? parse(p, bytes, size, error)
                                           : km_fail(error, KM_MEMORY, "out of memory while reading XML");
  p->bad_text = status == KM_MODEL && !p->fault;
  for (int i = 0; p->texts && i <= KM_XML_DEPTH; ++i)
    km_text_free(&p->texts[i]);
  km_free(p->texts);
  if (p->parser)
    XML_ParserFree(p->parser);
  return status;
}

/* End of the text section that begins with `start` at `at`; `end` if it isn't closed. NULL if it doesn't begin here. */
static char *end_of(char *at, char *end, const char *start, const char *stop) {
  size_t first = strlen(start), last = strlen(stop);
  if ((size_t)(end - at) < first || memcmp(at, start, first) != 0)
    return NULL;
  char *found = memmem(at + first, (size_t)(end - at) - first, stop, last);
  return found ? found + last : end;
}

static void blank_out(char *from, const char *to) {
  for (; from < to; ++from)
    if (*from != '\n')
      *from = ' ';
}

/* Blanks in the place of comments, which other readers let hold "--", and of XML declarations behind them. */
static char *without_comments(const char *bytes, size_t size) {
  char *copy = km_alloc(size + 1, 1), *end = copy ? copy + size : NULL;
  if (!copy)
    return NULL;
  memcpy(copy, bytes, size);
  for (char *at = copy; (at = memchr(at, '<', (size_t)(end - at))) != NULL; ++at) {
    char *data = end_of(at, end, "<![CDATA[", "]]>"), *comment = end_of(at, end, "<!--", "-->");
    char *declaration = at > copy ? end_of(at, end, "<?xml ", "?>") : NULL;
    if (data)
      at = data - 1;
    else if (comment)
      blank_out(at, comment);
    else if (declaration)
      blank_out(at, declaration);
  }
  return copy;
}

km_status km_xml_parse(const char *bytes, size_t size, const char *file, km_arena *arena, km_xml **root,
                       km_error *error) {
  parsing p = {.arena = arena, .file = file};
  bool wide = km_is_wide(bytes, size); /* bytes aren't characters: they stay as they are */
  *root = NULL;
  for (; !wide && size && is_blank(*bytes); ++bytes, --size)
    p.first_line += *bytes == '\n';
  while (!wide && size && (bytes[size - 1] == '\0' || is_blank(bytes[size - 1])))
    --size;
  if (size > INT_MAX)
    return km_fail(error, KM_MODEL, "the file has %zu bytes; expected at most %d", size, INT_MAX);
  parsing again = p;
  km_status status = parse_once(bytes, size, &p, error);
  if (p.bad_text && !wide) {
    char *copy = without_comments(bytes, size);
    status =
        copy ? parse_once(copy, size, &again, error) : km_fail(error, KM_MEMORY, "out of memory while reading XML");
    p.root = again.root;
    km_free(copy);
  }
  if (!status)
    *root = p.root;
  return status;
}

const char *km_xml_attribute_of(const km_xml *element, const char *name) {
  for (int i = 0; element && i < element->attribute_count; ++i)
    if (strcmp(element->attributes[i].name, name) == 0)
      return element->attributes[i].value;
  return NULL;
}

const km_xml *km_xml_child(const km_xml *element, const char *name) {
  for (const km_xml *e = element ? element->first : NULL; e; e = e->next)
    if (strcmp(e->name, name) == 0)
      return e;
  return NULL;
}

const km_xml *km_xml_next(const km_xml *element) {
  for (const km_xml *e = element->next; e; e = e->next)
    if (strcmp(e->name, element->name) == 0)
      return e;
  return NULL;
}
