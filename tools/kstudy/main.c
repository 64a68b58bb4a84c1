/* kstudy's commands. */
#include "kstudy/kstudy.h"

static const kt_command commands[] = {
    {"run", "ask every design of a study, and write plots, tables and the best model", kstudy_run},
    {"resume", "go on with a run that was stopped", kstudy_resume},
    {"show", "tables and plots from the store, without asking anything", kstudy_show},
    {"report", "a report to hand on from the store: PDF pages, or one HTML file", kstudy_report},
    {"export", "every design and its figures as CSV or JSON", kstudy_export},
    {"plan", "how long a run would take, from a measured pilot", kstudy_plan},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kstudy",
                     "Studies of designs: variants side by side, tolerances, the best design, from one core to many.",
                     commands, argc, argv);
}
