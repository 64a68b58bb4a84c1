/* Meshes in files of several formats, weighed through a model's density. */
#include "support/solids.h"
#include "support/support.h"

#include "base/file.h"
#include "base/memory.h"
#include "exchange/mesh/plain_meshes.h"
#include "model/model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/kmech_mesh.XXXXXX";

static int make_folder(void **state) {
  (void)state;
  return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
  (void)state;
  static const char *const names[] = {"m.json", "part.obj", "part.ply", "text.stl", "binary.stl", "own.msh"};
  char path[64];
  for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
    snprintf(path, sizeof path, "%s/%s", folder, names[i]);
    unlink(path);
  }
  return rmdir(folder);
}

static void put(const char *name, km_text *text) {
  char path[64];
  km_error error;
  snprintf(path, sizeof path, "%s/%s", folder, name);
  if (km_file_write(path, text, &error))
    fail_msg("%s", error.text);
  km_text_free(text);
}

static void put_obj(const km_mesh *m, const char *name) {
  km_text text = {0};
  for (int i = 0; i < m->vertex_count; ++i)
    km_text_format(&text, "v %.9g %.9g %.9g\n", m->vertices[i].x, m->vertices[i].y, m->vertices[i].z);
  for (int t = 0; t < m->triangle_count; ++t) {
    const int *c = m->triangles[t].corner;
    km_text_format(&text, "f %d %d %d\n", c[0] + 1, c[1] + 1, c[2] + 1);
  }
  put(name, &text);
}

static void put_ply(const km_mesh *m, const char *name) {
  km_text text = {0};
  km_text_format(&text,
                 "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face %d\nproperty list uchar int vertex_indices\nend_header\n",
                 m->vertex_count, m->triangle_count);
  for (int i = 0; i < m->vertex_count; ++i)
    km_text_format(&text, "%.9g %.9g %.9g\n", m->vertices[i].x, m->vertices[i].y, m->vertices[i].z);
  for (int t = 0; t < m->triangle_count; ++t)
    km_text_format(&text, "3 %d %d %d\n", m->triangles[t].corner[0], m->triangles[t].corner[1],
                   m->triangles[t].corner[2]);
  put(name, &text);
}

static void put_text_stl(const km_mesh *m, const char *name) {
  km_text text = {0};
  km_text_add(&text, "solid part\n");
  for (int t = 0; t < m->triangle_count; ++t) {
    km_text_add(&text, "facet normal 0 0 0\nouter loop\n");
    for (int k = 0; k < 3; ++k) {
      km_vec3 v = m->vertices[m->triangles[t].corner[k]];
      km_text_format(&text, "vertex %.9g %.9g %.9g\n", v.x, v.y, v.z);
    }
    km_text_add(&text, "endloop\nendfacet\n");
  }
  km_text_add(&text, "endsolid part\n");
  put(name, &text);
}

static void put_binary_stl(const km_mesh *m, const char *name) {
  km_text text = {0};
  const char head[80] = "part";
  uint32_t count = (uint32_t)m->triangle_count;
  km_text_bytes(&text, head, sizeof head);
  km_text_bytes(&text, &count, sizeof count);
  for (int t = 0; t < m->triangle_count; ++t) {
    float numbers[12] = {0};
    for (int k = 0; k < 3; ++k) {
      km_vec3 v = m->vertices[m->triangles[t].corner[k]];
      numbers[3 + 3 * k] = (float)v.x;
      numbers[4 + 3 * k] = (float)v.y;
      numbers[5 + 3 * k] = (float)v.z;
    }
    km_text_bytes(&text, numbers, sizeof numbers);
    km_text_bytes(&text, "\0\0", 2);
  }
  put(name, &text);
}

