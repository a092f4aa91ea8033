#include "slave/tactile/localise/electrode_layout.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <string_view>

#include <Eigen/Geometry>

#include "shared/text/csv.h"

namespace palpate {
namespace {

constexpr double kRounding = 1e-12;  // relative to the size: smaller distances have no direction

// Returns the outward direction from the sphere's centre, or from the cylinder's axis behind it.
Eigen::Vector3d Outward(const Eigen::Vector3d& p_F) {
  return {p_F.x() >= 0 ? p_F.x() : 0, p_F.y(), p_F.z()};
}

constexpr double kMillimetre = 1e-3;     // [m] [by definition]
constexpr double kMaxDistance = 1000;    // of an electrode from the origin [mm]
constexpr double kUnitTolerance = 0.05;  // of a normal's length: files print three digits

using Row = std::array<double, 6>;  // x y z [mm], nx ny nz

// Returns 0 for E1 or c1; nullopt for other names.
std::optional<std::size_t> ChannelOf(std::string_view name, const TactileChannels& channels) {
  for (int i = 0; i < channels.count; ++i) {
    if (name == channels.NameOf(i)) return static_cast<std::size_t>(i);
  }
  return std::nullopt;
}

// Parses the numbers after the name.
std::optional<Row> ParseRow(const std::vector<std::string_view>& cells) {
  Row row{};
  if (cells.size() != row.size() + 1) return std::nullopt;
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto number = ParseFinite(cells[i + 1]);
    if (!number) return std::nullopt;
    row[i] = *number;
  }
  return row;
}

// Throws std::runtime_error `file:line: ...`: the line of electrode `name` contains no position.
void RequirePlace(const CsvLines& lines, const std::string& name, const std::optional<Row>& row) {
  if (!row) lines.Fail(Shown(lines.text()) + ": expected NAME,x,y,z,nx,ny,nz in millimetres");
  const auto& [x, y, z, nx, ny, nz] = *row;
  if (Eigen::Vector3d(x, y, z).stableNorm() > kMaxDistance) {
    lines.Fail(name + " is farther than 1 m from the origin: expected millimetres");
  }
  if (!(std::abs(Eigen::Vector3d(nx, ny, nz).stableNorm() - 1) < kUnitTolerance)) {
    lines.Fail(name + ": nx,ny,nz is not a unit vector");
  }
}

// Throws std::runtime_error `file:line: ...`: all channels are within a tenth of a millimetre, as
// for a file in metres.
void RequireSize(const CsvLines& lines, const ElectrodeLayout& layout) {
  constexpr double kMinSize = 1e-4;  // [m]
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : layout.p_F) box.extend(p);
  const double size = box.sizes().maxCoeff();
  if (layout.p_F.size() < 2 || size >= kMinSize) return;
  lines.Fail(Formatted("the channels span %.3g mm, in metres %.3g mm: expected millimetres",
                       size / kMillimetre, size / kMillimetre / kMillimetre));
}

// Position of a simulated electrode. On the cylinder: `along` the axis from the origin in radii, <=
// 0. On the sphere: `along` is the elevation from the plane x = 0 towards the tip [degrees].
// Azimuth about the axis from the pad's centre towards +y [degrees].
struct Site {
  bool on_tip;
  double along;
  double azimuth;
};
constexpr std::array<Site, kElectrodeCount> kSites{{
    {true, 62, 0},       {true, 36, -38},     {true, 36, 38},  // around the tip
    {true, 18, -82},     {true, 18, 82},      {true, 12, 0},   // and down its sides
    {false, -0.30, -42}, {false, -0.30, 42},                   // pad and its flanks, backwards
    {false, -0.62, 0},   {false, -0.70, -84}, {false, -0.70, 84},  {false, -0.98, -42},
    {false, -0.98, 42},  {false, -1.32, 0},   {false, -1.38, -84}, {false, -1.38, 84},
    {false, -1.66, -42}, {false, -1.66, 42},  {false, -2.00, 0},
}};
// Ratio of the core's radius to the finger's. [-] [tuned:
// SimulatedElectrodesAreSpreadUnderTheSkinAtAnySize]
constexpr double kCore = 0.78;

}  // namespace

std::optional<Eigen::Vector3d> FingerSurface::Project(const Eigen::Vector3d& c_F) const noexcept {
  const Eigen::Vector3d outward = Outward(c_F);
  const double length = outward.stableNorm();
  const double size = c_F.x() >= 0 ? radius : radius - c_F.x();
  if (!c_F.allFinite() || !(length > kRounding * size)) return std::nullopt;
  const Eigen::Vector3d from_axis = radius * outward.stableNormalized();
  return Eigen::Vector3d(c_F.x() >= 0 ? from_axis.x() : c_F.x(), from_axis.y(), from_axis.z());
}

Eigen::Vector3d FingerSurface::Normal(const Eigen::Vector3d& p_F) const noexcept {
  return Outward(p_F).stableNormalized();
}

ElectrodeLayout ReadElectrodeLayout(const std::filesystem::path& file,
                                    const TactileChannels& channels) {
  CsvLines lines(file);
  ElectrodeLayout layout(channels.count);
  std::vector<bool> known(layout.p_F.size());
  while (lines.Next()) {
    const std::string name(lines.cells().front());
    const auto channel = ChannelOf(name, channels);
    if (!channel) continue;
    if (known[*channel]) lines.Fail(name + " occurs twice: expected one row each");
    const auto row = ParseRow(lines.cells());
    RequirePlace(lines, name, row);
    layout.p_F[*channel] = kMillimetre * Eigen::Map<const Eigen::Vector3d>(row->data());
    layout.n_F[*channel] = Eigen::Map<const Eigen::Vector3d>(row->data() + 3).normalized();
    known[*channel] = true;
  }
  for (int i = 0; i < channels.count; ++i) {
    if (known[static_cast<std::size_t>(i)]) continue;
    lines.Fail(channels.NameOf(i) + " is missing: expected all of " + channels.Names());
  }
  RequireSize(lines, layout);
  return layout;
}

ElectrodeLayout SimulatedLayout(double radius) {
  constexpr double kRadiansPerDegree = std::numbers::pi / 180;  // [rad] [by definition]
  ElectrodeLayout layout;
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const Site& site = kSites[i];
    const double elevation = site.on_tip ? site.along * kRadiansPerDegree : 0;
    const double azimuth = site.azimuth * kRadiansPerDegree;
    const Eigen::Vector3d n(std::sin(elevation), std::cos(elevation) * std::sin(azimuth),
                            -std::cos(elevation) * std::cos(azimuth));
    const double x = site.on_tip ? 0 : site.along * radius;
    layout.n_F[i] = n;
    layout.p_F[i] = kCore * radius * n + Eigen::Vector3d(x, 0, 0);
  }
  return layout;
}

}  // namespace palpate
