/* Sine and cosine of a double, or of two at once, with the bits of the batch versions (docs/theory.md 14.5). */
#ifndef KM_SPATIAL_SINCOS_H
#define KM_SPATIAL_SINCOS_H

#include <math.h>
#include <stdint.h>
#include <string.h>

/* 1.5 · 2⁵²: adding it to a number below 2⁵¹ rounds that to an integer, which is then in the low bits. */
#define KM_ROUNDING 6755399441055744.0

/* Largest angle of the polynomials. */
#define KM_SINCOS_MAX_ANGLE 1e5

static inline uint64_t km_double_bits(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
static inline double km_bits_double(uint64_t bits) {
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

#define T            double
#define BITS         uint64_t
#define NONE         ((uint64_t)0)
#define FN(name)     km_near_##name
#define km_bits_of   km_double_bits
#define km_number_of km_bits_double
#include "spatial/sincos_body.h"
#undef T
#undef BITS
#undef NONE
#undef FN
#undef km_bits_of
#undef km_number_of

typedef double km_two_numbers __attribute__((vector_size(16)));
typedef uint64_t km_two_words __attribute__((vector_size(16)));
#define T               km_two_numbers
#define BITS            km_two_words
#define NONE            ((km_two_words){0, 0})
#define FN(name)        km_two_##name
#define km_bits_of(x)   ((km_two_words)(x))
#define km_number_of(x) ((km_two_numbers)(x))
#include "spatial/sincos_body.h"
#undef T
#undef BITS
#undef NONE
#undef FN
#undef km_bits_of
#undef km_number_of

/* Sine and cosine of any angle, to about one ulp. */
static inline void km_sincos(double x, double *sine, double *cosine) {
  if (fabs(x) <= KM_SINCOS_MAX_ANGLE) {
    km_near_sincos(x, sine, cosine);
  } else {
    *sine = sin(x);
    *cosine = cos(x);
  }
}

#endif
