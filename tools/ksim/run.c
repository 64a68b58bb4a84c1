/* ksim run: the question "run" about one model, several, or variants. */
#include "ksim/ksim.h"

#include "kmech/inspect.h"

#include <string.h>

/* A note where the model's integration_type names no method of ours. */
static void report_integrator(const kt_sweep_job *j) {
  km_integrator found;
  const char *stated = km_model_integration_type(j->pose.model);
  if (stated && !km_model_integrator(j->pose.model, &found) && !kt_question_given(&j->options->asked, "integrator"))
    kt_print_message(
        &j->common, KM_NOTE,
        "%s: the model's integration_type \"%.80s\" isn't a method of ksim; adams is used, --integrator chooses another",
        j->name, stated);
}

static kt_exit tell(kt_sweep_job *j) {
  const km_history *h = km_question_history(j->question);
  const km_simulation_def *def = &km_question_run_def(j->question)->simulation;
  report_integrator(j);
  if (h->figures.relative > def->relative * (1.0 + 1e-9))
    kt_print_message(&j->common, KM_NOTE,
                     "%s: a relative error of %.3g is less than rounding allows; steps keep to %.3g", j->name,
                     def->relative, h->figures.relative);
  if (h->figures.stiff && def->integrator == KM_INTEGRATOR_ADAMS)
    kt_print_message(&j->common, KM_NOTE, "%s: the motion is stiff; --integrator bdf took over", j->name);
  kt_detail(&j->common,
            "%s: an evaluation solves for accelerations by about %.0f multiplications, a dense system takes %.0f",
            j->name, h->effort.multiplications, h->effort.dense);
  return ksim_tell(j);
}

kt_exit ksim_run(int argc, char **argv) {
  bool animate = false;
  kt_sweep_options o = {.common = KT_COMMON("ksim"), .tell = tell};
  kt_options all = {0};
  const kt_option table[] = {
      {"animate", 0, NULL, "Write BASE.motion.html too, which plays the motion", KT_FLAG, &animate, KT_ABOUT_FILES},
  };
  kt_sweep_options_several(&all, &o, "run", KT_SWEEP_BASE("run"));
  KT_OPTIONS_ADD(&all, table);
  kt_question_explain(
      &all, "rate", "JOINT=RATE",
      "Rate at the start, instead of the model's: A=60rpm, or in the model's unit per time unit; joints "
      "without a stated rate follow (repeatable)");
  kt_question_explain(&all, "until", "T",
                      "End, in the model's time unit (default: the model's, else a period of its loads over a joint at "
                      "the joint's rate, else 10 s)");
  kt_question_explain(&all, "joints", "LIST", "Joints whose curves are drawn (default: up to eight that move)");
  kt_options_read(
      &all,
      "The motion over time from the model's pose and initial rates, under gravity, loads, springs, dampers, motors, "
      "controllers, stops, tyres and prescribed motions; of several models or variants (--vary) with a common plot. Exit "
      "status 1 if stated initial rates contradict each other or a joint passes a limit where no stop acts, 4 if the run "
      "can't go on; what was reached is written."
      "\vColumns: t; q.JOINT, v.JOINT, a.JOINT; f.JOINT, the force that drives a prescribed joint; energy_kinetic, "
      "energy_potential (0 at the start), energy_dissipated, motor_work; loop_error (rms, over the loop's size), "
      "evaluations, repartitions; integrator_step, integrator_order of the last step; state.NAME.integral, slip, "
      "slip_angle, which --from continues; frame.BODY/FRAME.x … vx … ax; r.JOINT.fx … tz; m.JOINT. Rates of balls are angular "
      "velocities along the axes of the parent frame. JSON keys beside those of every record: events, beyond_max_rate, "
      "beyond_max_force, limits_passed (joint, limit, t, beyond), changed_initial_rates (joint, stated, start).",
      argc, argv);
  if (animate && kt_is_piped(o.base))
    return kt_usage(&o.common, "-o", "-", "a name, as --animate writes a page beside the table");
  if (kt_question_given(&o.asked, "from") && o.sets.count > 0)
    return kt_usage(&o.common, "--from", "a table beside --set", "one of them: both give the pose");
  o.write_more = animate ? ksim_animate : NULL;
  return kt_sweep(&o);
}
