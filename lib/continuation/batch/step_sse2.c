/* The lanes of drives in registers of two doubles, which every processor has. */
#define NAME  km_batch_step_sse2
#define WIDTH 2
#include "continuation/batch/step_body.h"
