/* Foundations: visibility of symbols, status and errors, memory, files, text, suggestions for misspelt names,
 * progress callbacks, threads. */
#ifndef KMECH_BASE_H
#define KMECH_BASE_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Marks an exported symbol: the shared library hides all others. */
#if defined(__GNUC__)
#define KM_API __attribute__((visibility("default")))
#else
#define KM_API
#endif

/* ---- Status codes, errors and messages: one convention for the whole library. */

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

/* ---- Memory as the library allocates it: all of its allocation goes through here, so that it can be observed and failed. */

/* Zeroed; NULL when out of memory. O(bytes). */
KM_API void *km_alloc(size_t count, size_t size);
/* Another size for a block (NULL: none yet); what is new isn't zeroed. NULL when out of memory: the block stays. */
KM_API void *km_resize(void *block, size_t count, size_t size);
/* Frees a block of km_alloc, km_resize or km_reserve. NULL is legal. */
KM_API void km_free(void *block);

/* Zeroed room for `count` of a type. */
#define KM_NEW(type, count) ((type *)km_alloc((count), sizeof(type)))

/* Memory that lives and dies together. Start from {0}, allocate everything, then ask once whether it failed. */
typedef struct km_arena {
  struct km_arena_block *block; /* of the library */
  bool failed;                  /* an allocation has failed; nothing resets it */
} km_arena;

/* Zeroed, aligned to 64 bytes. NULL when out of memory; `failed` then stays set. */
KM_API void *km_arena_alloc(km_arena *arena, size_t count, size_t size);
/* A copy of a text; NULL gives NULL. */
KM_API char *km_arena_string(km_arena *arena, const char *text);
KM_API void km_arena_free(km_arena *arena);

/* The same in an arena. */
#define KM_ARENA_NEW(arena, type, count) ((type *)km_arena_alloc((arena), (count), sizeof(type)))

/* Grows `*data`, which km_free frees, and its `*capacity` to hold at least `need` elements; false when out of memory (data unchanged). */
KM_API bool km_reserve(void **data, size_t *capacity, size_t need, size_t size);

/* ---- Bytes that the library hands over: the contents of a file. */

/* Ended by a NUL that `size` doesn't count. */
typedef struct km_bytes {
  char *data;  /* the caller's, freed by km_bytes_free */
  size_t size; /* without the closing NUL */
} km_bytes;
/* Frees what `bytes` holds, and empties it. */
KM_API void km_bytes_free(km_bytes *bytes);

/* ---- A growing text, and numbers as text. */

/* Bytes are followed by a NUL that `size` doesn't count. `failed` is sticky (out of memory). Start from {0}. */
typedef struct km_text {
  char *data;            /* the bytes, NULL while there are none */
  size_t size, capacity; /* without the closing NUL; room */
  bool failed;           /* memory ran out: the text isn't whole */
} km_text;

KM_API void km_text_free(km_text *text);
/* Moves the text into an arena, whose failure it shares, and frees it. "" when out of memory. */
KM_API const char *km_text_keep(km_text *text, km_arena *arena);
/* Hands the text over, and leaves an empty one. KM_MEMORY if it failed. */
KM_API km_status km_text_give(km_text *text, km_bytes *out, km_error *error);
/* Each appends: bytes, a `string`, a `format` of printf. O(bytes). */
KM_API void km_text_bytes(km_text *text, const void *bytes, size_t size);
KM_API void km_text_add(km_text *text, const char *string);
KM_API void km_text_format(km_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Bytes of UTF-8 in which control characters and those that turn the direction of writing are written as \u001b: a terminal or a page then
 * shows them and doesn't obey them. Line ends and tabs stay. */
KM_API void km_text_visible(km_text *text, const char *bytes, size_t size);
/* Bytes in base64 (RFC 4648), with padding. */
KM_API void km_text_base64(km_text *text, const void *bytes, size_t size);
/* The shortest decimal text of a `value` that reads back to the same double, in the C locale whatever the process's locale is; inf,
 * -inf, nan. */
KM_API void km_text_number(km_text *text, double value);

enum {
  KM_NUMBER_TEXT = 48 /* bytes of the longest number, the NUL included */
};
/* The same of a `value` into a buffer. Returns the length. */
KM_API size_t km_number_format(char out[KM_NUMBER_TEXT], double value);

/* ---- Whole files in and out. */

/* Appends the file's bytes; "-" is the standard input. KM_IO with the system's reason. O(bytes). */
KM_API km_status km_file_read(const char *path, km_text *out, km_error *error);
/* Writes the file whole or not at all: a temporary beside it, then a rename. "-" is the standard output. KM_IO. O(bytes). */
KM_API km_status km_file_write(const char *path, const km_text *bytes, km_error *error);

/* ---- Which known names are nearest to one that isn't known: for messages that suggest them. */

enum {
  KM_NEAREST = 4 /* how many names are kept */
};
/* The few nearest names to `wanted` among those that are offered; start from {.wanted = …}. Names are borrowed. */
typedef struct km_nearest {
  const char *wanted; /* the name that isn't known */
  int count;
  const char *names[KM_NEAREST]; /* [count] nearest first */
  size_t distance[KM_NEAREST];   /* [count] edits from `wanted` */
} km_nearest;

/* By edit distance in bytes. O(bytes²). */
KM_API void km_nearest_add(km_nearest *nearest, const char *name);

enum {
  KM_NEAREST_TEXT = 256 /* bytes of the text, the NUL included */
};
/* `"a", "b"`: nearest first; "none" where none was offered. Returns `out`. */
KM_API const char *km_nearest_text(const km_nearest *nearest, char out[KM_NEAREST_TEXT]);

/* ---- How long work tells how far it is, and is stopped. */

/* Asked now and then during long work with how much is done (0 … 1); returns false to cancel: the work then ends with
 * KM_CANCELLED. Called from the thread that called the library. Wherever it is taken NULL is legal: nobody asks. */
typedef bool (*km_progress)(void *context, double done);

/* ---- Independent pieces of work on several threads. */

/* Calls work(context, i) once for every i below `count`, on up to `jobs` threads (1: on the caller's). Pieces must not
 * share anything that they change; then the results don't depend on `jobs`. */
KM_API void km_parallel_for(int count, int jobs, void (*work)(void *context, int index), void *context);

#ifdef __cplusplus
}
#endif
#endif
