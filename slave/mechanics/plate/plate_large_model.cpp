#include "slave/mechanics/plate/plate_large_model.h"

#include <algorithm>
#include <cmath>

#include "shared/text/text.h"
#include "slave/mechanics/plate/plate_law.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using plate::ModalPlate;
using plate::Symmetry;
using plate::Touch;

constexpr double kCentral = 1e-9;        // places closer to the centre count as the centre [radii]
constexpr double kCentralRange = 10;     // range at the centre relative to that elsewhere
constexpr double kModerate = 0.3;        // |w| / a: rotations are moderate
constexpr double kLawsLargest = 0.1;     // largest accepted error of the plate's law
constexpr double kMaxDeflection = 1000;  // largest |w| / t that is tried
constexpr double kMaxForce = 1e11;       // largest force that is tried [E t^4 / a^2]
// Smallest nondimensional value: below it intermediate results become subnormal and lose digits.
constexpr double kMinValue = 1e-290;
constexpr std::string_view kDigitsLost = "the value is too small for the numerical precision";
constexpr std::size_t kMaxTools = 64;  // number of stored tool diameters

bool IsSubnormal(double value) {
  return std::fpclassify(value) == FP_SUBNORMAL;
}

PlateLargeModel::Params Checked(const PlateLargeModel::Params& params) {
  plate::RequirePlate({params.radius, params.thickness}, params.young_modulus,
                      params.poisson_ratio);
  RequirePositive("range", params.range);
  RequireNotNegative("prestress", params.prestress);
  return params;
}

double BendingStiffness(double nu) {
  return 1 / (12 * (1 - nu * nu));
}

// N0 divided by E t^3 / a^2.
double ScaledPrestress(const PlateLargeModel::Params& params) {
  const double slenderness = params.thickness / params.radius;
  return params.prestress / params.young_modulus / params.thickness / (slenderness * slenderness);
}

plate::PlateModes MakeModes(const PlateLargeModel::Params& params, Progress* progress) {
  if (progress != nullptr) {
    const double order = params.order;
    progress->Expect({.seconds = 0.05 + 4e-8 * std::pow(order, 5),
                      .memory_bytes = static_cast<std::size_t>(8 * std::pow(order, 5)) / 2});
    ReportProgress(progress, "plate modes", 0);
  }
  return {params.order, params.poisson_ratio};
}

}  // namespace

PlateLargeModel::PlateLargeModel(const Params& params, Progress* progress)
    : PlateSurface({Checked(params).radius, params.thickness}),
      params_(params),
      prestress_(ScaledPrestress(params_)),
      modes_(MakeModes(params_, progress)),
      modal_(modes_, BendingStiffness(params_.poisson_ratio), prestress_) {
  const double slenderness = params_.thickness / params_.radius;
  force_unit_ =
      params_.young_modulus * params_.thickness * params_.thickness * slenderness * slenderness;
  ReportProgress(progress, "central indentation", 0.7);
  ToolOf(0, plate::Face::kEven);
  info_.kind = "plate-large";
  info_.dof = static_cast<std::size_t>(modes_.deflections(Symmetry::kNone));
  info_.memory_bytes = modes_.memory_bytes();
  info_.range = std::min({params_.range * slenderness, kModerate,
                          plate::DeflectionOfExcess(kLawsLargest, slenderness)}) /
                2;
  info_.remark =
      "bending and stretching, without shear; the force at a depth of a / 8 is too high by 7 % at "
      "the centre, 9 % at 0.5 a, 13 % at 0.7 a (t = a / 39)";
  NotePrecompute();
  if (progress != nullptr) progress->Report("central indentation", 1);
}

bool PlateLargeModel::TryRespond(std::span<const Contact> contacts,
                                 std::span<ContactResponse> responses) {
  values_.resize(touches_.size());
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const bool moved = touches_[i].moved();
    values_[i] = moved ? touches_[i].value * (params_.radius / params_.thickness)
                       : touches_[i].value / force_unit_;
    if (!(std::abs(values_[i]) <= (moved ? kMaxDeflection : kMaxForce))) {
      return Fail(moved ? "a deflection beyond 1000 thicknesses" : "a load is too large");
    }
  }
  if (!IsSameSet()) Prepare();
  shaped_ = false;
  if (!(central_ != nullptr ? SolveCentral() : modal_.Solve(values_))) {
    return Fail("the equations of the stretching plate did not converge");
  }
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    responses[i] = ResponseOf(contacts[i], i);
    if (responses[i].validity == Validity::kFailed) {
      return Fail("the solution is not finite or too large");
    }
  }
  return true;
}

