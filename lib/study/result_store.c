/* Store of a study in an SQLite file. The key of a result is the hash of its request and the design's parameter
 * values, so an extended study finds its earlier results. One connection holds the file exclusively while it is
 * open.
 *
 * Keys of samples come in no order, so a commit of many results would change almost every page of a table sorted by
 * them. Runs of many designs therefore append results to a second table, which is sorted into the first one when it
 * has grown by a fraction of what was sorted before. In memory, results go to a hash table. */
#include "study/result_store.h"

#include "kmech/base.h"
#include "study/answer_cache.h"

#include <fcntl.h>
#include <libgen.h>
#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Bytes of appended results before they are sorted for the first time. */
static const double first_appended = 1 << 20;

struct km_entry_store {
  sqlite3 *db;
  sqlite3_stmt *get, *put, *append;
  const char *path;              /* name of the file in messages */
  bool in_memory;                /* no file: answers are in `cache` */
  bool read_only;                /* the file is read-only */
  bool writing;                  /* a transaction is open */
  bool appends;                  /* results are appended and sorted later */
  double appended, max_appended; /* approximate bytes that wait to be sorted; largest number allowed */
  km_answer_cache cache;
  km_arena arena;
};

static const char schema[] =
    "CREATE TABLE study(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;"
    "CREATE TABLE questions(id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, name TEXT NOT NULL);"
    "CREATE TABLE results(question INTEGER NOT NULL, design BLOB NOT NULL, outcome INTEGER NOT NULL, reason TEXT,"
    " figures BLOB NOT NULL, bands BLOB, PRIMARY KEY(question, design)) WITHOUT ROWID;";
/* table for appended results; stores of earlier versions don't have it */
static const char appended_schema[] =
    "CREATE TABLE IF NOT EXISTS appended(question INTEGER NOT NULL, design BLOB NOT NULL, outcome INTEGER NOT NULL,"
    " reason TEXT, figures BLOB NOT NULL, bands BLOB);";

static km_status fail_to_write(const km_entry_store *s, km_error *error) {
  return km_fail(error, KM_IO, "%s: the store can't be written, only shown and exported", s->path);
}

/* Reports an error of SQLite. */
static km_status fail(const km_entry_store *s, km_error *error) {
  if (s->arena.failed)
    return km_fail(error, KM_MEMORY, "out of memory for the store %s", s->path);
  int code = s->db ? sqlite3_extended_errcode(s->db) : SQLITE_NOMEM;
  const char *reason = s->db ? sqlite3_errmsg(s->db) : "out of memory";
  if ((code & 0xff) == SQLITE_NOMEM)
    return km_fail(error, KM_MEMORY, "out of memory for the store %s", s->path);
  if ((code & 0xff) == SQLITE_BUSY || (code & 0xff) == SQLITE_LOCKED)
    return km_fail(error, KM_IO,
                   "%s: another run is using this store; expected to wait until it has ended, or to stop it", s->path);
  if ((code & 0xff) == SQLITE_NOTADB || (code & 0xff) == SQLITE_CORRUPT)
    return km_fail(error, KM_IO, "%s: this is no store of a study, or a damaged one (%s)", s->path, reason);
  if ((code & 0xff) == SQLITE_READONLY)
    return fail_to_write(s, error);
  return km_fail(error, KM_IO, "%s: the store can't be used: %s", s->path, reason);
}

static km_status run(const km_entry_store *s, const char *sql, km_error *error) {
  return sqlite3_exec(s->db, sql, NULL, NULL, NULL) == SQLITE_OK ? KM_OK : fail(s, error);
}

/* Text that a statement with one bound text returns, in the store's memory; NULL: no row. */
static const char *query_text(km_entry_store *s, const char *sql, const char *bound) {
  sqlite3_stmt *statement = NULL;
  const char *text = NULL;
  if (sqlite3_prepare_v2(s->db, sql, -1, &statement, NULL) == SQLITE_OK) {
    if (bound)
      sqlite3_bind_text(statement, 1, bound, -1, SQLITE_STATIC);
    if (sqlite3_step(statement) == SQLITE_ROW)
      text = km_arena_string(&s->arena, (const char *)sqlite3_column_text(statement, 0));
  }
  sqlite3_finalize(statement);
  return text;
}

