/* Damaged files of meshes: whatever is cut off or changed, the reader gives a sound mesh or says why there is none. */
#include "support/support.h"

#include "base/file.h"
#include "kmech/base.h"
#include "model/geometry/mesh.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CUTS = 8, FLIPS = 8, KINDS = 7, VARIANTS = 1 + CUTS + FLIPS, FILES = KINDS * VARIANTS, PATH = 96 };

static char folder[] = "/tmp/kmech_damaged.XXXXXX";

/* A tetrahedron with legs 1, in each format. */
static const char ply[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
    "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
static const char off[] = "OFF\n4 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
/* Statements that only assimp reads: the plain reader leaves the file to it. */
static const char obj[] =
    "vp 0 0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nf 1//1 3//1 2//1\nf 1//1 2//1 4//1\nf 1//1 4//1 3//1\nf 2//1 3//1 4//1\n";
static const char gltf[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{"
    "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"buffers\":[{\"byteLength\":72,\"uri\":"
    "\"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/"
    "AAACAAEAAAABAAMAAAADAAIAAQACAAMA\"}],\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":48},{"
    "\"buffer\":0,\"byteOffset\":48,\"byteLength\":24}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,"
    "\"type\":\"VEC3\",\"min\":[0,0,0],\"max\":[1,1,1]},{\"bufferView\":1,\"componentType\":5123,\"count\":12,\"type\":"
    "\"SCALAR\"}]}";
static const char dae[] =
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>"
    "<unit meter=\"1\"/><up_axis>Z_UP</up_axis></asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\">"
    "<float_array id=\"a\" count=\"12\">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source=\"#a\" "
    "count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" "
    "type=\"float\"/></accessor></technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/>"
    "</vertices><triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p>"
    "</triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node id=\"n\">"
    "<instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/>"
    "</scene></COLLADA>";

static const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const uint16_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

static void add_chunk(km_text *out, uint16_t id, km_text *body) {
  uint32_t size = (uint32_t)body->size + 6;
  km_text_bytes(out, &id, sizeof id);
  km_text_bytes(out, &size, sizeof size);
  km_text_bytes(out, body->data, body->size);
  km_text_free(body);
}

static void make_3ds(km_text *out) {
  const uint16_t four = 4, flags = 7;
  km_text points = {0}, triangles = {0}, body = {0}, object = {0}, editor = {0}, scene = {0};
  km_text_bytes(&points, &four, sizeof four);
  km_text_bytes(&points, corners, sizeof corners);
  km_text_bytes(&triangles, &four, sizeof four);
  for (int f = 0; f < 4; ++f) {
    km_text_bytes(&triangles, faces[f], sizeof faces[f]);
    km_text_bytes(&triangles, &flags, sizeof flags);
  }
  add_chunk(&body, 0x4110, &points);
  add_chunk(&body, 0x4120, &triangles);
  km_text_bytes(&object, "part", 5);
  add_chunk(&object, 0x4100, &body);
  add_chunk(&editor, 0x4000, &object);
  add_chunk(&scene, 0x3D3D, &editor);
  add_chunk(out, 0x4D4D, &scene);
}

static void make_binary_ply(km_text *out) {
  const char *end = strstr(ply, "end_header\n") + strlen("end_header\n");
  const char *format = strstr(ply, "ascii"), three = 3;
  km_text_bytes(out, ply, (size_t)(format - ply));
  km_text_add(out, "binary_little_endian");
  km_text_bytes(out, format + strlen("ascii"), (size_t)(end - format) - strlen("ascii"));
  km_text_bytes(out, corners, sizeof corners);
  for (int f = 0; f < 4; ++f) {
    km_text_bytes(out, &three, 1);
    km_text_bytes(out, (const int32_t[]){faces[f][0], faces[f][1], faces[f][2]}, 12);
  }
}

static void make(int kind, km_text *out) {
  static const char *const texts[] = {ply, off, obj, gltf, dae};
  if (kind < 5)
    km_text_add(out, texts[kind]);
  else if (kind == 5)
    make_3ds(out);
  else
    make_binary_ply(out);
}

static void name_file(char path[PATH], int kind, int variant) {
  static const char *const endings[KINDS] = {"ply", "off", "obj", "gltf", "dae", "3ds", "PLY"};
  snprintf(path, PATH, "%s/%d.%s", folder, variant, endings[kind]);
}

/* Variant 0 is whole; then come files that end early, and files of which a byte has another value. */
static void damage(km_text *bytes, int kind, int variant) {
  if (variant == 0)
    return;
  if (variant <= CUTS) {
    bytes->size = bytes->size * (size_t)variant / (CUTS + 1);
    return;
  }
  uint32_t draw = 2654435761u * (uint32_t)(1 + kind * VARIANTS + variant);
  bytes->data[(draw >> 8) % bytes->size] ^= (char)(1u << (draw & 7));
}

static int make_files(void **state) {
  (void)state;
  if (!mkdtemp(folder))
    return -1;
  for (int i = 0; i < FILES; ++i) {
    char path[PATH];
    km_text bytes = {0};
    make(i / VARIANTS, &bytes);
    damage(&bytes, i / VARIANTS, i % VARIANTS);
    name_file(path, i / VARIANTS, i % VARIANTS);
    if (km_file_write(path, &bytes, NULL))
      return -1;
    km_text_free(&bytes);
  }
  return 0;
}

static int remove_files(void **state) {
  (void)state;
  char path[PATH];
  for (int i = 0; i < FILES; ++i) {
    name_file(path, i / VARIANTS, i % VARIANTS);
    unlink(path);
  }
  return rmdir(folder);
}

typedef struct reading {
  char path[PATH];
  km_status status;
  km_error error;
  bool sound; /* a mesh as it is promised */
  double volume;
} reading;

static void judge(const km_mesh *mesh, reading *r) {
  r->sound = mesh->vertex_count >= 0 && mesh->triangle_count >= 0;
  for (int v = 0; v < mesh->vertex_count; ++v)
    r->sound = r->sound && isfinite(km_vec3_norm(mesh->vertices[v]));
  for (int t = 0; t < mesh->triangle_count; ++t) {
    const int *c = mesh->triangles[t].corner;
    for (int k = 0; k < 3; ++k)
      r->sound = r->sound && c[k] >= 0 && c[k] < mesh->vertex_count;
    if (r->sound)
      r->volume += km_vec3_dot(mesh->vertices[c[0]], km_vec3_cross(mesh->vertices[c[1]], mesh->vertices[c[2]])) / 6.0;
  }
}

static void read_one(void *context, int index) {
  reading *r = (reading *)context + index;
  km_mesh *mesh;
  r->status = km_mesh_read(r->path, &mesh, &r->error);
  if (mesh)
    judge(mesh, r);
  km_mesh_free(mesh);
}

/* Seven formats, each whole, cut off at eight places and with a byte changed at eight, in sixteen threads. assimp
 * crashes, aborts or doesn't end on some of them. */
static void damaged_files_end_no_process(void **state) {
  (void)state;
  static reading all[FILES];
  for (int i = 0; i < FILES; ++i)
    name_file(all[i].path, i / VARIANTS, i % VARIANTS);
  km_parallel_for(FILES, 16, read_one, all);
  int refused = 0;
  for (int i = 0; i < FILES; ++i) {
    const reading *r = &all[i];
    if (i % VARIANTS == 0 && (r->status || fabs(r->volume - 1.0 / 6.0) > 1e-6))
      fail_msg("%s: %s, volume %g", r->path, r->status ? r->error.text : "read", r->volume);
    if (r->status ? r->status != KM_IO || !strstr(r->error.text, r->path) : !r->sound)
      fail_msg("%s: status %d: %s", r->path, (int)r->status, r->error.text);
    refused += r->status != KM_OK;
  }
  assert_true(refused > KINDS * CUTS / 2);
}

static void expect(const char *path, const char *words) {
  km_mesh *mesh;
  km_error error;
  assert_int_equal(km_mesh_read(path, &mesh, &error), KM_IO);
  assert_null(mesh);
  if (!strstr(error.text, words))
    fail_msg("%s\nexpected: %s", error.text, words);
}

/* Results don't depend on the caller's signals and descriptors. */
static void callers_may_ignore_signals(void **state) {
  (void)state;
  reading r = {.status = KM_OK};
  name_file(r.path, 0, 0);
  signal(SIGCHLD, SIG_IGN);
  signal(SIGALRM, SIG_IGN);
  signal(SIGPIPE, SIG_IGN);
  int output = dup(STDOUT_FILENO), input = dup(STDIN_FILENO);
  close(STDOUT_FILENO);
  close(STDIN_FILENO);
  read_one(&r, 0);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  close(input);
  close(output);
  if (r.status || fabs(r.volume - 1.0 / 6.0) > 1e-6)
    fail_msg("%s", r.error.text);
  name_file(r.path, 1, 3);
  expect(r.path, r.path);
  signal(SIGCHLD, SIG_DFL);
  signal(SIGALRM, SIG_DFL);
  signal(SIGPIPE, SIG_DFL);
}

static void sizes_and_formats_are_bounded(void **state) {
  (void)state;
  char path[PATH];
  km_text text = {0};
  km_error error;
  snprintf(path, sizeof path, "%s/0.blend", folder);
  expect("/dev/zero", "isn't a file");
  expect(folder, "isn't a file");
  expect("/nowhere/a.ply", "No such file");
  assert_int_equal(mkfifo(path, 0600), 0);
  expect(path, "isn't a file");
  unlink(path);
  km_text_add(&text, "BLENDER");
  assert_int_equal(km_file_write(path, &text, &error), KM_OK);
  expect(path, "expected .obj, .stl, .ply, .off, .dae, .gltf, .glb, .3ds or MuJoCo's .msh");
  assert_int_equal(truncate(path, (256l << 20) + 1), 0);
  expect(path, "has 268435457 bytes; expected at most 268435456");
  unlink(path);
  text.size = 0;
  snprintf(path, sizeof path, "%s/many.obj", folder);
  km_text_add(&text, "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
  for (int f = 0; f <= 2000000; ++f)
    km_text_add(&text, "f 1 2 3\n");
  assert_int_equal(km_file_write(path, &text, &error), KM_OK);
  expect(path, "has too many faces; expected at most 2000000");
  unlink(path);
  km_text_free(&text);
}

static void the_program_may_be_missing(void **state) {
  (void)state;
  char path[PATH];
  name_file(path, 0, 0);
  setenv("KMECH_LIBEXEC", "/nowhere", 1);
  expect(path, "kmech-mesh isn't found; expected it in libexec/kmech beside the library");
  setenv("KMECH_LIBEXEC", "", 1);
  reading r = {.status = KM_OK};
  strcpy(r.path, path);
  read_one(&r, 0);
  assert_int_equal(r.status, KM_OK);
  unsetenv("KMECH_LIBEXEC");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(damaged_files_end_no_process), cmocka_unit_test(callers_may_ignore_signals),
      cmocka_unit_test(sizes_and_formats_are_bounded), cmocka_unit_test(the_program_may_be_missing)};
  return cmocka_run_group_tests_name("damaged_meshes", tests, make_files, remove_files);
}
