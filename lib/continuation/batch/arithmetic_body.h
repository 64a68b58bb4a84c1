/* Arithmetic of lanes: a part of lanes_body.h. */
#include "spatial/simd_body.h"

#define T            vector
#define BITS         word
#define NONE         ((word){0})
#define FN(name)     lanes_##name
#define km_bits_of   (word)
#define km_number_of (vector)
#include "spatial/sincos_body.h"

/* Below, work is on `count` registers from lane `first` on: what isn't a number is read once for all of them. Register r
 * begins at lane first + AT(r) of a number. */
enum { TOGETHER = 2 };
#define EACH(r)            for (int r = 0; r < count; ++r)
#define AT(r)              (first + WIDTH * (r))
#define GET(number)        get((number).of + AT(r))
#define PUT(number, value) put((number).of + AT(r), (value))

/* Code that runs for most mechanisms stays in one piece; what only some of them need stays out of it. */
#define WITHIN inline __attribute__((always_inline))
#define APART  __attribute__((noinline))
