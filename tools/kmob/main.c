/* kmob's commands. */
#include "kmob/kmob.h"

static const kt_command commands[] = {
    {"info", "topology, substructures, mobility and mobility numbers at the file's pose", kmob_info},
    {"at", "the same at a pose: --set JOINT=VALUE", kmob_at},
    {"frame", "where a frame is and how it moves: --frame BODY/FRAME", kmob_frame},
    {"sweep", "every mobility number over a driver's range: tables and plots", kmob_sweep},
    {"allowance", "the play that redundant constraints need for errors of the parts", kmob_allowance},
    {"motion", "how far, how fast and with which acceleration each joint and point moves", kmob_motion},
    {"report", "how the mechanism moves, as a report to hand on: PDF pages, or one HTML file", kmob_report},
    {"graph", "bodies, joints, loops and substructures as a graph for graphviz", kmob_graph},
    {"check", "everything suspicious about a model, and what to do", kmob_check},
    {"draw", "a picture of the mechanism in one or more poses", kmob_draw},
    {"plot", "columns of any table that the tools write, one over another", kmob_plot},
    {"convert", "write the checked model: other units, the assembled pose", kmob_convert},
    {"new", "a model to start from: a linkage, a crane, a platform or an arm, in any units", kmob_new},
    {"schema", "the JSON schema of the model format", kmob_schema},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kmob", "Mobility of mechanisms: which joint can drive a linkage, and where it has dead points.",
                     commands, argc, argv);
}
