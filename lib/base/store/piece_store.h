/* Store of long work that is one sequence of pieces: the results of each piece, in their order, in one SQLite file.
 *
 * The work is the same each time it is done, so that piece i of the file is piece i of the work. Work that begins again
 * takes the results of the pieces that are there and does the others. */
#ifndef KM_BASE_PIECE_STORE_H
#define KM_BASE_PIECE_STORE_H

#include "base/memory.h"

typedef struct km_piece_store km_piece_store;

/* The results of a piece while they are written or read, by the same calls in the same order. Its creator sets
 * is_read. */
typedef struct km_piece {
  bool is_read; /* the data are copied from the bytes, else to them */
  bool failed;  /* out of memory, or the bytes have ended */
  unsigned char *bytes;
  size_t size, capacity, at; /* `at` bytes were read */
} km_piece;

/* Copies `size` bytes of `data` to the piece or from it. Data of a piece that has failed are unchanged. */
void km_piece_pass(km_piece *piece, void *data, size_t size);
void km_piece_free(km_piece *piece);

/* Opens or creates a file as km_store_file_open; `kind`: the work, in messages. KM_IO also for a read-only file. */
km_status km_piece_store_open(const char *path, const char *kind, const char *identity, const char *what, bool replace,
                              km_piece_store **out, km_error *error);
/* Commits all pieces. */
void km_piece_store_free(km_piece_store *store);
/* Reads the next piece, which the caller frees in any case. *is_there false: there are no further ones. KM_IO: it isn't
 * what was written. */
km_status km_piece_store_take(km_piece_store *store, km_piece *out, bool *is_there, km_error *error);
/* Adds the next piece, where there are no further ones. The end of the process loses those of the last tenth of a
 * second. */
km_status km_piece_store_add(km_piece_store *store, const km_piece *piece, km_error *error);
/* Reports that the last piece isn't what the work expects. */
km_status km_piece_store_fail(const km_piece_store *store, km_error *error);

#endif
