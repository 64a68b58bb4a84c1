/* Commands of kma. */
#ifndef KMA_H
#define KMA_H

#include "common/command_line/question_options.h"

kt_exit kma_at(int argc, char **argv);
kt_exit kma_sweep(int argc, char **argv);
kt_exit kma_report(int argc, char **argv);

/* Points with a direction fill the ends that no option names: one is the output, two are input and output. Says what is
 * wrong. */
bool kma_place_points(const kt_common *common, kt_question *asked, const kt_texts *points);

#endif
