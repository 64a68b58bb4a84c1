/* Store of a study in an SQLite file. The key of a result is the hash of its request and the design's parameter
 * values, so an extended study finds its earlier results.
 *
 * Keys of samples come in no order, so a commit of many results would change almost every page of a table sorted by
 * them. Runs of many designs therefore append results to a second table, which is sorted into the first one when it
 * has grown by a fraction of what was sorted before. In memory, results go to a hash table. */
#include "study/result_store.h"

#include "base/store/store_file.h"
#include "study/answer_cache.h"

#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of appended results before they are sorted for the first time. */
static const double first_appended = 1 << 20;

struct km_entry_store {
  km_store_file file; /* a store in memory has its answers in `cache` */
  sqlite3_stmt *get, *put, *append;
  bool appends;                  /* results are appended and sorted later */
  double appended, max_appended; /* approximate bytes that wait to be sorted; largest number allowed */
  km_answer_cache cache;
};

static const char schema[] =
    "CREATE TABLE questions(id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, name TEXT NOT NULL);"
    "CREATE TABLE results(question INTEGER NOT NULL, design BLOB NOT NULL, outcome INTEGER NOT NULL, reason TEXT,"
    " figures BLOB NOT NULL, bands BLOB, PRIMARY KEY(question, design)) WITHOUT ROWID;";
static const km_store_kind kind = {"study", schema,
                                   "DROP TABLE IF EXISTS appended; DROP TABLE results; DROP TABLE questions"};
/* table for appended results; stores of earlier versions don't have it */
static const char appended_schema[] =
    "CREATE TABLE IF NOT EXISTS appended(question INTEGER NOT NULL, design BLOB NOT NULL, outcome INTEGER NOT NULL,"
    " reason TEXT, figures BLOB NOT NULL, bands BLOB);";

/* Prepares the statements for reading and writing results. */
static km_status prepare(km_entry_store *s, km_error *error) {
  static const char get[] = "SELECT outcome, reason, figures, bands FROM results WHERE question = ? AND design = ?";
  static const char put[] = "INSERT OR REPLACE INTO results VALUES(?, ?, ?, ?, ?, ?)";
  static const char append[] = "INSERT INTO appended VALUES(?, ?, ?, ?, ?, ?)";
  if (s->file.read_only)
    return sqlite3_prepare_v3(s->file.db, get, -1, SQLITE_PREPARE_PERSISTENT, &s->get, NULL) == SQLITE_OK
               ? KM_OK
               : km_store_file_fail(&s->file, error);
  bool is_ok = sqlite3_prepare_v3(s->file.db, get, -1, SQLITE_PREPARE_PERSISTENT, &s->get, NULL) == SQLITE_OK &&
               sqlite3_prepare_v3(s->file.db, put, -1, SQLITE_PREPARE_PERSISTENT, &s->put, NULL) == SQLITE_OK &&
               sqlite3_prepare_v3(s->file.db, append, -1, SQLITE_PREPARE_PERSISTENT, &s->append, NULL) == SQLITE_OK;
  return is_ok ? KM_OK : km_store_file_fail(&s->file, error);
}

/* Sorts the appended results into the table; of two answers for one design the later one remains. */
static km_status sort_appended(km_entry_store *s, km_error *error) {
  static const char sort[] = "INSERT OR REPLACE INTO results SELECT * FROM appended ORDER BY question, design, rowid;"
                             "DELETE FROM appended";
  km_status status = km_store_file_begin(&s->file, error);
  s->appended = 0.0;
  return status ? status : km_store_file_run(&s->file, sort, error);
}

/* Sorts the results that a killed run left. */
static km_status sort_leftover(km_entry_store *s, km_error *error) {
  const char *left = km_store_file_text(&s->file, "SELECT 1 FROM appended LIMIT 1", NULL);
  if (s->file.arena.failed)
    return km_store_file_fail(&s->file, error);
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
  const char *left = km_store_file_text(&s->file, "SELECT 1 FROM main.appended LIMIT 1", NULL);
  if (s->file.arena.failed)
    return km_store_file_fail(&s->file, error);
  return left ? km_store_file_run(&s->file, sort, error) : KM_OK;
}

