#include "slave/pipeline/camera/object_registration_monitor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr double kOffOutline = 2;     // distance from the mesh of a point that is not on it [px]
constexpr double kEdgeSigma = 0.1;    // sigma of one edge position in a sharp image [px]
constexpr double kModelSigma = 0.06;  // sigma of a computed displacement, relative [-]
// Additional sigma at the contact, which decreases over one element [-].
constexpr double kBesidePatch = 0.25;
constexpr int kReach = 5;  // search distance along the normal [px]
// Additional search distance, relative to the indentation there [-].
constexpr double kIndentationReach = 0.6;
constexpr double kBesideTool = 4;    // margin of the occlusion beside the tool [px]
constexpr double kBeforeTip = 6;     // margin beyond its end [px]
constexpr double kBorder = 12;       // margin of the image that is too narrow for a search [px]
constexpr int kRounds = 12;          // iterations of the fit, at most [-]
constexpr double kAgrees = 4;        // gate of one edge position [sigma]
constexpr double kMaxError = 0.8;    // error that lens or shutter may cause [px]
constexpr double kMaxDisturbed = 4;  // factor by which a disturbed image widens the gate [-]
// Smallest fraction of the visible positions that must agree [-].
constexpr double kMinAgreeing = 0.5;
constexpr int kMinPlaces = 12;             // positions of a fit [-]
constexpr double kKnown = 0.4;             // sigma above which the motion is unknown [px]
constexpr double kIndentationKnown = 1.0;  // the same of the indentation [px]
// Motion that is not compensated [px]. [tuned: MotionThatIsNotCompensatedIsInSigma]
constexpr double kMinMotion = 0.2;
constexpr double kLookAgain = 1.5;  // correction after which the edge is searched again [px]
// Prior sigmas [px]. The shift is free. Rotation and growth are small; a disc or half an outline
// does not determine them.
constexpr double kAnyShift = 100, kTurn = 0.15, kGrowth = 0.7, kAnyIndentation = 6;

// Returns whether the tool hides `p`. If its direction is unknown: whether `p` is near its tip.
bool Hides(const ObjectRegistrationMonitor::Bar& tool, const Eigen::Vector2d& p) {
  const Eigen::Vector2d from_tip = p - tool.p_I_tip;
  if (tool.d_I.isZero(0)) return from_tip.norm() < tool.width + kBesideTool;
  const double aside = std::abs(from_tip.x() * tool.d_I.y() - from_tip.y() * tool.d_I.x());
  return aside < 0.5 * tool.width + kBesideTool && from_tip.dot(tool.d_I) < kBeforeTip;
}

// Returns the square of a motion measured as `moved` with covariance C, minus the part of the
// noise.
Eigen::Matrix2d StandingOut(const Eigen::Vector2d& moved, const Eigen::Matrix2d& C) {
  const double square = moved.dot(C.inverse() * moved);
  const double share = square > 2 ? 1 - 2 / square : 0;
  return share * moved * moved.transpose();
}

}  // namespace

ObjectRegistrationMonitor::ObjectRegistrationMonitor(const cv::Mat& first, CurveView rest_I,
                                                     const CameraView& view,
                                                     const Eigen::Isometry3d& X_SO,
                                                     const BoundaryMesh& mesh)
    : view_(view), X_SO_(X_SO), edge_(first, GreyFormat(first), rest_I) {
  const auto& places = edge_.places();
  for (const RestEdge::Place& place : places) {
    centre_ += place.p_I / static_cast<double>(places.size());
  }
  for (const RestEdge::Place& place : places) {
    size_ = std::max(size_, (place.p_I - centre_).norm());
  }
  const Eigen::Vector3d origin = X_SO.translation();
  const double unit = view.pixel();
  for (int axis : {0, 1}) {
    to_image_.col(axis) =
        view.ToImage(origin + unit * X_SO.linear().col(axis)) - view.ToImage(origin);
  }
  anchors_.resize(places.size());
  sights_.reserve(places.size());
  sorted_.reserve(places.size());
  Adopt(mesh);
  Reset();
}

