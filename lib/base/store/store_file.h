/* One SQLite file with the results of long work: the code that all stores share.
 *
 * One connection holds the file exclusively while it is open. A write-ahead log keeps every committed transaction,
 * whatever ends the process. The table named by `kind` has the identity of the work, a hash of all its inputs. */
#ifndef KM_BASE_STORE_FILE_H
#define KM_BASE_STORE_FILE_H

#include "base/memory.h"
#include "base/text.h"

/* Definition of a kind of store. */
typedef struct km_store_kind {
  const char *kind;   /* the work, in messages: "study"; also a table's name */
  const char *schema; /* creates the other tables */
  const char *drop;   /* removes them */
} km_store_kind;

typedef struct km_store_file {
  struct sqlite3 *db;
  const km_store_kind *of;
  const char *path; /* name of the file in messages */
  bool in_memory;   /* no file */
  bool read_only;   /* the file is read-only */
  bool writing;     /* a transaction is open */
  km_arena arena;
} km_store_file;

/* Opens or creates the file; path NULL or ":memory:": in memory. `identity` (hash) and `what` (text) identify the work.
 * `replace`: results of other work are deleted. A read-only file is opened for reading. KM_USAGE: results of other
 * work; KM_IO: unreadable, damaged, or in use by another run. Close it in any case. O(bytes of the file) for SQLite's
 * integrity check. */
km_status km_store_file_open(km_store_file *file, const char *path, const km_store_kind *kind, const char *identity,
                             const char *what, bool replace, km_error *error);
/* Commits and closes. Statements must be finalised before. */
void km_store_file_close(km_store_file *file);
/* Reports the last error of SQLite, or of memory. */
km_status km_store_file_fail(const km_store_file *file, km_error *error);
/* Reports that a read-only file would be written. */
km_status km_store_file_fail_to_write(const km_store_file *file, km_error *error);
/* Executes statements without parameters. */
km_status km_store_file_run(const km_store_file *file, const char *sql, km_error *error);
/* Executes a statement with two bound texts. */
km_status km_store_file_insert(const km_store_file *file, const char *sql, const char *a, const char *b,
                               km_error *error);
/* Text that a statement with one bound text (NULL: none) returns, in the file's memory; NULL: no row. */
const char *km_store_file_text(km_store_file *file, const char *sql, const char *bound);
/* Begins a transaction if none is open. */
km_status km_store_file_begin(km_store_file *file, km_error *error);
/* Commits the open transaction, if there is one: what was written survives the end of the process. */
km_status km_store_file_commit(km_store_file *file, km_error *error);

/* Append to a text whose hash is an identity or key: a name with its length, so that lists of names are unambiguous;
 * numbers, to the last digit; the hash of bytes. */
void km_identity_add_name(km_text *out, const char *name);
void km_identity_add_numbers(km_text *out, const double *numbers, int count);
void km_identity_add_bytes(km_text *out, const void *bytes, size_t size);

#endif
