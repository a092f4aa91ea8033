#include "slave/mechanics/shell/shell_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kRows = 48;            // of a table
constexpr double kSolved = 1.5;      // ranges that it goes beyond the range
constexpr double kOpposite = 0.2;    // of the tool's and the holder's directions [rad]
constexpr double kAcross = 0.2;      // of the displacement that may lie across the normal
constexpr double kSameWidth = 1e-9;  // relative
constexpr std::string_view kAside =
    "the tool moves along the surface, which the shell does not model";
constexpr std::string_view kPulled = "the tool pulls, which the shell models poorly";
constexpr std::string_view kNotOpposite = "the tool does not press opposite to the holder";

}  // namespace

ShellModel::ShellModel(BoundaryMesh mesh, const Params& params)
    : mesh_(std::move(mesh)), params_(params) {
  RequirePositive("range", params.range);
  for (int i = 0; i < mesh_.size(); ++i) {
    const Vector2d& a = mesh_.elements[Index(i)].a;
    field_mesh_.vertices.emplace_back(a.x(), a.y(), 0);
    field_mesh_.lines.push_back({i, mesh_.Next(i)});
  }
  tables_.reserve(16);
  if (params.tool_width > 0) TableFor(params.tool_width);
  info_.kind = "shell";
  info_.dof = 2 * Index(params.shell.pieces - 1) + 1;
  info_.elements = mesh_.size();
  info_.range = params.range;
  info_.remark = "a surface of revolution about the tool's direction; a wall that folds is softer";
  NotePrecompute();
}

ShellModel::Table& ShellModel::TableFor(double width) {
  for (Table& table : tables_) {
    if (std::abs(table.width - width) <= kSameWidth * width) return table;
  }
  FluidShell::Params params = params_.shell;
  params.tool_radius = width / 2;
  FluidShell shell(params);
  Table table{.width = width,
              .step = (1 + kSolved) * params_.range * 2 * params.radius / (kRows - 1)};
  for (int i = 0; i < kRows; ++i) {
    if (!shell.PressTo(i * table.step)) break;
    table.force.push_back(shell.state().force);
    table.meridian.push_back(shell.state().meridian);
  }
  const auto rows = static_cast<int>(table.force.size());
  for (int i = 0; i < rows; ++i) {
    const int before = std::max(i - 1, 0), after = std::min(i + 1, rows - 1);
    table.slope.push_back((table.force[Index(after)] - table.force[Index(before)]) /
                          (std::max(after - before, 1) * table.step));
  }
  shown_ = nullptr;
  Hide();
  if (tables_.size() == tables_.capacity()) tables_.erase(tables_.begin());
  tables_.push_back(std::move(table));
  return tables_.back();
}

double ShellModel::WidthOf(const Contact& contact) const {
  if (contact.width > 0) return contact.width;
  return mesh_.elements.front().length();
}

void ShellModel::Prefetch(std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) TableFor(WidthOf(contact));
}

void ShellModel::ComputeResponses(std::span<const Contact> contacts,
                                  std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  shown_ = nullptr;
  std::ranges::fill(responses, ContactResponse{});
  if (contacts.size() != 1 || responses.size() != 1 ||
      contacts.front().kind != Contact::Kind::kDisplacement) {
    Fail("a shell accepts one displacement at a time");
    return;
  }
  try {
    if (!Answer(contacts.front(), &responses.front())) responses.front() = {};
  } catch (const std::exception&) {
    Fail("the tool is too wide for the shell");
  }
}

bool ShellModel::Answer(const Contact& contact, ContactResponse* response) {
  const Vector2d p = contact.p_O.head<2>(), u = contact.prescribed_O.head<2>();
  if (!p.allFinite() || !contact.prescribed_O.allFinite() || !(p.norm() > 0)) {
    return Fail("a value is not finite, or the centre is touched");
  }
  const Table& table = TableFor(WidthOf(contact));
  normal_O_ = p.normalized();
  depth_ = -u.dot(normal_O_);
  shown_ = &table;
  const double at = std::max(0.0, depth_) / table.step;
  const auto row = static_cast<std::size_t>(at);
  if (row + 1 >= table.force.size()) return Fail("deeper than the solved range of the shell");
  // The cubic through both rows' forces and slopes.
  const double s = at - static_cast<double>(row), h = table.step;
  const double f0 = table.force[row], f1 = table.force[row + 1];
  const double m0 = h * table.slope[row], m1 = h * table.slope[row + 1];
  const double a = 2 * (f0 - f1) + m0 + m1, b = 3 * (f1 - f0) - 2 * m0 - m1;
  const double force = f0 + s * (m0 + s * (b + s * a)) + std::min(0.0, depth_) * table.slope[0];
  const double slope = (m0 + s * (2 * b + s * 3 * a)) / h;
  const Vector3d n(normal_O_.x(), normal_O_.y(), 0);
  response->force_O = -force * n;
  response->displacement_O = contact.prescribed_O;
  response->stiffness_O = slope * n * n.transpose();
  response->validity = Validity::kValid;
  const auto doubt = [&](bool is, std::string_view why) {
    if (!is || response->validity == Validity::kExtrapolated) return;
    response->validity = Validity::kExtrapolated;
    response->doubt = why;
  };
  const Vector2d held(std::cos(params_.held_direction), std::sin(params_.held_direction));
  doubt(u.norm() > params_.range * 2 * params_.shell.radius, kBeyondRange);
  doubt(-normal_O_.dot(held) < std::cos(kOpposite), kNotOpposite);
  doubt(depth_ < 0, kPulled);
  doubt((u + depth_ * normal_O_).norm() > kAcross * std::abs(depth_), kAside);
  return true;
}

// (away from the axis, along it outwards) of the wall at `angle` from the tool [rad], in [m].
Vector2d ShellModel::MeridianMove(double angle) const {
  const double at = std::max(0.0, depth_) / shown_->step;
  const auto row = static_cast<std::size_t>(at);
  const double s = at - static_cast<double>(row);
  const FluidShell::Meridian& rest = shown_->meridian.front();
  const auto angle_of = [&](std::size_t i) { return std::atan2(rest[i].x(), rest[i].y()); };
  const auto moved = [&](std::size_t i) -> Vector2d {
    return (1 - s) * shown_->meridian[row][i] + s * shown_->meridian[row + 1][i] - rest[i];
  };
  if (angle <= angle_of(0)) return moved(0);
  std::size_t low = 0, high = rest.size() - 1;
  if (angle >= angle_of(high)) return {0, 0};
  while (high - low > 1) {
    const std::size_t middle = (low + high) / 2;
    (angle_of(middle) <= angle ? low : high) = middle;
  }
  const double share = (angle - angle_of(low)) / (angle_of(high) - angle_of(low));
  return (1 - share) * moved(low) + share * moved(high);
}

void ShellModel::ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) {
  u_O->assign(mesh_.elements.size(), Vector3d::Zero());
  if (shown_ == nullptr) return;
  const Vector2d across(-normal_O_.y(), normal_O_.x());
  for (std::size_t i = 0; i < u_O->size(); ++i) {
    const Vector2d& p = mesh_.elements[i].a;
    const double aside = p.dot(across);
    const Vector2d move = MeridianMove(std::atan2(std::abs(aside), p.dot(normal_O_)));
    (*u_O)[i].head<2>() = std::copysign(move.x(), aside) * across + move.y() * normal_O_;
  }
}

}  // namespace palpate
