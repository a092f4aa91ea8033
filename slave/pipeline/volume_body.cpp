#include "slave/pipeline/volume_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "shared/mesh/surface_patch.h"
#include "slave/contact/surface_contact.h"
#include "slave/mechanics/make_model.h"
#include "slave/pipeline/nodal_load.h"
#include "slave/pipeline/node_displacement.h"
#include "slave/pipeline/point_greens.h"
#include "slave/pipeline/touch_stiffness.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLinearLoad = 1e-6;  // of E times the larger side squared
constexpr double kLeastWidth = 1e-3;  // of the larger side
constexpr int kBestNodes = 6;         // whose triangles are looked at closely
constexpr double kStandsOut = 25;     // misfit that the load must explain: five sigma squared
constexpr double kGoodFit = 3;        // residual
constexpr double kTrusted = 0.7, kLeastResidual = 0.1;  // as in LoadFitter
constexpr int kRounds = 4;                              // of leaving points out
constexpr double kOutlier = 5;                          // standard deviations of the scatter
constexpr double kLeastScatter = 0.25;                  // of the stated sigmas
constexpr double kMostLeftOut = 0.25;                   // share
constexpr int kLeastPoints = 4;
constexpr int kRefinements = 5;  // of the load through a model that is not linear
constexpr double kRefined = 1e-4;

std::size_t At(int i) {
  return static_cast<std::size_t>(i);
}

double LargerSide(const SurfaceMesh& surface) {
  Vector3d lower = surface.nodes.front(), upper = lower;
  for (const Vector3d& p : surface.nodes) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  return (upper - lower).maxCoeff();
}

bool IsLinear(const Scene& scene) {
  const std::string kind = ChooseModel(scene).kind;
  return kind == "fem-green" || kind == "bem3d" ||
         (kind == "fem" && scene.model.fem.law == FemOptions::Law::kLinear);
}

class VolumeBody final : public SurfaceBody {
 public:
  VolumeBody(const Scene& scene, double width, const ObjectMesh& mesh, SurfaceMesh surface)
      : surface_(std::move(surface)),
        model_(MakeModel(scene, mesh)),
        contact_(surface_),
        stiffness_(scene, surface_, std::get_if<SolidMesh>(&mesh)),
        larger_side_(LargerSide(surface_)),
        width_(std::max(width, kLeastWidth * larger_side_)),
        linear_(IsLinear(scene)),
        greens_(surface_,
                kLinearLoad * scene.object.material.young_modulus * larger_side_ * larger_side_,
                width_) {
    normals_.reserve(surface_.triangles.size());
    around_.resize(surface_.nodes.size());
    for (int t = 0; t < static_cast<int>(surface_.triangles.size()); ++t) {
      normals_.push_back(Normal(surface_, t));
      for (const int node : surface_.triangles[At(t)]) around_[At(node)].push_back(t);
    }
    node_normals_.resize(surface_.nodes.size(), Vector3d::Zero());
    for (std::size_t i = 0; i < around_.size(); ++i) {
      for (const int t : around_[i]) node_normals_[i] += Area(surface_, t) * normals_[At(t)];
      if (!around_[i].empty()) node_normals_[i].normalize();
    }
  }

  SurfaceLoad Fit(const std::vector<SurfacePoint>& points_O) noexcept override;
  Press PressAt(const Vector3d& p_O, double depth) noexcept override;
  void Nearest(const Vector3d& p_O_tip, Vector3d* p_O, Vector3d* n_O) const noexcept override;
  [[nodiscard]] const SurfaceMesh& surface() const override { return surface_; }
  void Displacements(std::vector<Vector3d>* u_O) override;
  void NodalForces(std::vector<Vector3d>* f_O) override {
    SpreadLoad(surface_, load_.p_O, load_.n_O, width_, load_.force * load_.n_O, f_O);
  }
  void Reset() override {
    model_->Reset();
    load_ = {};
  }
  [[nodiscard]] const ModelInfo& info() const override { return model_->info(); }

 private:
  struct Best {  // three nodal forces along the normal of a triangle
    int triangle = -1;
    Vector3d forces{0, 0, 0};  // [N]
    Matrix3d covariance = Matrix3d::Zero();
    double explained = -1;
  };
  SurfaceLoad TryFit(const std::vector<SurfacePoint>& points_O);
  void Read(const std::vector<SurfacePoint>& points_O);
  void Weigh() noexcept;
  Best Search() noexcept;
  void SolveTriangle(int triangle, Best* best) noexcept;
  bool LeaveOut(const Best& best) noexcept;
  void Place(const Best& best, SurfaceLoad* load);
  void Refine(Best* best, SurfaceLoad* load) noexcept;
  [[nodiscard]] Vector3d LinearDisplacement(const Best& best, std::size_t point) const noexcept;
  void Judge(const Best& best, SurfaceLoad* load) const noexcept;
  bool Load(const SurfaceLoad& load) noexcept;

