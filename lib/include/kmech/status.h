/* Status codes, errors and messages: one convention for the whole library. */
#ifndef KMECH_STATUS_H
#define KMECH_STATUS_H

#include "kmech/api.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a fallible function returns. 0 is success. */
typedef enum km_status {
  KM_OK = 0,    /* done */
  KM_PARTIAL,   /* done, but only a part of what was asked: the result holds it */
  KM_NO_RESULT, /* done, and the answer is that there is none: the result is empty */
  KM_USAGE,     /* the caller asked for something that doesn't exist or doesn't fit */
  KM_IO,        /* a file can't be read or written */
  KM_MODEL,     /* the model is bad: syntax, contents, or loops that can't close */
  KM_DIVERGED,  /* an iteration gave out */
  KM_CANCELLED, /* the progress callback asked to stop */
  KM_MEMORY,    /* out of memory */
  KM_INTERNAL   /* a broken invariant of the library */
} km_status;

enum {
  KM_ERROR_TEXT = 1024 /* bytes of a text, the NUL included */
};

/* One failure in words: where, what was found, what was expected. Owned by the caller. */
typedef struct km_error {
  km_status status;         /* what the call returned */
  char text[KM_ERROR_TEXT]; /* one line, without the name of a program */
} km_error;

/* Fills `error` (may be NULL) by a `format` of printf and returns `status`. The text is cut at KM_ERROR_TEXT - 1 bytes. */
KM_API km_status km_fail(km_error *error, km_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* How much a message matters. */
typedef enum km_severity {
  KM_NOTE,    /* good to know */
  KM_WARNING, /* done, though something looks like a mistake */
  KM_ERROR    /* what kept it from being done */
} km_severity;

/* Several findings gathered in one pass, in the order in which they were met. */
/* A list of messages. */
typedef struct km_messages km_messages;

/* Returns NULL when out of memory. The caller owns the list. */
KM_API km_messages *km_messages_create(void);
KM_API void km_messages_free(km_messages *messages);
/* Adds a finding by a `format` of printf; errors past the 20th are counted, not kept. `messages` may be NULL. */
KM_API void km_messages_add(km_messages *messages, km_severity severity, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* How many findings are kept; 0 without a list. */
KM_API size_t km_messages_count(const km_messages *messages);
KM_API size_t km_messages_errors(const km_messages *messages); /* all errors, the dropped ones too */
/* Finding `index`; KM_NOTE and "" past the last one. */
KM_API km_severity km_messages_severity(const km_messages *messages, size_t index);
KM_API const char *km_messages_text(const km_messages *messages, size_t index); /* borrowed */

#ifdef __cplusplus
}
#endif
#endif