/* MuJoCo's own format. `lost`: so many bytes are missing at its end. */
static void put_msh(const km_mesh *m, bool faces, int corner, size_t lost) {
  km_text text = {0};
  const int32_t counts[4] = {m->vertex_count, m->vertex_count, 0, faces ? m->triangle_count : 0};
  const float normal[3] = {0, 0, 1};
  km_text_bytes(&text, (const char *)counts, sizeof counts);
  for (int i = 0; i < m->vertex_count; ++i) {
    const float x[3] = {(float)m->vertices[i].x, (float)m->vertices[i].y, (float)m->vertices[i].z};
    km_text_bytes(&text, (const char *)x, sizeof x);
  }
  for (int i = 0; i < m->vertex_count; ++i)
    km_text_bytes(&text, (const char *)normal, sizeof normal);
  for (int t = 0; t < counts[3]; ++t) {
    const int32_t c[3] = {m->triangles[t].corner[0], m->triangles[t].corner[1],
                          t == 0 ? corner : m->triangles[t].corner[2]};
    km_text_bytes(&text, (const char *)c, sizeof c);
  }
  text.size -= lost;
  put("own.msh", &text);
}

/* A model in millimetres and grams with one body of density 0.5 g/mm³ and the mesh. */
static km_status load(const char *mesh, km_model **out, km_error *error) {
  char path[64];
  km_text text = {0};
  km_text_format(&text,
                 "{\"model_parameters\": {\"units\": {\"length\": \"millimeters\", \"mass\": \"grams\"}}, "
                 "\"assemblies\": [{\"name\": \"a\","
                 " \"bodies\": [{\"name\": \"b\", \"definition\": [\"%s\"], \"density\": 0.5}], \"joints\": "
                 "[{\"name\": \"J\", \"type\": \"Rz\","
                 " \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}",
                 mesh);
  put("m.json", &text);
  snprintf(path, sizeof path, "%s/m.json", folder);
  return km_model_read_file(path, NULL, out, error);
}

static void files(void **state) {
  (void)state;
  static const char *const names[] = {"part.obj", "part.ply", "text.stl", "binary.stl"};
  km_rotation R = solid_turn(0.1, 0.7, -0.4);
  km_mesh *m = solid_prism(24, 12.5, 40, 0);
  solid_move(m, &R, (km_vec3){30, -20, 10});
  km_mass_properties p = solid_weigh(m);
  put_obj(m, names[0]);
  put_ply(m, names[1]);
  put_text_stl(m, names[2]);
  put_binary_stl(m, names[3]);
  for (int i = 0; i < 4; ++i) {
    km_model *model;
    km_error error;
    if (load(names[i], &model, &error))
      fail_msg("%s", error.text);
    const km_model_body *body = &model->bodies[1];
    assert_near(body->mass / (0.5 * p.volume), 1, 1e-6);
    assert_near(km_vec3_norm(km_vec3_sub(body->center_of_mass, p.center)), 0, 1e-5);
    for (int k = 0; k < 6; ++k)
      assert_near(body->inertia[k] / (0.5 * p.inertia[0]), p.inertia[k] / p.inertia[0], 1e-6);
    km_model_free(model);
  }
  km_mesh_free(m);
}

/* A prism is convex: with its faces or without them it weighs the same. */
static void files_of_mujoco(void **state) {
  (void)state;
  km_mesh *m = solid_prism(24, 12.5, 40, 0);
  km_mass_properties p = solid_weigh(m);
  km_model *model;
  km_error error;
  for (int faces = 0; faces < 2; ++faces) {
    put_msh(m, faces, m->triangles[0].corner[2], 0);
    if (load("own.msh", &model, &error))
      fail_msg("%s", error.text);
    assert_near(model->bodies[1].mass / (0.5 * p.volume), 1, 1e-6);
    for (int k = 0; k < 6; ++k)
      assert_near(model->bodies[1].inertia[k] / (0.5 * p.inertia[0]), p.inertia[k] / p.inertia[0], 1e-6);
    km_model_free(model);
  }
  put_msh(m, true, m->vertex_count, 0);
  assert_int_equal(load("own.msh", &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "a corner that isn't there"));
  put_msh(m, true, -1, 0);
  assert_int_equal(load("own.msh", &model, &error), KM_MODEL);
  put_msh(m, true, 0, 4); /* no longer its format, nor any other one */
  assert_int_equal(load("own.msh", &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "isn't a mesh that can be read"));
  m->vertices[0].x = (double)NAN;
  put_msh(m, true, m->triangles[0].corner[2], 0);
  assert_int_equal(load("own.msh", &model, &error), KM_MODEL);
  for (int i = 0; i < m->vertex_count; ++i)
    m->vertices[i].z = 0, m->vertices[i].x = i;
  put_msh(m, false, 0, 0);
  assert_int_equal(load("own.msh", &model, &error), KM_MODEL);
  assert_non_null(strstr(error.text, "lie in a plane"));
  km_mesh_free(m);
}

