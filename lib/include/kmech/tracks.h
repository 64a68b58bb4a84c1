/* What arms do, as records, tables, text and pictures: tracks, self-motions, inverse kinematics. */
#ifndef KMECH_TRACKS_H
#define KMECH_TRACKS_H

#include "kmech/path_study.h"
#include "kmech/picture_format.h"
#include "kmech/selfmotion.h"
#include "kmech/value.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The tracks of one study, method by method. Everything is borrowed. */
typedef struct km_tracks {
  const km_study *study;  /* whose methods they are */
  const char *name;       /* of the study or model, for people */
  const char *model;      /* for pictures */
  km_track *const *items; /* [count]; NULL where a method failed */
  int count;              /* at most km_study_methods */
} km_tracks;

/* "lookahead", or "lookahead 2" for the second of its kind, with this separator. "" if there is no such track. */
KM_API void km_tracks_label(const km_tracks *tracks, int index, char separator, char *out, size_t size);
/* The track that goes furthest; of those that go as far (to 1e-6) the best by the objective's least value, or by its mean where it is one of
 * means; of those that are equal in this (to 1e-9) the best by the other of the two, then the one of less joint travel, then of the lower
 * largest rate, then the first. -1: none. */
KM_API int km_tracks_best(const km_tracks *tracks);
/* Why and where a track ends, appended; nothing if it is complete. */
KM_API void km_track_end_text(const km_track *track, km_text *out);
/* The table of summaries, appended. */
KM_API void km_tracks_print(const km_tracks *tracks, km_text *out);
/* What `kredund track --format json` gives (cli.md). `model`: its name. NULL when out of memory (arena->failed) or where
 * something is missing; so are the records below. */
KM_API km_value *km_tracks_record(const km_tracks *tracks, const char *model, km_arena *arena);

/* Pictures append their bytes to `out`, which stays as it was with any status but KM_OK. KM_USAGE: there is no track;
 * KM_MEMORY, KM_INTERNAL. */
/* Joint angles with their limits, path-control entries, objectives, limit margin and tracking error over the path, on one
 * page; of several methods side by side. O(samples). */
KM_API km_status km_tracks_picture(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error);
/* The arm along the best track, with the effector's path. */
KM_API km_status km_tracks_drawing(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error);
/* The map of self-motions: self-motion over path length, coloured by the objective, hatched where a joint is outside its
 * limits, with the tracks, if there are any. KM_USAGE: the study has no path, no start, or not one spare freedom. */
KM_API km_status km_tracks_map(const km_tracks *tracks, km_picture_format format, km_text *out, km_error *error);

/* A self-motion of the arm as record, text and table. Rows are the poses within the limits, or the whole curve with `all`.
 * `model` and `name`: the model's, for people. The caller frees the table; NULL when out of memory. */
KM_API km_value *km_selfmotion_record(const km_arm *arm, const km_selfmotion *motion, bool all, const char *model,
                                      km_arena *arena);
KM_API void km_selfmotion_print(const km_arm *arm, const km_selfmotion *motion, const char *name, km_text *out);
KM_API km_table *km_selfmotion_table(const km_arm *arm, const km_selfmotion *motion, bool all);

/* All branches of inverse kinematics; `model` and `name` as above. */
KM_API km_value *km_ik_solutions_record(const km_arm *arm, const km_ik_solutions *solutions, const char *model,
                                        km_arena *arena);
KM_API void km_ik_solutions_print(const km_arm *arm, const km_ik_solutions *solutions, const char *name, km_text *out);

#ifdef __cplusplus
}
#endif
#endif
