/* Answers of kview's server: pulls agree with kmob, loops stay closed and on their branch, designs are restored as
 * saved, and invalid messages are refused. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kmech/arm.h"
#include "kmech/continuation.h"
#include "kview/messages.h"
#include "kview/server/access_control.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char *const models[] = {"a02",          "andrews",      "bennett", "bonnet",       "brake",   "bricard",
                                     "delta",        "excavator",    "fourbar", "iiwa14",       "jansen",  "klann",
                                     "panda",        "peaucellier",  "robot7r", "rssr",         "sarrus3", "sarrus4",
                                     "scissor_lift", "slider_crank", "stewart", "toggle_press", "vehicle", NULL};

static uint64_t state_of_chance = 1;
static double chance(double low, double high) {
  state_of_chance = state_of_chance * 6364136223846793005u + 1442695040888963407u;
  return low + (high - low) * (double)(state_of_chance >> 11) / 9007199254740992.0;
}

static kv_session open_session(const char *name) {
  static char path[512];
  snprintf(path, sizeof path, MODELS_DIR "/%s.json", name);
  kv_session s = {.opening = {.path = path}, .asked = {.kind = -1}};
  km_error error;
  if (kv_session_load(&s, &error))
    fail_msg("%s", error.text);
  return s;
}

static kv_answer tell(kv_session *s, const char *text) {
  kv_answer answer;
  kv_answer_message(s, text, strlen(text), &answer);
  assert_true(answer.bytes.size > 0 && !answer.bytes.failed);
  return answer;
}

/* The answer is of this kind: a word of JSON, or of bytes. */
static void expect(kv_session *s, const char *text, const char *kind) {
  kv_answer answer = tell(s, text);
  if (answer.binary) {
    static const char *const words[] = {"", "pose", "patch", "table"};
    assert_string_equal(words[(unsigned char)answer.bytes.data[0]], kind);
  } else {
    char begin[64];
    snprintf(begin, sizeof begin, "{\"kind\":\"%s\"", kind);
    if (strncmp(answer.bytes.data, begin, strlen(begin)) != 0)
      fail_msg("%s: expected %s, found %.300s", text, kind, answer.bytes.data);
  }
  km_text_free(&answer.bytes);
}

static void every_model_answers(void **unused) {
  (void)unused;
  for (const char *const *name = models; *name; ++name) {
    kv_session s = open_session(*name);
    expect(&s, "1 hello 1", "model");
    expect(&s, "2 pose", "pose");
    expect(&s, "3 motions", "motions");
    expect(&s, "4 forces", "forces");
    expect(&s, "5 mark", "pose");
    expect(&s, "6 write", "file");
    if (km_sweep_plan_default(s.model).coordinate >= 0) {
      km_sweep_plan plan = km_sweep_plan_default(s.model);
      char text[128];
      snprintf(text, sizeof text, "7 ask 0 %d %.17g %.17g 20", plan.coordinate, plan.from, plan.to);
      expect(&s, text, "table");
      expect(&s, "8 again", "table");
      snprintf(text, sizeof text, "9 track %d", plan.coordinate);
      expect(&s, text, "track");
    }
    kv_session_close(&s);
  }
}

static int coordinate_of(const kv_session *s, const char *label) {
  int coordinate = -1;
  km_error error;
  assert_int_equal(km_model_find_coordinate(s->model, label, &coordinate, &error), KM_OK);
  return coordinate;
}

/* Pulled to a value as by a slider, the numbers are those of `kmob at --set`. */
static void a_slider_leads_to_the_pose_of_kmob_at(void **unused) {
  (void)unused;
  static const struct {
    const char *model, *joint;
    double to;
  } cases[] = {{"excavator", "M", 2.9},
               {"klann", "A", 1.0},
               {"brake", "K", 23.0},
               {"bricard", "A", 2.0},
               {"slider_crank", "A", 3.0}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    kv_session s = open_session(cases[i].model);
    km_hold goal = {coordinate_of(&s, cases[i].joint), cases[i].to};
    char text[128];
    snprintf(text, sizeof text, "1 joint %d %.17g", goal.coordinate, goal.value);
    s.move.is_reached = false;
    for (int k = 0; k < 400 && !s.move.is_reached; ++k)
      expect(&s, text, "pose");
    km_mechanism *mechanism;
    km_state *state;
    km_error error;
    km_mobility mobility;
    assert_int_equal(km_mechanism_compile_at(s.model, NULL, 0, &goal, 1, &mechanism, &state, &error), KM_OK);
    km_mobility_compute(mechanism, state, &mobility);
    for (int c = 0; c < km_model_coordinate_count(s.model); ++c) {
      assert_true(fabs(km_state_coordinate(state, c) - km_state_coordinate(s.state, c)) <= 1e-8);
      assert_true(fabs(km_mobility_number(state, c) - km_mobility_number(s.state, c)) <= 1e-8);
    }
    km_state_free(state);
    km_mechanism_free(mechanism);
    kv_session_close(&s);
  }
}