static bool is_plain(const char *name, const char *bytes, size_t size, size_t *triangles) {
  km_text text = {0};
  km_soup soup = {0};
  km_text_bytes(&text, bytes, size);
  bool plain = km_plain_mesh_scan(name, &text, &soup);
  assert_false(soup.failed);
  *triangles = soup.count / 3;
  km_free(soup.corners);
  km_text_free(&text);
  return plain;
}

#define CORNERS "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 0.5 0\nv 0 0 1\n"
#define FACET   "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"

/* Mesh files read without assimp, and files left to it. */
static void plain_files_are_told_from_others(void **state) {
  (void)state;
  static const struct {
    const char *name, *text;
    int triangles; /* 0: it isn't plain */
  } cases[] = {
      {"a.obj", CORNERS "f 1 2 3\n", 1},
      {"A.OBJ",
       "# two\r\nmtllib x\\y.mtl\r\ng a b\r\n" CORNERS
       "vn 0 0 1\nvt 0 0\ns off\nusemtl m\nl 1 2\nf 1//1 2//1 3//1 4//1",
       2},
      {"a.obj", CORNERS "f -6 -5/1/1 -4\nf 1 2\n  f\t1/1 2 3 \n", 2},
      {"a.obj", CORNERS "f 1 2 3\nv 5e-1 +1 .5\nf 1 2 7\n", 2},
      {"a.obj", CORNERS, 0},
      {"a.obj", "", 0},
      {"a.obj", CORNERS "f 1 2 5 4 3\n", 0},                    /* it turns right */
      {"a.obj", CORNERS "f 1 2 3 6\n", 0},                      /* it isn't flat */
      {"a.obj", CORNERS "f 1 2 2 3\n", 0},                      /* no corner */
      {"a.obj", CORNERS "v 1 3 0\nv 1 -1 0\nf 1 3 8 4 2\n", 0}, /* a star */
      {"a.obj", CORNERS "f 1 2 7\n", 0},
      {"a.obj", CORNERS "f 0 1 2\n", 0},
      {"a.obj", CORNERS "f -7 1 2\n", 0},
      {"a.obj", CORNERS "f 1 2 three\n", 0},
      {"a.obj", CORNERS "f 1 2 \\\n3\n", 0},
      {"a.obj", CORNERS "f 1 2 3\rf 2 3 4\n", 0},
      {"a.obj", CORNERS "f 1 2 3\nvp 0 0\n", 0},
      {"a.obj", "v 0 0 0 1\n" CORNERS "f 1 2 3\n", 0},
      {"a.obj", "v 0 0 nan\n" CORNERS "f 1 2 3\n", 0},
      {"a.obj", "v 0 0 1e999\n" CORNERS "f 1 2 3\n", 0},
      {"a.obj", "v 0 0 0x1\n" CORNERS "f 1 2 3\n", 0},
      {"a.obj", "v 0 0\n" CORNERS "f 1 2 3\n", 0},
      {"a.obj", "v 0 0 1,5\n" CORNERS "f 1 2 3\n", 0},
      {"a.stl", "solid of two parts\n" FACET "\n  endsolid\nsolid\n" FACET "endsolid b\n", 2},
      {"a.stl", "solid\n" FACET, 0},
      {"a.stl", FACET "endsolid\n", 0},
      {"a.stl", "solid\nendsolid\n", 0},
      {"a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n", 0},
      {"a.stl", "solid\nfacet normal 0 0 1\nouter\n", 0},
  };
  size_t triangles;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    bool plain = is_plain(cases[i].name, cases[i].text, strlen(cases[i].text), &triangles);
    if (plain != (cases[i].triangles > 0) || (plain && triangles != (size_t)cases[i].triangles))
      fail_msg("case %zu: plain %d, %zu triangles", i, plain, triangles);
  }
  assert_false(is_plain("a.obj", CORNERS "f 1 2 3\0\n", sizeof CORNERS "f 1 2 3\0\n" - 1, &triangles));
}

