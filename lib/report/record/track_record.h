/* Functions shared by records, texts and pictures of arms. */
#ifndef KM_REPORT_RECORD_TRACK_RECORD_H
#define KM_REPORT_RECORD_TRACK_RECORD_H

#include "arm/ik/ik_branches.h"
#include "arm/study/path_study.h"
#include "arm/tracking/track.h"
#include "kmech/report.h"

/* True if these are tracks of a study with a path. */
bool km_tracks_are_whole(const km_tracks *tracks);
/* "joint4 comes nearest to a limit: …; joint2 is the fastest of its drive: …", as far as joints have limits. */
void km_track_limits_words(const km_track *track, km_text *out);
/* The head of every record about an arm. */
km_value *km_arm_record(const km_arm *arm, const char *model, km_arena *arena);

#endif
