/* Orocos KDL behind a C interface: what others use for the same step. */
#ifndef BENCH_KDL_H
#define BENCH_KDL_H

#ifdef __cplusplus
extern "C" {
#endif

typedef struct bench_kdl bench_kdl;

/* A chain of revolute joints: axis[3·n], point[3·n] in the inertial frame at q = 0, and the tip's place there. */
bench_kdl *bench_kdl_create(int n, const double *axis, const double *point, const double *tip);
void bench_kdl_free(bench_kdl *chain);
/* Joint rates for a twist (v; ω) of the tip, linear part first: by the pseudo-inverse, or weighted damped least
 * squares. */
void bench_kdl_pinv(bench_kdl *chain, const double *q, const double *twist, double *rates);
void bench_kdl_wdls(bench_kdl *chain, const double *q, const double *twist, double *rates);

#ifdef __cplusplus
}
#endif
#endif