/* The bucket's tip over 1000 random drags: loops closed, limits kept, branch unchanged. Cylinder lengths of the
 * excavator determine the configuration on a branch, so driving from the file's configuration gives the same one. */
static void the_bucket_keeps_its_branch(void **unused) {
  (void)unused;
  kv_session s = open_session("excavator");
  static const char *const cylinders[] = {"B", "M", "N", "O"};
  int n = km_model_coordinate_count(s.model);
  for (int drag = 0; drag < 1000; ++drag) {
    char text[256];
    snprintf(text, sizeof text, "1 point 5 1.2 -0.3 0 %.12g %.12g %.12g 0 0 0", chance(-4, 12), chance(-6, 6),
             chance(-4, 9));
    for (int k = 0; k < 3; ++k)
      expect(&s, text, "pose");
    assert_true(s.mobility.residual <= 1e-9 && s.mobility.mobility == 4);
    if (drag % 50)
      continue;
    km_hold goals[4];
    km_error error;
    for (int k = 0; k < 4; ++k) {
      goals[k].coordinate = coordinate_of(&s, cylinders[k]);
      goals[k].value = km_state_coordinate(s.state, goals[k].coordinate);
    }
    km_mechanism *mechanism;
    km_state *state;
    assert_int_equal(km_mechanism_compile_at(s.model, NULL, 0, goals, 4, &mechanism, &state, &error), KM_OK);
    for (int c = 0; c < n; ++c)
      assert_true(fabs(km_state_coordinate(state, c) - km_state_coordinate(s.state, c)) <= 1e-7);
    km_state_free(state);
    km_mechanism_free(mechanism);
  }
  kv_session_close(&s);
}

/* Bricard's linkage passes its two planar poses, where half of its numbers are 0, and comes round. */
static void bricard_goes_round(void **unused) {
  (void)unused;
  kv_session s = open_session("bricard");
  int zero_poses = 0, a = coordinate_of(&s, "A"), b = coordinate_of(&s, "B");
  double way = 0.0, last = km_state_coordinate(s.state, a), sense = 1.0, least_a = 1.0, least_b = 1.0;
  for (int k = 0; k < 900; ++k) {
    /* whichever of two neighbours can move now is pulled on */
    bool by_a = km_mobility_number(s.state, a) > km_mobility_number(s.state, b);
    int coordinate = by_a ? a : b;
    double before[2] = {km_state_coordinate(s.state, a), km_state_coordinate(s.state, b)};
    static double rate[2] = {1.0, 0.0};
    double direction = rate[by_a ? 0 : 1] == 0.0 ? sense : rate[by_a ? 0 : 1];
    char text[128];
    snprintf(text, sizeof text, "1 joint %d %.17g", coordinate,
             km_state_coordinate(s.state, coordinate) + copysign(0.05, direction));
    expect(&s, text, "pose");
    assert_true(s.mobility.residual <= 1e-9 && s.mobility.mobility == 1);
    double moved[2] = {km_state_coordinate(s.state, a) - before[0], km_state_coordinate(s.state, b) - before[1]};
    for (int i = 0; i < 2; ++i)
      rate[i] = moved[i] != 0.0 ? moved[i] : rate[i];
    way += fabs(km_state_coordinate(s.state, a) - last);
    last = km_state_coordinate(s.state, a);
    least_a = fmin(least_a, km_mobility_number(s.state, a));
    least_b = fmin(least_b, km_mobility_number(s.state, b));
    zero_poses += km_mobility_number(s.state, a) < 1e-3 || km_mobility_number(s.state, b) < 1e-3;
  }
  assert_true(way > 6.0 && zero_poses >= 2 && least_a < 1e-3 && least_b < 1e-3);
  kv_session_close(&s);
}

