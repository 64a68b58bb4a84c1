/* Starts kmech-mesh on a file and takes over the triangles that it writes. */
#include "exchange/mesh/mesh_import.h"

#include "base/child_process.h"
#include "exchange/mesh/import/stream.h"

#include <math.h>
#include <signal.h>
#include <string.h>
#include <strings.h>

/* Formats that are offered, by their endings. assimp knows some forty more, most of them without a use for parts of
 * machines. */
static const char *const endings[] = {".obj", ".stl", ".ply", ".off", ".dae", ".gltf", ".glb", ".3ds"};
static const char formats[] = ".obj, .stl, .ply, .off, .dae, .gltf, .glb, .3ds or MuJoCo's .msh";

static bool is_offered(const char *path) {
  const char *ending = strrchr(path, '.');
  for (size_t i = 0; ending && i < sizeof endings / sizeof *endings; ++i)
    if (strcasecmp(ending, endings[i]) == 0)
      return true;
  return false;
}

/* Reads the vertices and the corners that follow a header. KM_OK with `*whole` false: the stream ends before they
 * do. */
static km_status copy_mesh(km_helper *helper, const km_mesh_stream *head, const char *path, km_mesh **out, bool *whole,
                           km_error *error) {
  int32_t corner[3];
  km_mesh *mesh = km_mesh_create(head->vertex_count, head->triangle_count);
  *out = mesh;
  if (!mesh)
    return km_fail(error, KM_MEMORY, "%s: out of memory", path);
  *whole = true;
  bool sound = true;
  for (int v = 0; v < mesh->vertex_count && *whole; ++v) {
    double x[3];
    *whole = km_helper_read(helper, x, sizeof x);
    if (*whole)
      mesh->vertices[v] = (km_vec3){x[0], x[1], x[2]};
    sound = sound && (!*whole || (isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2])));
  }
  for (int t = 0; t < mesh->triangle_count && *whole; ++t) {
    *whole = km_helper_read(helper, corner, sizeof corner);
    for (int k = 0; k < 3 && *whole; ++k) {
      sound = sound && corner[k] >= 0 && corner[k] < mesh->vertex_count;
      mesh->triangles[t].corner[k] = corner[k];
    }
  }
  if (*whole && !sound)
    return km_fail(error, KM_IO, "%s: a coordinate is not a finite number, or a face has a corner that isn't there",
                   path);
  return KM_OK;
}

/* Reads the reason why there is no mesh. */
static km_status copy_reason(km_helper *helper, size_t size, const char *path, bool *whole, km_error *error) {
  char reason[KM_MESH_MAX_REASON + 1] = {0};
  *whole = size <= KM_MESH_MAX_REASON && km_helper_read(helper, reason, size);
  return *whole ? km_fail(error, KM_IO, "%s: %s", path, reason) : KM_OK;
}

/* KM_OK with `*whole` false: the process wrote no whole stream. */
static km_status take(km_helper *helper, const char *path, km_mesh **out, bool *whole, km_error *error) {
  km_mesh_stream head;
  *whole = false;
  if (!km_helper_read(helper, &head, sizeof head) || head.vertex_count < 0)
    return KM_OK;
  if (head.outcome == KM_MESH_REFUSED)
    return copy_reason(helper, (size_t)head.vertex_count, path, whole, error);
  if (head.outcome != KM_MESH_IMPORTED || head.vertex_count > KM_MESH_MAX_CORNERS || head.triangle_count < 0 ||
      head.triangle_count > KM_MESH_MAX_TRIANGLES)
    return KM_OK;
  *whole = true;
  if (head.triangle_count == 0)
    return km_fail(error, KM_IO, "%s: has no faces; expected a closed surface", path);
  return copy_mesh(helper, &head, path, out, whole, error);
}

/* Reason of the end of a process whose stream is incomplete. */
static km_status explain(const char *path, int ended, km_error *error) {
  if (ended == SIGALRM || ended == SIGXCPU)
    return km_fail(error, KM_IO, "%s: isn't read within %d s: the mesh is damaged or too large", path, KM_MESH_SECONDS);
  if (ended > 0)
    return km_fail(error, KM_IO, "%s: isn't a mesh that can be read: its reader ended by %.60s; the file is damaged",
                   path, strsignal(ended));
  return km_fail(error, KM_IO,
                 "%s: can't be read: kmech-mesh ended early; expected that of this version of kmech, and assimp", path);
}

km_status km_mesh_import(const char *path, km_mesh **out, km_error *error) {
  km_helper helper;
  bool whole;
  *out = NULL;
  if (!is_offered(path))
    return km_fail(error, KM_IO, "%s: isn't a mesh that can be read: its name ends otherwise; expected %s", path,
                   formats);
  const char *reason = km_helper_start(&helper, "kmech-mesh", path);
  if (reason)
    return km_fail(error, KM_IO, "%s: meshes of this format can't be read: kmech-mesh %.300s", path, reason);
  km_status status = take(&helper, path, out, &whole, error);
  int ended = km_helper_end(&helper);
  if (!status && !whole)
    status = explain(path, ended, error);
  if (status) {
    km_mesh_free(*out);
    *out = NULL;
  }
  return status;
}
