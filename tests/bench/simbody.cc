// The four-bar in Simbody.
#include "peers.h"

#include <Simbody.h>

#include <memory>

using namespace SimTK;

struct bench_simbody {
  MultibodySystem system;
  SimbodyMatterSubsystem matter{system};
  GeneralForceSubsystem forces{system};
  State state;
};

static Body::Rigid rod(double length) {
  return Body::Rigid(MassProperties(1.0, Vec3(0.5 * length, 0, 0),
                                    UnitInertia::cylinderAlongX(1e-6, 0.5 * length)
                                        .shiftFromCentroid(Vec3(-0.5 * length, 0, 0))));
}

extern "C" bench_simbody *bench_simbody_create(const bench_fourbar *b) {
  bench_simbody *s = new bench_simbody;
  Force::UniformGravity(s->forces, s->matter, Vec3(0, -b->gravity, 0));
  MobilizedBody::Pin crank(s->matter.Ground(), Transform(), rod(b->crank), Transform());
  MobilizedBody::Pin coupler(crank, Transform(Vec3(b->crank, 0, 0)), rod(b->coupler), Transform());
  MobilizedBody::Pin rocker(s->matter.Ground(), Transform(Vec3(b->ground, 0, 0)), rod(b->rocker), Transform());
  Constraint::PointInPlane(rocker, UnitVec3(1, 0, 0), b->rocker, coupler, Vec3(b->coupler, 0, 0));
  Constraint::PointInPlane(rocker, UnitVec3(0, 1, 0), 0.0, coupler, Vec3(b->coupler, 0, 0));
  s->state = s->system.realizeTopology();
  s->system.realizeModel(s->state);
  for (int i = 0; i < 3; ++i) {
    s->state.updQ()[i] = b->q[i];
    s->state.updU()[i] = b->v[i];
  }
  return s;
}

extern "C" void bench_simbody_free(bench_simbody *s) {
  delete s;
}

extern "C" void bench_simbody_accelerate(bench_simbody *s, double out[3]) {
  s->state.updQ(); // invalidates cached results of this configuration
  s->system.realize(s->state, Stage::Acceleration);
  const Vector &a = s->state.getUDot();
  for (int i = 0; i < 3; ++i)
    out[i] = a[i];
}

// CPodes, Simbody's port of CVODE, fails an assertion in Debian's build.
extern "C" const char *bench_simbody_integrator(int integrator) {
  return integrator == 0 ? "Runge-Kutta-Merson" : "Runge-Kutta-Fehlberg";
}

static std::unique_ptr<Integrator> integrator_of(const System &system, int integrator) {
  if (integrator == 0)
    return std::make_unique<RungeKuttaMersonIntegrator>(system);
  return std::make_unique<RungeKuttaFeldbergIntegrator>(system);
}

extern "C" void bench_simbody_simulate(bench_simbody *s, int integrator, double accuracy, int times, double *q) {
  std::unique_ptr<Integrator> steps = integrator_of(s->system, integrator);
  steps->setAccuracy(accuracy);
  TimeStepper stepper(s->system, *steps);
  stepper.initialize(s->state);
  for (int t = 0; t < times; ++t) {
    stepper.stepTo(t + 1.0);
    for (int i = 0; i < 3; ++i)
      q[3 * t + i] = steps->getState().getQ()[i];
  }
}
