/* Meshes in files of several formats, weighed through a model's density. */
#include "support/solids.h"
#include "support/support.h"

#include "base/file.h"
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
  return km_model_load(path, NULL, out, error);
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
  const struct CMUnitTest tests[] = {cmocka_unit_test(files), cmocka_unit_test(files_of_mujoco),
                                     cmocka_unit_test(open_files)};
  return cmocka_run_group_tests_name("mesh_files", tests, make_folder, remove_folder);
}
