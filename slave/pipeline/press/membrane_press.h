// Position and force of one tool on an air-filled membrane, by least squares over the deflections
// of all visible points along the surface's normal:
//
//   y_i = n_i . (p_i - p_i_rest) = F g_i(patch) + noise
//
// g: deflection by one newton of uniform pressure on a round patch, with the response of the
// enclosed air. The patch position minimises the sum of squared residuals. Frame O.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/membrane/inflated_membrane.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Response of a membrane to a unit force, spread evenly over a round patch.
//
// Deflections are along the nodes' outward normals [m]; the force is one newton inward. Patches are
// centred at nodes; between them they are interpolated by barycentric weights.
class PatchCompliance {
 public:
  // `diameter` of the patch [m]. O(nodes^2).
  PatchCompliance(const InflatedMembrane& membrane, double diameter);

  // nodes x nodes [m/N]: column j by a patch at node j, zero at fixed nodes.
  [[nodiscard]] const Eigen::MatrixXd& by_patch() const { return by_patch_; }
  // A unit force (1 N) on the patch at `node`, distributed to the nodes under it.
  struct Share {
    int node = 0;
    double share = 0;
  };
  [[nodiscard]] const std::vector<Share>& shares(int node) const {
    return shares_[static_cast<std::size_t>(node)];
  }
  // Returns the mean inward displacement of a patch there under a force of 1 N [m/N]; `triangle`:
  // its nodes.
  [[nodiscard]] double At(const std::array<int, 3>& triangle,
                          const Eigen::Vector3d& weights) const noexcept;

 private:
  std::vector<std::vector<Share>> shares_;
  Eigen::MatrixXd by_patch_;
};

class MembranePress {
 public:
  struct Params {
    double patch = 0.014;         // diameter of the load [m], > 0
    double model_error = 0.1e-3;  // of a point's deflection, in addition to its own sigma [m], > 0
  };
  struct Estimate {
    bool found = false;            // enough points for an estimate
    Eigen::Vector3d p_O{0, 0, 0};  // centre of the patch, at rest [m]
    Eigen::Vector3d n_O{0, 0, 1};  // outward normal there
    double force = 0;              // inward [N]
    double depth = 0;              // of the surface under the patch, along -n_O, >= 0 [m]
    double sigma_force = 0;        // [N]
    double sigma_place = 0;        // the larger of the two along the surface [m]
    double sigma = 0;              // of a point's deflection, with the model error [m]
    double residual = 0;           // rms of (measured - fitted) / sigma [-]
  };
  // Precomputes the membrane's compliance: O(nodes^2). Throws std::invalid_argument naming the
  // parameter.
  MembranePress(InflatedMembrane membrane, const Params& params);

  // Points in frame O. Points farther from the surface at rest than half a triangle are excluded.
  // Never throws. Points with other ids or rest positions than in the last call are located again,
  // O(points nodes) with allocation; otherwise O(points nodes) without. Valid until the next call.
  const Estimate& Fit(const std::vector<SurfacePoint>& points_O) noexcept;

  [[nodiscard]] const InflatedMembrane& membrane() const { return membrane_; }
  [[nodiscard]] const PatchCompliance& compliance() const { return compliance_; }
  // Location of the estimated patch on the membrane's surface.
  [[nodiscard]] const SurfacePlace& place() const { return place_; }

 private:
  [[nodiscard]] bool IsAttached(const std::vector<SurfacePoint>& points_O) const noexcept;
  void Attach(const std::vector<SurfacePoint>& points_O);
  int Measure(const std::vector<SurfacePoint>& points_O) noexcept;
  [[nodiscard]] double Explained(const Eigen::Ref<const Eigen::VectorXd>& g) const noexcept;
  int BestNode() noexcept;
  Eigen::Vector3d Interpolate(int node) noexcept;
  void FillEstimate(int points) noexcept;

  InflatedMembrane membrane_;
  Params params_;
  PatchCompliance compliance_;
  std::vector<std::vector<int>> neighbours_;  // of nodes, by an edge

  // Attached points.
  std::vector<int> ids_;
  std::vector<Eigen::Vector3d> rest_;
  std::vector<std::size_t> used_;         // indices of those on the surface
  std::vector<Eigen::Vector3d> normals_;  // of the surface there
  Eigen::MatrixXd g_;                     // points x nodes [m/N]

  Eigen::VectorXd y_, w_, g_here_;  // deflections [m], weights [1/m^2], fitted shape [m/N]
  std::vector<double> explained_;   // sum of squares by a patch at each node [sigma^2]
  SurfacePlace place_;
  Estimate estimate_;
};

}  // namespace palpate
