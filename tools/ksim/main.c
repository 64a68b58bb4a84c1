/* ksim's commands. */
#include "ksim/ksim.h"

static const kt_command commands[] = {
    {"run", "the motion over time under gravity, springs, motors and all that the model says", ksim_run},
    {"inverse", "the forces that a prescribed motion takes", ksim_inverse},
    {"report", "a run or an inverse motion as a report to hand on: PDF pages, or one HTML file", ksim_report},
    {"linearise", "state matrices, natural frequencies and modes about a pose", ksim_linearise},
    {"equilibrium", "a pose at rest, and whether it is stable", ksim_equilibrium},
    {"serve", "steps one by one, with inputs from another program", ksim_serve},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("ksim", "Forward dynamics: how a mechanism with closed loops moves over time.", commands, argc,
                     argv);
}
