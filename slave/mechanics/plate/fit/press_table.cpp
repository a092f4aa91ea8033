#include "slave/mechanics/plate/fit/press_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace palpate {
namespace {

constexpr int kColumns = 16, kRows = 17;  // radii, depths
constexpr double kOuter = 0.9;            // largest radius of the tool's edge [radii]
constexpr double kDeepest = 0.3;          // at the centre [radii]: rotations are moderate
constexpr int kBisections = 12;
constexpr double kFirst = 1e-6;  // relative to the largest depth; counts as the first contact

ContactResponse PressAt(PlateSurface& plate, double x, const PlateSurface::Tool& tool,
                        double depth) {
  const Contact press =
      PlateSurface::ToolContact(Contact::Kind::kDisplacement, {x, 0}, tool, -depth);
  ContactResponse response;
  plate.Respond({&press, 1}, {&response, 1});
  return response;
}

}  // namespace

PressTable::PressTable(PlateSurface& plate, const PlateSurface::Tool& tool)
    : tool_(tool),
      radius_(plate.radius()),
      largest_radius_(std::max(0.1 * plate.radius(), kOuter * plate.radius() - tool.width / 2)),
      entries_(kColumns * kRows) {
  for (int column = 0; column < kColumns; ++column) {
    FillColumn(plate, column);
    const double r = largest_radius_ / radius_ * column / (kColumns - 1);
    valid_depths_.push_back(ValidDepth(plate, r));
  }
  plate.Reset();
}

double PressTable::RimShare(double r) const noexcept {
  const double outermost = r + (tool_.is_rigid ? tool_.width / 2 / radius_ : 0);
  const double inside = 1 - outermost * outermost;
  return inside * inside;
}

// Returns the largest depth, which decreases towards the rim.
double PressTable::Deepest(double r) const noexcept {
  return kDeepest * radius_ * (1 - r * r);
}

void PressTable::FillColumn(PlateSurface& plate, int column) {
  const double r = largest_radius_ / radius_ * column / (kColumns - 1);
  Entry* const first = &entries_[static_cast<std::size_t>(column * kRows)];
  plate.Reset();
  for (int row = 0; row < kRows; ++row) {
    const double share = static_cast<double>(row) / (kRows - 1);
    const double depth = Deepest(r) * (row == 0 ? kFirst : share * share);
    const ContactResponse response = PressAt(plate, r * radius_, tool_, depth);
    Entry& entry = first[row];
    if (response.validity == Validity::kFailed) {
      if (row == 0)
        throw std::runtime_error("the plate's response to a small indentation is not found");
      entry = {first[row - 1].secant + first[row - 1].slope, first[row - 1].slope};
      continue;
    }
    const double secant = -response.force_O.z() / depth;
    const double tangent = response.stiffness_O(2, 2);
    entry.secant = RimShare(r) * secant;
    entry.slope = row == 0 ? 0 : RimShare(r) * (tangent - secant) * 2 / row;
  }
}

// Finds the depth by bisection.
double PressTable::ValidDepth(PlateSurface& plate, double r) const {
  double valid = 0, beyond = Deepest(r);
  for (int step = 0; step < kBisections; ++step) {
    const double depth = (valid + beyond) / 2;
    const auto response = PressAt(plate, r * radius_, tool_, depth);
    const bool inside = response.validity == Validity::kValid;
    (inside ? valid : beyond) = depth;
  }
  return valid;
}

const PressTable::Entry& PressTable::EntryAt(int column, int row) const {
  const int mirrored = std::min(std::abs(column), kColumns - 1);
  return entries_[static_cast<std::size_t>(mirrored * kRows + row)];
}

PressTable::Press PressTable::At(double radius, double depth) const noexcept {
  if (!std::isfinite(radius) || !std::isfinite(depth)) return {};
  const double r = std::min(std::abs(radius), largest_radius_) / radius_;
  const double x = r / (largest_radius_ / radius_) * (kColumns - 1);
  const int column = std::min(static_cast<int>(x), kColumns - 2);
  const double u = x - column;
  const double known = std::clamp(depth, 0.0, Deepest(r));
  const double y = std::sqrt(known / Deepest(r)) * (kRows - 1);
  const int row = std::min(static_cast<int>(y), kRows - 2);
  const double v = y - row;
  // Catmull-Rom interpolation over radii, Hermite interpolation over depth: value and derivative.
  const std::array across = {u * (-0.5 + u * (1 - 0.5 * u)), 1 + u * u * (1.5 * u - 2.5),
                             u * (0.5 + u * (2 - 1.5 * u)), u * u * (0.5 * u - 0.5)};
  double secant = 0, change = 0;
  for (int k = 0; k < 4; ++k) {
    const Entry& a = EntryAt(column + k - 1, row);
    const Entry& b = EntryAt(column + k - 1, row + 1);
    const double c2 = 3 * (b.secant - a.secant) - 2 * a.slope - b.slope;
    const double c3 = 2 * (a.secant - b.secant) + a.slope + b.slope;
    const double share = across[static_cast<std::size_t>(k)];
    secant += share * (a.secant + v * (a.slope + v * (c2 + v * c3)));
    change += share * (a.slope + v * (2 * c2 + v * 3 * c3));
  }
  Press press;
  press.stiffness = (secant + change * y / 2) / RimShare(r);
  press.force = secant / RimShare(r) * known + press.stiffness * (std::max(depth, 0.0) - known);
  const auto at = static_cast<std::size_t>(column);
  press.valid = depth <= std::min(valid_depths_[at], valid_depths_[at + 1]);
  return press;
}

}  // namespace palpate
