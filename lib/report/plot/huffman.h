/* Huffman codes as Deflate writes them (RFC 1951). Private to report/plot/. */
#ifndef KM_REPORT_PLOT_HUFFMAN_H
#define KM_REPORT_PLOT_HUFFMAN_H

#include <stdint.h>

enum { KM_SYMBOLS = 286, KM_CODE_BITS = 15 }; /* at most */

typedef struct km_alphabet {
  int count;                      /* of symbols */
  unsigned occurs[KM_SYMBOLS];    /* how often each does; some may be made more alike */
  unsigned char size[KM_SYMBOLS]; /* bits of its code; 0: it doesn't occur */
  uint16_t bits[KM_SYMBOLS];      /* its code, the first bit lowest */
} km_alphabet;

/* Finds the codes, the shortest on the whole unless one of them would have more than KM_CODE_BITS. */
void km_alphabet_code(km_alphabet *alphabet);

/* The lowest `count` bits, in the opposite order. */
uint16_t km_bits_reversed(unsigned bits, int count);

#endif
