/* What the program kmech-mesh writes to its standard output, which is read by the library that started it.
 *
 *   header      km_mesh_stream: 16 bytes; `outcome` selects what follows
 *   IMPORTED    vertices [vertex_count][3] double, then corners [triangle_count][3] int32_t, counted from 0
 *   REFUSED     `vertex_count` bytes of text: why the file can't be read
 *
 * Both ends run on one machine: numbers are in the machine's own byte order. */
#ifndef KM_EXCHANGE_MESH_IMPORT_STREAM_H
#define KM_EXCHANGE_MESH_IMPORT_STREAM_H

#include <stdint.h>

enum {
  KM_MESH_MAX_TRIANGLES = 2000000, /* of one file: with them the reader stays below 1 GB */
  KM_MESH_MAX_CORNERS = 3 * KM_MESH_MAX_TRIANGLES,
  KM_MESH_MAX_REASON = 300, /* bytes of a text of refusal */
  KM_MESH_SECONDS = 4       /* of kmech-mesh, by the clock on the wall */
};

typedef enum km_mesh_outcome {
  KM_MESH_IMPORTED = 0x6b6d6d01, /* also tells the stream's version */
  KM_MESH_REFUSED = 0x6b6d6d02
} km_mesh_outcome;

typedef struct km_mesh_stream {
  int32_t outcome; /* km_mesh_outcome */
  int32_t vertex_count, triangle_count;
  int32_t unused; /* 0 */
} km_mesh_stream;

#endif
