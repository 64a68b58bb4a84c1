/* MuJoCo's binary meshes: counts, vertices, normals, texture coordinates, faces, in the bytes' order of the machine. */
#include "exchange/mesh/msh.h"

#include "exchange/mesh/import/stream.h"
#include "kmech/base.h"
#include "model/geometry/hull.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

enum { VERTICES, NORMALS, TEXTURES, FACES, COUNTS };

/* True if a header is consistent with the size of the file. */
static bool fits(const int32_t n[COUNTS], int64_t size) {
  for (int k = 0; k < COUNTS; ++k)
    if (n[k] < 0 || n[k] > KM_MESH_MAX_CORNERS)
      return false;
  if (n[VERTICES] < 4 || (n[NORMALS] && n[NORMALS] != n[VERTICES]) || (n[TEXTURES] && n[TEXTURES] != n[VERTICES]))
    return false;
  int64_t words = COUNTS + 3 * ((int64_t)n[VERTICES] + n[NORMALS] + n[FACES]) + 2 * (int64_t)n[TEXTURES];
  return words * (int64_t)sizeof *n == size;
}

static bool has_header(const char *path) {
  int32_t n[COUNTS];
  FILE *file = fopen(path, "rb");
  if (!file)
    return false;
  bool whole = fread(n, sizeof *n, COUNTS, file) == COUNTS && fseek(file, 0, SEEK_END) == 0;
  long size = whole ? ftell(file) : -1;
  fclose(file);
  return whole && fits(n, size);
}

static bool copy(const int32_t n[COUNTS], const char *bytes, km_mesh *mesh) {
  const char *vertices = bytes + COUNTS * sizeof *n;
  const char *faces = vertices + (3 * ((size_t)n[VERTICES] + (size_t)n[NORMALS]) + 2 * (size_t)n[TEXTURES]) * sizeof *n;
  for (int v = 0; v < n[VERTICES]; ++v) {
    float x[3];
    memcpy(x, vertices + (size_t)v * sizeof x, sizeof x);
    mesh->vertices[v] = (km_vec3){(double)x[0], (double)x[1], (double)x[2]};
    if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[2]))
      return false;
  }
  for (int f = 0; f < n[FACES]; ++f) {
    int32_t corner[3];
    memcpy(corner, faces + (size_t)f * sizeof corner, sizeof corner);
    for (int k = 0; k < 3; ++k)
      if (corner[k] < 0 || corner[k] >= n[VERTICES])
        return false;
    mesh->triangles[f] = (km_triangle){.corner = {corner[0], corner[1], corner[2]}};
  }
  return true;
}

/* Convex hull of a file without faces. */
static km_status wrap(const char *path, km_mesh **mesh, km_error *error) {
  km_mesh *points = *mesh;
  km_error reason;
  km_status status = km_mesh_hull(points, mesh, &reason);
  km_mesh_free(points);
  return status == KM_MODEL ? km_fail(error, KM_IO, "%s: %.200s", path, reason.text)
         : status           ? km_fail(error, status, "%s: out of memory", path)
                            : KM_OK;
}

km_status km_msh_read(const char *path, km_mesh **out, km_error *error) {
  int32_t n[COUNTS];
  km_text bytes = {0};
  *out = NULL;
  if (!has_header(path))
    return KM_OK;
  km_status status = km_file_read(path, &bytes, error);
  if (!status) {
    memcpy(n, bytes.data, bytes.size < sizeof n ? bytes.size : sizeof n);
    if (bytes.size < sizeof n || !fits(n, (int64_t)bytes.size))
      status = km_fail(error, KM_IO, "%s: changed while it was read", path);
    else if ((*out = km_mesh_create(n[VERTICES], n[FACES])) == NULL)
      status = km_fail(error, KM_MEMORY, "%s: out of memory", path);
    else if (!copy(n, bytes.data, *out))
      status = km_fail(error, KM_IO, "%s: a coordinate is not a finite number, or a face has a corner that isn't there",
                       path);
    else if (n[FACES] == 0)
      status = wrap(path, out, error);
  }
  km_text_free(&bytes);
  if (status) {
    km_mesh_free(*out);
    *out = NULL;
  }
  return status;
}
