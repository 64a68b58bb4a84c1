/* kspace's commands. */
#include "kspace/kspace.h"

static const kt_command commands[] = {
    {"modes", "all assembly modes: every way in which the loops close, each once and proved", kspace_modes},
    {"map", "sheets over two drivers, from each assembly mode, and their singularity curves", kspace_map},
    {"path", "a path between two configurations without a singularity of the drivers", kspace_path},
    {"turning", "where the driver goes fully round: its dead points over a number of the design", kspace_turning},
    {"clearance", "distances of bodies, and where they touch: at a pose, or over a motion", kspace_clearance},
    {0}};

kt_exit kspace_write_csv(const kt_common *common, const char *base, const km_table *table, const char *result) {
  size_t size = km_table_csv(table, NULL, 0);
  char *bytes = size > 0 ? KM_NEW(char, size + 1) : NULL;
  km_text out = {0};
  kt_exit written = KT_NO_MEMORY;
  if (bytes && km_table_csv(table, bytes, size + 1) == size) {
    km_text_add(&out, bytes);
    written = out.failed ? KT_NO_MEMORY : kt_write(common, base, result, "csv", &out);
  }
  km_free(bytes);
  km_text_free(&out);
  return written;
}

int main(int argc, char **argv) {
  return (int)kt_run("kspace",
                     "Configuration spaces: in which ways a mechanism can be assembled, and whether that is all.",
                     commands, argc, argv);
}
