/* The only place that knows assimp. It is loaded when the first mesh is read: linked, it would cost every start of
 * a tool 3 ms, most of what `kmob info` takes. Never unloaded: its own libraries don't stand that. */
#include "base/library.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "exchange/mesh/msh.h"
#include "exchange/mesh/plain.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

/* In the order of the names in find_assimp. */
typedef struct assimp_functions {
  const struct aiScene *(*import)(const char *path, unsigned steps);
  void (*release)(const struct aiScene *scene);
  const char *(*error)(void);
} assimp_functions;

static const assimp_functions *find_assimp(km_error *error) {
  static const char *const files[] = {KM_ASSIMP, NULL};
  static const char *const names[] = {"aiImportFile", "aiReleaseImport", "aiGetErrorString", NULL};
  static assimp_functions found;
  static km_library library = {files, names, &found, false};
  const char *reason = km_library_load(&library);
  if (!reason)
    return &found;
  km_fail(error, KM_IO, "meshes can't be read: %.300s; expected assimp to be installed", reason);
  return NULL;
}

static void count_parts(const struct aiScene *scene, int64_t *vertices, int64_t *triangles) {
  *vertices = *triangles = 0;
  for (unsigned p = 0; p < scene->mNumMeshes; ++p) {
    const struct aiMesh *part = scene->mMeshes[p];
    *vertices += part->mNumVertices;
    for (unsigned f = 0; f < part->mNumFaces; ++f)
      *triangles += part->mFaces[f].mNumIndices == 3;
  }
}

static bool copy_vertices(const struct aiMesh *part, km_vec3 *out) {
  bool finite = true;
  for (unsigned v = 0; v < part->mNumVertices; ++v) {
    struct aiVector3D p = part->mVertices[v];
    out[v] = (km_vec3){(double)p.x, (double)p.y, (double)p.z};
    finite = finite && isfinite(p.x) && isfinite(p.y) && isfinite(p.z);
  }
  return finite;
}

/* Points and lines (faces with fewer corners) bound nothing. Returns the number of triangles; -1: one has a
 * corner that isn't there. */
static int copy_triangles(const struct aiMesh *part, int first_vertex, km_triangle *out) {
  int count = 0;
  for (unsigned f = 0; f < part->mNumFaces; ++f) {
    const unsigned *corner = part->mFaces[f].mIndices;
    if (part->mFaces[f].mNumIndices != 3)
      continue;
    for (int k = 0; k < 3; ++k) {
      if (corner[k] >= part->mNumVertices)
        return -1;
      out[count].corner[k] = first_vertex + (int)corner[k];
    }
    ++count;
  }
  return count;
}

static km_status copy_scene(const struct aiScene *scene, const char *path, km_mesh **out, km_error *error) {
  int64_t vertices, triangles;
  count_parts(scene, &vertices, &triangles);
  if (triangles == 0)
    return km_fail(error, KM_IO, "%s: has no faces; expected a closed surface", path);
  if (vertices > INT_MAX || triangles > INT_MAX / 3)
    return km_fail(error, KM_IO, "%s: has too many faces; expected at most %d", path, INT_MAX / 3);
  km_mesh *mesh = km_mesh_create((int)vertices, (int)triangles);
  bool sound = true;
  for (unsigned p = 0, v = 0, t = 0; mesh && sound && p < scene->mNumMeshes; ++p) {
    int copied = copy_triangles(scene->mMeshes[p], (int)v, mesh->triangles + t);
    sound = copy_vertices(scene->mMeshes[p], mesh->vertices + v) && copied >= 0;
    t += (unsigned)copied;
    v += scene->mMeshes[p]->mNumVertices;
  }
  *out = mesh;
  if (!sound)
    return km_fail(error, KM_IO, "%s: a coordinate is not a finite number, or a face has a corner that isn't there",
                   path);
  return mesh && km_mesh_weld(mesh) ? KM_OK : km_fail(error, KM_MEMORY, "%s: out of memory", path);
}

typedef struct job {
  const assimp_functions *assimp;
  const char *path;
  km_mesh *mesh;
  km_error *error;
  km_status status;
} job;

static void read_job(void *context) {
  job *j = context;
  /* Polygons become triangles; every part goes where the scene's nodes put it. */
  const struct aiScene *scene = j->assimp->import(j->path, aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (!scene) {
    j->status = km_fail(j->error, KM_IO, "%s: isn't a mesh that can be read: %.300s", j->path, j->assimp->error());
    return;
  }
  j->status = copy_scene(scene, j->path, &j->mesh, j->error);
  j->assimp->release(scene);
}

km_status km_mesh_read(const char *path, km_mesh **out, km_error *error) {
  km_status status = km_msh_read(path, out, error);
  if (!status && !*out)
    status = km_plain_mesh_read(path, out, error);
  if (status || *out)
    return status;
  job j = {.assimp = find_assimp(error), .path = path, .error = error};
  if (!j.assimp)
    return KM_IO;
  km_serially(read_job, &j); /* assimp keeps its last error for the whole process */
  *out = j.mesh;
  if (j.status) {
    km_mesh_free(j.mesh);
    *out = NULL;
  }
  return j.status;
}
