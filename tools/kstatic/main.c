#include "kstatic/kstatic.h"

static const kt_command commands[] = {
    {"at", "actuator forces and reactions at a pose", kstatic_at},
    {"sweep", "actuator forces and reactions over a driver's range, with peaks and balances", kstatic_sweep},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kstatic", "Static forces: what actuators must hold, and what every joint carries.", commands,
                     argc, argv);
}
