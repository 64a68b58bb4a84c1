/* Tracks, self-motions and branches as records (JSON) and as text for people. */
#ifndef KM_REPORT_RECORD_TRACK_RECORD_H
#define KM_REPORT_RECORD_TRACK_RECORD_H

#include "arm/selfmotion/branches.h"
#include "arm/study.h"
#include "arm/track.h"
#include "base/text.h"
#include "base/value.h"

/* The tracks of one study, method by method; an entry may be NULL where a method failed. */
typedef struct km_tracks {
  const km_study *study;
  const char *name;  /* of the study or model, for people */
  const char *model; /* for pictures */
  km_track *const *items;
  int count;
} km_tracks;

/* The head of every record about an arm. */
km_value *km_arm_record(const km_arm *arm, const char *model, km_arena *arena);

/* What `kredund track --format json` gives. NULL when out of memory (arena->failed). */
km_value *km_tracks_record(const km_tracks *tracks, const char *model, km_arena *arena);
/* The table of summaries. */
void km_tracks_print(const km_tracks *tracks, km_text *out);
/* "lookahead", or "lookahead 2" for the second of its kind. */
void km_tracks_label(const km_tracks *tracks, int index, char separator, char *out, size_t size);
/* The track that goes furthest, then the best by the objective; of equals the later one. −1: none. */
int km_tracks_best(const km_tracks *tracks);
/* Why and where a track ends: empty if it is complete. */
void km_track_end_text(const km_track *track, km_text *out);

/* A self-motion's curve and arcs; the branches of inverse kinematics. Rows are the poses within the limits, or the
 * whole curve with `all`. */
km_value *km_selfmotion_record(const km_arm *arm, const km_selfmotion *motion, bool all, const char *model,
                               km_arena *arena);
void km_selfmotion_print(const km_arm *arm, const km_selfmotion *motion, const char *name, km_text *out);
km_table *km_selfmotion_table(const km_arm *arm, const km_selfmotion *motion, bool all);
km_value *km_ik_solutions_record(const km_arm *arm, const km_ik_solutions *branches, const char *model,
                                 km_arena *arena);
void km_ik_solutions_print(const km_arm *arm, const km_ik_solutions *branches, const char *name, km_text *out);

#endif