/* Executes a statement with two bound texts. */
static km_status insert(const km_entry_store *s, const char *sql, const char *a, const char *b, km_error *error) {
  sqlite3_stmt *statement = NULL;
  int code = sqlite3_prepare_v2(s->db, sql, -1, &statement, NULL);
  if (code == SQLITE_OK) {
    sqlite3_bind_text(statement, 1, a, -1, SQLITE_STATIC);
    sqlite3_bind_text(statement, 2, b, -1, SQLITE_STATIC);
    code = sqlite3_step(statement);
  }
  sqlite3_finalize(statement);
  return code == SQLITE_DONE ? KM_OK : fail(s, error);
}

/* Creates the tables of an empty file; checks that existing results belong to the same study. */
static km_status adopt_file(km_entry_store *s, const char *identity, const char *what, bool replace, km_error *error) {
  const char *tables = query_text(s, "SELECT count(*) FROM sqlite_master", NULL);
  if (!tables)
    return fail(s, error);
  const char *ours = query_text(s, "SELECT value FROM study WHERE key = ?", "identity");
  if (s->arena.failed)
    return fail(s, error);
  if (s->read_only && !ours)
    return km_fail(error, KM_IO, "%s: this is no store of a study, or a damaged one", s->path);
  if (strcmp(tables, "0") != 0 && !ours)
    return km_fail(error, KM_IO, "%s: this is a database, but no store of a study", s->path);
  if (ours && strcmp(ours, identity) == 0)
    return KM_OK;
  if (ours && !replace) {
    const char *theirs = query_text(s, "SELECT value FROM study WHERE key = ?", "what");
    return km_fail(error, KM_USAGE,
                   "%s: the store holds the results of another study: %.300s; expected those of %.300s", s->path,
                   theirs ? theirs : "", what);
  }
  km_status status = run(s, "BEGIN IMMEDIATE", error);
  if (!status && ours)
    status = run(s, "DROP TABLE IF EXISTS appended; DROP TABLE results; DROP TABLE questions; DROP TABLE study", error);
  if (!status)
    status = run(s, schema, error);
  if (!status)
    status = insert(s, "INSERT INTO study VALUES(?, ?)", "identity", identity, error);
  if (!status)
    status = insert(s, "INSERT INTO study VALUES(?, ?)", "what", what, error);
  return status ? status : run(s, "COMMIT", error);
}

/* Prepares the statements for reading and writing results. */
static km_status prepare(km_entry_store *s, km_error *error) {
  static const char get[] = "SELECT outcome, reason, figures, bands FROM results WHERE question = ? AND design = ?";
  static const char put[] = "INSERT OR REPLACE INTO results VALUES(?, ?, ?, ?, ?, ?)";
  static const char append[] = "INSERT INTO appended VALUES(?, ?, ?, ?, ?, ?)";
  if (s->read_only)
    return sqlite3_prepare_v3(s->db, get, -1, SQLITE_PREPARE_PERSISTENT, &s->get, NULL) == SQLITE_OK ? KM_OK
                                                                                                     : fail(s, error);
  bool is_ok = sqlite3_prepare_v3(s->db, get, -1, SQLITE_PREPARE_PERSISTENT, &s->get, NULL) == SQLITE_OK &&
               sqlite3_prepare_v3(s->db, put, -1, SQLITE_PREPARE_PERSISTENT, &s->put, NULL) == SQLITE_OK &&
               sqlite3_prepare_v3(s->db, append, -1, SQLITE_PREPARE_PERSISTENT, &s->append, NULL) == SQLITE_OK;
  return is_ok ? KM_OK : fail(s, error);
}

/* Begins a transaction if none is open. */
static km_status begin_transaction(km_entry_store *s, km_error *error) {
  km_status status = s->writing ? KM_OK : run(s, "BEGIN IMMEDIATE", error);
  s->writing = s->writing || !status;
  return status;
}

