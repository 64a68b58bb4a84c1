/* Text common to all sweeps, and text shared by reports. */
#ifndef KM_REPORT_RECORD_SWEEP_TEXT_H
#define KM_REPORT_RECORD_SWEEP_TEXT_H

#include "base/text.h"
#include "base/value.h"
#include "kmech/report.h"
#include "kmech/sweep.h"

const char *km_plural(int count); /* "" or "s" */
/* A label padded to a width counted in characters, not bytes. */
void km_text_padded(const char *label, int width, km_text *out);
int km_widest_label(const km_model *model);
/* The labels of a substructure's joints, each after a blank. */
void km_joints_print(const km_mechanism *mechanism, int substructure, km_text *out);

/* Range of a sweep; its mobility, cycle and branch points; and both, as the first lines of a summary. */
void km_sweep_print_range(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep,
                          const char *name, km_text *out);
/* "1 (planar count 1)", "1 (Kutzbach -2), 3 redundant constraints". */
void km_mobility_words(const km_mechanism *mechanism, const km_sweep *sweep, km_text *out);
void km_sweep_print_mobility(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep,
                             km_text *out);
/* The extent of a coordinate's motion, without the end of the line. False: it stays at rest, nothing is written. */
bool km_swing_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_swing *swing, int width,
                    km_text *out);
enum { KM_SWINGS_SHOWN = 8 }; /* lines of a summary about swings */
void km_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_sweep *sweep, const char *name,
                    km_text *out);

/* Largest size of a swing's acceleration and the driver's value there; 0 where it is rounding, NaN where unknown. */
double km_swing_acceleration(const km_motion_sweep *sweep, const km_swing *swing, double *where);
/* Record of a motion: rate, swings {joint, least, least_at, greatest, greatest_at, goes_round}, columns, rows; NULL
 * without memory. And its summary. */
km_value *km_motion_sweep_record(const km_mechanism *mechanism, const km_motion_sweep *sweep, const char *stopped_by,
                                 const char *name, km_arena *arena);
void km_motion_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_motion_sweep *sweep,
                           const char *name, km_text *out);

/* Largest norm √(x² + y² + z²) of three columns over the rows, and the first column's value there. */
double km_largest_norm(const km_table *table, size_t first, double *where);

/* Record of an allowance: tolerances, ratios, constraints, joints, play_in, remedy_set, columns, rows; NULL without
 * memory. And its summary. */
km_value *km_allowance_sweep_record(const km_mechanism *mechanism, const km_allowance_sweep *sweep,
                                    const char *stopped_by, const char *name, km_arena *arena);
void km_allowance_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_allowance_sweep *sweep,
                              const char *name, km_text *out);

/* Record and summary of a sweep with clearances; and of the clearances of any sweep: least values, contacts, pairs that
 * are left out, hulls. Nothing where none were requested. */
km_value *km_clearance_sweep_record(const km_mechanism *mechanism, const km_clearance_sweep *sweep,
                                    const char *stopped_by, const char *name, km_arena *arena);
void km_clearance_sweep_print(const km_mechanism *mechanism, const km_sweep_plan *plan, const km_clearance_sweep *sweep,
                              const char *name, km_text *out);
void km_clearance_course_record(const km_mechanism *mechanism, const km_clearance_course *course, km_value *record,
                                km_arena *arena);
void km_clearance_course_print(const km_mechanism *mechanism, const km_sweep_plan *plan,
                               const km_clearance_course *course, km_text *out);

#endif
