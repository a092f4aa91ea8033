// Presses on plates.
#pragma once

#include <Eigen/Core>

#include "slave/mechanics/deformation_model.h"

namespace palpate::plates {

// Downwards by `depth` [m], on a disc of `width` [m].
inline Contact Moved(const Eigen::Vector2d& p_O, double depth, double width = 0) {
  return {Contact::Kind::kDisplacement, {p_O.x(), p_O.y(), 0}, -1, width, {0, 0, -depth}};
}

// Downwards with `force` [N].
inline Contact Loaded(const Eigen::Vector2d& p_O, double force, double width = 0) {
  return {Contact::Kind::kForce, {p_O.x(), p_O.y(), 0}, -1, width, {0, 0, -force}};
}

}  // namespace palpate::plates
