/* Cost of a program's force function: a damped four-bar whose damping is computed by a function, over the same law as a
 * force module. */
#include "bench.h"
#include "kmech/dynamics.h"
#include "kmech/mechanism.h"
#include "moving.h"

#include <stdio.h>
#include <string.h>

static const double damping = 0.5;
static const double span = 4.0;

/* One of both runs. */
typedef struct damped_run {
  bench_moving m;
  const km_user_forces *user; /* NULL: the model has the damper */
  double end;                 /* rate of the crank at the end */
} damped_run;

static bool damp(void *context, const km_motion_sample *sample, double *joint_forces, double (*wrenches)[6]) {
  (void)wrenches;
  joint_forces[0] = -*(const double *)context * sample->rate[0];
  return true;
}

static void run_damped(void *context) {
  damped_run *r = context;
  km_forces *forces = NULL;
  km_state *s = NULL;
  km_history h;
  km_error error = {0};
  km_history_def def = km_history_default(r->m.model);
  def.until = span;
  def.every = span;
  if (km_forces_create_own(r->m.mechanism, &forces, &error) ||
      (r->user && km_forces_set_user(forces, r->user, &error)) || km_state_create(r->m.mechanism, &s, &error))
    bench_fail("dynamics", "force function: %s", error.text);
  km_state_copy(r->m.mechanism, s, r->m.state);
  if (km_history_run(r->m.mechanism, forces, s, &def, &h, &error))
    bench_fail("dynamics", "force function: %s", error.text);
  r->end = km_table_row(h.table, km_table_rows(h.table) - 1)[km_table_find(h.table, "v.A")];
  km_history_free(&h);
  km_state_free(s);
  km_forces_free(forces);
}

/* The four-bar with a damper in its crank's joint. */
static void write_damped(char *out, size_t size) {
  const char *end = strstr(bench_fourbar_model, "}], \"fixed\"");
  snprintf(
      out, size,
      "%.*s, \"force_modules\": [{\"name\": \"d\", \"type\": \"damping\", \"input\": {\"type\": \"joint\", \"joint\": "
      "\"A\"}, \"knot_points\": [], \"coefficients\": [[0, %g]]}]%s",
      (int)(end - bench_fourbar_model), bench_fourbar_model, -damping, end);
}

void bench_force_function(void) {
  char text[4096];
  write_damped(text, sizeof text);
  double context = damping;
  const km_user_forces user = {.compute = damp, .context = &context};
  damped_run runs[2] = {{.m = bench_start(bench_fourbar_model), .user = &user}, {.m = bench_start(text)}};
  bench_contender contenders[2] = {{.name = "function", .run = run_damped, .context = &runs[0]},
                                   {.name = "module", .run = run_damped, .context = &runs[1]}};
  bench_time(contenders, 2);
  bench_agree("dynamics", "force function", &runs[0].end, &runs[1].end, 1, 1e-5);
  bench_figure("dynamics", "force function of a program, time over that of the same law built in",
               bench_ratio(&contenders[0], &contenders[1]));
  for (int i = 0; i < 2; ++i)
    bench_end(&runs[i].m);
}
