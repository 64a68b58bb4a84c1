/* One SQLite file with the results of long work (base/store/store_file.h). */
#include "base/store/store_file.h"
#include "base/file.h"

#include <fcntl.h>
#include <libgen.h>
#include <sqlite3.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

km_status km_store_file_fail_to_write(const km_store_file *s, km_error *error) {
  return km_fail(error, KM_IO, "%s: the store can't be written, only read", s->path);
}

km_status km_store_file_fail(const km_store_file *s, km_error *error) {
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
    return km_fail(error, KM_IO, "%s: this is no store of a %s, or a damaged one (%s)", s->path, s->of->kind, reason);
  if ((code & 0xff) == SQLITE_READONLY)
    return km_store_file_fail_to_write(s, error);
  return km_fail(error, KM_IO, "%s: the store can't be used: %s", s->path, reason);
}

km_status km_store_file_run(const km_store_file *s, const char *sql, km_error *error) {
  return sqlite3_exec(s->db, sql, NULL, NULL, NULL) == SQLITE_OK ? KM_OK : km_store_file_fail(s, error);
}

const char *km_store_file_text(km_store_file *s, const char *sql, const char *bound) {
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

km_status km_store_file_insert(const km_store_file *s, const char *sql, const char *a, const char *b, km_error *error) {
  sqlite3_stmt *statement = NULL;
  int code = sqlite3_prepare_v2(s->db, sql, -1, &statement, NULL);
  if (code == SQLITE_OK) {
    sqlite3_bind_text(statement, 1, a, -1, SQLITE_STATIC);
    sqlite3_bind_text(statement, 2, b, -1, SQLITE_STATIC);
    code = sqlite3_step(statement);
  }
  sqlite3_finalize(statement);
  return code == SQLITE_DONE ? KM_OK : km_store_file_fail(s, error);
}

/* The value of a key in the table named by the kind; NULL: none, no such table, or out of memory (arena.failed). */
static const char *value_of(km_store_file *s, const char *key) {
  km_text sql = {0};
  km_text_format(&sql, "SELECT value FROM %s WHERE key = ?", s->of->kind);
  s->arena.failed = s->arena.failed || sql.failed;
  const char *value = sql.failed ? NULL : km_store_file_text(s, sql.data, key);
  km_text_free(&sql);
  return value;
}

/* Creates the tables, in place of those of other work if there are some. */
static km_status create_tables(km_store_file *s, const char *identity, const char *what, bool is_there,
                               km_error *error) {
  const char *kind = s->of->kind;
  km_text sql = {0}, insert = {0};
  if (is_there)
    km_text_format(&sql, "%s; DROP TABLE %s;", s->of->drop, kind);
  km_text_format(&sql, "CREATE TABLE %s(key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID; %s", kind,
                 s->of->schema);
  km_text_format(&insert, "INSERT INTO %s VALUES(?, ?)", kind);
  km_status status = sql.failed || insert.failed ? km_fail(error, KM_MEMORY, "out of memory for the store %s", s->path)
                                                 : km_store_file_run(s, "BEGIN IMMEDIATE", error);
  if (!status)
    status = km_store_file_run(s, sql.data, error);
  if (!status)
    status = km_store_file_insert(s, insert.data, "identity", identity, error);
  if (!status)
    status = km_store_file_insert(s, insert.data, "what", what, error);
  km_text_free(&sql);
  km_text_free(&insert);
  return status ? status : km_store_file_run(s, "COMMIT", error);
}

/* Creates the tables of an empty file; checks that existing results belong to the same work. */
static km_status adopt_file(km_store_file *s, const char *identity, const char *what, bool replace, km_error *error) {
  const char *kind = s->of->kind, *tables = km_store_file_text(s, "SELECT count(*) FROM sqlite_master", NULL);
  if (!tables)
    return km_store_file_fail(s, error);
  const char *ours = value_of(s, "identity");
  if (s->arena.failed)
    return km_store_file_fail(s, error);
  if (s->read_only && !ours)
    return km_fail(error, KM_IO, "%s: this is no store of a %s, or a damaged one", s->path, kind);
  if (strcmp(tables, "0") != 0 && !ours)
    return km_fail(error, KM_IO, "%s: this is a database, but no store of a %s", s->path, kind);
  if (ours && strcmp(ours, identity) == 0)
    return KM_OK;
  if (ours && !replace) {
    const char *theirs = value_of(s, "what");
    return km_fail(error, KM_USAGE, "%s: the store holds the results of another %s: %.300s; expected those of %.300s",
                   s->path, kind, theirs ? theirs : "", what);
  }
  return create_tables(s, identity, what, ours != NULL, error);
}

km_status km_store_file_begin(km_store_file *s, km_error *error) {
  km_status status = s->writing ? KM_OK : km_store_file_run(s, "BEGIN IMMEDIATE", error);
  s->writing = s->writing || !status;
  return status;
}

/* True if the file or its folder (for the write-ahead log) can't be written. */
static bool is_read_only(const char *path, const char *folder) {
  return faccessat(AT_FDCWD, path, F_OK, AT_EACCESS) == 0 &&
         (faccessat(AT_FDCWD, path, W_OK, AT_EACCESS) != 0 || faccessat(AT_FDCWD, folder, W_OK, AT_EACCESS) != 0);
}

/* Opens a read-only file by a URI with `immutable`, because locks and the log would need writing. */
static km_status open_read_only(km_store_file *s, km_error *error) {
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
      : sqlite3_open_v2(name.data, &s->db, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, NULL) == SQLITE_OK
          ? KM_OK
          : km_store_file_fail(s, error);
  km_text_free(&name);
  return status;
}

/* Checks for damage of pages, their order and links; a changed number isn't detected. O(bytes of the file). */
static km_status check_integrity(km_store_file *s, km_error *error) {
  const char *found = s->in_memory ? "ok" : km_store_file_text(s, "PRAGMA integrity_check(1)", NULL);
  if (!found)
    return km_store_file_fail(s, error);
  if (strcmp(found, "ok") == 0)
    return KM_OK;
  return km_fail(error, KM_IO,
                 "%s: the store is damaged (%.200s); expected a copy of it, or the %s run again without it", s->path,
                 found, s->of->kind);
}

/* Opens the file with an exclusive lock and a write-ahead log. */
static km_status open_file(km_store_file *s, const char *folder, km_error *error) {
  s->read_only = !s->in_memory && is_read_only(s->path, folder);
  if (s->read_only)
    return open_read_only(s, error);
  if (sqlite3_open(s->in_memory ? ":memory:" : s->path, &s->db) != SQLITE_OK)
    return km_store_file_fail(s, error);
  sqlite3_extended_result_codes(s->db, 1);
  /* write-ahead log: a commit doesn't wait for the disk and survives the end of the process */
  km_status status = km_store_file_run(
      s, "PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = WAL; PRAGMA synchronous = NORMAL", error);
  return status ? status : km_store_file_run(s, "BEGIN IMMEDIATE; COMMIT", error); /* takes the exclusive lock */
}

km_status km_store_file_open(km_store_file *s, const char *path, const km_store_kind *kind, const char *identity,
                             const char *what, bool replace, km_error *error) {
  *s = (km_store_file){.of = kind, .in_memory = !path || strcmp(path, ":memory:") == 0};
  s->path = km_arena_string(&s->arena, path ? path : "in memory");
  char *folder = km_arena_string(&s->arena, s->path);
  if (!folder)
    return km_fail(error, KM_MEMORY, "out of memory for a store");
  km_status status = open_file(s, dirname(folder), error);
  if (!status)
    status = check_integrity(s, error);
  return status ? status : adopt_file(s, identity, what, replace, error);
}

void km_store_file_close(km_store_file *s) {
  if (s->writing)
    sqlite3_exec(s->db, "COMMIT", NULL, NULL, NULL);
  sqlite3_close(s->db);
  km_arena_free(&s->arena);
}

km_status km_store_file_commit(km_store_file *s, km_error *error) {
  bool is_open = s->writing;
  s->writing = false;
  return is_open ? km_store_file_run(s, "COMMIT", error) : KM_OK;
}

void km_identity_add_name(km_text *out, const char *name) {
  km_text_format(out, "%zu:%s;", name ? strlen(name) : 0, name ? name : "");
}

void km_identity_add_numbers(km_text *out, const double *numbers, int count) {
  for (int i = 0; i < count; ++i) {
    km_text_number(out, numbers[i]);
    km_text_add(out, ";");
  }
}

void km_identity_add_bytes(km_text *out, const void *bytes, size_t size) {
  char hash[KM_SHA256_TEXT];
  km_sha256(size > 0 ? bytes : "", size, hash);
  km_identity_add_name(out, hash);
}
