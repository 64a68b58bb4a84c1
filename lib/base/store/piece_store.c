/* Store of long work that is one sequence of pieces (base/store/piece_store.h). */
#include "base/store/piece_store.h"

#include "base/clock.h"
#include "base/file.h"
#include "base/store/store_file.h"

#include <limits.h>
#include <sqlite3.h>
#include <string.h>

static const double commit_seconds = 0.1;

struct km_piece_store {
  km_store_file file;
  km_store_kind kind;
  sqlite3_stmt *get, *put;
  long long next; /* number of the next piece */
  double committed;
};

void km_piece_pass(km_piece *p, void *data, size_t size) {
  void *bytes = p->bytes;
  if (p->failed || size == 0)
    return;
  p->failed = p->is_read ? size > p->size - p->at : !km_reserve(&bytes, &p->capacity, p->size + size, 1);
  if (p->failed)
    return;
  p->bytes = bytes;
  if (p->is_read) {
    memcpy(data, p->bytes + p->at, size);
    p->at += size;
  } else {
    memcpy(p->bytes + p->size, data, size);
    p->size += size;
  }
}

void km_piece_free(km_piece *p) {
  km_free(p->bytes);
  *p = (km_piece){0};
}

static km_status prepare(km_piece_store *s, km_error *error) {
  static const char get[] = "SELECT results, hash FROM pieces WHERE number = ?",
                    put[] = "INSERT INTO pieces VALUES(?, ?, ?)";
  if (s->file.read_only)
    return km_store_file_fail_to_write(&s->file, error);
  bool is_ok = sqlite3_prepare_v3(s->file.db, get, -1, SQLITE_PREPARE_PERSISTENT, &s->get, NULL) == SQLITE_OK &&
               sqlite3_prepare_v3(s->file.db, put, -1, SQLITE_PREPARE_PERSISTENT, &s->put, NULL) == SQLITE_OK;
  return is_ok ? KM_OK : km_store_file_fail(&s->file, error);
}

km_status km_piece_store_open(const char *path, const char *kind, const char *identity, const char *what, bool replace,
                              km_piece_store **out, km_error *error) {
  km_piece_store *s = *out = KM_NEW(km_piece_store, 1);
  if (!s)
    return km_fail(error, KM_MEMORY, "out of memory for a store");
  s->kind = (km_store_kind){
      kind, "CREATE TABLE pieces(number INTEGER PRIMARY KEY, results BLOB NOT NULL, hash TEXT NOT NULL)",
      "DROP TABLE pieces"};
  s->committed = km_clock();
  km_status status = km_store_file_open(&s->file, path, &s->kind, identity, what, replace, error);
  if (!status)
    status = prepare(s, error);
  if (status) {
    km_piece_store_free(s);
    *out = NULL;
  }
  return status;
}

void km_piece_store_free(km_piece_store *s) {
  if (!s)
    return;
  sqlite3_finalize(s->get);
  sqlite3_finalize(s->put);
  km_store_file_close(&s->file);
  km_free(s);
}

/* Copies the piece of a row. False: its hash is another, or out of memory. */
static bool read_piece(sqlite3_stmt *row, km_piece *out) {
  const void *bytes = sqlite3_column_blob(row, 0);
  const unsigned char *stated = sqlite3_column_text(row, 1);
  char hash[KM_SHA256_TEXT];
  km_piece_pass(out, (void *)bytes, (size_t)sqlite3_column_bytes(row, 0));
  out->is_read = true;
  km_sha256(out->size ? out->bytes : (const unsigned char *)"", out->size, hash);
  return !out->failed && stated && strcmp((const char *)stated, hash) == 0;
}

km_status km_piece_store_take(km_piece_store *s, km_piece *out, bool *is_there, km_error *error) {
  *out = (km_piece){0};
  sqlite3_bind_int64(s->get, 1, s->next);
  int code = sqlite3_step(s->get);
  *is_there = code == SQLITE_ROW;
  s->next += *is_there;
  bool is_whole = !*is_there || read_piece(s->get, out);
  sqlite3_reset(s->get);
  if (code != SQLITE_ROW && code != SQLITE_DONE)
    return km_store_file_fail(&s->file, error);
  return is_whole      ? KM_OK
         : out->failed ? km_fail(error, KM_MEMORY, "out of memory for the store %s", s->file.path)
                       : km_piece_store_fail(s, error);
}

km_status km_piece_store_add(km_piece_store *s, const km_piece *piece, km_error *error) {
  const void *bytes = piece->size ? (const void *)piece->bytes : "";
  char hash[KM_SHA256_TEXT];
  if (piece->failed || piece->size > INT_MAX)
    return km_fail(error, KM_MEMORY, "out of memory for the store %s", s->file.path);
  km_status status = km_store_file_begin(&s->file, error);
  if (status)
    return status;
  km_sha256(bytes, piece->size, hash);
  sqlite3_bind_int64(s->put, 1, s->next++);
  sqlite3_bind_blob(s->put, 2, bytes, (int)piece->size, SQLITE_STATIC);
  sqlite3_bind_text(s->put, 3, hash, -1, SQLITE_STATIC);
  int code = sqlite3_step(s->put);
  sqlite3_reset(s->put);
  if (code != SQLITE_DONE)
    return km_store_file_fail(&s->file, error);
  if (km_clock() - s->committed < commit_seconds)
    return KM_OK;
  s->committed = km_clock();
  return km_store_file_commit(&s->file, error);
}

km_status km_piece_store_fail(const km_piece_store *s, km_error *error) {
  return km_fail(error, KM_IO,
                 "%s: the store is damaged (piece %lld); expected a copy of it, or the %s run again without it",
                 s->file.path, s->next - 1, s->kind.kind);
}
