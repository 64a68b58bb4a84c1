/* Sweeps a model over its own range: a CSV table, and a plot of its mobility numbers for gnuplot. */
#include <kmech/kmech.h>
#include <stdio.h>
#include <string.h>

static int give_up(const km_error *error) {
  fprintf(stderr, "%s\n", error->text);
  return 1;
}

static void write_plot(const km_table *table, const char *data, FILE *out) {
  fprintf(out, "set datafile separator ','\nset yrange [0:1]\nset ylabel 'mobility number'\nplot");
  for (size_t c = 0; c < km_table_columns(table); ++c)
    if (strncmp(km_table_name(table, c), "m.", 2) == 0)
      fprintf(out, " '%s' using 2:%zu with lines title '%s',", data, c + 1, km_table_name(table, c) + 2);
  fprintf(out, "\n");
}

int main(int argc, char **argv) {
  km_model *model = NULL;
  km_mechanism *mechanism = NULL;
  km_state *state = NULL;
  km_mobility_sweep sweep = {0};
  km_error error;
  if (argc != 4) {
    fprintf(stderr, "usage: sweep MODEL.json OUT.csv OUT.gp\n");
    return 2;
  }
  km_status status = km_model_read_file(argv[1], NULL, &model, &error);
  if (!status)
    status = km_mechanism_compile(model, NULL, 0, &mechanism, &error);
  if (!status)
    status = km_state_create(mechanism, &state, &error);
  if (!status)
    status = km_assemble(mechanism, state, NULL, &error);
  km_sweep_plan plan = km_sweep_plan_default(model);
  if (!status)
    status = km_mobility_sweep_run(mechanism, state, &plan, &sweep, &error);
  if (status == KM_OK || status == KM_PARTIAL) /* a part of the range has rows, too */
    status = km_table_write_csv(sweep.motion.table, argv[2], &error);
  FILE *plot = status ? NULL : fopen(argv[3], "w");
  if (plot) {
    write_plot(sweep.motion.table, argv[2], plot);
    fclose(plot);
    printf("%zu rows, %zu toggles\n", km_table_rows(sweep.motion.table), sweep.toggle_count);
  }
  km_mobility_sweep_free(&sweep);
  km_state_free(state);
  km_mechanism_free(mechanism);
  km_model_free(model);
  return status ? give_up(&error) : 0;
}