/* Sorts the appended results into the table; of two answers for one design the later one remains. */
static km_status sort_appended(km_entry_store *s, km_error *error) {
  static const char sort[] = "INSERT OR REPLACE INTO results SELECT * FROM appended ORDER BY question, design, rowid;"
                             "DELETE FROM appended";
  km_status status = begin_transaction(s, error);
  s->appended = 0.0;
  return status ? status : run(s, sort, error);
}

/* Sorts the results that a killed run left. */
static km_status sort_leftover(km_entry_store *s, km_error *error) {
  const char *left = query_text(s, "SELECT 1 FROM appended LIMIT 1", NULL);
  if (s->arena.failed)
    return fail(s, error);
  km_status status = left ? sort_appended(s, error) : KM_OK;
  return status ? status : km_store_commit(s, error);
}

/* As sort_leftover for a read-only file: a temporary table replaces the file's. */
static km_status sort_in_memory(km_entry_store *s, km_error *error) {
  static const char sort[] =
      "CREATE TEMP TABLE results(question INTEGER NOT NULL, design BLOB NOT NULL, outcome INTEGER NOT NULL, reason TEXT,"
      " figures BLOB NOT NULL, bands BLOB, PRIMARY KEY(question, design)) WITHOUT ROWID;"
      "INSERT INTO temp.results SELECT * FROM main.results;"
      "INSERT OR REPLACE INTO temp.results SELECT * FROM main.appended ORDER BY question, design, rowid";
  const char *left = query_text(s, "SELECT 1 FROM main.appended LIMIT 1", NULL);
  if (s->arena.failed)
    return fail(s, error);
  return left ? run(s, sort, error) : KM_OK;
}

/* True if the file or its folder (for the write-ahead log) can't be written. */
static bool is_read_only(const char *path, const char *folder) {
  return faccessat(AT_FDCWD, path, F_OK, AT_EACCESS) == 0 &&
         (faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) != 0 || faccessat(AT_FDCWD, folder, W_OK, AT_EACCESS) != 0);
}

/* Opens a read-only file by a URI with `immutable`, because locks and the log would need writing. */
static km_status open_read_only(km_entry_store *s, km_error *error) {
  struct stat log;
  km_text name = {0};
  km_text_format(&name, "%s-wal", s->path);
  bool pending = !name.failed && stat(name.data, &log) == 0 && log.st_size > 0;
  name.size = 0;
  km_text_add(&name, "file:");
  for (const char *c = s->path; *c; ++c)
    km_text_format(&name, strchr("%?#", *c) ? "%%%02X" : "%c", (unsigned char)*c);
  km_text_add(&name, "?immutable=1");
  km_status status =
      name.failed ? km_fail(error, KM_MEMORY, "out of memory for the store %s", s->path)
      : pending   ? km_fail(error, KM_IO,
                            "%s: the store can't be written, and a part of it waits in %s-wal; expected a copy of both "
                              "in a folder that can be written",
                            s->path, s->path)
      : sqlite3_open_v2(name.data, &s->db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, NULL) == SQLITE_OK ? KM_OK
                                                                                                      : fail(s, error);
  km_text_free(&name);
  return status;
}

/* Checks for damage of pages, their order and links; a changed number isn't detected. O(bytes of the file). */
static km_status check_integrity(km_entry_store *s, km_error *error) {
  const char *found = s->in_memory ? "ok" : query_text(s, "PRAGMA integrity_check(1)", NULL);
  if (!found)
    return fail(s, error);
  if (strcmp(found, "ok") == 0)
    return KM_OK;
  return km_fail(error, KM_IO,
                 "%s: the store is damaged (%.200s); expected a copy of it, or the study run again without it", s->path,
                 found);
}

/* Opens the file with an exclusive lock and a write-ahead log. */
static km_status open_file(km_entry_store *s, const char *folder, km_error *error) {
  s->read_only = !s->in_memory && is_read_only(s->path, folder);
  if (s->read_only)
    return open_read_only(s, error);
  if (sqlite3_open(s->in_memory ? ":memory:" : s->path, &s->db) != SQLITE_OK)
    return fail(s, error);
  sqlite3_extended_result_codes(s->db, 1);
  /* write-ahead log: a commit doesn't wait for the disk and survives the end of the process */
  km_status status =
      run(s, "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL", error);
  return status ? status : run(s, "BEGIN IMMEDIATE; COMMIT", error); /* takes the exclusive lock */
}

