#include "slave/service/observers/mesh_teller.h"

#include <chrono>
#include <stdexcept>

#include <Eigen/Core>

#include "shared/text/text.h"
#include "slave/service/messages.h"

namespace palpate {
namespace {

constexpr double kLeastError = 1e-6, kMostError = 0.1;  // of the diagonal
constexpr double kBytesPerSecond = 600'000;             // 4.8 Mbit/s: the rest is gRPC's

double ErrorOf(const v1::WatchMeshRequest& request) {
  const double error = request.relative_error();
  if (error == 0 || (error >= kLeastError && error <= kMostError)) return error;  // nor NaN
  throw std::invalid_argument(
      Formatted("relative_error = %g: accepted is 0, or %g to %g", error, kLeastError, kMostError));
}

std::size_t BudgetOf(const v1::WatchMeshRequest& request) {
  return static_cast<std::size_t>(kBytesPerSecond *
                                  std::chrono::duration<double>(GapOf(request)).count());
}

// Of the box around `places`, x, y, z each [m].
double DiagonalOf(const std::vector<float>& places) {
  if (places.empty()) return 0;
  const Eigen::Map<const Eigen::Matrix3Xf> p(places.data(), 3,
                                             static_cast<Eigen::Index>(places.size() / 3));
  return (p.rowwise().maxCoeff() - p.rowwise().minCoeff()).cast<double>().norm();
}

}  // namespace

MeshTeller::MeshTeller(const v1::WatchMeshRequest& request)
    : relative_error_(ErrorOf(request)), budget_(BudgetOf(request)) {}

void MeshTeller::Tell(const BoundaryShape& shape, v1::MeshState* message) {
  const bool with_topology = shape.elements != elements_;
  ToProto(shape, with_topology, message);
  if (with_topology) {
    elements_ = shape.elements;
    rest_ = shape.rest;
    encoder_.Restart(rest_.size() / 3, 2 * relative_error_ * DiagonalOf(rest_));
  }
  if (relative_error_ > 0 && encoder_.unit() > 0) Shorten(shape, message);
}

// What cannot be told in moves stays told in numbers.
void MeshTeller::Shorten(const BoundaryShape& shape, v1::MeshState* message) {
  auto code = encoder_.Encode(rest_, shape.positions, budget_);
  if (!code) return;
  message->clear_positions();
  v1::ShapeMoves* moves = message->mutable_moves();
  moves->set_unit(encoder_.unit());
  moves->set_exponent(static_cast<std::uint32_t>(code->exponent));
  moves->set_moves(std::move(code->moves));
  moves->set_error(encoder_.error());
}

}  // namespace palpate
