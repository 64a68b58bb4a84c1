/* kmech-mesh FILE: reads a mesh by assimp and writes its triangles to the standard output (stream.h).
 *
 * assimp's importers fail on damaged files by crashes, endless loops and unbounded memory. The library therefore starts
 * this program for each file. It limits its own time and memory before it opens the file, and its end doesn't affect
 * the caller. Exit status 0: the stream is complete, with a mesh or with the reason of its absence. 1: the stream
 * couldn't be written. */
#include "exchange/mesh/import/stream.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

static const rlim_t memory_limit = (rlim_t)800 << 20; /* bytes of address space: of 1 GB the caller needs the rest */
static const rlim_t stack_limit = (rlim_t)8
                                  << 20; /* bytes: nested scenes overflow it instead of the machine's memory */

/* A lower limit of the caller stays. */
static bool limit(__rlimit_resource_t resource, rlim_t most) {
  struct rlimit r;
  if (getrlimit(resource, &r))
    return false;
  r.rlim_cur = r.rlim_max < most ? r.rlim_max : most;
  r.rlim_max = r.rlim_cur;
  return setrlimit(resource, &r) == 0;
}

/* The timer ends the program by SIGALRM, whatever the caller does with that signal. No core is dumped, no file
 * written. */
static bool limit_all(void) {
  sigset_t alarms;
  sigemptyset(&alarms);
  sigaddset(&alarms, SIGALRM);
  if (signal(SIGALRM, SIG_DFL) == SIG_ERR || sigprocmask(SIG_UNBLOCK, &alarms, NULL))
    return false;
  alarm(KM_MESH_SECONDS);
  return limit(RLIMIT_AS, memory_limit) && limit(RLIMIT_STACK, stack_limit) && limit(RLIMIT_CORE, 0) &&
         limit(RLIMIT_FSIZE, 0) && prctl(PR_SET_DUMPABLE, 0L, 0L, 0L, 0L) == 0;
}

static bool write_text(const void *bytes, size_t size, size_t count) {
  return fwrite(bytes, size, count, stdout) == count;
}

static bool refuse(const char *reason) {
  size_t size = strnlen(reason, KM_MESH_MAX_REASON);
  km_mesh_stream head = {.outcome = KM_MESH_REFUSED, .vertex_count = (int32_t)size};
  return write_text(&head, sizeof head, 1) && write_text(reason, 1, size);
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

static bool write_vertices(const struct aiMesh *part) {
  bool done = true;
  for (unsigned v = 0; v < part->mNumVertices && done; ++v) {
    struct aiVector3D p = part->mVertices[v];
    done = write_text((const double[]){(double)p.x, (double)p.y, (double)p.z}, sizeof(double), 3);
  }
  return done;
}

/* Points and lines (faces with fewer than 3 corners) bound nothing. */
static bool write_triangles(const struct aiMesh *part, int64_t first_vertex) {
  bool done = true;
  for (unsigned f = 0; f < part->mNumFaces && done; ++f) {
    const unsigned *corner = part->mFaces[f].mIndices;
    int32_t own[3];
    if (part->mFaces[f].mNumIndices != 3)
      continue;
    for (int k = 0; k < 3; ++k) /* -1: a vertex that isn't there */
      own[k] = corner[k] < part->mNumVertices ? (int32_t)(first_vertex + (int64_t)corner[k]) : -1;
    done = write_text(own, sizeof *own, 3);
  }
  return done;
}

static bool write_scene(const struct aiScene *scene) {
  int64_t vertices, triangles, first = 0;
  char reason[KM_MESH_MAX_REASON];
  count_parts(scene, &vertices, &triangles);
  if (triangles > KM_MESH_MAX_TRIANGLES || vertices > KM_MESH_MAX_CORNERS) {
    snprintf(reason, sizeof reason, "has %lld faces with %lld corners; expected at most %d and %d",
             (long long)triangles, (long long)vertices, KM_MESH_MAX_TRIANGLES, KM_MESH_MAX_CORNERS);
    return refuse(reason);
  }
  km_mesh_stream head = {KM_MESH_IMPORTED, (int32_t)vertices, (int32_t)triangles, 0};
  bool done = write_text(&head, sizeof head, 1);
  for (unsigned p = 0; p < scene->mNumMeshes && done; ++p)
    done = write_vertices(scene->mMeshes[p]);
  for (unsigned p = 0; p < scene->mNumMeshes && done; ++p) {
    done = write_triangles(scene->mMeshes[p], first);
    first += scene->mMeshes[p]->mNumVertices;
  }
  return done;
}

/* Ends without the destructors of what a damaged file left behind. */
static _Noreturn void end(bool written) {
  _exit(written && fflush(stdout) == 0 ? 0 : 1);
}

int main(int argc, char **argv) {
  char reason[KM_MESH_MAX_REASON];
  if (argc != 2 || isatty(STDOUT_FILENO)) {
    fputs("usage: kmech-mesh FILE >STREAM; kmech's library starts it to read a mesh\n", stderr);
    return 2;
  }
  if (!limit_all())
    end(refuse("can't be read: the limits of time and memory can't be set"));
  /* Polygons become triangles; every part goes where the scene's nodes put it. */
  const struct aiScene *scene = aiImportFile(argv[1], aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (scene)
    end(write_scene(scene));
  bool large = strstr(aiGetErrorString(), "bad_alloc") != NULL;
  snprintf(reason, sizeof reason, "isn't a mesh that can be read: %.200s",
           large ? "it needs more than 800 MB of memory; it is damaged or too large" : aiGetErrorString());
  end(refuse(reason));
}
