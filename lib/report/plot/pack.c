/* Packs pixels: runs that repeat the pixel before or the pixels above, in Huffman codes made for each block. */
#include "report/plot/pack.h"

#include "base/memory.h"
#include "report/plot/huffman.h"

#include <string.h>

enum {
  LITERALS = 286, /* bytes, the end of a block, lengths */
  DISTANCES = 30,
  END = 256,
  LONGEST = 258, /* bytes of a repetition */
  FARTHEST = 32768,
  TOKENS = 1 << 15, /* of a block */
  SEEN_BITS = 12,
  LOOK_FURTHER = 4 /* pixels: where what is near repeats less */
};

/* A byte as it is, or a repetition of so many bytes. */
typedef struct token {
  uint16_t byte_or_length;
  uint16_t distance; /* 0: a byte */
} token;

/* Where a pair of pixels stood. */
typedef struct seen {
  const uint32_t *line;
  int y, x;
} seen;

typedef struct packer {
  km_text *out;
  uint64_t held; /* bits that aren't a byte yet */
  int held_count;
  token *tokens;
  int count;
  uint64_t sums[2];             /* Adler's */
  const uint32_t *line, *above; /* above: NULL where it is too far */
  int y, width;
  seen *seen;
} packer;

static void put_bits(packer *p, unsigned bits, int count) {
  p->held |= (uint64_t)bits << p->held_count;
  p->held_count += count;
  if (p->held_count < 32)
    return;
  unsigned char bytes[4];
  for (int i = 0; i < 4; ++i)
    bytes[i] = (unsigned char)(p->held >> 8 * i);
  km_text_bytes(p->out, bytes, 4);
  p->held >>= 32;
  p->held_count -= 32;
}

/* The symbol of a length or distance, and what is told behind it. */
typedef struct symbol {
  int index, extra_count;
  unsigned extra;
} symbol;

/* Lengths 3, 4, ... and distances 1, 2, ...: twice as many values a symbol after every fourth, or second, of them. */
static symbol symbol_of(unsigned value, int a_size) {
  int digits = 32 - __builtin_clz(value | 1), extra = digits > a_size + 1 ? digits - a_size - 1 : 0;
  return (symbol){(extra << a_size) + (int)(value >> extra), extra, value & ((1U << extra) - 1)};
}

static symbol length_symbol(unsigned length) {
  symbol s = symbol_of(length - 3, 2);
  s.index += END + 1;
  return length == LONGEST ? (symbol){LITERALS - 1, 0, 0} : s;
}

static symbol distance_symbol(unsigned distance) {
  return symbol_of(distance - 1, 1);
}

static void put_symbol(packer *p, const km_alphabet *a, int which) {
  put_bits(p, a->bits[which], a->size[which]);
}

static void put_token(packer *p, const km_alphabet *literals, const km_alphabet *distances, token t) {
  if (t.distance == 0) {
    put_symbol(p, literals, t.byte_or_length);
    return;
  }
  symbol length = length_symbol(t.byte_or_length), distance = distance_symbol(t.distance);
  put_symbol(p, literals, length.index);
  put_bits(p, length.extra, length.extra_count);
  put_symbol(p, distances, distance.index);
  put_bits(p, distance.extra, distance.extra_count);
}

/* The sizes of both codes, four bits each: with a code of their own they would take a hundred bytes less. */
static void put_sizes(packer *p, const km_alphabet *literals, const km_alphabet *distances) {
  static const unsigned char order[] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
  put_bits(p, LITERALS - 257, 5);
  put_bits(p, DISTANCES - 1, 5);
  put_bits(p, sizeof order - 4, 4);
  for (size_t i = 0; i < sizeof order; ++i)
    put_bits(p, order[i] < 16 ? 4 : 0, 3);
  for (int s = 0; s < LITERALS; ++s)
    put_bits(p, km_bits_reversed(literals->size[s], 4), 4);
  for (int s = 0; s < DISTANCES; ++s)
    put_bits(p, km_bits_reversed(distances->size[s], 4), 4);
}

static void put_block(packer *p, bool last) {
  km_alphabet literals = {.count = LITERALS}, distances = {.count = DISTANCES};
  for (int i = 0; i < p->count; ++i) {
    token t = p->tokens[i];
    literals.occurs[t.distance ? length_symbol(t.byte_or_length).index : t.byte_or_length]++;
    if (t.distance)
      distances.occurs[distance_symbol(t.distance).index]++;
  }
  literals.occurs[END] = 1;
  km_alphabet_code(&literals);
  km_alphabet_code(&distances);
  put_bits(p, last, 1);
  put_bits(p, 2, 2); /* with codes of its own */
  put_sizes(p, &literals, &distances);
  for (int i = 0; i < p->count; ++i)
    put_token(p, &literals, &distances, p->tokens[i]);
  put_symbol(p, &literals, END);
  p->count = 0;
}

static void add_token(packer *p, unsigned byte_or_length, unsigned distance) {
  if (p->count == TOKENS)
    put_block(p, false);
  p->tokens[p->count++] = (token){(uint16_t)byte_or_length, (uint16_t)distance};
}

static void add_repetition(packer *p, int pixels, unsigned distance) {
  for (int bytes = 3 * pixels; bytes > 0; bytes -= LONGEST)
    add_token(p, (unsigned)(bytes < LONGEST ? bytes : LONGEST), distance);
}

