#include "slave/service/observers/mesh_stream_encoder.h"

#include <chrono>
#include <stdexcept>

#include <Eigen/Core>

#include "shared/text/text.h"
#include "shared/wire/shape_code.h"
#include "slave/service/messages.h"

namespace palpate {
namespace {

constexpr double kLeastError = 1e-6, kMostError = 0.1;  // of the diagonal
constexpr double kBytesPerSecond = 600'000;             // 4.8 Mbit/s: the rest is gRPC's

double ErrorOf(const v1::WatchMeshRequest& request) {
  const double error = request.relative_error();
  if (error == 0 || (error >= kLeastError && error <= kMostError)) return error;  // nor NaN
  throw std::invalid_argument(
      Formatted("relative_error = %g: expected 0, or %g to %g", error, kLeastError, kMostError));
}

std::size_t BudgetOf(const v1::WatchMeshRequest& request) {
  return static_cast<std::size_t>(kBytesPerSecond *
                                  std::chrono::duration<double>(GapOf(request)).count());
}

// Corners of the box around `places`: x, y, z each [m].
double DiagonalOf(const std::vector<float>& places) {
  if (places.empty()) return 0;
  const Eigen::Map<const Eigen::Matrix3Xf> p(places.data(), 3,
                                             static_cast<Eigen::Index>(places.size() / 3));
  return (p.rowwise().maxCoeff() - p.rowwise().minCoeff()).cast<double>().norm();
}

// A third of each triangle around a node at rest [m^2].
std::vector<double> AreasOf(const BoundaryShape& shape) {
  std::vector<double> areas(shape.rest.size() / 3, 0);
  if (shape.nodes_per_element != 3) return areas;
  const auto at = [&](std::uint32_t node) {
    return Eigen::Vector3d(Eigen::Map<const Eigen::Vector3f>(&shape.rest[3 * node]).cast<double>());
  };
  for (std::size_t i = 0; i + 2 < shape.elements.size(); i += 3) {
    const std::uint32_t a = shape.elements[i], b = shape.elements[i + 1], c = shape.elements[i + 2];
    const double area = 0.5 * (at(b) - at(a)).cross(at(c) - at(a)).norm();
    for (const std::uint32_t node : {a, b, c}) areas[node] += area / 3;
  }
  return areas;
}

// As the model tells it; else of the forces on the nodes, each by its part of the surface.
std::vector<double> TractionOf(const BoundaryShape& shape, const std::vector<double>& areas) {
  const bool is_reported = !shape.traction.empty() || shape.nodes_per_element != 3;
  if (is_reported) return {shape.traction.begin(), shape.traction.end()};
  std::vector<double> pascals;
  for (std::size_t i = 0; 3 * i < shape.nodal_forces.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3f> force(&shape.nodal_forces[3 * i]);
    pascals.push_back(areas[i] > 0 ? static_cast<double>(force.norm()) / areas[i] : 0);
  }
  return pascals;
}

}  // namespace

MeshStreamEncoder::MeshStreamEncoder(const v1::WatchMeshRequest& request)
    : relative_error_(ErrorOf(request)),
      budget_(BudgetOf(request)),
      nodal_forces_(request.nodal_forces()),
      traction_(request.traction()) {}

void MeshStreamEncoder::Encode(const BoundaryShape& shape, v1::MeshState* message) {
  const bool with_topology = shape.elements != elements_;
  ToProto(shape, with_topology, message);
  if (!nodal_forces_) message->clear_nodal_forces();
  if (with_topology) {
    elements_ = shape.elements;
    rest_ = shape.rest;
    areas_ = AreasOf(shape);
    encoder_.Restart(rest_.size() / 3, 2 * relative_error_ * DiagonalOf(rest_));
  }
  const std::size_t taken = traction_ ? EncodeTraction(shape, message) : 0;
  if (relative_error_ > 0 && encoder_.unit() > 0) Shorten(shape, budget_ - taken, message);
}

std::size_t MeshStreamEncoder::EncodeTraction(const BoundaryShape& shape,
                                              v1::MeshState* message) const {
  const NodeTraction traction = Quantised(TractionOf(shape, areas_), budget_ / 2);
  if (traction.steps.size() != shape.rest.size() / 3 || traction.steps.empty()) return 0;
  message->mutable_traction()->set_unit(traction.unit);
  message->mutable_traction()->set_steps(Packed(traction));
  return message->traction().steps().size();
}

// What cannot be sent as moves is sent as numbers.
void MeshStreamEncoder::Shorten(const BoundaryShape& shape, std::size_t budget,
                                v1::MeshState* message) {
  auto code = encoder_.Encode(rest_, shape.positions, budget);
  if (!code) return;
  message->clear_positions();
  v1::ShapeMoves* moves = message->mutable_moves();
  moves->set_unit(encoder_.unit());
  moves->set_exponent(static_cast<std::uint32_t>(code->exponent));
  moves->set_moves(std::move(code->moves));
  moves->set_error(encoder_.error());
}

}  // namespace palpate
