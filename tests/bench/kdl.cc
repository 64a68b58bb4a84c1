#include "kdl.h"

#include <kdl/chain.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainiksolvervel_wdls.hpp>

struct bench_kdl {
  KDL::Chain chain;
  KDL::ChainIkSolverVel_pinv *pinv;
  KDL::ChainIkSolverVel_wdls *wdls;
  KDL::JntArray q, rates;
};

static KDL::Vector vector_of(const double *v) {
  return KDL::Vector(v[0], v[1], v[2]);
}

extern "C" bench_kdl *bench_kdl_create(int n, const double *axis, const double *point, const double *tip) {
  bench_kdl *k = new bench_kdl;
  for (int i = 0; i < n; ++i) {
    /* Each segment's frame stands at its joint; all axes parallel to the inertial ones at q = 0. */
    KDL::Vector here = vector_of(point + 3 * i), next = i + 1 < n ? vector_of(point + 3 * (i + 1)) : vector_of(tip);
    KDL::Vector before = i == 0 ? here : KDL::Vector::Zero();
    KDL::Joint joint("joint", before, vector_of(axis + 3 * i), KDL::Joint::RotAxis);
    k->chain.addSegment(KDL::Segment(joint, KDL::Frame(i == 0 ? next : next - here)));
  }
  k->pinv = new KDL::ChainIkSolverVel_pinv(k->chain);
  k->wdls = new KDL::ChainIkSolverVel_wdls(k->chain);
  k->q.resize((unsigned)n);
  k->rates.resize((unsigned)n);
  return k;
}

extern "C" void bench_kdl_free(bench_kdl *k) {
  delete k->pinv;
  delete k->wdls;
  delete k;
}

template <typename Solver>
static void solve(bench_kdl *k, Solver *solver, const double *q, const double *twist, double *rates) {
  for (unsigned i = 0; i < k->q.rows(); ++i)
    k->q(i) = q[i];
  KDL::Twist t(vector_of(twist), vector_of(twist + 3));
  solver->CartToJnt(k->q, t, k->rates);
  for (unsigned i = 0; i < k->q.rows(); ++i)
    rates[i] = k->rates(i);
}

extern "C" void bench_kdl_pinv(bench_kdl *k, const double *q, const double *twist, double *rates) {
  solve(k, k->pinv, q, twist, rates);
}

extern "C" void bench_kdl_wdls(bench_kdl *k, const double *q, const double *twist, double *rates) {
  solve(k, k->wdls, q, twist, rates);
}
