/* The store of a study: what each question said of each design, in one SQLite file. Private to study/. */
#ifndef KM_STUDY_RESULT_STORE_H
#define KM_STUDY_RESULT_STORE_H

#include "study/design_study.h"

/* Opens the file, or makes it; path NULL or ":memory:": in memory. `identity` and `what` (in words) tell whose results these are.
 * A file that can't be written is opened for reading: what is put there then is KM_IO. KM_USAGE: another study's; KM_IO: unreadable,
 * damaged, or written by another run. The caller frees `*out`. O(bytes of the file), of SQLite's integrity check. */
km_status km_store_open(const char *path, const char *identity, const char *what, bool replace, km_entry_store **out,
                        km_error *error);
void km_store_free(km_entry_store *store);

/* The number of a question by the hash of all that its answers depend on. */
km_status km_store_question(km_entry_store *store, const char *key, const char *name, int *id, km_error *error);
/* Are there no results yet? */
km_status km_store_is_empty(const km_entry_store *store, bool *empty, km_error *error);
/* How much of a kind of result there is: bands[band_numbers] only where the question keeps some. */
typedef struct km_store_shape {
  int question, parameters, figures, band_numbers;
} km_store_shape;
/* The answer about a design; its figures and bands must have room. `*found` false: it isn't there. */
km_status km_store_get(km_entry_store *store, const km_store_shape *shape, const double *values, km_design_answer *out,
                       bool *found, km_error *error);
/* Puts an answer into the open transaction, which begins with the first one. */
km_status km_store_put(km_entry_store *store, const km_store_shape *shape, const double *values,
                       const km_design_answer *answer, km_error *error);
/* What was put so far is safe when the process ends, however it ends. */
km_status km_store_commit(km_entry_store *store, km_error *error);
/* From here on answers are put at the end of the store, which for many designs takes far less writing; in memory they are put in
 * their places all the same. They can't be looked up before km_store_sort, which takes O(n log n); where a process ends before,
 * the next one that opens the store sorts them. */
void km_store_append(km_entry_store *store);
km_status km_store_sort(km_entry_store *store, km_error *error);

#endif
