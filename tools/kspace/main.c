/* kspace's commands. */
#include "kspace/kspace.h"

static const kt_command commands[] = {
    {"modes", "all assembly modes: every way in which the loops close, each once and proved", kspace_modes},
    {"map", "sheets over two drivers, from each assembly mode, and their singularity curves", kspace_map},
    {"path", "a path between two configurations without a singularity of the drivers", kspace_path},
    {"turning", "where the driver goes fully round: its dead points over a number of the design", kspace_turning},
    {"volume", "how large the workspace of a point is: volume or area by samples, with an interval", kspace_volume},
    {"clearance", "distances of bodies, and where they touch: at a pose, or over a motion", kspace_clearance},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kspace",
                     "Configuration spaces: in which ways a mechanism can be assembled, and whether that is all.",
                     commands, argc, argv);
}
