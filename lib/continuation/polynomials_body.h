/* Polynomials of the predictors for a type T, a double or a vector of doubles; included once for each type. The
 * includer defines T and FN(name) (theory 4.5). */

/* Weights, in a step of h, of the cubic through the last two configurations and their tangents (Hermite). */
typedef struct FN(cubic) {
  T last_h, h00, h10, h11;
} FN(cubic);

static inline FN(cubic) FN(cubic_weights)(T h, T last_h) {
  const T u = h / last_h + 1.0; /* 0 at the last configuration, 1 at the present one */
  return (FN(cubic)){last_h, 2.0 * u * u * u - 3.0 * u * u + 1.0, u * u * u - 2.0 * u * u + u, u * u * u - u * u};
}
/* Move of the cubic from the present configuration; last_move led here over last_h, last_t and t are the tangents. */
static inline T FN(cubic_value)(const FN(cubic) * c, T last_move, T last_t, T t) {
  return -c->h00 * last_move + c->last_h * (c->h10 * last_t + c->h11 * t);
}
