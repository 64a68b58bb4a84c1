/* The shortest decimal digits that read back to the same double: the Schubfach algorithm (R. Giulietti, "The Schubfach
 * way to render doubles", 2020).
 *
 * A double is c · 2^q, and every real number between its two halfway neighbours cl · 2^q and cr · 2^q reads back to it
 * (the ends too where c is even). With k = ⌊log10 2^q⌋ the interval, divided by 10^k, holds at least one and at most
 * ten integers, so the shortest digits are among two multiples of ten and two integers around c · 2^q / 10^k. These are
 * compared exactly: four times the quotients, rounded to odd, keep their order. */
#include "base/text.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/number/powers_of_ten.h"

enum { FRACTION_BITS = 52, EXPONENT_BIAS = 1075, FIRST_POWER = -292, MOST_DIGITS = 17 };

/* digits · 10^exponent */
typedef struct decimal {
  uint64_t digits;
  int exponent;
} decimal;

/* ⌊e · log2 10⌋, ⌊e · log10 2⌋, ⌊log10(3/4) + e · log10 2⌋ for |e| up to 1500. */
static int floor_log2_pow10(int e) {
  return (e * 1741647) >> 19;
}
static int floor_log10_pow2(int e) {
  return (e * 1262611) >> 22;
}
static int floor_log10_three_quarters_pow2(int e) {
  return (e * 1262611 - 524031) >> 22;
}

/* The product of a 128-bit power with x, divided by 2^128, rounded to odd. */
static uint64_t round_to_odd(const uint64_t power[2], uint64_t x) {
  __extension__ typedef unsigned __int128 wide;
  wide low = (wide)power[1] * x, high = (wide)power[0] * x;
  wide middle = (wide)(uint64_t)high + (uint64_t)(low >> 64);
  uint64_t top = (uint64_t)(high >> 64) + (uint64_t)(middle >> 64);
  return top | ((uint64_t)middle > 1);
}

static decimal shortest(uint64_t fraction, int biased) {
  bool normal = biased != 0;
  uint64_t c = normal ? ((uint64_t)1 << FRACTION_BITS) | fraction : fraction;
  int q = (normal ? biased : 1) - EXPONENT_BIAS;
  if (normal && q <= 0 && q > -(FRACTION_BITS + 1) && (c & (((uint64_t)1 << -q) - 1)) == 0)
    return (decimal){c >> -q, 0}; /* an integer */
  /* The lower neighbour of a power of two is nearer. */
  bool closer = fraction == 0 && biased > 1, even = c % 2 == 0;
  int k = closer ? floor_log10_three_quarters_pow2(q) : floor_log10_pow2(q);
  int h = q + floor_log2_pow10(-k) + 1;
  const uint64_t *power = powers[-k - FIRST_POWER];
  uint64_t below = round_to_odd(power, (4 * c - 2 + closer) << h), at = round_to_odd(power, (4 * c) << h),
           above = round_to_odd(power, (4 * c + 2) << h);
  uint64_t low = below + !even, high = above - !even, s = at / 4;
  if (s >= 10) {
    uint64_t tens = s / 10;
    bool down = low <= 40 * tens, up = 40 * tens + 40 <= high;
    if (down != up)
      return (decimal){tens + up, k + 1};
  }
  bool down = low <= 4 * s, up = 4 * s + 4 <= high;
  if (down != up)
    return (decimal){s + up, k};
  uint64_t middle = 4 * s + 2;
  return (decimal){s + (at > middle || (at == middle && s % 2 == 1)), k};
}

static void write_pair(char *to, uint32_t value) {
  static const char pairs[] =
      "00010203040506070809101112131415161718192021222324252627282930313233343536373839404142434445464748"
      "49505152535455565758596061626364656667686970717273747576777879808182838485868788899091929394959697"
      "9899";
  memcpy(to, pairs + 2 * value, 2);
}

/* Writes eight digits with leading zeros. */
static void write_eight(char *to, uint32_t value) {
  uint32_t high = value / 10000, low = value % 10000;
  write_pair(to, high / 100);
  write_pair(to + 2, high % 100);
  write_pair(to + 4, low / 100);
  write_pair(to + 6, low % 100);
}

/* The digits as text in `buffer`, without leading or trailing zeros, and their count; `exponent` becomes that of the
 * first digit. */
static const char *write_digits(decimal *d, char buffer[MOST_DIGITS], int *count) {
  uint64_t high = d->digits / 100000000;
  buffer[0] = (char)('0' + high / 100000000);
  write_eight(buffer + 1, (uint32_t)(high % 100000000));
  write_eight(buffer + 9, (uint32_t)(d->digits % 100000000));
  int first = 0, last = MOST_DIGITS - 1;
  while (buffer[first] == '0')
    ++first;
  while (buffer[last] == '0')
    --last;
  d->exponent += MOST_DIGITS - 1 - first;
  *count = last - first + 1;
  return buffer + first;
}

static char *write_text(char *to, const char *from, int count) {
  memcpy(to, from, (size_t)count);
  return to + count;
}

static char *write_zeros(char *to, int count) {
  memset(to, '0', (size_t)count);
  return to + count;
}

/* Writes d.ddde±XX with at least two digits of exponent. */
static char *write_scientific(char *to, const char *digits, int count, int point) {
  int e = point < 0 ? -point : point;
  *to++ = digits[0];
  if (count > 1) {
    *to++ = '.';
    to = write_text(to, digits + 1, count - 1);
  }
  *to++ = 'e';
  *to++ = point < 0 ? '-' : '+';
  if (e >= 100)
    *to++ = (char)('0' + e / 100);
  *to++ = (char)('0' + e / 10 % 10);
  *to++ = (char)('0' + e % 10);
  return to;
}

/* `point`: the power of ten of the first digit. */
static char *write_plain(char *to, const char *digits, int count, int point) {
  if (point < 0) {
    to = write_zeros(write_text(to, "0.", 2), -point - 1);
    return write_text(to, digits, count);
  }
  int whole = point + 1;
  if (count <= whole)
    return write_zeros(write_text(to, digits, count), whole - count);
  to = write_text(to, digits, whole);
  *to++ = '.';
  return write_text(to, digits + whole, count - whole);
}

size_t km_number_format(char out[KM_NUMBER_TEXT], double value) {
  if (!out)
    return 0;
  char *to = out, buffer[MOST_DIGITS];
  uint64_t bits;
  memcpy(&bits, &value, sizeof bits);
  if (isnan(value))
    return (size_t)(strcpy(out, "nan"), 3);
  if (signbit(value))
    *to++ = '-';
  if (isinf(value)) {
    strcpy(to, "inf");
    return (size_t)(to + 3 - out);
  }
  if (value == 0.0) {
    *to++ = '0';
  } else {
    decimal d = shortest(bits & (((uint64_t)1 << FRACTION_BITS) - 1), (int)(bits >> FRACTION_BITS & 0x7FF));
    int count;
    const char *digits = write_digits(&d, buffer, &count);
    int point = d.exponent, precision = count > 15 ? count : 15;
    /* Formats like printf's %g with the precision of these digits. */
    bool scientific = point < -4 || point >= precision;
    to = scientific ? write_scientific(to, digits, count, point) : write_plain(to, digits, count, point);
  }
  *to = '\0';
  return (size_t)(to - out);
}

const char *km_number_shown(char out[KM_NUMBER_TEXT], double value) {
  km_number_format(out, value);
  return out;
}
