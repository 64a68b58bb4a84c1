/* Every allocation of the main jobs fails once: the job ends with KM_MEMORY, nothing crashes, nothing is leaked (which
 * the build under AddressSanitizer shows). */
#include "support/failing.h"
#include "support/lattices.h"
#include "support/support.h"

#include "base/memory.h"
#include "base/text.h"
#include "exchange/json/json.h"
#include "exchange/json/write/convert.h"
#include "kmech/kmech.h"
#include "kmech/report.h"
#include "report/charts/designs_plot.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A job from the model's text to the bytes of its result. */
typedef km_status (*job)(const char *json);

static km_status open_pose(const char *json, fixture *f) {
  km_error error;
  *f = (fixture){0};
  km_status status = km_model_read(json, strlen(json), NULL, &f->model, &error);
  return status ? status : km_mechanism_compile_at(f->model, NULL, 0, NULL, 0, &f->mechanism, &f->state, &error);
}

static km_status diagnose(const char *json) {
  fixture f;
  km_findings findings = {0};
  km_text text = {0};
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_check(f.mechanism, f.state, NULL, NULL, NULL, &findings, NULL);
  km_findings_free(&findings);
  km_text_free(&text);
  fixture_close(&f);
  return status;
}

/* Computes a question, and writes the answer as record, plot and report. */
static km_status write_answer(const fixture *f, const km_question *q) {
  km_answered answer = {q, "model", NULL, 0, NULL};
  km_chart *chart = NULL;
  km_arena arena = {0};
  km_text record = {0}, summary = {0}, plot = {0}, report = {0};
  const km_value *value = km_question_record(q, f->mechanism, "", "model", &arena);
  if (value)
    km_json_write(value, &record);
  km_question_print(q, f->mechanism, "model", &summary);
  km_status status = km_question_chart(&(const km_comparison){&answer, 1, false}, &chart, NULL);
  if (!status)
    status = km_chart_picture(chart, KM_PICTURE_SVG, &plot, NULL);
  if (!status && !km_question_mobility(q))
    status = km_question_report(&answer, "", true, &report, NULL);
  if (!status && (!value || arena.failed || record.failed || summary.failed || plot.failed || report.failed))
    status = KM_MEMORY;
  km_chart_free(chart);
  km_text_free(&report);
  km_text_free(&plot);
  km_text_free(&summary);
  km_text_free(&record);
  km_arena_free(&arena);
  return status;
}

static km_status ask(const char *json, const char *kind) {
  fixture f;
  km_question *q = NULL;
  km_option_value steps = {.whole = 3}, yes = {.flag = true};
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_question_create(f.mechanism, kind, &q, NULL);
  if (!status)
    status = km_question_set(q, "steps", &steps, NULL);
  if (!status && strcmp(kind, "forces") != 0)
    status = km_question_set(q, strcmp(kind, "mobility") == 0 ? "redundancies" : "transmission", &yes, NULL);
  if (!status)
    status = km_question_compute(q, f.state, NULL);
  if (!status)
    status = write_answer(&f, q);
  km_question_free(q);
  fixture_close(&f);
  return status;
}

static km_status ask_mobility(const char *json) {
  return ask(json, "mobility");
}

static km_status ask_advantage(const char *json) {
  return ask(json, "advantage");
}

static km_status ask_forces(const char *json) {
  return ask(json, "forces");
}