void ObjectRegistrationMonitor::Reset() noexcept {
  match_ = {};
  match_.sighting.motion = MotionOf(match_.x);
}

void ObjectRegistrationMonitor::Adopt(const BoundaryMesh& mesh) {
  has_indentation_ = false;
  const Eigen::Isometry3d X_OS = X_SO_.inverse();
  for (std::size_t k = 0; k < anchors_.size(); ++k) {
    const Eigen::Vector2d p = (X_OS * view_.ToSlave(edge_.places()[k].p_I)).head<2>();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < mesh.elements.size(); ++i) {
      const Eigen::Vector2d side = mesh.elements[i].b - mesh.elements[i].a;
      const double s =
          std::clamp((p - mesh.elements[i].a).dot(side) / side.squaredNorm(), 0.0, 1.0);
      const double away = (p - mesh.elements[i].a - s * side).norm();
      if (away < nearest) nearest = away, anchors_[k].from = i, anchors_[k].s = s;
    }
    anchors_[k].to = static_cast<std::size_t>(mesh.Next(static_cast<int>(anchors_[k].from)));
    anchors_[k].on_outline = nearest <= kOffOutline * view_.pixel();
  }
}

void ObjectRegistrationMonitor::SetIndentation(const std::vector<Eigen::Vector3d>& along_x,
                                               const std::vector<Eigen::Vector3d>& along_y,
                                               const Patch& patch) noexcept {
  has_indentation_ = true;
  for (std::size_t k = 0; k < anchors_.size(); ++k) {
    Anchor& anchor = anchors_[k];
    const double beside = (edge_.places()[k].p_I - patch.p_I).norm() - 0.5 * patch.width;
    anchor.indentation_sigma =
        kModelSigma + kBesidePatch * std::exp(-std::max(beside, 0.0) / patch.element);
    const auto at = [&](const std::vector<Eigen::Vector3d>& u) -> Eigen::Vector2d {
      return ((1 - anchor.s) * u[anchor.from] + anchor.s * u[anchor.to]).head<2>();
    };
    Eigen::Matrix2d u_O;
    u_O << at(along_x), at(along_y);
    anchor.indentation_I = to_image_ * u_O;
  }
}

ImageMotion ObjectRegistrationMonitor::MotionOf(const Vector& x) const noexcept {
  return {centre_, x.head<2>(), x(2) / size_, x(3) / size_};
}

Curve ObjectRegistrationMonitor::Edge() const {
  Curve edge;
  if (!match_.sighting.known) return edge;
  const ImageMotion motion = MotionOf(match_.x);
  for (std::size_t k = 0; k < anchors_.size(); ++k) {
    if (!anchors_[k].on_outline) continue;
    edge.push_back(
        motion.Apply(edge_.places()[k].p_I + anchors_[k].indentation_I * match_.x.tail<2>()));
  }
  return edge;
}

// Searches every edge position where `x` predicts it.
void ObjectRegistrationMonitor::Gather(const cv::Mat& image, const Bar& tool,
                                       const Vector& x) noexcept {
  const ImageMotion motion = MotionOf(x);
  const Eigen::Matrix2d linear = motion.linear();
  sights_.clear();
  found_.sighting.places = 0;
  for (std::size_t k = 0; k < anchors_.size(); ++k) {
    if (!anchors_[k].on_outline) continue;
    const RestEdge::Place& place = edge_.places()[k];
    const Eigen::Vector2d arm = linear * (place.p_I - centre_);
    const Eigen::Vector2d indentation = anchors_[k].indentation_I * x.tail<2>();
    const Eigen::Vector2d p = centre_ + motion.shift + arm + linear * indentation;
    const bool in_image = p.minCoeff() > kBorder && p.x() < image.cols - 1 - kBorder &&
                          p.y() < image.rows - 1 - kBorder;
    if (!in_image || Hides(tool, p)) continue;
    ++found_.sighting.places;
    const Eigen::Vector2d n = (linear * place.n_I).normalized();
    const int reach =
        std::min(RestEdge::kMaxReach,
                 kReach + static_cast<int>(kIndentationReach * std::abs(n.dot(indentation))));
    const auto offset = edge_.Locate(image, place, p, n, reach);
    if (!offset) continue;
    Sight sight{k,
                *offset,
                std::abs(n.x()) > std::abs(n.y()),
                edge_.sharpness(),
                edge_.exposure(),
                std::hypot(kEdgeSigma, anchors_[k].indentation_sigma * indentation.norm()),
                Vector::Zero()};
    sight.J.head<2>() = n;
    sight.J(2) = (arm.x() * n.y() - arm.y() * n.x()) / size_;
    sight.J(3) = arm.dot(n) / size_;
    if (has_indentation_) sight.J.tail<2>() = (linear * anchors_[k].indentation_I).transpose() * n;
    sights_.push_back(sight);
  }
}

