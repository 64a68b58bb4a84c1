/* Store of a study: the answers of all requests for all designs, in one SQLite file. Private to study/. */
#ifndef KM_STUDY_RESULT_STORE_H
#define KM_STUDY_RESULT_STORE_H

#include "study/design_study.h"

/* Opens or creates the file; path NULL or ":memory:": in memory. `identity` (hash) and `what` (text) identify the
 * study. A read-only file is opened for reading; writing to it returns KM_IO. KM_USAGE: another study's; KM_IO:
 * unreadable, damaged, or in use by another run. The caller frees `*out`. O(bytes of the file) for SQLite's
 * integrity check. */
km_status km_store_open(const char *path, const char *identity, const char *what, bool replace, km_entry_store **out,
                        km_error *error);
void km_store_free(km_entry_store *store);

/* Finds or creates the number of a request, by the hash of all inputs of its answers. */
km_status km_store_question(km_entry_store *store, const char *key, const char *name, int *id, km_error *error);
/* True in *empty if there are no results. */
km_status km_store_is_empty(const km_entry_store *store, bool *empty, km_error *error);
/* Sizes of the results of a request. */
typedef struct km_store_shape {
  int question, parameters, figures, band_numbers;
} km_store_shape;
/* Reads the answer for a design into `out`, whose figures and bands must be allocated. *found false: no answer. */
km_status km_store_get(km_entry_store *store, const km_store_shape *shape, const double *values, km_design_answer *out,
                       bool *found, km_error *error);
/* Writes an answer in the open transaction, which begins with the first one. */
km_status km_store_put(km_entry_store *store, const km_store_shape *shape, const double *values,
                       const km_design_answer *answer, km_error *error);
/* Commits: the results written so far survive the end of the process. */
km_status km_store_commit(km_entry_store *store, km_error *error);
/* Switches to appending, which needs far less writing for many designs; no effect in memory. Appended answers can't
 * be looked up before km_store_sort, which takes O(n log n). If the process ends earlier, the next one that opens
 * the store sorts them. */
void km_store_append(km_entry_store *store);
km_status km_store_sort(km_entry_store *store, km_error *error);

#endif
