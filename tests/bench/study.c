/* Studies of designs: what a sample costs beside its sweep, threads, and memory over the number of samples. */
#include "kmech/study.h"
#include "bench.h"
#include "machine.h"
#include "question/question.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { FEW = 200, MANY = 100000, POSES = 200 };

static const km_design_parameter parameters[2] = {{"crank", "slider_crank.crank.end.y"},
                                                  {"rod", "slider_crank.rod.end.z"}};
static const km_design_spread spreads[2] = {{0, KM_NORMAL, .mean = 0.6, .deviation = 0.001},
                                            {1, KM_NORMAL, .mean = -1.5, .deviation = 0.001}};
static const double steps = POSES - 1;
static const km_design_option option = {.name = "steps", .numbers = &steps, .number_count = 1};
static const km_design_figure figures[3] = {
    {.name = "least", .kind = KM_DESIGN_MIN, .column = "m.A", .low = -HUGE_VAL, .high = HUGE_VAL},
    {.name = "greatest", .kind = KM_DESIGN_MAX, .column = "m.A", .low = -HUGE_VAL, .high = HUGE_VAL},
    {.name = "stroke", .kind = KM_DESIGN_SPAN, .column = "q.B", .low = -HUGE_VAL, .high = HUGE_VAL}};
static const km_design_question question = {.name = "mobility",
                                            .kind = "mobility",
                                            .options = &option,
                                            .option_count = 1,
                                            .figures = figures,
                                            .figure_count = 3};

/* A study of `count` slider-cranks of 200 poses each. */
typedef struct sampled {
  km_design_study_def def;
  km_design_sample sample;
  int jobs;
} sampled;

static sampled make(int count, int jobs) {
  sampled s = {.def = km_design_study_default(), .jobs = jobs};
  s.sample = (km_design_sample){.count = count, .seed = 1, .spreads = spreads, .spread_count = 2};
  s.def.model = BENCH_MODELS "/slider_crank.json";
  s.def.parameters = parameters;
  s.def.parameter_count = 2;
  s.def.questions = &question;
  s.def.question_count = 1;
  return s;
}

/* With a store of its own in memory, which is new each time. */
static void run_study(void *context) {
  sampled *s = context;
  km_design_study *study;
  km_error error;
  s->def.sample = &s->sample;
  if (km_design_study_open(&s->def, NULL, false, &study, &error) ||
      km_design_study_run(study, s->jobs, NULL, NULL, &error))
    bench_fail("study", "%s", error.text);
  km_design_study_free(study);
}

typedef struct sweeps {
  bench_machine machine;
  km_question *question;
  int count;
} sweeps;

/* The sweeps alone, of one design: from the assembled pose, with the three figures. */
static void run_sweeps(void *context) {
  sweeps *s = context;
  double value;
  for (int i = 0; i < s->count; ++i) {
    km_state_restart(s->machine.state);
    if (km_assemble(s->machine.mechanism, s->machine.state, NULL, NULL) ||
        km_question_compute(s->question, s->machine.state, NULL))
      bench_fail("study", "a sweep failed");
    for (int f = 0; f < 3; ++f)
      km_table_figure(km_question_table(s->question), figures[f].column, (km_figure)figures[f].kind, 0.0, &value, NULL,
                      NULL);
  }
}

/* One question about a batch of slider-cranks. */
typedef struct group {
  bench_machine machines[KM_BATCH_LANES];
  km_question *questions[KM_BATCH_LANES];
} group;

static group open_group(const char *kind) {
  group g;
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    const km_option_value interval_count = {.whole = POSES - 1};
    km_error error;
    g.machines[i] = bench_machine_load("slider_crank");
    const km_mechanism *m = g.machines[i].mechanism;
    if (km_question_create(m, kind, &g.questions[i], &error) ||
        km_question_set(g.questions[i], "steps", &interval_count, &error))
      bench_fail("study", "%s", error.text);
    const km_option_value input = {.end = {.kind = KM_PORT_JOINT, .coordinate = 0, .name = "A"}};
    const km_option_value output = {.end = {.kind = KM_PORT_JOINT, .coordinate = m->coordinate_count - 1, .name = "B"}};
    if (strcmp(kind, "advantage") == 0 && (km_question_set(g.questions[i], "input", &input, &error) ||
                                           km_question_set(g.questions[i], "output", &output, &error)))
      bench_fail("study", "%s", error.text);
  }
  return g;
}

static void close_group(group *g) {
  for (int i = 0; i < KM_BATCH_LANES; ++i) {
    km_question_free(g->questions[i]);
    bench_machine_free(&g->machines[i]);
  }
}

static km_state *begin(const bench_machine *machine) {
  km_state_restart(machine->state);
  if (km_assemble(machine->mechanism, machine->state, NULL, NULL))
    bench_fail("study", "no assembly");
  return machine->state;
}

static void ask_together(void *context) {
  group *g = context;
  km_state *states[KM_BATCH_LANES];
  km_status statuses[KM_BATCH_LANES];
  km_error errors[KM_BATCH_LANES];
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    states[i] = begin(&g->machines[i]);
  km_questions_compute(g->questions, states, KM_BATCH_LANES, statuses, errors);
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    if (statuses[i])
      bench_fail("study", "%s", errors[i].text);
}

