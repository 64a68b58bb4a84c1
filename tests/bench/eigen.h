/* Eigen behind a C interface: minimum-norm rates of a 6 × 7 Jacobian by the Cholesky factorisation of JJᵀ. */
#ifndef BENCH_EIGEN_H
#define BENCH_EIGEN_H

#ifdef __cplusplus
extern "C" {
#endif

/* rates[7] = Jᵀ(JJᵀ)⁻¹ twist[6], J by columns. */
void bench_eigen_llt(const double *jacobian, const double *twist, double *rates);

#ifdef __cplusplus
}
#endif
#endif
