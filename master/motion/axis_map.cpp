#include "master/motion/axis_map.h"

#include <stdexcept>

#include <Eigen/LU>

#include "shared/text/text.h"

namespace palpate {

AxisMap::AxisMap(const Eigen::Matrix3d& P) : P_(P) {
  const Eigen::Matrix3d size = P.cwiseAbs();
  const bool is_permutation = ((size.array() == 0) || (size.array() == 1)).all() &&
                              (size.rowwise().sum().array() == 1).all() &&
                              (size.colwise().sum().array() == 1).all();
  if (!is_permutation) {
    throw std::invalid_argument("axes: expected each of x, y and z once, each with or without -");
  }
}

AxisMap AxisMap::Parse(std::string_view text) {
  Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
  int row = 0;
  std::size_t at = 0;
  bool good = true;
  while (good && row < 3) {
    const bool is_negative = text.substr(at).starts_with('-');
    at += is_negative ? 1 : 0;
    const std::size_t axis =
        at < text.size() ? kAxisLetters.find(text[at]) : std::string_view::npos;
    good = axis != std::string_view::npos;
    if (good) P(row++, static_cast<int>(axis)) = is_negative ? -1 : 1;
    ++at;
    if (row < 3) good = good && at < text.size() && text[at++] == ',';
  }
  good = good && at == text.size() && (P.cwiseAbs().colwise().sum().array() == 1).all();
  if (good) return AxisMap(P);
  throw std::invalid_argument(
      "--axes " + std::string(text) +
      ": expected the device's axes for right, up and towards the operator, for example x,y,z "
      "or -z,y,x");
}

DeviceReading AxisMap::ToMaster(const DeviceReading& reading_D) const noexcept {
  DeviceReading reading = reading_D;
  reading.p_M = P_ * reading_D.p_M;
  reading.v_M = P_ * reading_D.v_M;
  // P R P^T turns about the mapped axis by the same angle, reversed by a mirror.
  const double sign = P_.determinant();
  const Eigen::Vector3d vec = sign * (P_ * reading_D.q_M.vec());
  reading.q_M = Eigen::Quaterniond(reading_D.q_M.w(), vec.x(), vec.y(), vec.z());
  reading.w_M = sign * (P_ * reading_D.w_M);
  return reading;
}

}  // namespace palpate