// Fits the offsets gathered at `x` by iteratively reweighted least squares and corrects `x`.
// Returns false if too few places agree.
bool ObjectRegistrationMonitor::Fit(Vector& x) noexcept {
  if (static_cast<int>(sights_.size()) < kMinPlaces) return false;
  Vector hold;  // 1 / sigma^2
  hold << 1 / (kAnyShift * kAnyShift), 1 / (kAnyShift * kAnyShift), 1 / (kTurn * kTurn),
      1 / (kGrowth * kGrowth), 1 / (kAnyIndentation * kAnyIndentation),
      1 / (kAnyIndentation * kAnyIndentation);
  Vector move = Vector::Zero();
  double scale = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    sorted_.clear();
    for (const Sight& sight : sights_) {
      sorted_.push_back(std::abs(sight.offset - sight.J.dot(move)) / sight.sigma);
    }
    scale = std::max(SigmaOfSizes(sorted_), 1.0);
    Matrix A = hold.asDiagonal();
    Vector b = hold.cwiseProduct(prior_ - x);
    for (const Sight& sight : sights_) {
      const double u = (sight.offset - sight.J.dot(move)) / (kBiweightCut * scale * sight.sigma);
      if (std::abs(u) >= 1) continue;
      const double weight = Biweight(u) / (scale * scale * sight.sigma * sight.sigma);
      A += weight * sight.J * sight.J.transpose();
      b += weight * sight.offset * sight.J;
    }
    const Eigen::LLT<Matrix> solver(A);
    const Vector next = solver.solve(b);
    const double change = (next - move).cwiseAbs().maxCoeff();
    move = next;
    if (change < 1e-3 || round + 1 == kRounds) {
      covariance_ = solver.solve(Matrix::Identity());
      break;
    }
  }
  Compare(move, scale);
  x += move;
  const ObjectSighting& found = found_.sighting;
  return x.allFinite() &&
         found.agreeing >= std::max<double>(kMinPlaces, kMinAgreeing * found.places);
}

// Counts the positions that agree with the fit, and the longest run that deviates to one side.
void ObjectRegistrationMonitor::Compare(const Vector& move, double scale) noexcept {
  ObjectSighting& found = found_.sighting;
  found.agreeing = found.apart = 0;
  double square = 0, side = 0;
  int row = 0;
  std::size_t last = 0;
  for (const Sight& sight : sights_) {
    const double error = sight.offset - sight.J.dot(move);
    const bool agrees = std::abs(error) <= kAgrees * std::min(scale, kMaxDisturbed) * sight.sigma;
    if (agrees) ++found.agreeing, square += error * error;
    const bool is_apart = !agrees && std::abs(error) > kMaxError;
    const bool goes_on = is_apart && row > 0 && sight.place == last + 1 && error * side > 0;
    row = !is_apart ? 0 : goes_on ? row + 1 : 1;
    found.apart = std::max(found.apart, row);
    last = sight.place, side = error;
  }
  found.residual_px = found.agreeing > 0 ? std::sqrt(square / found.agreeing) : 0;
}

