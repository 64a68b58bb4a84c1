/* Pieces of records (JSON) that all tools share. */
#ifndef KM_REPORT_RECORD_RECORD_H
#define KM_REPORT_RECORD_RECORD_H

#include "base/value.h"
#include "kmech/report.h"
#include "kmech/sweep.h"

/* `model_sha256` and `units`. */
void km_record_model(const km_model *model, km_value *record, km_arena *arena);
/* Adds the course of the motion: branch_points, cycle, complete, stopped_by. */
void km_sweep_record(const km_sweep *sweep, const char *stopped_by, km_value *record, km_arena *arena);

/* `reactions_note`, where the reactions leave something out. */
void km_reactions_note_record(const km_model *model, km_value *record, km_arena *arena);
/* `held_joints` and `configuration` of a pose. */
void km_held_record(const km_mechanism *mechanism, km_value *record, km_arena *arena);
void km_configuration_record(const km_mechanism *mechanism, const km_state *state, km_value *record, km_arena *arena);

#endif