/* All rows of an arm's self-motion hold its effector. */
static void a_selfmotion_holds_the_effector(void **unused) {
  (void)unused;
  kv_session s = open_session("iiwa14");
  int frame = -1;
  km_error error;
  const char *const names[] = {"flange", "tool"};
  assert_int_equal(km_model_find_frame(s.model, names, 2, &frame, &error), KM_OK);
  expect(&s, "1 joint 1 0.7 5", "pose");
  expect(&s, "1 joint 3 -1.1 5", "pose");
  km_frame_pose before, after;
  assert_int_equal(km_frame_place(s.mechanism, s.state, frame, &before, &error), KM_OK);
  char text[64];
  snprintf(text, sizeof text, "2 selfmotion %d", frame);
  kv_answer answer = tell(&s, text);
  assert_memory_equal(answer.bytes.data, "{\"kind\":\"selfmotion\"", 20);
  int rows = 0;
  for (const char *at = strstr(answer.bytes.data, "\"q\":["); (at = strchr(at + 1, '[')) != NULL;) {
    double q[7];
    if (at[1] == '[')
      continue;
    const char *number = at + 1;
    for (int k = 0; k < 7; ++k) {
      char *end;
      q[k] = strtod(number, &end);
      number = end + 1;
    }
    assert_int_equal(kv_session_place(&s, q, &error), KM_OK);
    assert_int_equal(km_frame_place(s.mechanism, s.state, frame, &after, &error), KM_OK);
    for (int k = 0; k < 3; ++k)
      assert_true(fabs(after.p[k] - before.p[k]) <= 1e-8);
    ++rows;
  }
  assert_true(rows > 20);
  km_text_free(&answer.bytes);
  kv_session_close(&s);
}

/* Numbers of a table's answer, and how many there are. */
static const double *table_numbers(const kv_answer *answer, uint32_t *rows, uint32_t *columns) {
  uint32_t header;
  assert_int_equal(answer->bytes.data[0], KV_TABLE);
  memcpy(&header, answer->bytes.data + 8, sizeof header);
  memcpy(rows, answer->bytes.data + 12, sizeof *rows);
  memcpy(columns, answer->bytes.data + 16, sizeof *columns);
  assert_int_equal(answer->bytes.size, 20 + header + 8 * *rows * *columns);
  return (const double *)(const void *)(answer->bytes.data + 20 + header);
}

/* Cells of the five-bar's map are closed configurations, on the sheet of each mode; on its singularity curve the ends
 * of the cranks are two rods of 0.9 apart. */
static void a_map_has_closed_configurations(void **unused) {
  (void)unused;
  kv_session s = open_session("five_bar");
  km_error error;
  uint32_t rows, columns, sheets[3] = {0};
  expect(&s, "1 singular", "error");
  kv_answer answer = tell(&s, "2 map 0 4 -2 2 -2 2 10");
  const double *cells = table_numbers(&answer, &rows, &columns);
  for (uint32_t r = 0; r < rows; ++r) {
    const double *c = cells + r * columns; /* q.A q.E sheet aspect q.B q.C q.D … */
    const double q[] = {c[0], c[4], c[5], c[6], c[1]};
    assert_int_equal(kv_session_place(&s, q, &error), KM_OK);
    for (int k = 0; k < 5; ++k)
      assert_true(fabs(km_state_coordinate(s.state, k) - q[k]) <= 1e-9);
    ++sheets[(int)c[2]];
  }
  assert_true(sheets[1] > 80 && sheets[1] == sheets[2]);
  km_text_free(&answer.bytes);
  answer = tell(&s, "3 singular");
  const double *curve = table_numbers(&answer, &rows, &columns);
  assert_true(rows > 100);
  for (uint32_t r = 0; r < rows; ++r) {
    const double *c = curve + r * columns; /* curve kind q.A q.B q.C q.D q.E; the cranks stand up at 0 */
    double x = 1.0 - 0.6 * sin(c[6]) + 0.6 * sin(c[2]), y = 0.6 * cos(c[6]) - 0.6 * cos(c[2]);
    assert_true(fmin(fabs(hypot(x, y) - 1.8), hypot(x, y)) <= 1e-9); /* the rods are stretched or folded */
  }
  km_text_free(&answer.bytes);
  expect(&s, "4 map 0 4 -2 2 -2 2 201", "error");
  expect(&s, "5 map 0 0 -2 2 -2 2 10", "error");
  expect(&s, "6 map 0 9 -2 2 -2 2 10", "error");
  expect(&s, "7 hold 0 1", "model");
  expect(&s, "8 singular", "error"); /* the mechanism is another one */
  kv_session_close(&s);
}

