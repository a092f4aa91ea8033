// The part --register of `calibrate`.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/commands/calibrate/calibrate.h"
#include "slave/scene/scene_loader.h"
#include "slave/vision/calibration/registration.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

// The row's image point in the columns `u` and `v`.
Eigen::Vector2d ImagePoint(const CsvTable& table, const char* u, const char* v,
                           const std::array<int, 2>& size) {
  const Eigen::Vector2d p_I(table.Number(u), table.Number(v));
  const std::array<const char*, 2> columns{u, v};
  for (int k = 0; k < 2; ++k) {
    const auto axis = static_cast<std::size_t>(k);
    if (p_I[k] >= -0.5 && p_I[k] <= size[axis] - 0.5) continue;
    table.Refuse(columns[axis], fmt::format("0 to {}: it is outside of the image of {} x {}",
                                            size[axis] - 1, size[0], size[1]));
  }
  return p_I;
}

// Throws InputError with file and line: a cell is no number, or a point is outside of its image.
std::vector<TipPlace> ReadTipPlaces(const std::filesystem::path& file, const StereoRig& rig) {
  CsvTable table(file, {{"x", true, Quantity::kLength},
                        {"y", true, Quantity::kLength},
                        {"z", true, Quantity::kLength},
                        {"u"},
                        {"v"},
                        {"u_right", false},
                        {"v_right", false}});
  if (table.Has("u_right") != table.Has("v_right")) {
    table.Fail("expected u_right and v_right, or neither");
  }
  if (table.Has("u_right") && rig.baseline() == 0) {
    table.Fail("u_right, v_right: only with a rig of two cameras");
  }
  std::vector<TipPlace> places;
  while (table.Next()) {
    TipPlace& place = places.emplace_back();
    place.p_S = {table.Number("x"), table.Number("y"), table.Number("z")};
    place.left_I = ImagePoint(table, "u", "v", rig.left.size);
    if (!table.Has("u_right")) continue;
    place.right_I = ImagePoint(table, "u_right", "v_right", rig.right.size);
  }
  return places;
}

void WarnOfUnit(const std::vector<TipPlace>& places, double pixel) {
  constexpr double kMaxSpan = 2, kMinSpan = 2e-5, kMaxPixel = 5e-3;  // [m]
  Eigen::AlignedBox3d box;
  for (const TipPlace& place : places) box.extend(place.p_S);
  const double span = box.sizes().maxCoeff();
  if (span > kMaxSpan || (span < kMinSpan && span > 0)) {
    std::fprintf(stderr,
                 "calibrate: the positions of --register span %.4g m: x, y, z are in metres, these "
                 "look like %s\n",
                 span, span > kMaxSpan ? "millimetres" : "another unit");
  }
  if (pixel > kMaxPixel) {
    std::fprintf(stderr, "calibrate: pixel of %.4g mm: larger than 5 mm\n", 1e3 * pixel);
  }
}

std::string Words(const CameraRegistration& found) {
  std::string words = "row  error [mm]\n";
  for (std::size_t i = 0; i < found.residuals.size(); ++i) {
    const double error = found.residuals[i];
    words += fmt::format("{:5}  {}{}\n", i + 1,
                         std::isfinite(error) ? fmt::format("{:.4f}", 1e3 * error) : "no ray",
                         found.used[i] ? "" : "  not used");
  }
  words += fmt::format(
      "rms {:.4f} mm; one sigma of the direction {:.3g} deg, of the camera position {:.3g} mm\n",
      1e3 * found.rms, found.sigma_angle * 180 / std::numbers::pi, 1e3 * found.sigma_place);
  for (const std::string& warning : found.warnings) words += "check: " + warning + "\n";
  for (const std::string& reason : found.reasons) words += "rejected: " + reason + "\n";
  return words;
}

// Returns the positions in the undistorted image.
std::vector<TipPlace> Undistorted(const Lens& lens, std::vector<TipPlace> places) {
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto at = Straight(lens, places[i].left_I);
    if (!at) {
      throw std::invalid_argument(
          fmt::format("--register: row {}: u, v = {:g}, {:g} is outside of the undistorted image",
                      i + 1, places[i].left_I.x(), places[i].left_I.y()));
    }
    places[i].left_I = *at;
  }
  return places;
}

}  // namespace

int RunRegister(const CalibrateOptions& options, const StereoRig* rig,
                const std::filesystem::path& lens_file, const std::filesystem::path& out) {
  StereoRig camera;
  if (rig != nullptr) {
    camera = *rig;
  } else if (!options.size.empty()) {
    camera.left.size = TwoCounts("--size", options.size, 1, 100000, "640x480");
  } else {
    throw std::invalid_argument(
        "--register: only with --left, --rig, or --size of a camera that looks straight "
        "down on z = 0");
  }
  const bool is_plane = options.plane || rig == nullptr, is_pair = camera.baseline() > 0;
  if (options.plane && is_pair) {
    throw std::invalid_argument("--plane: only with one camera; this rig has two");
  }
  std::vector<TipPlace> places;
  try {
    places = ReadTipPlaces(options.tip_places, camera);
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
  if (options.plane) places = Undistorted(camera.left, std::move(places));
  const bool in_both = places.front().right_I.has_value();
  const CameraRegistration found = is_plane  ? RegisterPlane(camera.left.size, places)
                                   : in_both ? RegisterPair(camera, places)
                                             : RegisterLens(camera.left, places);
  WarnOfUnit(places, found.pixel);
  std::fputs(Words(found).c_str(), stderr);
  const bool is_trusted = found.reasons.empty();
  if (!is_trusted && !options.force) {
    std::fputs("calibrate: rejected, no lines are written; --force writes them\n", stderr);
    return 1;
  }
  std::string lines = "# for sense.camera\n";
  if (options.plane) {
    lines += "intrinsics: " + lens_file.string() + "  # relative to the scene's folder\n";
  } else if (!is_plane && !is_pair) {
    lines += "# for a depth camera; a planar scene needs the lines that --plane prints\n";
  }
  for (const std::string& warning : found.warnings) lines += "# check: " + warning + "\n";
  if (is_plane) lines += fmt::format("pixel: {:.8g} mm\n", 1e3 * found.pixel);
  lines += ScenePose(found.X_SC) + "\n";
  std::fputs(lines.c_str(), stdout);
  if (!out.empty()) WriteWholeFile(out, lines);
  return is_trusted ? 0 : 1;
}

}  // namespace palpate
