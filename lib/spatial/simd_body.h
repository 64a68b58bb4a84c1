/* Vectors of WIDTH doubles and their masks, for files that are included once for each instruction set. */
#ifdef __SSE2__
#include <immintrin.h>
#endif

typedef double vector __attribute__((vector_size(8 * WIDTH)));
typedef uint64_t word __attribute__((vector_size(8 * WIDTH)));

#define SIGN_BIT ((uint64_t)1 << 63)

/* a > b ? a : b, as the processor's maximum. */
static inline vector larger(vector a, vector b) {
#if WIDTH == 8
  return (vector)_mm512_max_pd((__m512d)a, (__m512d)b);
#elif WIDTH == 4
  return (vector)_mm256_max_pd((__m256d)a, (__m256d)b);
#elif defined __SSE2__
  return (vector)_mm_max_pd((__m128d)a, (__m128d)b);
#else
  return (vector){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}

static inline vector root(vector a) {
#if WIDTH == 8
  return (vector)_mm512_sqrt_pd((__m512d)a);
#elif WIDTH == 4
  return (vector)_mm256_sqrt_pd((__m256d)a);
#elif defined __SSE2__
  return (vector)_mm_sqrt_pd((__m128d)a);
#else
  return (vector){sqrt(a[0]), sqrt(a[1])};
#endif
}

/* Loads and stores at the alignment of doubles. The type excludes aliasing with pointers, which memcpy would not. */
typedef double stored __attribute__((vector_size(8 * WIDTH), aligned(8)));
static inline vector get(const double *number) {
  return *(const stored *)number;
}
static inline void put(double *number, vector value) {
  *(stored *)number = value;
}
static inline vector size_of(vector a) {
  return (vector)((word)a & INT64_MAX);
}
static inline vector all(double value) {
  return (vector){0.0} + value;
}

/* Mask of lanes: one bit per lane in mask registers, else all bits of a lane. */
#if WIDTH == 8
typedef unsigned mask;
static inline mask at_most(vector a, vector b) {
  return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LE_OQ);
}
static inline mask below(vector a, vector b) {
  return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_LT_OQ);
}
static inline mask equal(vector a, vector b) {
  return _mm512_cmp_pd_mask((__m512d)a, (__m512d)b, _CMP_EQ_OQ);
}
static inline vector pick(mask m, vector a, vector b) { /* a in lanes of the mask, else b */
  return (vector)_mm512_mask_blend_pd((__mmask8)m, (__m512d)b, (__m512d)a);
}
static inline unsigned bits_of(mask m) {
  return m & 0xff;
}
static inline mask mask_of(unsigned bits) {
  return bits;
}
#else
typedef int64_t mask __attribute__((vector_size(8 * WIDTH)));
/* Comparisons by intrinsics: gcc 12 fails on some code if it combines its vector operators. */
static inline mask at_most(vector a, vector b) {
#if WIDTH == 4
  return (mask)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_LE_OQ);
#elif defined __SSE2__
  return (mask)_mm_cmple_pd((__m128d)a, (__m128d)b);
#else
  return a <= b;
#endif
}
static inline mask below(vector a, vector b) {
#if WIDTH == 4
  return (mask)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_LT_OQ);
#elif defined __SSE2__
  return (mask)_mm_cmplt_pd((__m128d)a, (__m128d)b);
#else
  return a < b;
#endif
}
static inline mask equal(vector a, vector b) {
#if WIDTH == 4
  return (mask)_mm256_cmp_pd((__m256d)a, (__m256d)b, _CMP_EQ_OQ);
#elif defined __SSE2__
  return (mask)_mm_cmpeq_pd((__m128d)a, (__m128d)b);
#else
  return a == b;
#endif
}
static inline vector pick(mask m, vector a, vector b) {
#if WIDTH == 4
  return (vector)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m);
#else
  return (vector)(((mask)a & m) | ((mask)b & ~m));
#endif
}
static inline unsigned bits_of(mask m) {
#if WIDTH == 4
  return (unsigned)_mm256_movemask_pd((__m256d)m);
#elif defined __SSE2__
  return (unsigned)_mm_movemask_pd((__m128d)m);
#else
  return (unsigned)(m[0] & 1) | (unsigned)(m[1] & 1) << 1;
#endif
}
static inline mask mask_of(unsigned bits) {
  mask m = {0};
  for (int i = 0; i < WIDTH; ++i)
    m[i] = -(int64_t)(bits >> i & 1);
  return m;
}
#endif
static inline mask is_finite(vector a) {
  return equal(a - a, all(0.0));
}