/* Waits for the map that is being computed; other messages are answered meanwhile. */
static kv_answer mapped(kv_session *s) {
  double before = 0.0;
  for (;;) {
    kv_answer answer = tell(s, "50 mapped");
    if (answer.binary)
      return answer;
    const char *done = strstr(answer.bytes.data, "\"done\":");
    assert_non_null(done);
    double share = atof(done + 7);
    assert_true(share >= before && share < 1.0);
    before = share;
    km_text_free(&answer.bytes);
    expect(s, "51 pose", "pose");
  }
}

/* The outline of the workspace of a five-bar's point lies on circles around both pins: 0.9 + 0.6 and 0.9 - 0.6. */
static void a_map_is_computed_while_the_page_goes_on(void **unused) {
  (void)unused;
  kv_session s = open_session("five_bar");
  uint32_t rows, columns, count;
  int frame = -1;
  for (int f = 0; f < km_model_frame_count(s.model); ++f)
    frame = strcmp(km_model_frame_name(s.model, f), "P") == 0 ? f : frame;
  expect(&s, "1 mapped", "error");
  expect(&s, "2 stop", "error");
  expect(&s, "3 boundary", "error");
  expect(&s, "4 mapping 0 4 -2 2 -2 2 20 9999", "error");
  expect(&s, "5 mapping 0 4 -2 2 -2 2 20", "mapping");
  kv_answer answer = mapped(&s), waited = tell(&s, "6 map 0 4 -2 2 -2 2 20");
  const double *cells = table_numbers(&answer, &rows, &columns);
  assert_memory_equal(cells, table_numbers(&waited, &count, &columns), rows * columns * sizeof *cells);
  assert_int_equal(rows, count);
  km_text_free(&answer.bytes);
  km_text_free(&waited.bytes);
  expect(&s, "7 boundary", "error");
  char text[80];
  snprintf(text, sizeof text, "8 mapping 0 4 -3.14159 3.14159 -3.14159 3.14159 30 %d", frame);
  expect(&s, text, "mapping");
  answer = mapped(&s);
  km_text_free(&answer.bytes);
  answer = tell(&s, "9 boundary");
  const double *outline = table_numbers(&answer, &rows, &columns);
  assert_true(rows > 100);
  for (uint32_t r = 0; r < rows; ++r) {
    const double *p = outline + r * columns + 3; /* loop kind curve x y z */
    double from_pins[] = {hypot(p[0], p[1]), hypot(p[0] - 1.0, p[1])}, least = HUGE_VAL;
    for (int k = 0; k < 2; ++k)
      least = fmin(least, fmin(fabs(from_pins[k] - 1.5), fabs(from_pins[k] - 0.3)));
    assert_true(least <= 1e-8); /* the corners are crossings of curves that are exact to 1e-11 */
  }
  km_text_free(&answer.bytes);
  /* A map that is stopped, or whose mechanism changes, leaves the last one, or nothing, and the page goes on. */
  expect(&s, "10 mapping 0 4 -2 2 -2 2 200", "mapping");
  answer = tell(&s, "11 stop");
  km_text_free(&answer.bytes);
  expect(&s, "12 mapped", "error");
  expect(&s, "13 mapping 0 4 -2 2 -2 2 200", "mapping");
  expect(&s, "14 hold 0 1", "model");
  expect(&s, "15 mapped", "error");
  expect(&s, "16 hold 0 0", "model");
  expect(&s, "17 mapping 0 4 -2 2 -2 2 200", "mapping");
  kv_session_close(&s); /* a page that is closed leaves no thread behind */
}

static void undo_comes_back(void **unused) {
  (void)unused;
  kv_session s = open_session("fourbar");
  double first = km_state_coordinate(s.state, 0);
  expect(&s, "1 joint 0 1.2 1", "pose");
  expect(&s, "2 mark", "pose");
  expect(&s, "3 pivot 1 1 1.2 0", "model");
  expect(&s, "4 mark", "pose");
  double second = km_state_coordinate(s.state, 0);
  assert_true(s.edited);
  expect(&s, "5 undo -1", "pose");
  assert_true(!s.edited);
  expect(&s, "6 undo -1", "pose");
  assert_true(fabs(km_state_coordinate(s.state, 0) - first) <= 1e-12);
  expect(&s, "7 undo -1", "pose"); /* there is nothing before */
  expect(&s, "8 undo 1", "pose");
  expect(&s, "9 undo 1", "pose");
  assert_true(s.edited && fabs(km_state_coordinate(s.state, 0) - second) <= 1e-12);
  kv_session_close(&s);
}

