// One tool pressed against an air-filled membrane: its place and force from the deflection of all
// points that are seen, by least squares through the membrane's model.
//
// What is measured is y = n . (p - p_rest), the way of each point along the surface's normal. What
// explains it is an even pressure on a round patch (force F, inward) and the rise dp of the air's
// pressure behind the whole membrane:
//
//   y = (F g + dp b) / s
//
// g, b: deflections by a unit force and a unit pressure at the model's own stiffness; s: how many
// times stiffer the membrane really is, the one number that a known load identifies. The patch lies
// where both shapes together explain most; the force is then
//
//   F = s F_own + A dp,   F_own = <g, y> / <g, g>,   A = -<g, b> / <g, g>
//
// with dp measured. Without such a measurement the model's own air resists, and A = 0.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/membrane/inflated_membrane.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// What a unit force, spread evenly over a round patch, does to a membrane.
//
// Deflections are along the nodes' outward normals [m]; the force is one newton inward. Patches are
// centred at nodes; between them they are mixed by barycentric weights.
class PatchCompliance {
 public:
  // `diameter` of the patch [m]. `steady_air`: the pressure does not answer. O(nodes^2).
  PatchCompliance(const InflatedMembrane& membrane, double diameter, bool steady_air);

  // nodes x nodes [m/N]: column j by a patch at node j, zero at held nodes.
  [[nodiscard]] const Eigen::MatrixXd& by_patch() const { return by_patch_; }
  // By one pascal behind the whole membrane [m/Pa].
  [[nodiscard]] const Eigen::VectorXd& by_pressure() const { return by_pressure_; }
  // The newton of a patch at `node`, shared out over the nodes under it; sums to one.
  struct Share {
    int node = 0;
    double share = 0;
  };
  [[nodiscard]] const std::vector<Share>& shares(int node) const {
    return shares_[static_cast<std::size_t>(node)];
  }
  // Mean way inward of a patch there under its own newton [m/N]; `triangle` names the nodes.
  [[nodiscard]] double GiveAt(const std::array<int, 3>& triangle,
                              const Eigen::Vector3d& weights) const noexcept;

 private:
  std::vector<std::vector<Share>> shares_;
  Eigen::MatrixXd by_patch_;
  Eigen::VectorXd by_pressure_;
};

class MembranePress {
 public:
  struct Params {
    bool pressure_is_measured = true;
    double patch = 0.014;         // diameter of the load [m]
    double model_error = 0.1e-3;  // of a point's way, beside its own sigma [m]
  };
  struct Reading {
    bool found = false;            // enough points for an estimate
    int points = 0;                // that took part
    Eigen::Vector3d p_O{0, 0, 0};  // the patch's centre, at rest [m]
    Eigen::Vector3d n_O{0, 0, 1};  // outward normal there
    double own_force = 0;          // F_own [N]; it or F positive: presses
    double air_area = 0;           // A [m^2]
    // The two amplitudes that together explain most, at the model's own stiffness.
    double explained_force = 0;    // [N]
    double own_pressure = 0;       // [Pa]
    double depth = 0;              // of the surface as it is explained there, along -n_O [m]
    double sigma_own_force = 0;    // [N]
    double sigma_place = 0;        // the larger of the two along the surface [m]
    double deflection = 0;         // rms of the measurements y [m]
    double residual = 0;           // rms of (measured - explained) [m]
    double relative_residual = 0;  // the same in sigmas, with the model's own error [-]
    // Size of the force of the tool on the membrane, along -n_O [N].
    [[nodiscard]] double Force(double stiffness, double pressure_rise) const {
      return stiffness * own_force + air_area * pressure_rise;
    }
  };
  // Precomputes the membrane's compliance: O(nodes^2). Throws std::invalid_argument naming the
  // parameter.
  MembranePress(InflatedMembrane membrane, const Params& params);

  // Points in frame O. Points that lie farther from the surface at rest than half a triangle are
  // left out. Never throws. Points with other names or rest places than in the last call are placed
  // again, O(points nodes) with allocation; else O(points nodes) without. Valid until the next
  // call.
  const Reading& Fit(const std::vector<SurfacePoint>& points_O) noexcept;
  [[nodiscard]] const Reading& reading() const { return reading_; }

  [[nodiscard]] const InflatedMembrane& membrane() const { return membrane_; }
  [[nodiscard]] const PatchCompliance& compliance() const { return compliance_; }
  // Where the reading's patch lies, on the membrane's surface.
  [[nodiscard]] const SurfacePlace& place() const { return place_; }

 private:
  struct Sums {  // of products over the points, weighted
    double gg = 0, gy = 0, gb = 0;
  };
  struct Amplitudes {
    double force = 0, pressure = 0;
    double misfit = 0;  // sum of squares, in sigmas
  };
  [[nodiscard]] bool IsAttached(const std::vector<SurfacePoint>& points_O) const noexcept;
  void Attach(const std::vector<SurfacePoint>& points_O);
  int Measure(const std::vector<SurfacePoint>& points_O) noexcept;
  [[nodiscard]] Sums SumsOf(const Eigen::Ref<const Eigen::VectorXd>& g) const noexcept;
  [[nodiscard]] Amplitudes Explaining(const Sums& sums) const noexcept;
  int BestNode() noexcept;
  Eigen::Vector3d Between(int node) noexcept;
  void ReadAt() noexcept;

  InflatedMembrane membrane_;
  Params params_;
  PatchCompliance compliance_;
  std::vector<std::vector<int>> neighbours_;  // of nodes, by an edge

  // Attached points: where they are and what the patch of every node does to them.
  std::vector<int> ids_;
  std::vector<Eigen::Vector3d> rest_;
  std::vector<std::size_t> taking_part_;
  std::vector<Eigen::Vector3d> normals_;  // of the surface there
  Eigen::MatrixXd g_;                     // points x nodes
  Eigen::VectorXd b_;

  // Of the current points: ways along the normals, and weights.
  Eigen::VectorXd y_, w_, g_here_;
  double yy_ = 0, yb_ = 0, bb_ = 0;
  std::vector<double> misfits_;  // of nodes
  SurfacePlace place_;
  Reading reading_;
};

}  // namespace palpate
