// Rigid bodies of a world: how many are stepped in real time, and how true they are. One line of JSON a run,
// for scripts/study_world.
#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "engine/core/index.h"
#include "engine/nodes/world/rigid_bodies.h"

using namespace tactus;

namespace {

constexpr double kGravity = 9.81, kEdge_m = 0.04;

/// Computing time of this thread: other programs of a shared machine do not count.
double cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Solver {
  const char* name;
  bool direct;
  int iterations;
  double cfm;
};
constexpr Solver kSolvers[] = {{"direct", true, 1, 0},
                               {"direct, cfm 1e-5", true, 1, 1e-5},
                               {"iterative, 20", false, 20, 0},
                               {"iterative, 100", false, 100, 0}};

RigidModel model_of(const Solver& solver, double step_s) {
  RigidModel model;
  model.step_s = step_s;
  model.direct = solver.direct;
  model.iterations = solver.iterations;
  model.cfm = solver.cfm;
  return model;
}

void add_floor(RigidModel& model, double restitution = 0) {
  BodyModel floor;
  floor.shape = WorldShape::Plane;
  floor.restitution = restitution;
  model.bodies.push_back(floor);
}

void add_body(RigidModel& model, WorldShape shape, const Vector3& at, double mass,
              const Vector3& velocity = {}, double restitution = 0) {
  BodyModel body;
  body.shape = shape;
  body.restitution = restitution;
  body.initial.position = at;
  body.initial.velocity = velocity;
  body.initial.size = {kEdge_m, kEdge_m, kEdge_m};
  if (shape == WorldShape::Sphere) body.initial.size = {kEdge_m / 2, 0, 0};
  body.initial.mass = mass;
  model.bodies.push_back(body);
}

std::unique_ptr<RigidBodies> made(RigidModel& model) {
  model.most_contacts = 6 * static_cast<int>(model.bodies.size()) + 16;
  auto bodies = RigidBodies::make(model);
  if (!bodies) std::exit(1);
  (*bodies)->set_gravity({0, 0, -kGravity});
  return std::move(*bodies);
}

double deepest(const RigidBodies& bodies) {
  double depth = 0;
  for (const auto& contact : bodies.contacts()) depth = std::max(depth, contact.depth);
  return depth;
}

// How many.

/// `count` bodies: balls that lie apart, blocks in stacks of five, or blocks that all touch their neighbours.
void add_crowd(RigidModel& model, const std::string& kind, int count) {
  const int side = static_cast<int>(std::ceil(std::sqrt(count / (kind == "wall" ? 1.0 : 5.0))));
  for (int i = 0; i < count; ++i) {
    if (kind == "balls apart")
      add_body(model, WorldShape::Sphere, {2 * kEdge_m * i, 0, kEdge_m / 2}, 0.05);
    else if (kind == "stacks of five")
      add_body(model, WorldShape::Box,
               {1.5 * kEdge_m * (i / 5 % side), 1.5 * kEdge_m * (i / 5 / side), kEdge_m * (0.5 + i % 5)},
               0.05);
    else  // a wall of bricks, each on two
      add_body(model, WorldShape::Box,
               {1.02 * kEdge_m * (i % side + 0.5 * (i / side % 2)), 0, kEdge_m * (0.5 + i / side)}, 0.05);
  }
}

void time_crowd(const Solver& solver, const std::string& kind, int count) {
  constexpr int kSettle = 100, kSteps = 1000;
  auto model = model_of(solver, 1e-3);
  add_floor(model);
  add_crowd(model, kind, count);
  const auto bodies = made(model);
  std::vector<double> times;
  double all = 0;
  for (int step = 0; step < kSettle + kSteps && all < 60; ++step) {
    const double from = cpu_s();
    bodies->step();
    const double took = cpu_s() - from;
    all += took;
    if (step >= kSettle) times.push_back(took);
  }
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  fmt::print(
      "{{\"study\": \"crowd\", \"solver\": \"{}\", \"kind\": \"{}\", \"count\": {}, \"median_us\": {:.4g}, "
      "\"p99_us\": {:.4g}, \"bytes\": {}, \"refused\": {}}}\n",
      solver.name, kind, count, 1e6 * times[times.size() / 2], 1e6 * times[times.size() * 99 / 100],
      bodies->bytes_used(), bodies->refused());
}

// How true.

/// A pendulum of 20 cm from 90 degrees, 60 s.
void swing(const Solver& solver, double step_s) {
  auto model = model_of(solver, step_s);
  add_body(model, WorldShape::Sphere, {0.2, 0, 0}, 0.05);
  model.joints.push_back({WorldJoint::Hinge, 0, -1, {}, {0, 1, 0}});
  const auto bodies = made(model);
  const double scale = 0.05 * kGravity * 0.2, before = bodies->energy();
  double worst = 0;
  const int steps = static_cast<int>(std::lround(60 / step_s));
  const double from = cpu_s();
  for (int step = 0; step < steps; ++step) {
    bodies->step();
    worst = std::max(worst, std::abs(bodies->energy() - before) / scale);
  }
  const double took = cpu_s() - from;
  const auto p = bodies->position(0);
  fmt::print(
      "{{\"study\": \"pendulum\", \"solver\": \"{}\", \"step_s\": {:.6g}, \"worst\": {:.4g}, \"drift\": "
      "{:.4g}, \"length_error\": {:.3g}, \"cpu_s\": {:.4g}}}\n",
      solver.name, step_s, worst, (bodies->energy() - before) / scale, std::hypot(p[0], p[1], p[2]) / 0.2 - 1,
      took);
}

/// A ball falls 30 cm on a floor without loss, 20 s.
void bounce(const Solver& solver, double step_s) {
  auto model = model_of(solver, step_s);
  add_floor(model, 1.0);
  add_body(model, WorldShape::Sphere, {0, 0, 0.3 + kEdge_m / 2}, 0.05, {}, 1.0);
  const auto bodies = made(model);
  const double rest = 0.05 * kGravity * kEdge_m / 2, scale = 0.05 * kGravity * 0.3;
  double depth = 0, most = 0;
  const int steps = static_cast<int>(std::lround(20 / step_s));
  const double from = cpu_s();
  for (int step = 0; step < steps; ++step) {
    bodies->step();
    depth = std::max(depth, deepest(*bodies));
    most = std::max(most, bodies->energy() - rest);
  }
  fmt::print(
      "{{\"study\": \"bounce\", \"solver\": \"{}\", \"step_s\": {:.6g}, \"drift\": {:.4g}, \"most\": {:.4g}, "
      "\"depth_m\": {:.4g}, \"cpu_s\": {:.4g}}}\n",
      solver.name, step_s, (bodies->energy() - rest) / scale - 1, most / scale - 1, depth, cpu_s() - from);
}

/// A ball hits a plate of 1 cm with half of its speed left by the restitution, ten times, each a tenth of a
/// step later than the one before.
void impact(const Solver& solver, double step_s, double speed) {
  constexpr int kTimes = 10;
  int through = 0;
  double depth = 0, least = 1, most = 0;
  for (int time = 0; time < kTimes; ++time) {
    auto model = model_of(solver, step_s);
    BodyModel plate;
    plate.shape = WorldShape::Box;
    plate.moves = false;
    plate.initial.size = {0.01, 1, 1};
    plate.initial.position = {0.5, 0, 0};
    model.bodies.push_back(plate);
    add_body(model, WorldShape::Sphere, {-speed * step_s * (time + 0.5) / kTimes, 0, 0}, 0.05, {speed, 0, 0},
             0.5);
    const auto bodies = made(model);
    bodies->set_gravity({});
    const int steps = static_cast<int>(std::lround(1.0 / speed / step_s));
    for (int step = 0; step < steps; ++step) {
      bodies->step();
      depth = std::max(depth, deepest(*bodies));
    }
    if (bodies->position(1)[0] > 0.5) {
      ++through;
      continue;
    }
    least = std::min(least, -bodies->velocity(1)[0] / speed);
    most = std::max(most, -bodies->velocity(1)[0] / speed);
  }
  fmt::print(
      "{{\"study\": \"impact\", \"solver\": \"{}\", \"step_s\": {:.6g}, \"speed\": {}, \"depth_m\": {:.4g}, "
      "\"least\": {:.6g}, \"most\": {:.6g}, \"through\": {}}}\n",
      solver.name, step_s, speed, depth, least, most, through);
}

/// A heavy block on a light one, 5 s.
void ratio(const Solver& solver, double times) {
  auto model = model_of(solver, 1e-3);
  add_floor(model);
  add_body(model, WorldShape::Box, {0, 0, kEdge_m / 2}, 0.01);
  add_body(model, WorldShape::Box, {0, 0, 1.5 * kEdge_m}, 0.01 * times);
  const auto bodies = made(model);
  double depth = 0;
  for (int step = 0; step < 5000; ++step) {
    bodies->step();
    depth = std::max(depth, deepest(*bodies));
  }
  const auto top = bodies->position(2);
  fmt::print(
      "{{\"study\": \"ratio\", \"solver\": \"{}\", \"ratio\": {}, \"depth_m\": {:.4g}, \"sunk_m\": {:.4g}, "
      "\"aside_m\": {:.4g}}}\n",
      solver.name, times, depth, 1.5 * kEdge_m - top[2], std::hypot(top[0], top[1]));
}

/// A stack of equal blocks, 5 s.
void stack(const Solver& solver, int count) {
  auto model = model_of(solver, 1e-3);
  add_floor(model);
  for (int i = 0; i < count; ++i) add_body(model, WorldShape::Box, {0, 0, kEdge_m * (0.5 + i)}, 0.05);
  const auto bodies = made(model);
  double depth = 0;
  const double from = cpu_s();
  for (int step = 0; step < 5000 && cpu_s() - from < 60; ++step) {
    bodies->step();
    depth = std::max(depth, deepest(*bodies));
  }
  const auto top = bodies->position(count);
  fmt::print(
      "{{\"study\": \"stack\", \"solver\": \"{}\", \"count\": {}, \"depth_m\": {:.4g}, \"sunk_m\": {:.4g}, "
      "\"aside_m\": {:.4g}, \"cpu_s\": {:.4g}}}\n",
      solver.name, count, depth, kEdge_m * (count - 0.5) - top[2], std::hypot(top[0], top[1]),
      cpu_s() - from);
}

}  // namespace

// world_study [studies…]: crowd, steps, solvers; without a name all.
int main(int count, char** names) {
  const auto wanted = [&](const std::string& study) {
    return count == 1 || std::find(names + 1, names + count, study) != names + count;
  };
  for (const auto& solver : {kSolvers[0], kSolvers[2]})
    for (const char* kind : {"balls apart", "stacks of five", "wall"})
      for (const int bodies : {1, 2, 5, 10, 15, 20, 25, 30, 40, 50, 75, 100, 150, 200, 300, 400})
        if (wanted("crowd") && bodies <= (solver.direct && kind[0] == 'w' ? 40 : 400))
          time_crowd(solver, kind, bodies);
  for (const double step_s : {4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4}) {
    if (!wanted("steps")) break;
    swing(kSolvers[0], step_s);
    bounce(kSolvers[0], step_s);
    for (const double speed : {1.0, 3.0, 10.0, 30.0}) impact(kSolvers[0], step_s, speed);
  }
  for (const auto& solver : kSolvers) {
    if (!wanted("solvers")) break;
    for (const double times : {1.0, 10.0, 100.0, 1e3, 1e4}) ratio(solver, times);
    for (const int blocks : {2, 5, 10, 20}) stack(solver, blocks);
  }
}
