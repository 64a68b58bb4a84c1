/* Reading robot descriptions: a URDF file of 60 joints and an MJCF file of 1000 bodies, beside parsing their XML
 * alone. */
#include "base/memory.h"
#include "base/text.h"
#include "bench.h"
#include "exchange/xml/xml.h"
#include "kmech/model.h"

typedef struct file {
  const char *name;
  km_text text;
} file;

static void read_model(void *context) {
  const file *f = context;
  km_model *model;
  km_error error;
  if (km_model_read(f->text.data, f->text.size, NULL, &model, &error))
    bench_fail(f->name, "%s", error.text);
  km_model_free(model);
}

static void parse_alone(void *context) {
  const file *f = context;
  km_arena arena = {0};
  km_xml *root;
  km_error error;
  if (km_xml_parse(f->text.data, f->text.size, NULL, &arena, &root, &error))
    bench_fail(f->name, "%s", error.text);
  km_arena_free(&arena);
}

static void write_chain(km_text *out, int joints) {
  km_text_add(out, "<robot name='chain'><link name='l0'/>");
  for (int i = 0; i < joints; ++i)
    km_text_format(
        out,
        "<link name='l%d'><inertial><origin xyz='0.1 0 0'/><mass value='1'/><inertia ixx='0.01' iyy='0.01' "
        "izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial><visual><geometry><box size='0.1 0.1 0.2'/></geometry>"
        "</visual></link><joint name='j%d' type='revolute'><origin xyz='0.2 0 0' rpy='0.1 0.2 0.3'/>"
        "<parent link='l%d'/><child link='l%d'/><axis xyz='0 0 1'/><limit lower='-1' upper='1' effort='1' "
        "velocity='1'/></joint>",
        i + 1, i, i, i + 1);
  km_text_add(out, "</robot>");
}

/* Trees of ten bodies each. */
static void write_forest(km_text *out, int bodies) {
  km_text_add(out, "<mujoco><worldbody>");
  for (int i = 0; i < bodies; ++i)
    km_text_format(out, "<body name='b%d' pos='%d 0 0'><joint name='j%d' axis='0 0 1'/><geom size='0.1'/>%s", i,
                   i % 10 ? 1 : i, i,
                   i % 10 == 9 ? "</body></body></body></body></body></body></body></body></body></body>" : "");
  km_text_add(out, "</worldbody></mujoco>");
}

static void compare(file *f, const char *figure, const char *ratio) {
  bench_contender both[2] = {{.name = "model", .run = read_model, .context = f},
                             {.name = "XML alone", .run = parse_alone, .context = f}};
  bench_time(both, sizeof both / sizeof *both);
  bench_figure("load", figure, 1e-6 * both[0].median);
  bench_figure("load", ratio, bench_ratio(&both[0], &both[1]));
  km_text_free(&f->text);
}

void bench_load(void) {
  file chain = {.name = "URDF"}, forest = {.name = "MJCF"};
  write_chain(&chain.text, 60);
  write_forest(&forest.text, 1000);
  compare(&chain, "URDF of 60 joints, ms", "URDF of 60 joints, model/XML");
  compare(&forest, "MJCF of 1000 bodies, ms", "MJCF of 1000 bodies, model/XML");
}