void PlateLargeModel::Prepare() {
  prepared_ = false;
  if (tools_.size() > kMaxTools) tools_.clear();
  known_ = touches_;
  central_ = nullptr;
  if (touches_.size() == 1 && touches_[0].disc.centre.norm() < kCentral) {
    central_ = &ToolOf(touches_[0].disc.radius, touches_[0].face);
  }
  Orient();
  presses_.clear();
  for (const Touch& touch : touches_) {
    const Vector2d& p = touch.disc.centre;
    const Vector2d turned(axis_.dot(p), axis_.x() * p.y() - axis_.y() * p.x());
    const double across = symmetry_ == Symmetry::kMirror ? 0 : turned.y();
    presses_.push_back({.disc = {{turned.x(), across}, touch.disc.radius},
                        .face = touch.face,
                        .is_force = !touch.moved(),
                        .value = 0,
                        .waves = ToolOf(touch.disc.radius, touch.face).waves.get()});
  }
  modal_.Place(presses_, symmetry_);
  prepared_ = true;
}

// If all contacts are on one diameter, the plate is symmetric to it, and half of the modes are
// sufficient.
void PlateLargeModel::Orient() {
  axis_ = {1, 0};
  double farthest = 0;
  for (const Touch& touch : touches_) {
    const double r = touch.disc.centre.norm();
    if (r <= farthest) continue;
    farthest = r;
    axis_ = touch.disc.centre / r;
  }
  const bool in_line = std::ranges::all_of(touches_, [this](const Touch& touch) {
    const Vector2d& p = touch.disc.centre;
    return std::abs(axis_.x() * p.y() - axis_.y() * p.x()) < kCentral;
  });
  symmetry_ = in_line ? Symmetry::kMirror : Symmetry::kNone;
  if (!in_line) axis_ = {1, 0};
}

PlateLargeModel::Pressed& PlateLargeModel::ToolOf(double load_radius, plate::Face face) {
  for (const auto& tool : tools_) {
    if (tool->waves->load_radius() == load_radius && tool->waves->face() == face) return *tool;
  }
  const double nu = params_.poisson_ratio;
  tools_.push_back(std::make_unique<Pressed>(
      Pressed{plate::ShortWaves::Of(params_.order, nu, prestress_, load_radius, face),
              plate::RoundPress(nu, load_radius, prestress_, face)}));
  return *tools_.back();
}

bool PlateLargeModel::SolveCentral() {
  plate::RoundPress& press = central_->central;
  return touches_[0].moved() ? press.SolveDeflection(values_[0]) : press.SolveForce(values_[0]);
}

ContactResponse PlateLargeModel::ResponseOf(const Contact& contact, std::size_t touch) const {
  const bool centred = central_ != nullptr;
  const double t = params_.thickness;
  const plate::RoundPress* press = centred ? &central_->central : nullptr;
  const auto [force, w, k] =
      centred ? ModalPlate::Answer{press->force(), press->deflection(), press->stiffness()}
              : modal_.AnswerOf(touch);
  const bool moved = contact.kind == Contact::Kind::kDisplacement;
  ContactResponse response;
  response.force_O.z() = moved ? -force_unit_ * force : contact.prescribed_O.z();
  response.displacement_O.z() = moved ? contact.prescribed_O.z() : -t * w;
  response.stiffness_O(2, 2) = force_unit_ / t * k;
  const bool known =
      std::isfinite(force_unit_ * force) && std::isfinite(k) && std::abs(w) <= kMaxDeflection;
  if (!known) return {};
  const double p = known_[touch].disc.centre.norm();
  const double inside_rim = std::max(0.0, 1 - p * p);
  const double range = params_.range * (centred ? kCentralRange : inside_rim * inside_rim);
  // Error of the plate's law in the result: the force, or the deflection under a given force.
  const double excess = plate::ExcessAtDepth(
      {.place = p, .deflection = w * t / params_.radius, .slenderness = t / params_.radius});
  const double share = moved || !(force * k * w > 0) ? 1 : force / (k * w);
  const bool inside = std::abs(w) <= range && std::abs(w) * t <= kModerate * params_.radius &&
                      excess * share <= kLawsLargest;
  const double value = std::abs(values_[touch]);
  const bool lost =
      (value > 0 && value < kMinValue) || IsSubnormal(force_unit_ * force) || IsSubnormal(t * w);
  response.validity = inside && !lost ? Validity::kValid : Validity::kExtrapolated;
  response.flag_reason = !inside ? kBeyondRange : lost ? kDigitsLost : std::string_view();
  return response;
}

void PlateLargeModel::Reset() {
  modal_.Reset();
  for (const auto& tool : tools_) tool->central.Reset();
  Hide();
}

// The shape is that of the modes under a load at the centre, too, so that it does not jump when the
// load moves.
double PlateLargeModel::DisplacementAt(const Vector2d& x) noexcept {
  if (central_ != nullptr && !shaped_) {
    modal_.Solve(values_);
    shaped_ = true;
  }
  return -params_.thickness *
         modal_.Deflection({axis_.dot(x), axis_.x() * x.y() - axis_.y() * x.x()});
}

}  // namespace palpate
