#include <gtest/gtest.h>
#include <iostream>
#include "ch5_backend/solve/problem.h"
#include "ch5_backend/world/mono_ba.h"
using namespace ch5;
TEST(Smoke, MonoBa) {
  for (auto [f, p] : {std::pair{3, 20}, {10, 200}, {30, 1000}}) {
    for (auto alg : {Algorithm::kLevenbergMarquardt, Algorithm::kGaussNewton, Algorithm::kDogleg}) {
      MonoBaOptions o;
      o.frames = f;
      o.points = p;
      MonoBa ba;
      BuildMonoBa(SimulateMonoBa(o), Gauge::kFixTwoFrames, 1.0, 0.0, &ba);
      Problem problem(&ba.graph);
      SolveOptions so;
      so.algorithm = alg;
      so.max_iterations = 20;
      auto s = problem.Solve(so);
      std::cout << f << "x" << p << " " << s.initial_cost << " -> " << s.final_cost << " it " << s.iterations << " ev "
                << s.cost_evaluations << " " << s.seconds * 1e3 << " ms " << s.message << "\n";
    }
  }
}