/* A simulation, its linearisation at the end, the plot and the record. */
static km_status simulate(const char *json) {
  fixture f;
  km_forces *forces = NULL;
  km_dynamics *dynamics = NULL;
  km_history history = {0};
  km_linear linear = {0};
  km_arena arena = {0};
  km_text out = {0};
  km_chart *chart = NULL;
  km_drawing *drawing = NULL;
  km_status status = open_pose(json, &f);
  km_history_def def = km_history_default(f.model); /* also for a NULL model */
  def.until = 0.02;
  def.every = 0.01;
  def.reactions = def.mobility = true;
  if (!status)
    status = km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL);
  if (!status)
    status = km_history_run(f.mechanism, forces, f.state, &def, &history, NULL);
  if (!status)
    status = km_dynamics_create(f.mechanism, forces, &dynamics, NULL);
  if (!status)
    status = km_linearise(dynamics, f.state, &linear, NULL);
  const km_plotted_history shown = {.mechanism = f.mechanism, .table = history.table, .name = "m"};
  if (!status)
    status = km_history_chart(&shown, &chart, NULL);
  if (!status)
    status = km_drawing_create(f.mechanism, &drawing, NULL);
  if (!status)
    status = km_drawing_add_path(drawing, 1, "path", NULL);
  if (!status)
    status = km_drawing_add_rows(drawing, history.table, NULL);
  if (!status) {
    static const double times[] = {0.0, 0.01, 0.02};
    const km_motion_page page = {.quantity = "time", .values = times, .seconds = 1.0, .chart = chart};
    status = km_drawing_page(drawing, &(const km_drawing_look){0}, &page, &out, NULL);
  }
  if (!status && (!km_history_record(f.mechanism, &def, &history, "", "m", &arena) ||
                  !km_linear_record(f.mechanism, f.state, &linear, "ksim", "m", &arena)))
    status = KM_MEMORY;
  if (!status) {
    km_linear_mat(&linear, &out);
    status = out.failed ? KM_MEMORY : KM_OK;
  }
  km_drawing_free(drawing);
  km_chart_free(chart);
  km_text_free(&out);
  km_arena_free(&arena);
  km_linear_free(&linear);
  km_dynamics_free(dynamics);
  km_history_free(&history);
  km_forces_free(forces);
  fixture_close(&f);
  return status;
}

/* A prescribed motion. */
static km_status invert(const char *json) {
  fixture f;
  km_forces *forces = NULL;
  km_history history = {0};
  const km_constant_rate rate = {0, 0.1};
  const km_inverse_def def = {.rates = &rate, .rate_count = 1, .until = 0.1, .steps = 2, .reactions = true};
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_forces_create(f.mechanism, NULL, NULL, 0, &forces, NULL);
  if (!status)
    status = km_inverse_run(f.mechanism, forces, f.state, &def, &history, NULL);
  km_history_free(&history);
  km_forces_free(forces);
  fixture_close(&f);
  return status;
}

/* Fails the first calls one by one, and later ones in growing strides: a job has thousands. A study sizes its
 * batches by the clock: a run that needed fewer calls than were counted had them all. */
static void fail_each_of(job run, const char *text) {
  failing_arm(0);
  assert_int_equal(run(text), KM_OK);
  long all = failing_calls();
  assert_true(all > 20);
  for (long n = 1; n <= all; n += 1 + n / 400) {
    failing_arm(n);
    km_status status = run(text);
    km_status expected = failing_calls() < n ? KM_OK : KM_MEMORY;
    failing_arm(0);
    if (status != expected)
      fail_msg("status %d where call %ld of %ld failed", (int)status, n, all);
  }
}

static void fail_each(job run, const char *model) {
  char *json = read_model_text(model);
  fail_each_of(run, json);
  km_free(json);
}

static void test_mobility(void **unused) {
  (void)unused;
  fail_each(ask_mobility, "fourbar");
}

static void test_advantage(void **unused) {
  (void)unused;
  fail_each(ask_advantage, "brake");
}

static void test_forces(void **unused) {
  (void)unused;
  fail_each(ask_forces, "excavator");
}

static void test_simulation(void **unused) {
  (void)unused;
  fail_each(simulate, "slider_crank");
}

static void test_inverse(void **unused) {
  (void)unused;
  fail_each(invert, "slider_crank");
}

static void test_check(void **unused) {
  (void)unused;
  fail_each(diagnose, "brake");
  fail_each(diagnose, "bricard");
}