km_status km_store_open(const char *path, const char *identity, const char *what, bool replace, km_entry_store **out,
                        km_error *error) {
  km_entry_store *s = *out = KM_NEW(km_entry_store, 1);
  if (!s)
    return km_fail(error, KM_MEMORY, "out of memory for a store");
  s->path = km_arena_string(&s->arena, path ? path : "in memory");
  s->in_memory = !path || strcmp(path, ":memory:") == 0;
  s->max_appended = first_appended;
  char *folder = km_arena_string(&s->arena, s->path);
  if (!folder)
    return km_fail(error, KM_MEMORY, "out of memory for a store");
  km_status status = open_file(s, dirname(folder), error);
  if (!status)
    status = check_integrity(s, error);
  if (!status)
    status = adopt_file(s, identity, what, replace, error);
  if (!status && !s->read_only)
    status = run(s, appended_schema, error);
  if (!status)
    status = s->read_only ? sort_in_memory(s, error) : sort_leftover(s, error);
  return status ? status : prepare(s, error);
}

void km_store_free(km_entry_store *s) {
  if (!s)
    return;
  if (s->writing)
    sqlite3_exec(s->db, "COMMIT", NULL, NULL, NULL);
  sqlite3_finalize(s->get);
  sqlite3_finalize(s->put);
  sqlite3_finalize(s->append);
  sqlite3_close(s->db);
  km_answer_cache_free(&s->cache);
  km_arena_free(&s->arena);
  km_free(s);
}

km_status km_store_question(km_entry_store *s, const char *key, const char *name, int *id, km_error *error) {
  static const char find[] = "SELECT id FROM questions WHERE key = ?";
  const char *text = query_text(s, find, key);
  km_status status = s->arena.failed ? fail(s, error) : KM_OK;
  *id = 0; /* no request: a read-only store without it has no answers to it */
  if (!status && !text && s->read_only)
    return KM_OK;
  if (!status && !text)
    status = insert(s, "INSERT INTO questions(key, name) VALUES(?, ?)", key, name, error);
  if (!status && !text)
    text = query_text(s, find, key);
  *id = text ? (int)strtol(text, NULL, 10) : 0;
  return status || text ? status : fail(s, error);
}

km_status km_store_is_empty(const km_entry_store *s, bool *empty, km_error *error) {
  sqlite3_stmt *statement = NULL;
  if (s->in_memory) {
    *empty = s->cache.count == 0;
    return KM_OK;
  }
  int code = sqlite3_prepare_v2(s->db, "SELECT 1 FROM results LIMIT 1", -1, &statement, NULL);
  if (code == SQLITE_OK)
    code = sqlite3_step(statement);
  sqlite3_finalize(statement);
  *empty = code == SQLITE_DONE;
  return code == SQLITE_DONE || code == SQLITE_ROW ? KM_OK : fail(s, error);
}

static void bind_numbers(sqlite3_stmt *statement, int index, const double *numbers, int count) {
  /* no parameters: an empty blob is bound, not NULL */
  sqlite3_bind_blob(statement, index, count ? (const void *)numbers : "", count * (int)sizeof *numbers, SQLITE_STATIC);
}

static bool copy_numbers(sqlite3_stmt *statement, int column, double *out, int count) {
  const void *blob = sqlite3_column_blob(statement, column);
  if (sqlite3_column_type(statement, column) != SQLITE_BLOB ||
      sqlite3_column_bytes(statement, column) != count * (int)sizeof *out)
    return false;
  if (count > 0)
    memcpy(out, blob, (size_t)count * sizeof *out);
  return true;
}

/* Normalises a key: one bit pattern for NaN and one for zero. */
static void key_of(const double *values, int count, double *out) {
  for (int i = 0; i < count; ++i)
    out[i] = isnan(values[i]) ? nan("") : values[i] == 0.0 ? 0.0 : values[i];
}

