/* Texts that readers refuse or warn about, and words that the messages must contain. */
#ifndef KM_TESTS_REFUSALS_H
#define KM_TESTS_REFUSALS_H

#include "support/support.h"

typedef struct told_text {
  const char *text, *words;
} told_text;

/* Reads each as a model, with assembly: it is refused with these words (or, if it isn't `refused`, read with a
 * warning or note of these words). A text may be any format of models. */
void assert_models_told(const told_text *list, size_t count, bool refused);

/* Checks the status and the words of the error or of one of the messages; prints a mismatch. */
bool is_told(const told_text *text, km_status status, km_status expected, const km_messages *messages,
             const km_error *error);

#define assert_words(text, status, expected, messages, error)                                                          \
  assert_true(is_told((text), (status), (expected), (messages), (error)))
#define COUNT(list) (sizeof(list) / sizeof *(list))

#endif
