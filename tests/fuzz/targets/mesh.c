/* Bytes as a mesh's file, read without assimp: whole triangles of finite corners, or nothing. */
#include "target.h"

#include "base/memory.h"
#include "exchange/mesh/plain_meshes.h"

#include <math.h>

static void read_as(const char *name, const uint8_t *data, size_t size) {
  km_text text = {0};
  km_soup soup = {0};
  km_text_bytes(&text, data, size);
  if (km_plain_mesh_scan(name, &text, &soup) && (soup.count == 0 || soup.count % 3))
    fuzz_fail("a plain mesh has no triangles, or a part of one");
  for (size_t i = 0; i < soup.count; ++i)
    if (!(isfinite(soup.corners[i].x) && isfinite(soup.corners[i].y) && isfinite(soup.corners[i].z)))
      fuzz_fail("a corner isn't finite");
  km_free(soup.corners);
  km_text_free(&text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  read_as("a.obj", data, size);
  read_as("a.stl", data, size);
  return 0;
}
