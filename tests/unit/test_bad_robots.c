/* Errors and warnings of the readers of URDF, MJCF and SDF, each with its text. */
#include "support/refusals.h"

#include "base/text.h"
#include "kmech/base.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#define ROBOT(inside) "<robot name='r'><link name='a'/><link name='b'/>" inside "</robot>"
#define ENDS          "<parent link='a'/><child link='b'/>"

static const told_text urdf[] = {
    {ROBOT("<joint type='fixed'>" ENDS "</joint>"), "a joint without a name"},
    {ROBOT("<link name='c'/><joint name='J' type='fixed'>" ENDS
           "</joint><joint name='J' type='fixed'><parent link='a'/><child link='c'/></joint>"),
     "joint \"J\": this name is used twice"},
    {ROBOT("<joint name='J' type='revolute'>" ENDS "<axis xyz='0 0 0'/></joint>"), "its axis is 0 0 0"},
    {ROBOT("<link/>"), "a link without a name"},
    {"<robot name='r'/>", "found no link; expected at least one"},
    {ROBOT("<joint name='J' type='fixed'>" ENDS
           "</joint><joint name='K' type='fixed'><parent link='b'/><child link='a'/></joint>"),
     "every link is child of a joint"},
    {ROBOT("<joint name='J' type='revolute'>" ENDS "<limit lower='low' upper='1' effort='1' velocity='1'/></joint>"),
     "found \"low\"; expected a number"},
};

#define WORLD(inside)        "<mujoco><worldbody>" inside "</worldbody></mujoco>"
#define BEFORE(head, inside) "<mujoco>" head "<worldbody>" inside "</worldbody></mujoco>"
#define PAIR                 "<body name='a'><joint name='A'/><body name='b'><joint name='B'/></body></body>"
#define MESH(mesh)                                                                                                     \
  BEFORE("<asset><mesh name='m' " mesh "/></asset>", "<body><joint/><geom type='mesh' mesh='m'/></body>")
#define JOINTS_8 "<joint/><joint/><joint/><joint/><joint/><joint/><joint/><joint/>"
#define CORNERS  "vertex='0 0 0 1 0 0 0 1 0 0 0 1' "

static const told_text mjcf[] = {
    {WORLD("<body><joint name='A'/><joint name='A' type='slide'/></body>"), "joint \"A\": this name is used twice"},
    {WORLD("<body name='a'/><body name='a'/>"), "body \"a\": this name is used twice"},
    {WORLD("<body name='a'><site name='s'/><site name='s'/></body>"), "site \"s\": this name is used twice"},
    {BEFORE("<compiler eulerseq='xyw'/>", ""), "eulerseq: found \"xyw\""},
    {BEFORE("<default><default><joint/></default></default>", ""), "a nested class of defaults without a name"},
    {WORLD("<body><joint axis='0 0 0'/></body>"), "found 0 0 0; expected a direction"},
    {WORLD("<body quat='0 0 0 0'/>"), "quat: found 0 0 0 0"},
    {WORLD("<body><joint/><geom type='box' size='1 0 1'/></body>"), "size: a box of no volume"},
    {WORLD("<body><joint type='roll'/></body>"), "type: found \"roll\"; expected hinge, slide, ball or free"},
    {WORLD("<body><body><freejoint name='F'/></body></body>"), "joint \"F\": a free joint inside of a body"},
    {MESH(CORNERS "inertia='thick'"), "inertia: found \"thick\""},
    {MESH("vertex='0 0 0 1'"), "vertex: found 4 numbers; expected three for each"},
    {MESH(CORNERS "face='0 1 7'"), "face: found the vertex 7; expected one of the 4"},
    {"<mujoco><worldbody>" PAIR "</worldbody><equality><connect body1='a' body2='b'/></equality></mujoco>",
     "a connection without anchor"},
    {"<mujoco><worldbody>" PAIR
     "</worldbody><equality><connect body1='a' body2='a' anchor='0 0 0'/></equality></mujoco>",
     "both ends are on the body \"a\""},
    {"<mujoco><worldbody><body><joint name='A' type='ball'/></body></worldbody><tendon><fixed name='t'><joint joint='A' coef='1'/>"
     "</fixed></tendon><equality><tendon tendon1='t'/></equality></mujoco>",
     "found the joint \"A\"; expected at most"},
    {WORLD("<body>" JOINTS_8 JOINTS_8 JOINTS_8 JOINTS_8 "<joint/></body>"), "a body with more than 32 joints"},
    {WORLD("<attach model='gone' body='x' prefix='p'/>"), "the model \"gone\" to attach isn't there"},
};

