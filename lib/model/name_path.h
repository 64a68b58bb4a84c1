/* Paths as a file writes them: a name, a list of names, or one text with slashes between the names. */
#ifndef KM_MODEL_NAME_PATH_H
#define KM_MODEL_NAME_PATH_H

#include "base/value.h"

enum {
  KM_LONGEST_PATH = 2100, /* names; more than the parser's nesting limit */
  KM_PATH_TEXT = 256      /* bytes of a path as text, the NUL included */
};

typedef struct km_path_names {
  const char *names[KM_LONGEST_PATH]; /* borrowed, or parts of `copy` */
  size_t count;
  char *copy;
  bool failed; /* out of memory */
} km_path_names;

/* Collects the names unchanged; a text is one name. False if there are too many. */
bool km_path_names_gather(const km_value *value, km_path_names *out);
/* One text with slashes becomes the names between them; a backslash keeps the character after it. False where it has no
 * slash, an empty name, too many names, or memory is out. */
bool km_path_names_split(const char *text, km_path_names *out);
void km_path_names_free(km_path_names *path);

/* Names as a person reads them: `a/b/c`. */
const char *km_path_names_text(const char *const *names, size_t count, char out[KM_PATH_TEXT]);

#endif
