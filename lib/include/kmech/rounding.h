/* Rounded numbers: the mechanism that a file means, where its numbers are written with few digits. */
#ifndef KMECH_ROUNDING_H
#define KMECH_ROUNDING_H

#include "kmech/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Verdict on the numbers of a substructure. */
typedef enum km_rounding_verdict {
  KM_ROUNDING_EXACT, /* the loops close as written, and no singular value of J is within rounding of 0 */
  KM_ROUNDING_FOUND, /* numbers within half a last digit of those written give the mobility below */
  KM_ROUNDING_BEYOND /* the gap or the small singular values exceed rounding; no number is changed */
} km_rounding_verdict;

enum {
  KM_NUMBER_PLACE = 256 /* bytes of the place of a number, the NUL included */
};

/* A substructure whose numbers were examined. */
typedef struct km_rounding {
  int substructure;            /* index */
  km_rounding_verdict verdict; /* the verdict */
  bool closes;                 /* the loops close as written, to 1e-9 */
  int mobility_as_written;     /* mobility of the linearised loops as written */
  int mobility;                /* mobility of the nearest mechanism; as written if none was found */
  double largest_change;       /* largest change of a number, in units of its last digit */
  char place[KM_NUMBER_PLACE]; /* number with that change, such as "R[5] of frame link/B"; "": none */
} km_rounding;

/* A number that was changed. */
typedef struct km_number_change {
  int substructure;            /* index */
  char place[KM_NUMBER_PLACE]; /* such as "T[0] of frame link/B" */
  double written, nearest;     /* value in the file, and in the nearest mechanism, in the file's unit; NaN: the file
                                * states the frame in another form */
  double digits;               /* change in units of the last digit */
} km_number_change;

/* Result of km_model_idealise. */
typedef struct km_idealisation {
  int count;                /* number of substructures that were examined */
  km_rounding *verdict;     /* [count] */
  int change_count;         /* number of changed numbers */
  km_number_change *change; /* [change_count] by substructure */
  int parallel_axes;        /* relations that were made exact: pairs of parallel axes on one body */
  int right_angles;         /* pairs of orthogonal axes on one body */
  int equal_lengths;        /* pairs of equal distances of two joints on a body */
} km_idealisation;

/* Replaces the numbers of each substructure by the nearest ones for which its loops close and move, if these are within
 * half a last digit of the written ones (docs/theory.md 14.6-14.8): numbers p + h x and a rank r of J with
 *
 *   min |x|²   subject to   e(q_i, p + h x) = 0,   rank J(q_i) = r,   |x_k| <= 1
 *
 * at configurations q_i along the motion; h: half a unit of the last digit. Other substructures are unchanged, and so
 * is a model whose file states a closure tolerance. `regular`: in substructures with loops also axes on one body that
 * are parallel or orthogonal within rounding become so, and distances of joints that are equal within it; those that
 * would need more are left out. Each substructure that is changed adds a note to `messages` (may be
 * NULL). `found` (may be NULL): verdicts and changes; free it in any case. KM_MEMORY; KM_IO: LAPACKE is not installed.
 * Cost: O(rows · columns²) for a substructure without small singular values; about 100 times that for others. */
KM_API km_status km_model_idealise(km_model *model, bool regular, km_messages *messages, km_idealisation *found,
                                   km_error *error);
KM_API void km_idealisation_free(km_idealisation *idealisation);

#ifdef __cplusplus
}
#endif
#endif
