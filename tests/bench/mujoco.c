/* The four-bar in MuJoCo. */
#include "peers.h"

#include <mujoco/mujoco.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct bench_mujoco {
  mjModel *model;
  mjData *data;
};

/* The loop is closed where all joints are 0: bodies are turned, not joints. */
static const char text[] =
    "<mujoco><compiler angle='radian'/><option gravity='0 %g 0'><flag contact='disable'/></option><size njmax='20' nconmax='1'/><worldbody>"
    "<body name='crank' euler='0 0 %.17g'><joint axis='0 0 1'/>"
    "<inertial pos='%.17g 0 0' mass='1' diaginertia='1e-6 %.17g %.17g'/>"
    "<body name='coupler' pos='%.17g 0 0' euler='0 0 %.17g'><joint axis='0 0 1'/>"
    "<inertial pos='%.17g 0 0' mass='1' diaginertia='1e-6 %.17g %.17g'/></body></body>"
    "<body name='rocker' pos='%.17g 0 0' euler='0 0 %.17g'><joint axis='0 0 1'/>"
    "<inertial pos='%.17g 0 0' mass='1' diaginertia='1e-6 %.17g %.17g'/></body></worldbody>"
    "<equality><connect body1='rocker' body2='coupler' anchor='%.17g 0 0' solimp='0.9999 0.9999 0.001'/></equality>"
    "</mujoco>";

static double about_middle(double length) {
  return length * length / 12.0;
}

bench_mujoco *bench_mujoco_create(const bench_fourbar *b) {
  bench_mujoco *m = calloc(1, sizeof *m);
  mjVFS *files = calloc(1, sizeof *files);
  char xml[4096], error[500] = "out of memory";
  double i1 = about_middle(b->crank), i2 = about_middle(b->coupler), i3 = about_middle(b->rocker);
  int size = snprintf(xml, sizeof xml, text, -b->gravity, b->q[0], 0.5 * b->crank, i1, i1, b->crank, b->q[1],
                      0.5 * b->coupler, i2, i2, b->ground, b->q[2], 0.5 * b->rocker, i3, i3, b->rocker);
  if (m && files) {
    mj_defaultVFS(files);
    mj_makeEmptyFileVFS(files, "fourbar.xml", size);
    memcpy(files->filedata[0], xml, (size_t)size);
    m->model = mj_loadXML("fourbar.xml", files, error, sizeof error);
    mj_deleteVFS(files);
    m->data = m->model ? mj_makeData(m->model) : NULL;
  }
  free(files);
  if (!m || !m->data) {
    fprintf(stderr, "MuJoCo: %s\n", error);
    abort();
  }
  memcpy(m->data->qvel, b->v, sizeof b->v);
  return m;
}

void bench_mujoco_free(bench_mujoco *m) {
  mj_deleteData(m->data);
  mj_deleteModel(m->model);
  free(m);
}

void bench_mujoco_accelerate(bench_mujoco *m, double out[3]) {
  mj_forward(m->model, m->data);
  memcpy(out, m->data->qacc, 3 * sizeof *out);
}