km_status km_store_open(const char *path, const char *identity, const char *what, bool replace, km_entry_store **out,
                        km_error *error) {
  km_entry_store *s = *out = KM_NEW(km_entry_store, 1);
  if (!s)
    return km_fail(error, KM_MEMORY, "out of memory for a store");
  s->max_appended = first_appended;
  km_status status = km_store_file_open(&s->file, path, &kind, identity, what, replace, error);
  if (!status && !s->file.read_only)
    status = km_store_file_run(&s->file, appended_schema, error);
  if (!status)
    status = s->file.read_only ? sort_in_memory(s, error) : sort_leftover(s, error);
  return status ? status : prepare(s, error);
}

void km_store_free(km_entry_store *s) {
  if (!s)
    return;
  sqlite3_finalize(s->get);
  sqlite3_finalize(s->put);
  sqlite3_finalize(s->append);
  km_store_file_close(&s->file);
  km_answer_cache_free(&s->cache);
  km_free(s);
}

km_status km_store_question(km_entry_store *s, const char *key, const char *name, int *id, km_error *error) {
  static const char find[] = "SELECT id FROM questions WHERE key = ?";
  const char *text = km_store_file_text(&s->file, find, key);
  km_status status = s->file.arena.failed ? km_store_file_fail(&s->file, error) : KM_OK;
  *id = 0; /* no request: a read-only store without it has no answers to it */
  if (!status && !text && s->file.read_only)
    return KM_OK;
  if (!status && !text)
    status = km_store_file_insert(&s->file, "INSERT INTO questions(key, name) VALUES(?, ?)", key, name, error);
  if (!status && !text)
    text = km_store_file_text(&s->file, find, key);
  *id = text ? (int)strtol(text, NULL, 10) : 0;
  return status || text ? status : km_store_file_fail(&s->file, error);
}

km_status km_store_is_empty(const km_entry_store *s, bool *empty, km_error *error) {
  sqlite3_stmt *statement = NULL;
  if (s->file.in_memory) {
    *empty = s->cache.count == 0;
    return KM_OK;
  }
  int code = sqlite3_prepare_v2(s->file.db, "SELECT 1 FROM results LIMIT 1", -1, &statement, NULL);
  if (code == SQLITE_OK)
    code = sqlite3_step(statement);
  sqlite3_finalize(statement);
  *empty = code == SQLITE_DONE;
  return code == SQLITE_DONE || code == SQLITE_ROW ? KM_OK : km_store_file_fail(&s->file, error);
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
  if (s->file.in_memory) {
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
  return code == SQLITE_ROW || code == SQLITE_DONE ? KM_OK : km_store_file_fail(&s->file, error);
}

/* Writes an answer: to the cache, the table, or the appended table. */
km_status km_store_put(km_entry_store *s, const km_store_shape *shape, const double *values, const km_design_answer *a,
                       km_error *error) {
  double key[KM_MAX_DESIGN_PARAMETERS];
  sqlite3_stmt *put = s->appends ? s->append : s->put;
  key_of(values, shape->parameters, key);
  if (s->file.in_memory)
    return km_answer_cache_put(&s->cache, shape, key, a)
               ? KM_OK
               : km_fail(error, KM_MEMORY, "out of memory for the store %s", s->file.path);
  km_status status =
      s->file.read_only ? km_store_file_fail_to_write(&s->file, error) : km_store_file_begin(&s->file, error);
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
  return code == SQLITE_DONE ? KM_OK : km_store_file_fail(&s->file, error);
}

void km_store_append(km_entry_store *s) {
  s->appends = !s->file.in_memory && !s->file.read_only;
}

km_status km_store_sort(km_entry_store *s, km_error *error) {
  km_status status = s->appends ? sort_appended(s, error) : KM_OK;
  s->appends = false;
  km_status committed = km_store_commit(s, status ? NULL : error); /* results that can't be sorted remain appended */
  return status ? status : committed;
}

km_status km_store_commit(km_entry_store *s, km_error *error) {
  km_status status = KM_OK;
  if (!s->file.writing)
    return KM_OK;
  if (s->appends && s->appended >= s->max_appended) {
    status = sort_appended(s, error);
    s->max_appended *= 1.5;
  }
  km_status committed =
      km_store_file_commit(&s->file, status ? NULL : error); /* results that can't be sorted remain appended */
  return status ? status : committed;
}
