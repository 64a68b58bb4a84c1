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

/* Result of a fallible function; 0 is success. */
typedef enum km_status {
  KM_OK = 0,    /* done */
  KM_PARTIAL,   /* done in part: the result holds that part */
  KM_NO_RESULT, /* done: no result exists, the output is empty */
  KM_USAGE,     /* an argument is missing, out of range, or belongs to another object */
  KM_IO,        /* a file can't be read or written */
  KM_MODEL,     /* the model is bad: syntax, contents, or loops that can't close */
  KM_DIVERGED,  /* an iteration didn't converge */
  KM_CANCELLED, /* the progress callback returned false */
  KM_MEMORY,    /* out of memory */
  KM_INTERNAL   /* a broken invariant of the library */
} km_status;

enum {
  KM_ERROR_TEXT = 1024 /* bytes of a text, the NUL included */
};

/* One failure as text: location, found, expected. Owned by the caller. */
typedef struct km_error {
  km_status status;         /* status that the call returned */
  char text[KM_ERROR_TEXT]; /* one line, without the name of a program */
} km_error;

/* Fills `error` (may be NULL) by a `format` of printf and returns `status`. The text is cut at KM_ERROR_TEXT - 1
 * bytes. */
KM_API km_status km_fail(km_error *error, km_status status, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;

/* Severity of a message. */
typedef enum km_severity {
  KM_NOTE,    /* information */
  KM_WARNING, /* done, but the input is probably wrong */
  KM_ERROR    /* the operation failed */
} km_severity;

/* A list of messages in the order in which they were added. */
typedef struct km_messages km_messages;

/* Returns NULL when out of memory. The caller owns the list. */
KM_API km_messages *km_messages_create(void);
KM_API void km_messages_free(km_messages *messages);
/* Adds a message by a `format` of printf. Errors after the 20th are counted, not kept. `messages` may be NULL. */
KM_API void km_messages_add(km_messages *messages, km_severity severity, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 3, 4)))
#endif
    ;
/* Number of messages that are kept; 0 without a list. */
KM_API size_t km_messages_count(const km_messages *messages);
KM_API size_t km_messages_errors(const km_messages *messages); /* number of all errors, kept or not */
/* Message `index`; KM_NOTE and "" after the last one. */
KM_API km_severity km_messages_severity(const km_messages *messages, size_t index);
KM_API const char *km_messages_text(const km_messages *messages, size_t index); /* borrowed */

/* ---- Memory. The library allocates through these functions only, so that tests can observe allocations and make
 * them fail. */

/* Zeroed; NULL when out of memory. O(bytes). */
KM_API void *km_alloc(size_t count, size_t size);
/* Resizes a block (NULL: allocates one); added bytes aren't zeroed. NULL when out of memory; the block is then
 * unchanged. */
KM_API void *km_resize(void *block, size_t count, size_t size);
/* Frees a block of km_alloc, km_resize or km_reserve. NULL is legal. */
KM_API void km_free(void *block);

/* A zeroed array of `count` elements of a type. */
#define KM_NEW(type, count) ((type *)km_alloc((count), sizeof(type)))

/* Memory that is freed at once. Start from {0}, allocate everything, then check `failed` once. */
typedef struct km_arena {
  struct km_arena_block *block; /* private */
  bool failed;                  /* an allocation has failed; never reset */
} km_arena;

/* Zeroed, aligned to 64 bytes. NULL when out of memory; `failed` then stays set. */
KM_API void *km_arena_alloc(km_arena *arena, size_t count, size_t size);
/* A copy of `text`; NULL gives NULL. */
KM_API char *km_arena_string(km_arena *arena, const char *text);
KM_API void km_arena_free(km_arena *arena);

/* A zeroed array of `count` elements of a type in an arena. */
#define KM_ARENA_NEW(arena, type, count) ((type *)km_arena_alloc((arena), (count), sizeof(type)))

/* Grows the array `*data` and its `*capacity` to at least `need` elements of `size` bytes. False when out of memory;
 * the array is then unchanged. km_free frees the array. */
KM_API bool km_reserve(void **data, size_t *capacity, size_t need, size_t size);

/* ---- Bytes that a function returns, such as the contents of a file. */

/* A block of bytes, followed by a NUL that `size` doesn't count. */
typedef struct km_bytes {
  char *data;  /* owned by the caller, freed by km_bytes_free */
  size_t size; /* number of bytes, the closing NUL not counted */
} km_bytes;
/* Frees the bytes and resets the structure to {0}. */
KM_API void km_bytes_free(km_bytes *bytes);

/* ---- A growing text, and numbers as text. */