static unsigned channel(uint32_t pixel, int k) {
  return pixel >> (16 - 8 * k) & 255U;
}

static bool same(uint32_t a, uint32_t b) {
  return ((a ^ b) & 0xffffff) == 0;
}

static bool same_two(const uint32_t *a, const uint32_t *b) {
  uint64_t x, y;
  memcpy(&x, a, sizeof x);
  memcpy(&y, b, sizeof y);
  return ((x ^ y) & 0xffffff00ffffff) == 0;
}

/* Adler's sums over pixels, and over `count` times the same one. */
static void sum_pixel(packer *p, uint32_t pixel) {
  for (int k = 0; k < 3; ++k) {
    p->sums[0] += channel(pixel, k);
    p->sums[1] += p->sums[0];
  }
}

static void sum_run(packer *p, uint32_t pixel, int count) {
  uint64_t n = (uint64_t)count, all = 3 * n * (n + 1) / 2;
  p->sums[1] += 3 * n * p->sums[0];
  for (int k = 0; k < 3; ++k) {
    p->sums[0] += n * channel(pixel, k);
    p->sums[1] += (all - n * (unsigned)k) * channel(pixel, k);
  }
}

/* Repeats pixels from `distance` bytes before. */
typedef struct repetition {
  int pixels;
  unsigned distance;
} repetition;

/* How many pixels from x on are those from `from` on, which lie in one line, too. */
static repetition repeats(const packer *p, int x, const uint32_t *from, int most, unsigned distance) {
  int count = 0;
  while (count + 1 < most && same_two(p->line + x + count, from + count))
    count += 2;
  while (count < most && same(p->line[x + count], from[count]))
    ++count;
  return (repetition){count, distance};
}

/* Where two pixels like those at x stood last. */
static repetition repeats_seen(packer *p, int x) {
  const unsigned stride = 3 * (unsigned)p->width + 1;
  uint64_t pair = (uint64_t)(p->line[x] & 0xffffff) << 24 | (p->line[x + 1] & 0xffffff);
  seen *last = &p->seen[pair * 0x9e3779b97f4a7c15U >> (64 - SEEN_BITS)], here = {p->line, p->y, x};
  unsigned distance = (unsigned)(p->y - last->y) * stride + 3 * (unsigned)(x - last->x);
  repetition r = {0, 0};
  if (last->line && (unsigned)(p->y - last->y) <= FARTHEST / stride && distance <= FARTHEST) {
    int most = p->width - (x > last->x ? x : last->x);
    r = repeats(p, x, last->line + last->x, most, distance);
  }
  *last = here;
  return r;
}

static repetition find_repetition(packer *p, int x) {
  const unsigned stride = 3 * (unsigned)p->width + 1;
  int most = p->width - x;
  repetition best = {0, 0};
  if (x > 0)
    best = repeats(p, x, p->line + x - 1, most, 3);
  if (p->above && best.pixels < most) {
    repetition up = repeats(p, x, p->above + x, most, stride);
    best = up.pixels > best.pixels ? up : best;
  }
  if (best.pixels < LOOK_FURTHER && most > 1) {
    repetition far = repeats_seen(p, x);
    best = far.pixels > best.pixels + 1 ? far : best;
  }
  return best;
}

static void pack_line(packer *p) {
  p->sums[1] += p->sums[0];
  add_token(p, 0, 0);
  for (int x = 0; x < p->width;) {
    repetition r = find_repetition(p, x);
    if (r.pixels == 0) {
      for (int k = 0; k < 3; ++k)
        add_token(p, channel(p->line[x], k), 0);
      sum_pixel(p, p->line[x++]);
      continue;
    }
    add_repetition(p, r.pixels, r.distance);
    if (r.distance == 3)
      sum_run(p, p->line[x], r.pixels);
    else
      for (int i = 0; i < r.pixels; ++i)
        sum_pixel(p, p->line[x + i]);
    x += r.pixels;
  }
  for (int k = 0; k < 2; ++k)
    p->sums[k] %= 65521;
}

static void finish(packer *p) {
  put_block(p, true);
  put_bits(p, 0, -p->held_count & 7);
  for (; p->held_count > 0; p->held_count -= 8, p->held >>= 8)
    km_text_bytes(p->out, (const char[]){(char)(p->held & 255)}, 1);
  unsigned char sum[4];
  km_png_put_number(sum, (uint32_t)(p->sums[1] << 16 | p->sums[0]));
  km_text_bytes(p->out, sum, 4);
}

bool km_pack_pixels(const km_pixels *pixels, km_text *out) {
  packer p = {.out = out, .width = pixels->width, .sums = {1, 0}};
  p.tokens = KM_NEW(token, TOKENS);
  p.seen = KM_NEW(seen, 1 << SEEN_BITS);
  if (p.tokens && p.seen) {
    km_text_bytes(out, "\x78\x01", 2); /* Deflate, a window of 32 KiB, made fast */
    for (; p.y < pixels->height; ++p.y) {
      const void *at = pixels->data + (size_t)p.y * (size_t)pixels->stride;
      p.above = 3 * p.width + 1 <= FARTHEST ? p.line : NULL;
      p.line = at;
      pack_line(&p);
    }
    finish(&p);
  }
  bool packed = p.tokens && p.seen && !out->failed;
  km_free(p.tokens);
  km_free(p.seen);
  return packed;
}
