/* kma's commands. */
#include "kma/kma.h"

static const kt_command commands[] = {
    {"at", "mechanical advantage at a pose", kma_at},
    {"sweep", "mechanical advantage over a driver's range, with its dead points and extremes", kma_sweep},
    {"report", "the same as a report to hand on: PDF pages, or one HTML file", kma_report},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kma", "Mechanical advantage: how a mechanism trades speed for force.", commands, argc, argv);
}
