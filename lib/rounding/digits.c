/* Digits of the numbers of a substructure. */
#include "rounding/digits.h"

#include "base/number/tolerances.h"

#include <string.h>

enum { LONG_DIGITS = 4 }; /* digits from which on a number counts as rounded */

enum { NO_OWNER = -1, SHARED = -2 };

int *km_frame_owners(const km_mechanism *m, km_arena *arena) {
  int *owner = KM_ARENA_NEW(arena, int, (size_t)m->model->frame_count);
  for (int f = 0; owner && f < m->model->frame_count; ++f)
    owner[f] = NO_OWNER;
  for (int j = 0; owner && j < m->model->joint_count; ++j)
    for (int end = 0; end < 2; ++end) {
      int *of_frame = &owner[m->model->joints[j].frame[end]], index = m->topology.substructure_of_joint[j];
      *of_frame = *of_frame == NO_OWNER ? index : *of_frame == index ? index : SHARED;
      if (index < 0)
        *of_frame = SHARED;
    }
  return owner;
}

/* True if the number's frames are those of the substructure, or of no joint at all. */
static bool is_usable(const km_written_number *number, const int *owner, int index) {
  bool one = false;
  for (int end = 0; end < 2; ++end) {
    int f = number->frame[end];
    if (f >= 0 && owner[f] != index && owner[f] != NO_OWNER)
      return false;
    one = one || (f >= 0 && owner[f] == index);
  }
  return one;
}

/* Largest deviation of RᵀR from I, or of the length of a quaternion or a unit axis from 1, for the list that begins at
 * number[i]; 0 for other lists. */
static double misfit(const km_rounded_numbers *n, int i, int size) {
  double v[9], worst = 0.0;
  for (int k = 0; k < size && k < 9; ++k)
    v[k] = n->number[i + k]->value;
  if (strcmp(n->number[i]->key, "quaternion") == 0 && size == 4)
    return fabs(v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + v[3] * v[3] - 1.0);
  if (strcmp(n->number[i]->key, "axis") == 0 && size == 3) {
    double off = fabs(sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) - 1.0);
    return off < km_three_digits ? off : 0.0;
  }
  if (strcmp(n->number[i]->key, "R") != 0 || size != 9)
    return 0.0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      worst = fmax(worst, fabs(v[a] * v[b] + v[3 + a] * v[3 + b] + v[6 + a] * v[6 + b] - (a == b)));
  return worst;
}

/* Kinds of numbers, each with a unit of its own. */
enum { KIND_T, KIND_R, KIND_QUATERNION, KINDS = 7 };

static int kind_of(const char *key) {
  static const char *const keys[KINDS] = {"T", "R", "quaternion", "euler", "rotation_vector", "axis", "turn"};
  for (int i = 0; i < KINDS; ++i)
    if (strcmp(key, keys[i]) == 0)
      return i;
  return KIND_T; /* "at" */
}

/* Length of the list of numbers that begins at i. */
static int list_size(const km_rounded_numbers *n, int i) {
  int size = 1;
  while (i + size < n->count && n->number[i + size]->key == n->number[i]->key &&
         n->number[i + size]->frame[0] == n->number[i]->frame[0])
    ++size;
  return size;
}

/* Finds the unit of each kind: of its rounded numbers, else of all that aren't 0. */
static void find_units(km_rounded_numbers *n, double *half, const int *digits) {
  double rounded[KINDS], any[KINDS];
  for (int k = 0; k < KINDS; ++k)
    rounded[k] = any[k] = HUGE_VAL;
  for (int i = 0, size; i < n->count; i += size) {
    size = list_size(n, i);
    bool is_off = misfit(n, i, size) > km_solved_rounding;
    for (int k = i; k < i + size; ++k) {
      int kind = kind_of(n->number[k]->key);
      bool is_shape = kind == KIND_R || kind == KIND_QUATERNION || is_off, is_given = n->number[k]->half > 0.0;
      n->is_long[k] = is_given || (is_shape ? is_off && digits[k] > 1 : digits[k] >= LONG_DIGITS);
      if (digits[k] > 0 || is_given)
        any[kind] = fmin(any[kind], half[k]);
      if (n->is_long[k])
        rounded[kind] = fmin(rounded[kind], half[k]);
      n->is_rounded = n->is_rounded || n->is_long[k];
    }
  }
  for (int i = 0; i < n->count; ++i) {
    int kind = kind_of(n->number[i]->key);
    double unit = isfinite(rounded[kind]) ? rounded[kind] : isfinite(any[kind]) ? any[kind] : 0.0;
    /* a number with as many decimals as the longest has its unit, however few its digits */
    n->is_long[i] = n->is_long[i] || (isfinite(rounded[kind]) && digits[i] > 1 && half[i] <= 1.5 * unit);
    n->half[i] = unit;
  }
}

bool km_rounded_numbers_find(const km_mechanism *m, int index, const int *owner, km_arena *arena,
                             km_rounded_numbers *out) {
  const km_model *model = m->model;
  km_arena scratch = {0};
  int count = 0;
  *out = (km_rounded_numbers){0};
  for (int i = 0; i < model->written_count; ++i)
    count += is_usable(&model->written[i], owner, index);
  double *half = KM_ARENA_NEW(&scratch, double, (size_t)count);
  int *digits = KM_ARENA_NEW(&scratch, int, (size_t)count);
  out->number = KM_ARENA_NEW(arena, const km_written_number *, (size_t)count);
  out->half = KM_ARENA_NEW(arena, double, (size_t)count);
  out->is_long = KM_ARENA_NEW(arena, bool, (size_t)count);
  bool found = !scratch.failed && !arena->failed;
  for (int i = 0; i < model->written_count && found; ++i) {
    const km_written_number *number = &model->written[i];
    if (!is_usable(number, owner, index))
      continue;
    half[out->count] = km_half_digit(number->value, &digits[out->count]);
    if (number->half > 0.0)
      half[out->count] = number->half;
    out->number[out->count++] = number;
  }
  if (found)
    find_units(out, half, digits);
  km_arena_free(&scratch);
  return found;
}
