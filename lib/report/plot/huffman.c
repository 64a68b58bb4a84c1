/* Huffman codes of limited length. */
#include "report/plot/huffman.h"

#include <stdlib.h>
#include <string.h>

typedef struct node {
  unsigned occurs;
  int symbol, parent; /* symbol -1: it joins two */
} node;

static int by_occurrence(const void *a, const void *b) {
  const node *x = a, *y = b;
  return x->occurs != y->occurs ? (x->occurs > y->occurs) - (x->occurs < y->occurs) : x->symbol - y->symbol;
}

/* The rarer of what is left of the leaves and of the joints, both of which come in order. */
static int take_rarest(const node *nodes, int leaves, int joints, int *leaf, int *joint) {
  return *joint == joints || (*leaf < leaves && nodes[*leaf].occurs <= nodes[*joint].occurs) ? (*leaf)++ : (*joint)++;
}

/* Huffman's: the two rarest are joined until one is left (D. A. Huffman, A method for the construction of minimum-redundancy
 * codes, 1952). Returns the bits of the longest code. */
static int find_sizes(km_alphabet *a) {
  node nodes[2 * KM_SYMBOLS];
  int leaves = 0, longest = 0;
  for (int s = 0; s < a->count; ++s)
    if (a->occurs[s])
      nodes[leaves++] = (node){a->occurs[s], s, 0};
  qsort(nodes, (size_t)leaves, sizeof *nodes, by_occurrence);
  int count = leaves, leaf = 0, joint = leaves;
  for (; count < 2 * leaves - 1; ++count) {
    int one = take_rarest(nodes, leaves, count, &leaf, &joint), two = take_rarest(nodes, leaves, count, &leaf, &joint);
    nodes[one].parent = nodes[two].parent = count;
    nodes[count] = (node){nodes[one].occurs + nodes[two].occurs, -1, 0};
  }
  int depth[2 * KM_SYMBOLS] = {0};
  memset(a->size, 0, sizeof a->size);
  for (int i = count - 1; i >= 0; --i) {
    depth[i] = i == count - 1 ? 0 : depth[nodes[i].parent] + 1;
    if (nodes[i].symbol >= 0)
      a->size[nodes[i].symbol] = (unsigned char)(leaves == 1 ? 1 : depth[i]);
    longest = depth[i] > longest ? depth[i] : longest;
  }
  return longest;
}

uint16_t km_bits_reversed(unsigned bits, int count) {
  unsigned out = 0;
  for (int i = 0; i < count; ++i)
    out |= (bits >> i & 1U) << (count - 1 - i);
  return (uint16_t)out;
}

/* Codes of one size are numbers that follow each other (RFC 1951, 3.2.2). */
void km_alphabet_code(km_alphabet *a) {
  unsigned next[KM_CODE_BITS + 2] = {0}, of_size[KM_CODE_BITS + 1] = {0};
  while (find_sizes(a) > KM_CODE_BITS)
    for (int s = 0; s < a->count; ++s)
      a->occurs[s] = (a->occurs[s] + 1) / 2;
  for (int s = 0; s < a->count; ++s)
    of_size[a->size[s]]++;
  of_size[0] = 0;
  for (int size = 1; size <= KM_CODE_BITS; ++size)
    next[size + 1] = (next[size] + of_size[size]) << 1;
  for (int s = 0; s < a->count; ++s)
    if (a->size[s])
      a->bits[s] = km_bits_reversed(next[a->size[s]]++, a->size[s]);
}
