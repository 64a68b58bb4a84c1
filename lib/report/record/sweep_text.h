/* Text common to all sweeps, and text shared by reports. */
#ifndef KM_REPORT_RECORD_SWEEP_TEXT_H
#define KM_REPORT_RECORD_SWEEP_TEXT_H

#include "base/text.h"
#include "kmech/report.h"
#include "kmech/sweep.h"

const char *km_plural(int count); /* "" or "s" */
/* A label padded to a width counted in characters, not bytes. */
void km_text_padded(const char *label, int width, km_text *out);
int km_widest_label(const km_model *model);
/* The labels of a substructure's joints, each after a blank. */
void km_joints_print(const km_mechanism *mechanism, int substructure, km_text *out);

/* The first lines of a summary: range, mobility, cycle and branch points. */
void km_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep, const char *name,
                    km_text *out);

#endif