/* Reads an answer. False: the row is damaged and is computed again. */
static bool read_answer(sqlite3_stmt *row, const km_store_shape *shape, km_design_answer *out) {
  const unsigned char *reason = sqlite3_column_text(row, 1);
  int outcome = sqlite3_column_int(row, 0);
  if (sqlite3_column_type(row, 0) != SQLITE_INTEGER || outcome < 0 || outcome >= KM_DESIGN_MISSING ||
      !copy_numbers(row, 2, out->figures, shape->figures))
    return false;
  out->outcome = (km_design_outcome)outcome;
  snprintf(out->reason, sizeof out->reason, "%s", reason ? (const char *)reason : "");
  bool has_bands = out->bands && shape->band_numbers && out->outcome <= KM_DESIGN_SHORT;
  return !has_bands || copy_numbers(row, 3, out->bands, shape->band_numbers);
}

km_status km_store_get(km_entry_store *s, const km_store_shape *shape, const double *values, km_design_answer *out,
                       bool *found, km_error *error) {
  double key[KM_MAX_DESIGN_PARAMETERS];
  key_of(values, shape->parameters, key);
  if (s->in_memory) {
    *found = km_answer_cache_get(&s->cache, shape, key, out);
    return KM_OK;
  }
  sqlite3_bind_int(s->get, 1, shape->question);
  bind_numbers(s->get, 2, key, shape->parameters);
  int code = sqlite3_step(s->get);
  *found = code == SQLITE_ROW && read_answer(s->get, shape, out);
  if (!*found)
    out->outcome = KM_DESIGN_MISSING;
  sqlite3_reset(s->get);
  return code == SQLITE_ROW || code == SQLITE_DONE ? KM_OK : fail(s, error);
}

/* Writes an answer: to the cache, the table, or the appended table. */
km_status km_store_put(km_entry_store *s, const km_store_shape *shape, const double *values, const km_design_answer *a,
                       km_error *error) {
  double key[KM_MAX_DESIGN_PARAMETERS];
  sqlite3_stmt *put = s->appends ? s->append : s->put;
  key_of(values, shape->parameters, key);
  if (s->in_memory)
    return km_answer_cache_put(&s->cache, shape, key, a)
               ? KM_OK
               : km_fail(error, KM_MEMORY, "out of memory for the store %s", s->path);
  km_status status = s->read_only ? fail_to_write(s, error) : begin_transaction(s, error);
  if (status)
    return status;
  sqlite3_bind_int(put, 1, shape->question);
  bind_numbers(put, 2, key, shape->parameters);
  sqlite3_bind_int(put, 3, (int)a->outcome);
  if (a->reason[0])
    sqlite3_bind_text(put, 4, a->reason, -1, SQLITE_STATIC);
  else
    sqlite3_bind_null(put, 4);
  bind_numbers(put, 5, a->figures, shape->figures);
  bool has_bands = shape->band_numbers && a->outcome <= KM_DESIGN_SHORT;
  if (has_bands)
    bind_numbers(put, 6, a->bands, shape->band_numbers);
  else
    sqlite3_bind_null(put, 6);
  int code = sqlite3_step(put);
  sqlite3_reset(put);
  if (s->appends)
    s->appended +=
        (shape->parameters + shape->figures + (has_bands ? shape->band_numbers : 0)) * (double)sizeof *values;
  return code == SQLITE_DONE ? KM_OK : fail(s, error);
}

void km_store_append(km_entry_store *s) {
  s->appends = !s->in_memory && !s->read_only;
}

km_status km_store_sort(km_entry_store *s, km_error *error) {
  km_status status = s->appends ? sort_appended(s, error) : KM_OK;
  s->appends = false;
  km_status committed = km_store_commit(s, status ? NULL : error); /* results that can't be sorted remain appended */
  return status ? status : committed;
}

km_status km_store_commit(km_entry_store *s, km_error *error) {
  km_status status = KM_OK;
  if (!s->writing)
    return KM_OK;
  if (s->appends && s->appended >= s->max_appended) {
    status = sort_appended(s, error);
    s->max_appended *= 1.5;
  }
  s->writing = false;
  km_status committed = run(s, "COMMIT", status ? NULL : error); /* results that can't be sorted remain appended */
  return status ? status : committed;
}