/* A joint that was held in the meantime is held where it was then. */
static void undo_comes_back_to_what_is_held(void **unused) {
  (void)unused;
  kv_session s = open_session("fourbar");
  expect(&s, "1 joint 0 1.2 1", "pose");
  expect(&s, "2 mark", "pose");
  double first[2] = {km_state_coordinate(s.state, 0), km_state_coordinate(s.state, 3)};
  expect(&s, "3 joint 0 1.6 1", "pose");
  expect(&s, "4 mark", "pose");
  double held = km_state_coordinate(s.state, 3);
  expect(&s, "5 hold 3 1", "model");
  expect(&s, "6 undo -1", "pose");
  assert_true(fabs(km_state_coordinate(s.state, 0) - first[0]) <= 1e-9);
  assert_true(fabs(km_state_coordinate(s.state, 3) - first[1]) <= 1e-9);
  assert_true(fabs(held - first[1]) > 0.05);
  assert_int_equal(s.hold_count, 1);
  expect(&s, "7 undo 1", "pose");
  assert_true(fabs(km_state_coordinate(s.state, 3) - held) <= 1e-9);
  kv_session_close(&s);
}

/* Reads what was saved as a model of its own, at its pose. */
static void reads_back(const kv_session *s, const char *json) {
  const char *from = strstr(json, "\"text\":\"");
  char *text = malloc(strlen(json) + 1), *to = text;
  assert_non_null(from);
  for (from += 8; *from != '"'; ++from) { /* the escapes that the server writes */
    if (*from != '\\') {
      *to++ = *from;
      continue;
    }
    ++from;
    *to++ = *from == 'u' ? (char)strtol((char[]){from[1], from[2], from[3], from[4], 0}, NULL, 16) : *from;
    from += *from == 'u' ? 4 : 0;
  }
  km_model *model;
  km_mechanism *mechanism;
  km_state *state;
  km_error error;
  km_read_def def = {.file = s->opening.path};
  if (km_model_read_as(text, (size_t)(to - text), &def, NULL, &model, &error) ||
      km_mechanism_compile(model, NULL, 0, &mechanism, &error) || km_state_create(mechanism, &state, &error) ||
      km_assemble(mechanism, state, NULL, &error))
    fail_msg("%s", error.text);
  km_poses_compute(mechanism, state);
  double length = km_mechanism_characteristic_length(mechanism, NULL);
  for (int j = 0; j < km_model_joint_count(model); ++j) {
    double a[3], b[3];
    km_frame_position(mechanism, state, km_model_joint_frame(model, j, true), a);
    km_frame_position(s->mechanism, s->state, km_model_joint_frame(s->model, j, true), b);
    for (int k = 0; k < 3; ++k)
      assert_true(fabs(a[k] - b[k]) <= 1e-7 * length);
  }
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  free(text);
}

/* A pivot that is moved keeps the pose, but for those of cylinders, which follow; the joint is where it was put; and
 * what is saved is the same mechanism. */
static void a_design_is_saved(void **unused) {
  (void)unused;
  static const char *const names[] = {"fourbar",   "klann",        "jansen", "toggle_press", "bennett", "slider_crank",
                                      "excavator", "scissor_lift", NULL};
  for (const char *const *name = names; *name; ++name) {
    kv_session s = open_session(*name);
    int n = km_model_coordinate_count(s.model), moved = 0;
    bool cylinders = strcmp(*name, "excavator") == 0 || strcmp(*name, "scissor_lift") == 0;
    bool slides =
        strcmp(*name, "toggle_press") == 0 || strcmp(*name, "slider_crank") == 0; /* its position is the origin of
                                                                                   * the ground */
    if (!cylinders) /* the excavator's would turn out of its plane */
      expect(&s, "1 joint 0 0.1", "pose");
    double *q = malloc((size_t)n * sizeof *q), length = km_mechanism_characteristic_length(s.mechanism, NULL);
    for (int j = 0; j < km_model_joint_count(s.model); ++j) {
      double at[3];
      char text[256];
      km_error error;
      int frames[2] = {km_model_joint_frame(s.model, j, false), km_model_joint_frame(s.model, j, true)};
      bool ground = km_model_frame_body(s.model, frames[0]) == 0 || km_model_frame_body(s.model, frames[1]) == 0;
      if (ground && (strcmp(km_model_frame_name(s.model, frames[0]), "origin") == 0 ||
                     strcmp(km_model_frame_name(s.model, frames[1]), "origin") == 0))
        continue;
      km_state_coordinates(s.mechanism, s.state, q, &error);
      km_frame_position(s.mechanism, s.state, frames[1], at);
      at[0] += 0.01 * length;
      at[1] += 0.0;
      snprintf(text, sizeof text, "2 pivot %d %.17g %.17g %.17g", j, at[0], at[1], at[2]);
      expect(&s, text, "model");
      for (int c = 0; c < n && !cylinders; ++c)
        assert_true(fabs(km_state_coordinate(s.state, c) - q[c]) <= 1e-7 * (1.0 + fabs(q[c])) ||
                    (slides && km_model_coordinate_is_length(s.model, c)));
      double now[3];
      km_frame_position(s.mechanism, s.state, frames[1], now);
      for (int k = 0; k < 3 && !slides; ++k)
        assert_true(fabs(now[k] - at[k]) <= 1e-9 * length);
      assert_true(s.mobility.residual <= 1e-9);
      ++moved;
    }
    free(q);
    if (moved) {
      kv_answer answer = tell(&s, "3 write");
      reads_back(&s, answer.bytes.data);
      km_text_free(&answer.bytes);
    }
    kv_session_close(&s);
  }
}

