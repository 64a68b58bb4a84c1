/* A slider-crank reduced by hand: what a careful engineer would write for this one mechanism. */
#ifndef BENCH_HAND_H
#define BENCH_HAND_H

typedef struct hand_crank {
  double crank, rod, weight; /* lengths, and D of the slider's coordinate */
  double beta, x;            /* direction of the rod, place of the slider */
  double numbers[4];         /* A crank, B slider, C rod-slider, D crank-rod */
} hand_crank;

/* Newton from the last pose to that of crank angle `angle`, to 1e-12; then the numbers. */
void hand_crank_move(hand_crank *h, double angle);

#endif
