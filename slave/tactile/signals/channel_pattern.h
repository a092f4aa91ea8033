// ChannelPattern describes the channels of a sensor without electrodes while its network was
// trained.
#pragma once

#include <Eigen/Core>

namespace palpate {

// All values are in the unit of the N channels; x: change since the baseline, margins included.
// Learnt with a network, from the same contacts.
struct ChannelPattern {
  // N x N matrix with a zero diagonal: the best linear prediction of each channel from the others.
  Eigen::MatrixXd expectation;
  // A channel differs from it by at most sqrt(tolerance^2 + relative^2 s^2), s: rms of the others.
  Eigen::VectorXd tolerance, relative_tolerance;
  Eigen::VectorXd below, above;  // farthest from the baseline, both >= 0
  // Largest difference of two successive changes from sample to sample.
  Eigen::VectorXd second_difference;
  Eigen::VectorXd baseline;  // mean of those of the training; empty: there were too few
  // Largest force that the network estimates for another one of these baselines [N].
  double baseline_force = 0;
};

}  // namespace palpate