static const told_text mjcf_warned[] = {
    {"<mujoco><worldbody>" PAIR "</worldbody><equality><flex name='f'/></equality></mujoco>",
     "a constraint of the kind \"flex\" is left out"},
    {"<mujoco><worldbody>" PAIR "</worldbody><equality><tendon tendon1='t'/></equality></mujoco>",
     "found \"t\", which is no fixed tendon"},
    {"<mujoco><worldbody>" PAIR
     "</worldbody><tendon><fixed name='t'><joint joint='A' coef='1'/></fixed><fixed name='u'><joint "
     "joint='B' coef='1'/></fixed></tendon><equality><tendon tendon1='t' tendon2='u' polycoef='0 1 1 0 0'/></equality></mujoco>",
     "polycoef: found a curve between two tendons"},
    {"<robot name='r'><link name='a'><inertial><mass value='-2'/></inertial></link></robot>",
     "body \"a\": its mass is -2; it is taken as 0"},
};

#define MODEL(inside) "<sdf version='1.9'><model name='m'><link name='a'/><link name='b'/>" inside "</model></sdf>"
#define BETWEEN       "<parent>a</parent><child>b</child>"

static const told_text sdf[] = {
    {MODEL("<joint name='J' type='revolute'><parent>a</parent></joint>"), "joint \"J\" has no child"},
    {MODEL("<joint name='J' type='revolute'><child>b</child></joint>"), "joint \"J\" has no parent"},
    {MODEL("<joint name='J' type='elastic'>" BETWEEN "</joint>"), "joint \"J\": found the type \"elastic\""},
    {MODEL("<joint name='J' type='revolute'><parent>a</parent><child>a</child></joint>"),
     "joint \"J\": both ends are on \"a\""},
    {MODEL("<joint name='J' type='screw'>" BETWEEN
           "<axis><xyz>0 0 1</xyz></axis><thread_pitch>0</thread_pitch></joint>"),
     "joint \"J\": its thread_pitch is 0"},
    {MODEL("<model name='n'/><joint name='J' type='revolute'><parent>n</parent><child>a</child></joint>"),
     "joint \"J\": one of its ends is no link"},
    {MODEL("<joint name='J' type='revolute'>" BETWEEN "<axis><xyz>0 0 0</xyz></axis></joint>"), "its axis is 0 0 0"},
    {MODEL("<link/>"), "a link without a name"},
    {MODEL("<link name='a'/>"), "link \"a\": this name is used twice"},
    {"<sdf version='1.9'/>", "found no model"},
    {MODEL("<joint name='J' type='revolute'>" BETWEEN
           "<axis><xyz>0 0 1</xyz><mimic joint='J'><multiplier>1</multiplier></mimic></axis></joint>"),
     "joint \"J\" imitates itself"},
    {MODEL(
         "<link name='c'/><joint name='K' type='ball'><parent>a</parent><child>c</child></joint><joint name='J' type='revolute'>" BETWEEN
         "<axis><xyz>0 0 1</xyz><mimic joint='K'><multiplier>1</multiplier></mimic></axis></joint>"),
     "joint \"J\" imitates axis of \"K\"; expected two axes of joints that turn or slide"},
    {MODEL("<joint name='J' type='gearbox'>" BETWEEN
           "<gearbox_ratio>2</gearbox_ratio><gearbox_reference_body>a</gearbox_reference_body></joint>"),
     "found no joint between"},
};

static void urdf_is_refused(void **state) {
  (void)state;
  assert_models_told(urdf, COUNT(urdf), true);
}

static void mjcf_is_refused(void **state) {
  (void)state;
  assert_models_told(mjcf, COUNT(mjcf), true);
}

static void what_is_read_all_the_same_is_warned_of(void **state) {
  (void)state;
  assert_models_told(mjcf_warned, COUNT(mjcf_warned), false);
}

static void sdf_is_refused(void **state) {
  (void)state;
  assert_models_told(sdf, COUNT(sdf), true);
}

/* A file that includes another one a thousand times and once more. */
static void includes_end(void **state) {
  (void)state;
  enum { MOST = 1000 };
  char folder[] = "/tmp/kmech_includes.XXXXXX", path[64];
  km_text part = {0}, all = {0};
  assert_non_null(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/part.sdf", folder);
  km_text_add(&part, "<sdf version='1.9'><model name='p'><link name='l'/></model></sdf>");
  assert_int_equal(km_file_write(path, &part, NULL), KM_OK);
  km_text_add(&all, "<sdf version='1.9'><model name='m'><link name='a'/>");
  for (int i = 0; i <= MOST; ++i)
    km_text_format(&all, "<include><name>p%d</name><uri>%s</uri></include>", i, path);
  km_text_add(&all, "</model></sdf>");
  const told_text many = {all.data, "is one include too many; expected at most a thousand"};
  assert_models_told(&many, 1, true);
  unlink(path);
  rmdir(folder);
  km_text_free(&part);
  km_text_free(&all);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(urdf_is_refused), cmocka_unit_test(mjcf_is_refused),
                                     cmocka_unit_test(what_is_read_all_the_same_is_warned_of),
                                     cmocka_unit_test(sdf_is_refused), cmocka_unit_test(includes_end)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