static void ask_alone(void *context) {
  group *g = context;
  km_error error;
  for (int i = 0; i < KM_BATCH_LANES; ++i)
    if (km_question_compute(g->questions[i], begin(&g->machines[i]), &error))
      bench_fail("study", "%s", error.text);
}

/* Cost of a sample of a sweep, including the search for events between samples. */
static void kinds(void) {
  static const char *const names[] = {"mobility", "advantage", "forces"};
  for (int k = 0; k < 3; ++k) {
    char name[64];
    group g = open_group(names[k]);
    bench_contender c[] = {{.name = names[k], .run = ask_together, .context = &g},
                           {.name = "one by one", .run = ask_alone, .context = &g}};
    bench_time(c, sizeof c / sizeof *c);
    snprintf(name, sizeof name, "%s_microseconds_a_pose", names[k]);
    bench_figure("study", name, 1e-3 * c[0].median / (KM_BATCH_LANES * POSES));
    snprintf(name, sizeof name, "%s_one_by_one_over_side_by_side", names[k]);
    bench_figure("study", name, bench_ratio(&c[1], &c[0]));
    close_group(&g);
  }
}

/* The resident memory, in MB, at its greatest, of a study in a process of its own. */
static double memory_of(int count, const char *store) {
  struct rusage usage;
  int status;
  pid_t child = fork();
  if (child == 0) {
    sampled s = make(count, 1);
    static const double two = 2.0;
    static const km_design_option short_motion = {.name = "steps", .numbers = &two, .number_count = 1};
    km_design_question quick = question;
    km_design_study *study;
    quick.options = &short_motion;
    s.def.questions = &quick;
    s.def.sample = &s.sample;
    bool failed =
        km_design_study_open(&s.def, store, false, &study, NULL) || km_design_study_run(study, 1, NULL, NULL, NULL);
    km_design_study_free(study); /* including the side files of an open store */
    _exit(failed);
  }
  if (child < 0 || wait4(child, &status, 0, &usage) != child || status != 0)
    bench_fail("study", "a study of %d designs failed", count);
  unlink(store);
  return (double)usage.ru_maxrss / 1024.0;
}

static void memory(void) {
  char store[64];
  snprintf(store, sizeof store, P_tmpdir "/kmech_bench.%d.sqlite", (int)getpid());
  double small = memory_of(1000, store), large = memory_of(1000000, store);
  bench_figure("study", "memory_MB_of_1e3", small);
  bench_figure("study", "memory_MB_of_1e6", large);
}

static void renumber(void *context) {
  const bench_machine *machine = context;
  for (int i = 0; i < FEW; ++i)
    if (km_mechanism_renumber(machine->mechanism, NULL))
      bench_fail("study", "no new numbers");
}

static void many(void) {
  double seconds[2];
  for (int jobs = 1; jobs <= 2; ++jobs) {
    sampled s = make(MANY, jobs);
    double start = bench_now();
    run_study(&s);
    seconds[jobs - 1] = bench_now() - start;
  }
  bench_figure("study", "seconds_of_1e5_on_1_thread", seconds[0]);
  bench_figure("study", "seconds_of_1e5_on_2_threads", seconds[1]);
  bench_figure("study", "two_threads_over_one_of_1e5", seconds[0] / seconds[1]);
}

void bench_study(void) {
  static const km_design_setting pose = {"A", 0.5};
  sampled few = make(FEW, 1), more = make(2 * FEW, 1), two = make(2 * FEW, 2), posed = make(2 * FEW, 1);
  km_design_question from_pose = question;
  from_pose.sets = &pose;
  from_pose.set_count = 1;
  posed.def.questions = &from_pose;
  sweeps alone = {.machine = bench_machine_load("slider_crank"), .count = FEW};
  km_option_value value = {.whole = POSES - 1};
  if (km_question_create(alone.machine.mechanism, "mobility", &alone.question, NULL) ||
      km_question_set(alone.question, "steps", &value, NULL))
    bench_fail("study", "no question");
  bench_contender c[] = {{.name = "200 designs", .run = run_study, .context = &few},
                         {.name = "400 designs", .run = run_study, .context = &more},
                         {.name = "400 designs on two threads", .run = run_study, .context = &two},
                         {.name = "400 designs from a pose that is set", .run = run_study, .context = &posed},
                         {.name = "200 sweeps", .run = run_sweeps, .context = &alone},
                         {.name = "200 times new numbers", .run = renumber, .context = &alone.machine}};
  bench_time(c, sizeof c / sizeof *c);
  /* the cost of opening is in both studies */
  bench_figure("study", "overhead_per_sample", (c[1].median - c[0].median) / c[4].median - 1.0);
  bench_figure("study", "new_numbers_microseconds", 1e-3 * c[5].median / FEW);
  bench_figure("study", "two_threads_over_one", bench_ratio(&c[1], &c[2]));
  bench_figure("study", "pose_that_is_set_over_drawn_one", bench_ratio(&c[3], &c[1]));
  km_question_free(alone.question);
  bench_machine_free(&alone.machine);
  kinds();
  memory();
  many();
}