/* A text that grows. A NUL that `size` doesn't count follows the bytes. Start from {0}. */
typedef struct km_text {
  char *data;            /* the bytes; NULL while the text is empty */
  size_t size, capacity; /* bytes without the closing NUL; bytes allocated */
  bool failed;           /* memory ran out: the text is incomplete; never reset */
} km_text;

KM_API void km_text_free(km_text *text);
/* Moves the text into an arena and frees it. "" when out of memory; the arena's `failed` is then set. */
KM_API const char *km_text_move_to_arena(km_text *text, km_arena *arena);
/* Moves the text to `*out` and leaves it empty. KM_MEMORY if the text has failed. */
KM_API km_status km_text_move_to_bytes(km_text *text, km_bytes *out, km_error *error);
/* Append bytes, a `string`, a `format` of printf. O(bytes). */
KM_API void km_text_bytes(km_text *text, const void *bytes, size_t size);
KM_API void km_text_add(km_text *text, const char *string);
KM_API void km_text_format(km_text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Appends UTF-8 with control characters and bidirectional controls written as \u001b, so that a terminal or a page
 * shows them and doesn't execute them. Line ends and tabs are kept. */
KM_API void km_text_visible(km_text *text, const char *bytes, size_t size);
/* Appends bytes in base64 (RFC 4648) with padding. */
KM_API void km_text_base64(km_text *text, const void *bytes, size_t size);
/* Appends the shortest decimal text of `value` that reads back to the same double, with a decimal point in every
 * locale; inf, -inf, nan. */
KM_API void km_text_number(km_text *text, double value);

enum {
  KM_NUMBER_TEXT = 48 /* bytes of the longest number, the NUL included */
};
/* Writes `value` as km_text_number does into a buffer. Returns the length. */
KM_API size_t km_number_format(char out[KM_NUMBER_TEXT], double value);

/* ---- Files. */

/* Appends the bytes of a file to `out`; "-" is the standard input. KM_IO with the system's reason. O(bytes). */
KM_API km_status km_file_read(const char *path, km_text *out, km_error *error);
/* Writes a file atomically: a temporary file in its folder is renamed. "-" is the standard output. KM_IO. O(bytes). */
KM_API km_status km_file_write(const char *path, const km_text *bytes, km_error *error);

/* ---- Suggestions for a name that isn't known: the known names with the smallest edit distance. */

enum {
  KM_NEAREST = 4 /* number of names that are kept */
};
/* The names nearest to `wanted` among those added. Start from {.wanted = …}. Names are borrowed. */
typedef struct km_nearest {
  const char *wanted; /* the unknown name */
  int count;
  const char *names[KM_NEAREST]; /* [count], nearest first */
  size_t distance[KM_NEAREST];   /* [count], edit distances in bytes */
} km_nearest;

/* Keeps `name` if its edit distance to `wanted` is among the smallest. O(bytes²). */
KM_API void km_nearest_add(km_nearest *nearest, const char *name);

enum {
  KM_NEAREST_TEXT = 256 /* bytes of the text, the NUL included */
};
/* Writes `"a", "b"`, nearest first, or "none". Returns `out`. */
KM_API const char *km_nearest_text(const km_nearest *nearest, char out[KM_NEAREST_TEXT]);

/* ---- Progress of long work, and its cancellation. */

/* Called during long work with the share that is done (0 … 1). False cancels the work, which then returns
 * KM_CANCELLED. Called from the thread that called the library. NULL is legal everywhere: no progress is reported. */
typedef bool (*km_progress)(void *context, double done);

/* A stage of longer work, of one call or of several that follow each other. */
typedef struct km_progress_stage {
  km_progress progress; /* callback of the whole work; NULL: none */
  void *context;        /* passed to it */
  double from, to;      /* share of the whole work that is done when the stage begins, and when it ends */
  double reported;      /* largest share reported so far; 0 at the beginning of the whole work */
} km_progress_stage;

/* Begins the next stage: from the end of the present one to the share `to` of the whole work. */
KM_API void km_progress_stage_next(km_progress_stage *stage, double to);

/* A km_progress whose context is a km_progress_stage: reports from + (to − from) `done` of the whole work, but never
 * less than before, also where `from` and `to` have changed. Returns true without a callback or without a stage. */
KM_API bool km_progress_stage_report(void *stage, double done);

/* ---- Independent pieces of work on several threads. */

/* Calls work(context, i) once for each i < `count` on up to `jobs` threads (1: the caller's thread). The calls must
 * not share data that they change; then results don't depend on `jobs`. */
KM_API void km_parallel_for(int count, int jobs, void (*work)(void *context, int index), void *context);

#ifdef __cplusplus
}
#endif
#endif