/* A start that inverse kinematics finds, every shape but the weave, and every method. */
static const char study_text[] =
    "{\"model\": \"panda.json\", \"effector\": \"flange/origin\", \"path\": {\"segments\": ["
    "{\"type\": \"spline\", \"points\": [{\"T\": [0.4, 0, 0.6], \"time\": 0}, {\"T\": [0.4, 0.02, 0.6], \"time\": 1},"
    " {\"T\": [0.4, 0.03, 0.61], \"time\": 2}], \"steps\": 3},"
    "{\"type\": \"arc\", \"center\": [0.3, 0, 0.6], \"axis\": [0, 0, 1], \"angle\": 0.2, \"steps\": 3},"
    "{\"type\": \"line\", \"to\": [0.4, 0, 0.6], \"steps\": 3}]}, \"rates\": [9, 9, 9, 9, 9, 9, 9],"
    "\"methods\": [\"greedy\", {\"method\": \"lookahead\", \"levels\": 2, \"stride\": 2}, {\"method\": \"fixed\", "
    "\"joint\": \"joint3\"}, \"dls\", \"gradient\", {\"method\": \"dp\", \"spacing\": 1}, {\"method\": \"global\", "
    "\"evaluations\": 10}], \"objective\": {\"singular-value\": 1, \"limit-distance\": 0.1}}";

static km_status follow(const char *json) {
  fixture f;
  km_study_def def = km_study_def_default();
  km_study *study = NULL;
  km_track *track = NULL;
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_study_read(study_text, sizeof study_text - 1, "", NULL, &def, NULL);
  if (!status)
    status = km_study_bind(f.mechanism, f.state, &def, 1, NULL, &study, NULL);
  for (int i = 0; !status && i < km_study_methods(study); ++i) {
    km_track_plan plan = km_study_plan(study, i);
    status = km_track_run(km_study_arm(study), &plan, &track, NULL);
    km_track_free(track);
    track = NULL;
  }
  km_study_free(study);
  km_study_def_free(&def);
  fixture_close(&f);
  return status;
}

static void test_track(void **unused) {
  (void)unused;
  fail_each(follow, "panda");
}

static char poses_file[] = "/tmp/kmech_poses_XXXXXX";

/* The path of a file of poses, in the place of the text's own. */
static km_status take_poses(const char *json) {
  fixture f;
  km_study_def def = km_study_def_default();
  km_study *study = NULL;
  km_status status = open_pose(json, &f);
  if (!status)
    status = km_study_read_poses(poses_file, (km_study_place){"--path", true}, NULL, &def, NULL);
  if (!status)
    status = km_study_read(study_text, sizeof study_text - 1, "", NULL, &def, NULL);
  if (!status)
    status = km_study_bind(f.mechanism, f.state, &def, 1, NULL, &study, NULL);
  km_study_free(study);
  km_study_def_free(&def);
  fixture_close(&f);
  return status;
}

static void test_poses(void **unused) {
  (void)unused;
  static const char text[] = "x,y,z,rx,ry,rz,t\n0.4,0,0.6,0,3,0,0\n0.4,0.1,0.6,0,3,0,1\n";
  int handle = mkstemp(poses_file);
  assert_true(handle >= 0);
  assert_int_equal(write(handle, text, sizeof text - 1), sizeof text - 1);
  close(handle);
  fail_each(take_poses, "panda");
  unlink(poses_file);
}

/* Reads a robot description and writes it in the model format. */
static km_status convert(const char *text) {
  km_model *model = NULL;
  km_arena arena = {0};
  km_error error;
  const km_value *value;
  km_status status = km_model_read(text, strlen(text), NULL, &model, &error);
  if (!status)
    status = km_model_convert(model, &model->units, NULL, false, &arena, &value, &error);
  km_arena_free(&arena);
  km_model_free(model);
  return status;
}

