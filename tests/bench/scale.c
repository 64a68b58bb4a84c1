/* Many four-bars: in substructures of their own (time must be linear), and coupled into one (still dense). */
#include "bench.h"

#include "base/text.h"
#include "kmech/mobility.h"

#include <stdio.h>

/* N crank-rockers side by side on the ground. */
static void write_separate(km_text *t, int n) {
  km_text_add(t, "{\"fixed\": {\"frames\": [{\"name\": \"p\", \"T\": [0.4, 0, 0]}]}, \"assemblies\": [");
  for (int i = 0; i < n; ++i)
    km_text_format(
        t,
        "%s{\"name\": \"n%d\", \"bodies\": [{\"name\": \"l\", \"frames\": [{\"name\": \"t\", \"T\": [0.15, 0, 0]}]},"
        "{\"name\": \"c\", \"frames\": [{\"name\": \"t\", \"T\": [0.5, 0, 0]}]},"
        "{\"name\": \"r\", \"frames\": [{\"name\": \"t\", \"T\": [0.45, 0, 0]}]}], \"joints\": ["
        "{\"name\": \"A\", \"type\": \"Rz\", \"body_frame_pairs\": [\"fixed\", \"l\"], \"initial_displacement\": "
        "1.5707963267948966},"
        "{\"name\": \"B\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"l\", \"t\"], \"c\"], \"initial_displacement\": "
        "-0.9272952180016122},"
        "{\"name\": \"C\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c\", \"t\"], [\"r\", \"t\"]], "
        "\"initial_displacement\": 0.9272952180016122},"
        "{\"name\": \"D\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p\"], \"r\"], "
        "\"initial_displacement\": 1.5707963267948966}]}",
        i ? ", " : "", i);
  km_text_add(t, "]}");
}

/* N parallelograms, each rocker the next one's crank: one substructure of mobility 1. */
static void write_chain(km_text *t, int n) {
  km_text_add(t, "{\"fixed\": {\"frames\": [");
  for (int i = 0; i <= n; ++i)
    km_text_format(t, "%s{\"name\": \"p%d\", \"T\": [%d, 0, 0]}", i ? ", " : "", i, 2 * i);
  km_text_add(t, "]}, \"assemblies\": [{\"name\": \"a\", \"bodies\": [");
  for (int i = 0; i <= n; ++i)
    km_text_format(t,
                   "%s{\"name\": \"b%d\", \"frames\": [{\"name\": \"t\", \"T\": [1, 0, 0]}]}, {\"name\": \"c%d\", "
                   "\"frames\": [{\"name\": \"t\", \"T\": [2, 0, 0]}]}",
                   i ? ", " : "", i, i);
  km_text_add(t, "], \"joints\": [");
  for (int i = 0; i <= n; ++i)
    km_text_format(t,
                   "%s{\"name\": \"P%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"fixed\", \"p%d\"], \"b%d\"], "
                   "\"initial_displacement\": 1},"
                   "{\"name\": \"Q%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"b%d\", \"t\"], \"c%d\"], "
                   "\"initial_displacement\": -1}",
                   i ? ", " : "", i, i, i, i, i, i);
  for (int i = 0; i < n; ++i)
    km_text_format(t,
                   ", {\"name\": \"R%d\", \"type\": \"Rz\", \"body_frame_pairs\": [[\"c%d\", \"t\"], [\"b%d\", "
                   "\"t\"]], \"initial_displacement\": 1}",
                   i, i, i + 1);
  km_text_add(t, "]}]}");
}

/* Seconds to read, compile, assemble and analyse. */
static double whole(const char *bench, const km_text *text, int mobility) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_mobility found;
  km_error error;
  double start = bench_now();
  if (km_model_read(text->data, text->size, NULL, &model, &error) ||
      km_mechanism_compile(model, NULL, 0, &mechanism, &error) || km_state_create(mechanism, &state, &error) ||
      km_assemble(mechanism, state, NULL, &error))
    bench_fail(bench, "%s", error.text);
  km_mobility_update(mechanism, state, &found);
  double end = bench_now();
  if (found.mobility != mobility)
    bench_fail(bench, "mobility %d instead of %d", found.mobility, mobility);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return end - start;
}

static void measure(const char *bench, void (*write)(km_text *, int), int n, int mobility) {
  enum { RUNS = 5 };
  double seconds[RUNS];
  char figure[32];
  km_text text = {0};
  write(&text, n);
  for (int i = 0; i < RUNS; ++i)
    seconds[i] = whole(bench, &text, mobility);
  km_text_free(&text);
  snprintf(figure, sizeof figure, "us_per_loop_%d", n);
  bench_figure(bench, figure, 1e6 * bench_median(seconds, RUNS) / n);
}

void bench_scale(void) {
  for (int n = 10; n <= 10000; n *= 10)
    measure("scale/separate", write_separate, n, n);
  /* The last chain link's coupler hangs free: one freedom more. */
  for (int n = 10; n <= 160; n *= 2)
    measure("scale/chain", write_chain, n, 2);
}
