#include "hand.h"

#include <math.h>

/* r cos α + l cos β − x = 0, r sin α + l sin β = 0 for β, x. Rates per rate of the crank:
 * β' = −r cos α/(l cos β), x' = −r sin α − l sin β β'. */
void hand_crank_move(hand_crank *h, double angle) {
  double c = cos(angle), s = sin(angle), cosine = 1.0, sine = 0.0;
  for (int i = 0; i < 20; ++i) {
    cosine = cos(h->beta);
    sine = sin(h->beta);
    double ex = h->crank * c + h->rod * cosine - h->x, ey = h->crank * s + h->rod * sine;
    if (fabs(ex) <= 1e-12 && fabs(ey) <= 1e-12)
      break;
    double turn = -ey / (h->rod * cosine);
    h->beta += turn;
    h->x += ex - h->rod * sine * turn;
  }
  double turn = -h->crank * c / (h->rod * cosine), slide = -h->crank * s - h->rod * sine * turn;
  double z[4] = {1.0, h->weight * slide, -turn, turn - 1.0}, sum = 0.0;
  for (int i = 0; i < 4; ++i)
    sum += z[i] * z[i];
  for (int i = 0; i < 4; ++i)
    h->numbers[i] = z[i] * z[i] / sum;
}
