/* Time of a message in kview's server: drags of the excavator's bucket and of a chain of 1000 four-bars, and the
 * mechanical advantage over the stroke after a pivot has moved; compared with closing and mobility of one
 * configuration. */
#include "bench.h"
#include "kview/messages.h"
#include "support/chains.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct hand {
  kv_session session;
  const char *texts[2]; /* there and back */
  int turn;
} hand;

static void open_file(hand *h, const char *path) {
  km_error error;
  h->session = (kv_session){.opening = {.path = path}, .asked = {.kind = -1}};
  if (kv_session_load(&h->session, &error))
    bench_fail("view", "%s", error.text);
}

static void tell(kv_session *s, const char *text) {
  kv_answer answer;
  kv_answer_message(s, text, strlen(text), &answer);
  if (!answer.binary && strncmp(answer.bytes.data, "{\"kind\":\"error\"", 15) == 0)
    bench_fail("view", "%s: %.200s", text, answer.bytes.data);
  km_text_free(&answer.bytes);
}

static void drag(void *context) {
  hand *h = context;
  tell(&h->session, h->texts[h->turn = !h->turn]);
}

/* The least that any answer needs: poses, pivots and numbers of the pose. */
static void follow(void *context) {
  kv_session_follow(&((hand *)context)->session);
}

static void pivot(void *context) {
  hand *h = context;
  tell(&h->session, h->texts[h->turn = !h->turn]);
  tell(&h->session, "1 again");
}

static void compare(const char *name, hand *h, void (*run)(void *)) {
  bench_contender contenders[] = {{.name = name, .run = run, .context = h},
                                  {.name = "pose alone", .run = follow, .context = h}};
  char figure[64];
  bench_time(contenders, sizeof contenders / sizeof *contenders);
  snprintf(figure, sizeof figure, "%s_ms", name);
  bench_figure("view", figure, contenders[0].median * 1e-6);
  snprintf(figure, sizeof figure, "%s_over_pose", name);
  bench_figure("view", figure, bench_ratio(&contenders[0], &contenders[1]));
  kv_session_close(&h->session);
}

static void excavator(void) {
  hand h = {.texts = {"1 point 5 1.2 -0.3 0 5.9 0.2 1.4 0 0 0", "1 point 5 1.2 -0.3 0 6.2 -0.2 1.1 0 0 0"}};
  open_file(&h, BENCH_MODELS "/excavator.json");
  compare("excavator_drag", &h, drag);
  hand joint = {.texts = {"1 joint 10 2.5", "1 joint 10 2.6"}};
  open_file(&joint, BENCH_MODELS "/excavator.json");
  compare("excavator_slider", &joint, drag);
}

/* n parallelograms, each rocker the next one's crank. */
static void chain(void) {
  char path[] = "/tmp/kview-bench-XXXXXX";
  km_text text = {0};
  write_chain(&text, 1000);
  int file = mkstemp(path);
  if (file < 0 || write(file, text.data, text.size) != (ssize_t)text.size)
    bench_fail("view", "%s can't be written", path);
  close(file);
  km_text_free(&text);
  hand h = {0};
  open_file(&h, path);
  static char texts[2][128];
  for (int k = 0; k < 2; ++k) {
    snprintf(texts[k], sizeof texts[k], "1 joint 0 %.17g",
             km_state_coordinate(h.session.state, 0) + (k ? 0.02 : -0.02));
    h.texts[k] = texts[k];
  }
  compare("chain1000_slider", &h, drag);
  open_file(&h, path);
  km_frame_pose X;
  km_error error;
  int body = km_model_body_count(h.session.model) - 1;
  km_frame_place(h.session.mechanism, h.session.state, h.session.origin[body], &X, &error);
  for (int k = 0; k < 2; ++k)
    snprintf(texts[k], sizeof texts[k], "1 point %d 0 0 0 %.17g %.17g %.17g 0 0 1", body, X.p[0] + (k ? 0.02 : -0.02),
             X.p[1], X.p[2]);
  compare("chain1000_drag", &h, drag);
  unlink(path);
}

static void brake(void) {
  hand h = {0};
  static char texts[2][160];
  double at[3];
  int joint = -1;
  km_error error;
  open_file(&h, BENCH_MODELS "/brake.json");
  tell(&h.session, "1 hello 1");
  km_port input, output;
  km_sweep_plan plan = km_sweep_plan_default(h.session.model);
  char ask[160];
  if (!km_port_default(h.session.model, false, &input) || !km_port_default(h.session.model, true, &output) ||
      km_model_find_joint(h.session.model, "D", &joint, &error))
    bench_fail("view", "the brake has no leverage");
  for (int kind = 0; kv_question_kind(&h.session, kind) >= 0; ++kind)
    if (strcmp(km_question_kind_name(kv_question_kind(&h.session, kind)), "advantage") == 0) {
      snprintf(ask, sizeof ask, "1 ask %d %d %.17g %.17g 199 %d %d", kind, plan.coordinate, plan.from, plan.to,
               input.coordinate, output.coordinate);
      tell(&h.session, ask);
    }
  km_frame_position(h.session.mechanism, h.session.state, km_model_joint_frame(h.session.model, joint, true), at);
  for (int k = 0; k < 2; ++k) {
    snprintf(texts[k], sizeof texts[k], "1 pivot %d %.17g %.17g %.17g", joint, at[0] + (k ? 0.2 : 0.0), at[1], at[2]);
    h.texts[k] = texts[k];
  }
  compare("brake_pivot_and_200_rows", &h, pivot);
}

void bench_view(void) {
  excavator();
  chain();
  brake();
}
