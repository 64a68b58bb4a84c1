/* kstatic's commands. */
#include "kstatic/kstatic.h"

static const kt_command commands[] = {
    {"at", "actuator forces and reactions at a pose", kstatic_at},
    {"sweep", "actuator forces and reactions over a driver's range, with peaks and balances", kstatic_sweep},
    {"report", "the same as a report to hand on: PDF pages, or one HTML file", kstatic_report},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kstatic", "Static forces: what actuators must hold, and what every joint carries.", commands,
                     argc, argv);
}
