/* A four-bar in other multibody libraries, to compare accelerations with. */
#ifndef BENCH_PEERS_H
#define BENCH_PEERS_H

#ifdef __cplusplus
extern "C" {
#endif

/* Crank, coupler and rocker as uniform rods of 1 kg and these lengths, hinges about z at (0, 0) and (ground, 0),
 * gravity along −y. */
typedef struct bench_fourbar {
  double crank, coupler, rocker, ground, gravity;
  double q[3], v[3]; /* crank on ground, coupler on crank, rocker on ground */
} bench_fourbar;

typedef struct bench_simbody bench_simbody;
bench_simbody *bench_simbody_create(const bench_fourbar *bars);
void bench_simbody_free(bench_simbody *simbody);
/* Accelerations of the same three coordinates. */
void bench_simbody_accelerate(bench_simbody *simbody, double out[3]);

/* Moves the four-bar from its first pose to the times 1, 2, … by one of Simbody's integrators, to an accuracy:
 * q[times][3]. */
enum { BENCH_SIMBODY_INTEGRATORS = 2 };
const char *bench_simbody_integrator(int integrator); /* its name */
void bench_simbody_simulate(bench_simbody *simbody, int integrator, double accuracy, int times, double *q);

typedef struct bench_mujoco bench_mujoco;
bench_mujoco *bench_mujoco_create(const bench_fourbar *bars);
void bench_mujoco_free(bench_mujoco *mujoco);
/* Accelerations by MuJoCo. Its constraints are soft and omit J̇ q̇, so they are those of rigid loops at rest only. */
void bench_mujoco_accelerate(bench_mujoco *mujoco, double out[3]);

#ifdef __cplusplus
}
#endif
#endif