static void read_column(const char *text, int which, double *out, int count) {
  const char *at = strstr(text, "\"columns\":[") + strlen("\"columns\":[");
  for (int k = 0; k <= which; ++k)
    at = strchr(at, '[') + 1;
  for (int c = 0; c < count; ++c) {
    char *end;
    out[c] = strtod(at, &end);
    at = end + 1;
  }
}

/* The path-control column moves the effector along the direction alone, and the pose-control column not at all. */
static void columns_move_the_effector(void **unused) {
  (void)unused;
  kv_session s = open_session("iiwa14");
  int tool = km_model_frame_count(s.model) - 1;
  for (int direction = 0; direction < 6; ++direction) {
    char text[64];
    double J[6 * 7], q[7], rates[7];
    km_arm *arm;
    km_error error;
    snprintf(text, sizeof text, "1 columns %d %d", tool, direction);
    kv_answer answer = tell(&s, text);
    assert_int_equal(km_arm_create(s.mechanism, s.state, tool, KM_TASK_POSE, &arm, &error), KM_OK);
    km_state_coordinates(s.mechanism, s.state, q, &error);
    assert_int_equal(km_arm_jacobian(arm, q, J, &error), KM_OK);
    for (int k = 0; k < 2; ++k) {
      double twist[6] = {0};
      read_column(answer.bytes.data, k, rates, 7);
      for (int c = 0; c < 7; ++c)
        for (int r = 0; r < 6; ++r)
          twist[r] += J[6 * c + r] * rates[c];
      for (int r = 0; r < 6; ++r)
        assert_true(k == 0 && r == direction ? twist[r] > 1e-3 : fabs(twist[r]) < 1e-12);
    }
    km_arm_free(arm);
    km_text_free(&answer.bytes);
  }
  expect(&s, "1 columns 0 0", "error");
  expect(&s, "1 columns 999 0", "error");
  kv_session_close(&s);
}

static const char by_name[] =
    "{\"model_parameters\": {\"version\": \"1.1\"}, \"parameters\": {\"crank\": {\"value\": 2, \"low\": 1}, \"reach\": "
    "\"2*crank\", \"load\": 3}, \"poses\": {\"up\": {\"A\": 1.5}}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [{\"name\": "
    "\"b\", \"mass\": \"load\", \"frames\": [{\"name\": \"f\", \"T\": [\"reach\", 0, 0]}]}, {\"name\": \"c\"}], \"joints\": "
    "[{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}, {\"name\": \"B\", \"type\": \"Rz\", "
    "\"body_frame_pairs\": [\"b/f\", \"c\"]}]}]}";

static double reach_of(const kv_session *s) {
  double R[9], T[3] = {0};
  km_error error;
  for (int f = 0; f < km_model_frame_count(s->model); ++f)
    if (strcmp(km_model_frame_name(s->model, f), "f") == 0)
      km_model_frame_pose(s->model, f, R, T, &error);
  return T[0];
}

/* Dependent numbers follow a parameter; undo restores them, also past a dragged frame; the written file has both.
 * Poses have their names. */