double ObjectRegistrationMonitor::SharpnessAlong(bool along_x) noexcept {
  sorted_.clear();
  for (const Sight& sight : sights_) {
    if (sight.along_x == along_x) sorted_.push_back(sight.sharpness);
  }
  if (sorted_.size() < kMinPlaces) return 1;
  return MedianOf(sorted_);
}

double ObjectRegistrationMonitor::Exposure() noexcept {
  sorted_.clear();
  for (const Sight& sight : sights_) sorted_.push_back(sight.exposure);
  return MedianOf(sorted_);
}

bool ObjectRegistrationMonitor::FitFrom(const cv::Mat& image, const Bar& tool, Vector& x) noexcept {
  const Vector before = x;
  Gather(image, tool, x);
  if (!Fit(x)) return false;
  if ((x - before).cwiseAbs().maxCoeff() < kLookAgain) return true;
  Gather(image, tool, x);
  return Fit(x);
}

ObjectRegistrationMonitor::Match ObjectRegistrationMonitor::Measure(
    const cv::Mat& image, const Bar& tool, const Eigen::Vector2d& expected_O) noexcept {
  found_ = match_;
  found_.sighting.known = found_.sighting.indentation_known = false;
  if (!edge_.Fits(image)) return found_;
  Vector start = match_.x;
  start.tail<2>() = has_indentation_ ? expected_O : Eigen::Vector2d(0, 0);
  prior_.setZero();
  prior_.tail<2>() = start.tail<2>();
  Vector x = start;
  bool is_fitted = FitFrom(image, tool, x);
  if (!is_fitted) {
    x = start;
    x.head<2>() += edge_.FindShift(image, MotionOf(start));
    is_fitted = FitFrom(image, tool, x);
  }
  if (!is_fitted) return found_;
  const Vector before = std::exchange(found_.x, x);
  SetSighting(tool);
  if (!found_.sighting.known) found_.x = before;
  return found_;
}

void ObjectRegistrationMonitor::Accept(const Match& match) noexcept {
  match_ = match;
  if (sharpness_at_rest_ == 0 && match.sighting.known) {
    sharpness_at_rest_ = match.sighting.sharpness_at_rest;
  }
}

// Converts the result x of the fit.
void ObjectRegistrationMonitor::SetSighting(const Bar& tool) noexcept {
  const Vector& x = found_.x;
  ObjectSighting& found = found_.sighting;
  // Motion of the tip that results from the motion of the image.
  const Eigen::Vector2d arm = (tool.p_I_tip - centre_ - x.head<2>()) / size_;
  Eigen::Matrix<double, 2, 4> J;
  J << 1, 0, -arm.y(), arm.x(), 0, 1, arm.x(), arm.y();
  const Eigen::Matrix2d C = J * covariance_.topLeftCorner<4, 4>() * J.transpose();
  const double sigma = std::sqrt(C.trace());
  if (!(sigma < kKnown)) return;
  found.known = true;
  found.sigma_px = sigma;
  // Compensating a motion smaller than its error would only add noise to the tip.
  const bool still = x.head<4>().cwiseAbs().maxCoeff() < kMinMotion;
  found.motion = MotionOf(still ? Vector(Vector::Zero()) : x);
  found.motion_covariance = still ? StandingOut(J * x.head<4>(), C) : C;
  const double sharpness = std::min(SharpnessAlong(true), SharpnessAlong(false));
  found.sharpness_at_rest = sharpness_at_rest_ > 0 ? sharpness_at_rest_ : sharpness;
  found.sharpness = sharpness / found.sharpness_at_rest;
  found.exposure = Exposure();
  found.indentation_O = x.tail<2>();
  found.indentation_covariance = covariance_.bottomRightCorner<2, 2>();
  // One direction is enough: without friction the other is not observable.
  const Eigen::Matrix2d& C_indentation = found.indentation_covariance;
  const double mean = 0.5 * C_indentation.trace();
  const double better = mean - std::sqrt(std::max(0.0, mean * mean - C_indentation.determinant()));
  found.indentation_known = has_indentation_ && better < kIndentationKnown * kIndentationKnown;
}

}  // namespace palpate