  struct Seen {
    Vector3d moved{0, 0, 0};               // [m]
    Vector3d beyond{0, 0, 0};              // the model's share beyond the linear one [m]
    Matrix3d whitener = Matrix3d::Zero();  // inverse of the covariance's Cholesky factor
    double residual = 0;                   // by sigma
    bool usable = false, kept = false;
  };
  SurfaceMesh surface_;
  std::unique_ptr<DeformationModel> model_;
  SurfaceContact contact_;
  TouchStiffness stiffness_;
  double larger_side_, width_;  // [m]
  bool linear_;
  PointGreens greens_;
  std::vector<Vector3d> normals_, node_normals_;
  std::vector<std::vector<int>> around_;  // triangles of each node

  std::vector<Seen> seen_;
  std::vector<Vector3d> rest_, field_;
  std::vector<double> sorted_;
  VectorXd measured_, shape_, score_;  // by sigma
  std::array<VectorXd, 3> corner_;     // shapes of a triangle's nodes, by sigma
  double nothing_ = 0;                 // squares of what was measured
  int usable_ = 0, kept_ = 0;
  bool unsolved_ = false;  // the model found no equilibrium under the load
  SurfaceLoad load_;
};

SurfaceLoad VolumeBody::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  try {
    load_ = TryFit(points_O);
  } catch (const std::exception&) {
    load_ = {};
    load_.why = "out of memory";
  }
  return load_;
}

SurfaceLoad VolumeBody::TryFit(const std::vector<SurfacePoint>& points_O) {
  SurfaceLoad load;
  Read(points_O);
  if (usable_ < kLeastPoints) {
    load.validity = Validity::kTrackingLost;
    load.why = "fewer than four points of the object are in view";
    return load;
  }
  Best best;
  for (int round = 0; round <= kRounds; ++round) {
    Weigh();
    best = Search();
    if (best.triangle < 0 || round == kRounds || !LeaveOut(best)) break;
  }
  if (best.triangle < 0) {
    load.why = "no load explains the points";
    return load;
  }
  Place(best, &load);
  if (!linear_) Refine(&best, &load);
  Judge(best, &load);
  return load;
}

void VolumeBody::Read(const std::vector<SurfacePoint>& points_O) {
  rest_.clear();
  for (const SurfacePoint& point : points_O) rest_.push_back(point.p_S_rest);
  greens_.See(*model_, contact_, rest_);
  seen_.assign(points_O.size(), {});
  usable_ = 0;
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    const SurfacePoint& point = points_O[i];
    const Eigen::LLT<Matrix3d> factor(point.covariance);
    Seen& seen = seen_[i];
    seen.moved = point.p_S - point.p_S_rest;
    seen.whitener = factor.matrixL().solve(Matrix3d::Identity());
    seen.usable = seen.kept = point.seen && greens_.Knows(i) && seen.moved.allFinite() &&
                              factor.info() == Eigen::Success && seen.whitener.allFinite();
    usable_ += seen.usable ? 1 : 0;
  }
  kept_ = usable_;
  unsolved_ = false;
  const auto rows = 3 * static_cast<Index>(points_O.size());
  measured_.resize(rows);
  shape_.resize(rows);
  for (VectorXd& corner : corner_) corner.resize(rows);
  score_.resize(static_cast<Index>(greens_.nodes().size()));
  sorted_.reserve(points_O.size());
}

void VolumeBody::Weigh() noexcept {
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Seen& seen = seen_[i];
    measured_.segment<3>(3 * static_cast<Index>(i)) =
        seen.kept ? Vector3d(seen.whitener * (seen.moved - seen.beyond)) : Vector3d::Zero();
  }
  nothing_ = measured_.squaredNorm();
}

// The nodes whose load along their own normal explains most, then the triangles around them.
VolumeBody::Best VolumeBody::Search() noexcept {
  const auto shape_of = [this](Index column, const Vector3d& n, VectorXd* shape) {
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const Index row = 3 * static_cast<Index>(i);
      Vector3d u = Vector3d::Zero();
      for (int axis = 0; axis < 3; ++axis) {
        u += n[axis] * greens_.by(axis).col(column).segment<3>(row);
      }
      shape->segment<3>(row) = seen_[i].kept ? Vector3d(seen_[i].whitener * u) : Vector3d::Zero();
    }
  };
  for (Index k = 0; k < score_.size(); ++k) {
    const int node = greens_.nodes()[static_cast<std::size_t>(k)];
    shape_of(k, node_normals_[At(node)], &shape_);
    const double mixed = shape_.dot(measured_), square = shape_.squaredNorm();
    score_[k] = square > 0 ? mixed * mixed / square : 0;
  }
  Best best;
  for (int n = 0; n < kBestNodes && n < score_.size(); ++n) {
    Index k = 0;
    if (!(score_.maxCoeff(&k) >= 0)) break;
    score_[k] = -1;
    for (const int t : around_[At(greens_.nodes()[static_cast<std::size_t>(k)])]) {
      for (std::size_t c = 0; c < 3; ++c) {
        const int node = surface_.triangles[At(t)][c];
        shape_of(greens_.IndexOf(node), normals_[At(t)], &corner_[c]);
      }
      SolveTriangle(t, &best);
    }
  }
  return best;
}