/* A study from its text to its tables and pictures. */
static km_status study_designs(const char *json) {
  static const char text[] =
      "{\"model\": \"in memory\", \"parameters\": {\"crank\": \"crank.end.y\"}, \"sample\": {\"count\": 5,"
      "\"parameters\": {\"crank\": {\"uniform\": [0.5, 0.6]}}}, \"ask\": [{\"question\": \"mobility\","
      "\"options\": {\"steps\": 4, \"point\": \"crank/end\"}, \"bands\": [\"q.B\"], \"figures\": {"
      "\"stroke\": \"span q.B\", \"path\": {\"figure\": \"distance\", \"point\": \"rod/end\", \"through\": [[0, 1]]}}}]}";
  km_design_study_def def = km_design_study_default();
  km_design_study *study = NULL;
  km_text table = {0}, csv = {0}, picture = {0}, report = {0};
  km_error error;
  km_status status = km_design_study_read(text, strlen(text), NULL, &def, &error);
  def.model = NULL;
  def.bytes = json;
  def.size = strlen(json);
  if (!status)
    status = km_design_study_open(&def, NULL, false, &study, &error);
  if (!status)
    status = km_design_study_run(study, 1, NULL, NULL, &error);
  if (!status)
    status = km_designs_print(study, &def, "study", &table, &error);
  if (!status)
    status = km_designs_csv(study, &def, &csv, &error);
  if (!status)
    status = km_designs_report(study, &def, "study", NULL, true, &report, &error);
  const km_designs_shown shown = {.study = study, .def = &def, .name = "study", .format = KM_PICTURE_SVG};
  if (!status)
    status = km_designs_bands(&shown, 0, 0, &picture, &error);
  if (!status)
    status = km_designs_histogram(&shown, 0, &picture, &error);
  km_text_free(&table);
  km_text_free(&csv);
  km_text_free(&picture);
  km_text_free(&report);
  km_design_study_free(study);
  km_design_study_def_free(&def);
  return status;
}

static void test_designs(void **unused) {
  (void)unused;
  fail_each(study_designs, "slider_crank");
}

/* Nothing in them is left out: a note that finds no memory is lost without harm. */
static void test_robots(void **unused) {
  (void)unused;
  fail_each_of(convert, "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/></inertial></link>"
                        "<link name='c'/><joint name='j' type='prismatic'><origin xyz='1 0 0'/><parent link='a'/>"
                        "<child link='b'/></joint><joint name='k' type='continuous'><parent link='a'/><child link='c'/>"
                        "<axis xyz='1 1 0'/><mimic joint='j'/></joint></robot>");
  fail_each_of(
      convert,
      "<mujoco><default><joint axis='0 0 1' stiffness='2'/><default class='x'/></default><worldbody>"
      "<replicate count='2'><body name='b' childclass='x'><joint/><joint type='slide'/><geom size='1' mass='1'/><site name='s' "
      "pos='1 0 0'/></body></replicate></worldbody><equality><connect site1='s0' site2='s1'/>"
      "<joint joint1='b0' joint2='b1' polycoef='0 1 2'/></equality><actuator><motor joint='b0' ctrlrange='-1 1'/>"
      "</actuator><keyframe><key qpos='0 0 0 0'/></keyframe></mujoco>");
  fail_each_of(convert,
               "<sdf version='1.9'><model name='m'><link name='a'/><link name='b'><pose relative_to='a'/></link>"
               "<frame name='f' attached_to='a'><pose>1 0 0 0 0 0</pose></frame><joint name='j' type='universal'>"
               "<parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis><axis2><xyz>1 1 0</xyz></axis2>"
               "</joint></model></sdf>");
}

/* Writes a model in every format. */
static km_status write_all(const char *json) {
  km_model *model = NULL;
  km_bytes bytes;
  km_error error;
  km_status status = km_model_read(json, strlen(json), NULL, &model, &error);
  for (int format = KM_FORMAT_JSON; format <= KM_FORMAT_SDF && !status; ++format) {
    status = km_model_write_as(model, (km_model_format)format, NULL, NULL, NULL, &bytes, &error);
    km_bytes_free(&bytes);
  }
  km_model_free(model);
  return status;
}

static void test_written(void **unused) {
  (void)unused;
  fail_each_of(
      write_all,
      "{\"poses\": {\"home\": {\"A\": 1}}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": \"b\", "
      "\"shapes\": [{\"box\": [1, 2, 3], \"density\": 2}], \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}, "
      "{\"name\": \"c\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}], \"joints\": [{\"name\": \"A\", "
      "\"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}, {\"name\": \"B\", \"type\": \"universal\", "
      "\"body_frame_pairs\": [\"b/t\", \"c/t\"]}, {\"name\": \"C\", \"type\": \"screw\", \"pitch\": 1, "
      "\"body_frame_pairs\": [\"fixed\", \"c\"]}], \"couplings\": [{\"name\": \"k\", \"joints\": [\"A\", \"C\"], "
      "\"polynomial\": [0, 1, 2]}]}]}");
}

