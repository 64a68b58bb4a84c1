/* The numbers of a substructure that are rounded, and the digit of each (docs/theory.md 14.8).
 *
 *   A list of numbers is rounded if one of them has at least four digits; a matrix, if its columns aren't orthonormal;
 *   a quaternion or a unit axis, if its length isn't 1. The unit of all numbers of one kind is that of the rounded one
 *   with the most decimals. Numbers with few digits (1, 0.5, 90) stay exact unless nothing else explains the gap. */
#ifndef KM_ROUNDING_DIGITS_H
#define KM_ROUNDING_DIGITS_H

#include "kinematics/state.h"
#include "model/written_numbers.h"

/* Relative deviation above that of three digits: an axis so near length 1 is meant as a unit vector, and axes at a
 * smaller sine as parallel. */
static const double km_three_digits = 0.03;

/* The numbers that place the frames of a substructure's joints. */
typedef struct km_rounded_numbers {
  int count;
  const km_written_number **number; /* [count] */
  double *half;                     /* [count] unit of the number if it may change */
  bool *is_long;                    /* [count] may change even where other numbers explain the gap */
  bool is_rounded;                  /* at least one number is known to be rounded */
} km_rounded_numbers;

/* The substructure of each frame's joints: owner[frame]; below 0 for frames of joints in none or several, and of no
 * joint. NULL when out of memory. O(frames + joints). */
int *km_frame_owners(const km_mechanism *mechanism, km_arena *arena);
/* Lists the numbers of frames that belong to joints of this substructure only. False without memory. O(numbers). */
bool km_rounded_numbers_find(const km_mechanism *mechanism, int substructure, const int *owner, km_arena *arena,
                             km_rounded_numbers *out);

#endif
