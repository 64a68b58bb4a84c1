#include "kma/kma.h"

static const kt_command commands[] = {{"at", "mechanical advantage at a pose", kma_at}, {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kma", "Mechanical advantage: how a mechanism trades speed for force.", commands, argc, argv);
}
