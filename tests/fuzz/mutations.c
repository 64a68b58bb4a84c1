/* Damages model files: bytes, tokens, whole pieces, or gently, so that much of it is still read. */
#include "mutations.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t next(uint64_t *state) {
  uint64_t z = (*state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

static size_t below(uint64_t *state, size_t n) {
  return n ? (size_t)(next(state) % n) : 0;
}

static void replace(input *in, size_t at, size_t length, const char *with, size_t size) {
  if (in->size - length + size > LONGEST)
    return;
  memmove(in->bytes + at + size, in->bytes + at + length, in->size - at - length);
  memcpy(in->bytes + at, with, size);
  in->size += size - length;
}

static const char *const numbers[] = {"0",
                                      "-0.0",
                                      "1",
                                      "-1",
                                      "1e308",
                                      "-1e308",
                                      "1e999",
                                      "1e-320",
                                      "1e60",
                                      "-1e60",
                                      "1e30",
                                      "1e-30",
                                      "1e-9",
                                      "0.5",
                                      "90",
                                      "360",
                                      "1e15",
                                      "NaN",
                                      "null",
                                      "true",
                                      "[]",
                                      "{}",
                                      "\"x\"",
                                      "[0,0]",
                                      "[0,0,0]",
                                      "2147483648",
                                      "-9223372036854775809",
                                      "3.141592653589793"};
static const char *const words[] = {"\"fixed\"",
                                    "\"origin\"",
                                    "\"Rx\"",
                                    "\"Ry\"",
                                    "\"Rz\"",
                                    "\"Tx\"",
                                    "\"Ty\"",
                                    "\"Tz\"",
                                    "\"rigid\"",
                                    "\"float\"",
                                    "\"spherical\"",
                                    "\"screw\"",
                                    "\"planar\"",
                                    "\"pitch\"",
                                    "\"limits\"",
                                    "\"active\"",
                                    "\"universal\"",
                                    "\"cylindrical\"",
                                    "\"degrees\"",
                                    "\"inches\"",
                                    "\"hold\"",
                                    "\"couplings\"",
                                    "\"\"",
                                    "\"a\\u0000\"",
                                    "\"0.2\"",
                                    "\"1.0\"",
                                    "[]",
                                    "{}",
                                    "null",
                                    "\"\\ud83d\\ude00\"",
                                    "\"A\"",
                                    "\"B[0]\""};

typedef struct span {
  size_t at, length;
} span;

/* Some token of the kind that lies behind a random place: a string with its quotes, or a number. */
static bool token(const input *in, uint64_t *state, bool string, span *out) {
  size_t i = below(state, in->size);
  const char *b = in->bytes;
  for (; i < in->size; ++i) {
    size_t end = i + 1;
    if (string && b[i] == '"') {
      while (end < in->size && b[end] != '"')
        ++end;
      *out = (span){i, end < in->size ? end + 1 - i : end - i};
      return true;
    }
    if (!string && (b[i] == '-' || (b[i] >= '0' && b[i] <= '9')) && i > 0 && strchr(" ,[:", b[i - 1])) {
      while (end < in->size && strchr("+-.eE0123456789", b[end]) && b[end])
        ++end;
      *out = (span){i, end - i};
      return true;
    }
  }
  return false;
}

static void swap_tokens(input *in, uint64_t *state, bool strings) {
  span a, b;
  char copy[256];
  if (!token(in, state, strings, &a) || !token(in, state, strings, &b) || a.at == b.at)
    return;
  span first = a.at < b.at ? a : b, second = a.at < b.at ? b : a;
  if (first.at + first.length > second.at || second.length > sizeof copy || first.length > sizeof copy)
    return;
  char other[256];
  memcpy(copy, in->bytes + second.at, second.length);
  memcpy(other, in->bytes + first.at, first.length);
  replace(in, second.at, second.length, other, first.length);
  replace(in, first.at, first.length, copy, second.length);
}

/* A piece from one bracket or comma to a later one, so that the result often parses. */
static span piece(const input *in, uint64_t *state) {
  size_t from = below(state, in->size), to;
  while (from < in->size && !strchr(",[{", in->bytes[from]))
    ++from;
  to = from + 1 + below(state, 400);
  while (to < in->size && !strchr(",]}", in->bytes[to]))
    ++to;
  return to < in->size ? (span){from, to - from} : (span){0, 0};
}

static void copy_piece(input *in, uint64_t *state, bool remove) {
  char copy[1024];
  span p = piece(in, state);
  if (p.length == 0 || p.length > sizeof copy)
    return;
  memcpy(copy, in->bytes + p.at, p.length);
  if (remove)
    replace(in, p.at, p.length, "", 0);
  else
    replace(in, p.at + p.length, 0, copy, p.length);
}

static void mutate(input *in, uint64_t *state) {
  span t;
  char byte;
  switch (below(state, 16)) {
  case 0:
    if (in->size)
      in->bytes[below(state, in->size)] ^= (char)(1 << below(state, 8));
    break;
  case 1:
    in->size = below(state, in->size + 1);
    break;
  case 2:
    byte = (char)next(state);
    replace(in, below(state, in->size + 1), 0, &byte, 1);
    break;
  case 3:
    swap_tokens(in, state, false);
    break;
  case 4:
  case 5:
    swap_tokens(in, state, true);
    break;
  case 6:
    copy_piece(in, state, true);
    break;
  case 7:
    copy_piece(in, state, false);
    break;
  case 8:
  case 9:
    if (token(in, state, true, &t)) {
      const char *word = words[below(state, sizeof words / sizeof *words)];
      replace(in, t.at, t.length, word, strlen(word));
    }
    break;
  default:
    if (token(in, state, false, &t)) {
      const char *number = numbers[below(state, sizeof numbers / sizeof *numbers)];
      replace(in, t.at, t.length, number, strlen(number));
    }
  }
}

/* A change that leaves the model readable: another finite number, another type of joint, or a
 * number a little off. */
static void mutate_gently(input *in, uint64_t *state) {
  enum { FINITE = 18, TYPES = 12 };
  static const char *const types[TYPES] = {"\"Rx\"",    "\"Ry\"",        "\"Rz\"",     "\"Tx\"",
                                           "\"Ty\"",    "\"Tz\"",        "\"rigid\"",  "\"spherical\"",
                                           "\"float\"", "\"universal\"", "\"planar\"", "\"cylindrical\""};
  span t;
  char text[32];
  size_t choice = below(state, 8);
  if (choice < 3) { /* the next known type becomes another */
    for (int tries = 0; tries < 40 && token(in, state, true, &t); ++tries)
      for (size_t k = 0; k < TYPES; ++k)
        if (t.length == strlen(types[k]) && memcmp(in->bytes + t.at, types[k], t.length) == 0) {
          const char *type = types[below(state, TYPES)];
          replace(in, t.at, t.length, type, strlen(type));
          return;
        }
  } else if (token(in, state, false, &t)) {
    const char *number = numbers[below(state, FINITE - 1)];
    if (choice < 7) {
      snprintf(text, sizeof text, "%.3g", (double)(int)below(state, 20001) * 1e-3 - 10.0);
      number = text;
    }
    replace(in, t.at, t.length, number, strlen(number));
  }
}

input mutation_make(uint64_t seed, const input *files, size_t count) {
  uint64_t state = seed;
  const input *from = &files[below(&state, count)];
  input in = {malloc(LONGEST), from->size};
  if (!in.bytes)
    exit(2);
  memcpy(in.bytes, from->bytes, from->size);
  bool gently = below(&state, 2) == 0;
  for (size_t n = 1 + below(&state, 4); n > 0; --n) {
    if (gently)
      mutate_gently(&in, &state);
    else
      mutate(&in, &state);
  }
  return in;
}
