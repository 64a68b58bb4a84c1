/* ksim's commands. */
#ifndef KSIM_H
#define KSIM_H

#include "common/common.h"
#include "common/pose.h"
#include "common/sweep.h"

#include "kmech/data.h"
#include "kmech/dynamics.h"
#include "kmech/report.h"

kt_exit ksim_run(int argc, char **argv);
kt_exit ksim_inverse(int argc, char **argv);
kt_exit ksim_linearise(int argc, char **argv);
kt_exit ksim_equilibrium(int argc, char **argv);
kt_exit ksim_report(int argc, char **argv);
kt_exit ksim_serve(int argc, char **argv);

/* Says what a motion over time calls for: hinges without friction radius, drives beyond their bounds, changed initial
 * rates, passed limits, the reason of an early end. Returns the exit code. */
kt_exit ksim_tell(kt_sweep_job *job);
/* Warns of a limit that a motion passes where no stop acts. */
void ksim_report_limit(const kt_common *common, const char *name, const km_model *model, const km_passed_limit *limit);
/* Names stated initial rates that the motion doesn't start with; KT_PARTIAL where they contradict each other. */
kt_exit ksim_report_rates(const kt_sweep_job *job, const km_history *history);

/* The modes of linearised equations in motion. */
typedef struct ksim_modes {
  const kt_common *common;
  const char *model, *base; /* the model's file, BASE of the files */
  const kt_pose *pose;
  km_dynamics *dynamics;
  const km_linear *linear;
  int only; /* one line of the modes' table, from 1 on; 0: all */
} ksim_modes;
/* BASE.mode1.html …: by the lines of the table. */
kt_exit ksim_animate_modes(const ksim_modes *modes);
/* BASE.motion.html: the mechanism in motion beside its curves. */
kt_exit ksim_animate(const kt_sweep_job *job, const char *base);

#endif