/* Mobility data of a state, bit by bit. */
typedef struct told {
  km_mobility mobility;
  km_advantage advantage;
  double numbers;
} told;

static km_status tell(const fixture *f, km_transfer *lever, told *out) {
  km_status status = km_mobility_compute(f->mechanism, f->state, &out->mobility);
  if (!status)
    status = km_transfer_compute(f->mechanism, f->state, lever, &out->advantage);
  out->numbers = 0.0;
  for (int c = 0; c < km_model_coordinate_count(f->model) && !status; ++c)
    out->numbers += (c + 1.0) * km_mobility_number(f->state, c);
  return status;
}

/* A state of the closed pose in which no pivots were searched yet. */
static void open_fresh(const char *json, fixture *f, km_transfer **lever) {
  km_port ends[2] = {{.kind = KM_PORT_JOINT, .coordinate = 0}, {.kind = KM_PORT_JOINT, .coordinate = 3}};
  assert_int_equal(open_pose(json, f), KM_OK);
  km_state *fresh;
  assert_int_equal(km_state_create(f->mechanism, &fresh, NULL), KM_OK);
  for (int c = 0; c < km_model_coordinate_count(f->model); ++c)
    assert_int_equal(km_state_set_coordinate(f->mechanism, fresh, c, km_state_coordinate(f->state, c), NULL), KM_OK);
  km_state_free(f->state);
  f->state = fresh;
  ends[0].name = km_model_coordinate_label(f->model, 0);
  ends[1].name = km_model_coordinate_label(f->model, 3);
  assert_int_equal(km_transfer_create(f->mechanism, &ends[0], &ends[1], lever, NULL), KM_OK);
}

/* Every call for memory fails once: the request says so, gives no number, and the next one is right. */
static long failures_leave_no_trace(const char *json) {
  fixture f;
  km_transfer *lever;
  told wanted, found;
  open_fresh(json, &f, &lever);
  failing_arm(0);
  assert_int_equal(tell(&f, lever, &wanted), KM_OK);
  long calls = failing_calls();
  km_transfer_free(lever);
  fixture_close(&f);
  for (long n = 1; n <= calls; ++n) {
    open_fresh(json, &f, &lever);
    failing_arm(n);
    km_status status = tell(&f, lever, &found);
    failing_arm(0);
    if (status != KM_MEMORY && (status || memcmp(&found.mobility, &wanted.mobility, sizeof wanted.mobility) != 0))
      fail_msg("call %ld: status %d, mobility %d", n, (int)status, found.mobility.mobility);
    for (int again = 0; again < 2; ++again) {
      assert_int_equal(tell(&f, lever, &found), KM_OK);
      if (memcmp(&found.mobility, &wanted.mobility, sizeof wanted.mobility) != 0 || found.numbers != wanted.numbers ||
          found.advantage.value != wanted.advantage.value)
        fail_msg("after call %ld: mobility %d, numbers %.17g; expected %d, %.17g", n, found.mobility.mobility,
                 found.numbers, wanted.mobility.mobility, wanted.numbers);
    }
    km_transfer_free(lever);
    fixture_close(&f);
  }
  return calls;
}

static void test_states(void **unused) {
  (void)unused;
  km_text json[3] = {{0}};
  write_balls(&json[0], 20);
  write_five_bars(&json[1], 60, 0.0);
  write_ball_couplers(&json[2], 30);
  long calls = 0;
  for (int i = 0; i < 3; ++i) {
    calls += failures_leave_no_trace(json[i].data);
    km_text_free(&json[i]);
  }
  assert_true(calls > 0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_mobility), cmocka_unit_test(test_advantage),  cmocka_unit_test(test_forces),
      cmocka_unit_test(test_check),    cmocka_unit_test(test_simulation), cmocka_unit_test(test_inverse),
      cmocka_unit_test(test_track),    cmocka_unit_test(test_poses),      cmocka_unit_test(test_robots),
      cmocka_unit_test(test_designs),  cmocka_unit_test(test_written),    cmocka_unit_test(test_states),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