// Nodal forces of one sign: of all choices of nodes that take part, the one that explains most.
void VolumeBody::SolveTriangle(int triangle, Best* best) noexcept {
  for (unsigned choice = 1; choice < 8; ++choice) {
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (int a = 0; a < 3; ++a) {
      const bool takes_part = (choice >> a & 1U) != 0;
      normal(a, a) = takes_part ? corner_[At(a)].squaredNorm() : 1;
      right[a] = takes_part ? corner_[At(a)].dot(measured_) : 0;
      for (int b = 0; b < a; ++b) {
        if (!takes_part || (choice >> b & 1U) == 0) continue;
        normal(a, b) = normal(b, a) = corner_[At(a)].dot(corner_[At(b)]);
      }
    }
    const Eigen::LDLT<Matrix3d> factor(normal);
    const Vector3d forces = factor.solve(right);
    const bool one_sign = (forces.array() >= 0).all() || (forces.array() <= 0).all();
    const double explained = forces.dot(right);
    if (!forces.allFinite() || !one_sign || !(explained > best->explained)) continue;
    *best = {triangle, forces, factor.solve(Matrix3d::Identity()), explained};
    for (int a = 0; a < 3; ++a) {
      if ((choice >> a & 1U) == 0) best->covariance(a, a) = 0;
    }
  }
}

bool VolumeBody::LeaveOut(const Best& best) noexcept {
  sorted_.clear();
  double worst = 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    if (!seen_[i].kept) continue;
    const Vector3d misfit = seen_[i].whitener * (seen_[i].moved - LinearDisplacement(best, i));
    seen_[i].residual = misfit.norm() / std::sqrt(3.0);
    worst = std::max(worst, seen_[i].residual);
    sorted_.push_back(seen_[i].residual);
  }
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  const double accepted = std::max(kOutlier * std::max(kLeastScatter, *middle), worst / 2);
  bool left_out = false;
  for (Seen& seen : seen_) {
    if (!seen.kept || seen.residual <= accepted || kept_ <= kLeastPoints) continue;
    seen.kept = false;
    left_out = true;
    --kept_;
  }
  return left_out;
}

void VolumeBody::Place(const Best& best, SurfaceLoad* load) {
  const auto& nodes = surface_.triangles[At(best.triangle)];
  load->force = best.forces.sum();
  load->n_O = normals_[At(best.triangle)];
  load->p_O.setZero();
  for (std::size_t c = 0; c < 3; ++c) {
    load->p_O += best.forces[static_cast<Index>(c)] / load->force * surface_.nodes[At(nodes[c])];
  }
  const double misfit = std::max(0.0, nothing_ - best.explained);
  load->residual = std::sqrt(misfit / std::max(1, 3 * kept_ - 3));
  const double scatter = std::max(1.0, load->residual);
  load->sigma_force = scatter * std::sqrt(best.covariance.sum());
  double place = 0;
  for (const int axis : {0, 1, 2}) {
    Vector3d by;
    for (std::size_t c = 0; c < 3; ++c) {
      by[static_cast<Index>(c)] =
          (surface_.nodes[At(nodes[c])][axis] - load->p_O[axis]) / load->force;
    }
    place = std::max(place, by.dot(best.covariance * by));
  }
  load->sigma_place = scatter * std::sqrt(place);
  const Vector3d weights = best.forces / load->force;
  const Matrix3d K = stiffness_.At(best.triangle, weights, width_ / 2);
  load->depth = -load->force / load->n_O.dot(K * load->n_O);
}

