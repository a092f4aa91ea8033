// How a gradient changes the weights.
#pragma once

#include <memory>

#include <Eigen/Core>

namespace palpate {

class Optimiser {
 public:
  virtual ~Optimiser() = default;
  Optimiser() = default;
  Optimiser(const Optimiser&) = delete;
  Optimiser& operator=(const Optimiser&) = delete;
  // `rate`: of this step; schedules are the caller's.
  virtual void Step(double rate, const Eigen::VectorXf& gradient, Eigen::VectorXf* weights) = 0;
};

// weights -= rate * gradient: the paper's.
std::unique_ptr<Optimiser> MakeSgd();
// Adam (Kingma and Ba 2015) with its usual constants 0.9, 0.999, 1e-8.
std::unique_ptr<Optimiser> MakeAdam(Eigen::Index weights);

}  // namespace palpate