static void parameters_and_poses_have_names(void **unused) {
  (void)unused;
  char path[] = "/tmp/kview_names.XXXXXX";
  double center[3];
  int file = mkstemp(path);
  assert_true(file >= 0 && write(file, by_name, sizeof by_name - 1) == (ssize_t)(sizeof by_name - 1));
  close(file);
  kv_session s = {.opening = {.path = path}, .asked = {.kind = -1}};
  km_error error;
  assert_int_equal(kv_session_load(&s, &error), KM_OK);
  assert_int_equal(s.parameters.count, 2);
  expect(&s, "1 named 0", "pose");
  assert_true(km_state_coordinate(s.state, 0) == 1.5);
  expect(&s, "2 named 1", "error");
  expect(&s, "3 parameters 5 7", "model");
  assert_true(reach_of(&s) == 10.0 && km_model_body_mass(s.model, 1, center) == 7.0 && s.edited);
  assert_true(km_state_coordinate(s.state, 0) == 1.5); /* the pose stays */
  expect(&s, "4 mark", "pose");
  expect(&s, "5 frame 2 11 0 0", "model");
  expect(&s, "6 parameters 6 7", "model");
  assert_true(reach_of(&s) == 13.0); /* dragged by 1, it goes on from there */
  kv_answer answer = tell(&s, "7 write");
  assert_non_null(strstr(answer.bytes.data, "[13, 0, 0]"));
  assert_non_null(strstr(answer.bytes.data, "value\\\": 6"));
  km_text_free(&answer.bytes);
  expect(&s, "8 undo -1", "pose");
  assert_true(reach_of(&s) == 10.0 && s.parameters.items[0].value == 5.0);
  expect(&s, "9 undo -1", "pose");
  assert_true(reach_of(&s) == 4.0 && !s.edited && km_model_body_mass(s.model, 1, center) == 3.0);
  expect(&s, "10 parameters 1", "error");
  expect(&s, "11 parameters 1 -1", "error"); /* a negative mass */
  assert_true(km_model_body_mass(s.model, 1, center) == 3.0);
  kv_session_close(&s);
  unlink(path);
}

/* A design is continued by another session of the same file, but not by one whose model has other parts. A saved
 * model finds its meshes from any folder. */
static void designs_are_kept(void **unused) {
  (void)unused;
  static const char meshed[] =
      "{\"model_parameters\": {\"include_dir\": \"parts\"}, \"assemblies\": [{\"name\": \"a\", "
      "\"bodies\": [{\"name\": \"b\", \"definition\": [\"link.stl\"]}], \"joints\": [{\"name\": \"A\", "
      "\"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"b\"]}]}]}";
  char path[] = "/tmp/kview_kept.XXXXXX", other[] = "/tmp/kview_other.XXXXXX", folder[64];
  int file = mkstemp(path), second = mkstemp(other);
  assert_true(file >= 0 && write(file, by_name, sizeof by_name - 1) == (ssize_t)(sizeof by_name - 1));
  assert_true(second >= 0 && write(second, meshed, sizeof meshed - 1) == (ssize_t)(sizeof meshed - 1));
  close(file);
  close(second);
  kv_session s = {.opening = {.path = path}, .asked = {.kind = -1}}, next = s, apart = s;
  apart.opening.path = other;
  km_error error;
  assert_int_equal(kv_session_load(&s, &error), KM_OK);
  assert_null(kv_session_keep(&s)); /* the file's own */
  expect(&s, "1 parameters 5 7", "model");
  expect(&s, "2 frame 2 11 0 0", "model");
  kv_design *design = kv_session_keep(&s);
  assert_non_null(design);
  assert_true(design->unsaved);
  assert_non_null(strstr(design->file.data, "[11, 0, 0]"));
  assert_int_equal(kv_session_load(&next, &error), KM_OK);
  assert_true(kv_session_restore(&next, design));
  assert_true(next.edited && next.unsaved && reach_of(&next) == 11.0 && next.parameters.items[0].value == 5.0);
  expect(&next, "3 parameters 6 7", "model");
  assert_true(reach_of(&next) == 13.0); /* dragged by 1 from 10 */
  kv_answer answer = tell(&next, "4 write");
  km_text_free(&answer.bytes);
  assert_true(next.edited && !next.unsaved);
  assert_int_equal(kv_session_load(&apart, &error), KM_OK);
  assert_false(kv_session_restore(&apart, design));
  answer = tell(&apart, "5 write");
  snprintf(folder, sizeof folder, "\\\"/tmp/parts\\\"");
  assert_non_null(strstr(answer.bytes.data, folder));
  assert_non_null(strstr(answer.bytes.data, "\\\"/tmp\\\""));
  km_text_free(&answer.bytes);
  kv_design_free(design);
  kv_session_close(&s);
  kv_session_close(&next);
  kv_session_close(&apart);
  unlink(path);
  unlink(other);
}

