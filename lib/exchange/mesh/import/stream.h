/* Format of the standard output of kmech-mesh, which the library reads: a header km_mesh_stream of 16 bytes, whose
 * `outcome` selects the rest. IMPORTED: vertices [vertex_count][3] double, then corners [triangle_count][3] int32_t
 * from 0. REFUSED: `vertex_count` bytes of text, the reason. Numbers are in the byte order of the machine. */
#ifndef KM_EXCHANGE_MESH_IMPORT_STREAM_H
#define KM_EXCHANGE_MESH_IMPORT_STREAM_H

#include <stdint.h>

enum {
  KM_MESH_MAX_TRIANGLES = 2000000, /* limits of one file: with them the reader needs less than 1 GB */
  KM_MESH_MAX_CORNERS = 3 * KM_MESH_MAX_TRIANGLES,
  KM_MESH_MAX_REASON = 300, /* bytes of a text of refusal */
  KM_MESH_SECONDS = 4       /* time limit of kmech-mesh, in seconds of elapsed time */
};

typedef enum km_mesh_outcome {
  KM_MESH_IMPORTED = 0x6b6d6d01, /* also identifies the version of the stream */
  KM_MESH_REFUSED = 0x6b6d6d02
} km_mesh_outcome;

typedef struct km_mesh_stream {
  int32_t outcome; /* km_mesh_outcome */
  int32_t vertex_count, triangle_count;
  int32_t unused; /* 0 */
} km_mesh_stream;

#endif