void VolumeBody::Judge(const Best& best, SurfaceLoad* load) const noexcept {
  const double doubt = std::clamp(load->residual / kTrusted, kLeastResidual / kTrusted, 1.0);
  load->validity = Validity::kValid;
  if (best.explained < kStandsOut * doubt * doubt) {
    load->force = load->depth = load->sigma_place = 0;
    return;
  }
  const double range = model_->info().range;
  const auto flag = [load](std::string_view why) {
    load->validity = Validity::kExtrapolated;
    load->why = why;
  };
  if (range > 0 && std::abs(load->depth) > range * larger_side_) {
    flag("the deflection is beyond the model's range");
  }
  if (unsolved_) flag("the model finds no equilibrium under this load: it is that of small strain");
  if (load->residual > kGoodFit) {
    flag("one load of this width leaves more than the points' noise");
  }
  if (usable_ - kept_ > kMostLeftOut * usable_) {
    flag("more than a quarter of the points contradict the others");
  }
}

// Newton's method with the tangent at rest: what the model makes of the load beyond its linear part
// is taken off the measured displacements, and the load fitted anew.
void VolumeBody::Refine(Best* best, SurfaceLoad* load) noexcept {
  for (int iteration = 0; iteration < kRefinements && load->force != 0; ++iteration) {
    if (!Load(*load)) {
      unsolved_ = true;
      break;
    }
    for (std::size_t i = 0; i < seen_.size(); ++i) {
      const auto place = contact_.Find(rest_[i], std::numeric_limits<double>::infinity());
      if (!seen_[i].kept || !place) continue;
      Vector3d u = Vector3d::Zero();
      for (std::size_t c = 0; c < 3; ++c) {
        u += place->weights[static_cast<Index>(c)] *
             field_[At(surface_.triangles[At(place->triangle)][c])];
      }
      seen_[i].beyond = u - LinearDisplacement(*best, i);
    }
    const double last = load->force;
    Weigh();
    *best = Search();
    if (best->triangle < 0) return;
    Place(*best, load);
    if (std::abs(load->force - last) < kRefined * std::abs(last)) break;
  }
}

Vector3d VolumeBody::LinearDisplacement(const Best& best, std::size_t point) const noexcept {
  Vector3d u = Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c) {
    const Index column = greens_.IndexOf(surface_.triangles[At(best.triangle)][c]);
    const Vector3d f = best.forces[static_cast<Index>(c)] * normals_[At(best.triangle)];
    for (int axis = 0; axis < 3; ++axis) {
      u += f[axis] * greens_.by(axis).col(column).segment<3>(3 * static_cast<Index>(point));
    }
  }
  return u;
}

bool VolumeBody::Load(const SurfaceLoad& load) noexcept {
  const Contact contact{.kind = Contact::Kind::kForce,
                        .p_O = load.p_O,
                        .width = width_,
                        .value_O = load.force * load.n_O};
  ContactResponse response;
  model_->Respond(std::span(&contact, 1), std::span(&response, 1));
  if (response.validity == Validity::kFailed) return false;
  try {
    NodeDisplacement(*model_, surface_, &field_);
  } catch (const std::exception&) {
    return false;
  }
  return true;
}

SurfaceBody::Press VolumeBody::PressAt(const Vector3d& p_O, double depth) noexcept {
  const auto place = contact_.Find(p_O, std::numeric_limits<double>::infinity());
  if (!place || !std::isfinite(depth)) return {};
  Press press;
  try {
    const Matrix3d K = stiffness_.At(place->triangle, place->weights, width_ / 2);
    press.stiffness = place->n_O.dot(K * place->n_O);
  } catch (const std::exception&) {
    return {};
  }
  press.force = press.stiffness * std::max(0.0, depth);
  const double range = model_->info().range;
  press.valid = !(range > 0) || depth <= range * larger_side_;
  return press;
}

void VolumeBody::Nearest(const Vector3d& p_O_tip, Vector3d* p_O, Vector3d* n_O) const noexcept {
  const auto place = contact_.Find(p_O_tip, std::numeric_limits<double>::infinity());
  *p_O = place ? place->p_O : surface_.nodes.front();
  *n_O = place ? place->n_O : Vector3d::UnitZ();
}

void VolumeBody::Displacements(std::vector<Vector3d>* u_O) {
  if (load_.force != 0 && Load(load_)) {
    *u_O = field_;
  } else {
    u_O->assign(surface_.nodes.size(), Vector3d::Zero());
  }
}

}  // namespace

std::unique_ptr<SurfaceBody> MakeVolumeBody(const Scene& scene, double width) {
  if (!IsVolume(scene.object.geometry)) {
    throw std::invalid_argument(
        "object.geometry: accepted under two eyes or a depth camera is a membrane or a volume: "
        "box or mesh");
  }
  if (MovesInTime(scene)) {
    throw std::invalid_argument(
        "model.time = dynamic: accepted for points seen by the eyes is static");
  }
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  SurfaceMesh surface = solid != nullptr ? SurfaceOf(*solid) : std::get<SurfaceMesh>(mesh);
  return std::make_unique<VolumeBody>(scene, width, mesh, std::move(surface));
}

}  // namespace palpate