static void what_is_wrong_is_refused(void **unused) {
  (void)unused;
  static const char *const wrong[] = {"",
                                      " ",
                                      "x",
                                      "1",
                                      "1 ",
                                      "1 fly",
                                      "1 joint",
                                      "1 joint 0",
                                      "1 joint x 1",
                                      "1 joint 0 nan",
                                      "1 joint 0 inf",
                                      "1 joint 1e9 1",
                                      "1 joint -1 1",
                                      "1 joint 0.5 1",
                                      "1 hello 2",
                                      "1 place 1 2",
                                      "1 place 0 0 1e60 0",
                                      "1 hold 99 1",
                                      "1 point 99 0 0 0 0 0 0 0 0 0",
                                      "1 point 1 0 0",
                                      "1 ask 0 -1 0 0 0",
                                      "1 ask 99 0 0 1 10",
                                      "1 ask 0 0 0 1 99999999",
                                      "1 mode 3",
                                      "1 pivot 99 0 0 0",
                                      "1 pivot 0 0.1 0.1 0",
                                      "1 frame 999 0 0 0",
                                      "1 patch 0 0",
                                      "1 design 1",
                                      "1 parameters 1",
                                      "1 named 0",
                                      "1 columns 1 6",
                                      "1 lever 0 0",
                                      "1 track 99",
                                      "1 undo",
                                      "-1 pose"};
  kv_session s = open_session("fourbar");
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i)
    expect(&s, wrong[i], "error");
  kv_answer answer;
  char *large = malloc(KV_MOST_MESSAGE + 1);
  memset(large, '1', KV_MOST_MESSAGE + 1);
  kv_answer_message(&s, large, KV_MOST_MESSAGE + 1, &answer);
  assert_non_null(strstr(answer.bytes.data, "65536"));
  km_text_free(&answer.bytes);
  kv_answer_message(&s, "1 pose\0more", 11, &answer);
  assert_non_null(strstr(answer.bytes.data, "NUL"));
  km_text_free(&answer.bytes);
  free(large);
  kv_session_close(&s);
  expect(&s, "1 pose", "error"); /* no model */
}

static void only_this_page_comes_in(void **unused) {
  (void)unused;
  kv_guard g = {.port = 4711}, other;
  char path[128];
  assert_true(kv_guard_make(&g) && kv_guard_make(&other));
  assert_int_equal(strlen(g.token), 32);
  assert_string_not_equal(g.token, other.token);
  snprintf(path, sizeof path, "/%s/", g.token);
  assert_true(kv_guard_path(&g, path, "") && !kv_guard_path(&other, path, "") && !kv_guard_path(&g, path, "ws"));
  snprintf(path, sizeof path, "/%s/ws", g.token);
  assert_true(kv_guard_path(&g, path, "ws"));
  snprintf(path, sizeof path, "/%s/../etc/passwd", g.token);
  assert_true(!kv_guard_path(&g, path, "") && !kv_guard_path(&g, "/", "") && !kv_guard_path(&g, "", ""));
  assert_true(kv_guard_host(&g, "127.0.0.1:4711") && kv_guard_host(&g, "localhost:4711"));
  assert_true(!kv_guard_host(&g, "evil.example:4711") && !kv_guard_host(&g, "127.0.0.1:4712") &&
              !kv_guard_host(&g, ""));
  assert_true(kv_guard_origin(&g, "http://127.0.0.1:4711") && !kv_guard_origin(&g, "http://evil.example"));
  assert_true(!kv_guard_origin(&g, "") && !kv_guard_origin(&g, "null") &&
              !kv_guard_origin(&g, "http://127.0.0.1:47110"));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_model_answers),
      cmocka_unit_test(a_slider_leads_to_the_pose_of_kmob_at),
      cmocka_unit_test(the_bucket_keeps_its_branch),
      cmocka_unit_test(bricard_goes_round),
      cmocka_unit_test(undo_comes_back),
      cmocka_unit_test(undo_comes_back_to_what_is_held),
      cmocka_unit_test(a_selfmotion_holds_the_effector),
      cmocka_unit_test(a_map_has_closed_configurations),
      cmocka_unit_test(a_map_is_computed_while_the_page_goes_on),
      cmocka_unit_test(a_design_is_saved),
      cmocka_unit_test(columns_move_the_effector),
      cmocka_unit_test(designs_are_kept),
      cmocka_unit_test(parameters_and_poses_have_names),
      cmocka_unit_test(what_is_wrong_is_refused),
      cmocka_unit_test(only_this_page_comes_in),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