/* Binary STL: its size has to be that of its count, and its numbers finite. */
static void binary_files_are_whole(void **state) {
  (void)state;
  char bytes[84 + 50] = "solid, though binary";
  const uint32_t one = 1;
  const float bad = HUGE_VALF;
  size_t triangles;
  memcpy(bytes + 80, &one, sizeof one);
  assert_true(is_plain("a.stl", bytes, sizeof bytes, &triangles) && triangles == 1);
  assert_false(is_plain("a.stl", bytes, sizeof bytes - 1, &triangles));
  memcpy(bytes + 100, &bad, sizeof bad);
  assert_false(is_plain("a.stl", bytes, sizeof bytes, &triangles));
}

/* An L, 1 thick, of three bars of 1 × 2, 1 and 1 × 2, its faces as polygons. With a statement that only assimp
 * knows, or with its two concave faces, it is assimp's: the same body. */
static void polygons_bound_the_same_body(void **state) {
  (void)state;
  static const char corners[] = "v 0 0 0\nv 3 0 0\nv 3 1 0\nv 1 1 0\nv 1 3 0\nv 0 3 0\n"
                                "v 0 0 1\nv 3 0 1\nv 3 1 1\nv 1 1 1\nv 1 3 1\nv 0 3 1\n"
                                "f 1 2 8 7\nf 2 3 9 8\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12\n";
  static const char convex[] = "f 1 4 3 2\nf 1 6 5 4\nf 7 8 9 10\nf 7 10 11 12\n",
                    concave[] = "f 6 5 4 3 2 1\nf 7 8 9 10 11 12\n";
  for (int way = 0; way < 3; ++way) {
    km_text text = {0};
    km_model *model;
    km_error error;
    size_t triangles;
    km_text_add(&text, way == 2 ? "vp 0 0\n" : "");
    km_text_add(&text, corners);
    km_text_add(&text, way == 1 ? concave : convex);
    assert_int_equal(is_plain("part.obj", text.data, text.size, &triangles), way == 0);
    put("part.obj", &text);
    if (load("part.obj", &model, &error))
      fail_msg("%s", error.text);
    const km_model_body *body = &model->bodies[1];
    const double tolerance = way == 0 ? 1e-14 : 1e-6;
    assert_near(body->mass, 0.5 * 5.0, 5 * tolerance);
    assert_near(body->center_of_mass.x, (3.0 * 1.5 + 2.0 * 0.5) / 5.0, 5 * tolerance);
    assert_near(body->center_of_mass.z, 0.5, 5 * tolerance);
    km_model_free(model);
  }
}

static void open_files(void **state) {
  (void)state;
  km_model *model;
  km_error error;
  km_mesh *m = solid_prism(5, 1, 1, 0);
  m->triangle_count -= 1;
  put_obj(m, "part.obj");
  assert_int_equal(load("part.obj", &model, &error), KM_MODEL);
  assert_null(model);
  assert_non_null(strstr(error.text, "assemblies[0].bodies[0].definition: "));
  assert_non_null(strstr(error.text, "has 3 open edges"));
  km_mesh_free(m);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(files),
                                     cmocka_unit_test(files_of_mujoco),
                                     cmocka_unit_test(open_files),
                                     cmocka_unit_test(plain_files_are_told_from_others),
                                     cmocka_unit_test(binary_files_are_whole),
                                     cmocka_unit_test(polygons_bound_the_same_body)};
  return cmocka_run_group_tests_name("mesh_files", tests, make_folder, remove_folder);
}
