/* Sine and cosine for a type T, a double or a vector of doubles; included once for each type. Every operation is equal
 * in each lane and nothing is contracted, so a lane has the bits of the plain double, on every machine.
 *
 * The includer defines T; BITS, an unsigned integer type of equal size, and NONE, its 0; FN(name); km_bits_of(x),
 * km_number_of(bits). */

/* Sine and cosine for |x| <= 1e5, to about one ulp: Cody and Waite's reduction by π/2 in three parts, and the
 * polynomials of fdlibm. */
static inline void FN(sincos)(T x, T *sine, T *cosine) {
  T shifted = x * 0.63661977236758134308 + KM_ROUNDING, n = shifted - KM_ROUNDING;
  T r = ((x - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11) - n * 2.02226624879595063154e-21;
  T z = r * r;
  T s = r + r * z *
                (-1.66666666666666324348e-01 +
                 z * (8.33333333332248946124e-03 +
                      z * (-1.98412698298579493134e-04 +
                           z * (2.75573137070700676789e-06 +
                                z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)))));
  T c = 1.0 - (0.5 * z - z * z *
                             (4.16666666666666019037e-02 +
                              z * (-1.38888888888741095749e-03 +
                                   z * (2.48015872894767294178e-05 +
                                        z * (-2.75573143513906633035e-07 +
                                             z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))))));
  BITS quadrant = km_bits_of(shifted), odd = NONE - (quadrant & 1);
  BITS sine_bits = (km_bits_of(c) & odd) | (km_bits_of(s) & ~odd);
  BITS cosine_bits = (km_bits_of(s) & odd) | (km_bits_of(c) & ~odd);
  *sine = km_number_of(sine_bits ^ ((quadrant & 2) << 62));
  *cosine = km_number_of(cosine_bits ^ (((quadrant + 1) & 2) << 62));
}
