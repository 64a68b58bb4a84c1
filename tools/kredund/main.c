/* kredund's commands. */
#include "kredund/kredund.h"

static const kt_command commands[] = {
    {"track", "follow an effector path and use the spare freedom well: tables and plots", kredund_track},
    {"compare", "several methods on one path, side by side, with the map of self-motions", kredund_compare},
    {"report", "tracks as a report to hand on: PDF pages, or one HTML file", kredund_report},
    {"selfmotion", "every pose that holds the effector where it is, as a curve with its limits", kredund_selfmotion},
    {"ik", "every branch of poses that reach the path's first pose", kredund_ik},
    {"matrix", "path-control and pose-control columns of a Jacobian in a CSV file", kredund_matrix},
    {0}};

int main(int argc, char **argv) {
  return (int)kt_run("kredund", "Redundant arms: inverse kinematics, self-motion, and path tracking that looks ahead.",
                     commands, argc, argv);
}
