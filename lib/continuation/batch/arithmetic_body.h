/* Arithmetic on the lanes of a batch; part of step_body.h. A vector is one register, a mask its comparison result. */
#include "spatial/simd_body.h"

#define T            vector
#define BITS         word
#define NONE         ((word){0})
#define FN(name)     lanes_##name
#define km_bits_of   (word)
#define km_number_of (vector)
#include "spatial/sincos_body.h"

/* Functions work on `count` registers from lane `first` on, so that data common to all lanes are read once. Register
 * r begins at lane first + AT(r) of a number. */
enum { REGISTERS = 2 };
#define EACH(r)            for (int r = 0; r < count; ++r)
#define AT(r)              (first + WIDTH * (r))
#define GET(number)        get((number).of + AT(r))
#define PUT(number, value) put((number).of + AT(r), (value))

/* Code of most mechanisms is inlined; code that few need is not. */
#define INLINED     inline __attribute__((always_inline))
#define NOT_INLINED __attribute__((noinline))
