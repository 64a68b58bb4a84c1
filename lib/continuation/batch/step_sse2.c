/* The lanes of drives in registers of two doubles, which every processor has. */
#define NAME  km_lanes_step_plain
#define WIDTH 2
#include "continuation/batch/step_body.h"
