// How many solutions one sample may cost.
#include <algorithm>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "slave/contact/surface_contact.h"
#include "slave/pipeline/load/triangle_search.h"
#include "slave/pipeline/load/volume_limits.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

class CountingModel final : public DeformationModel {
 public:
  explicit CountingModel(std::size_t dof) { info_.dof = dof; }
  int solutions = 0;

 protected:
  void ComputeResponses(std::span<const Contact> /*contacts*/,
                        std::span<ContactResponse> responses) noexcept override {
    ++solutions;
    for (ContactResponse& response : responses) response.validity = Validity::kValid;
  }
  void ComputeDisplacements(std::vector<Vector3d>* u_O) override {
    u_O->assign(4, Vector3d::Zero());
  }
};

// A body so large that a sample has time for two points: the others follow, and none is solved
// twice.
TEST(PointGreensTest, NewPointsOfALargeBodyAreSpreadOverSamples) {
  constexpr std::size_t kPoints = 7;
  SurfaceMesh surface;
  surface.nodes = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  const SurfaceContact contact(surface);
  std::vector<Vector3d> rest;
  for (std::size_t i = 0; i < kPoints; ++i) rest.emplace_back(0.1 * static_cast<double>(i), 0.1, 0);
  CountingModel model(static_cast<std::size_t>(VolumeLimits::kWork / 6));
  PointGreens greens(surface, 1, 0.01);
  const auto known = [&] {
    int count = 0;
    for (std::size_t i = 0; i < kPoints; ++i) count += greens.Knows(i) ? 1 : 0;
    return count;
  };
  for (const int expected : {2, 4, 6, 7, 7}) {
    greens.Update(model, contact, rest);
    EXPECT_EQ(known(), expected);
    EXPECT_EQ(model.solutions, 3 * expected);
  }
}

}  // namespace
}  // namespace palpate
