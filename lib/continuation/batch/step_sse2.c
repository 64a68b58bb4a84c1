/* Batch step with registers of two doubles, which every x86-64 processor has. */
#define NAME  km_batch_step_sse2
#define WIDTH 2
#include "continuation/batch/step_body.h"
