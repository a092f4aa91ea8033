// How the axes in which contact normals were measured stand in the fingertip's frame.
#pragma once

#include <string>

#include <Eigen/Core>

namespace palpate {

// `-x,y,-z`, say: x of frame F is minus the measured x, and so on. Throws std::invalid_argument:
// not three different axes, each with a sign or without.
Eigen::Matrix3d ParseAxes(const std::string& text);
std::string AxesText(const Eigen::Matrix3d& axes);

// The rotation by quarter turns that is nearest to `rotation`.
Eigen::Matrix3d NearestAxes(const Eigen::Matrix3d& rotation);

}  // namespace palpate
