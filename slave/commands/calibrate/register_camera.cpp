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
  const auto in_image = [&](const char* column, int count) {
    const double at = table.Number(column);
    if (at >= -0.5 && at <= count - 0.5) return at;
    table.Refuse(column, fmt::format("0 to {}: it is outside of the image of {} x {}", count - 1,
                                     size[0], size[1]));
  };
  return {in_image(u, size[0]), in_image(v, size[1])};
}

// With --plane the image points are those of the undistorted image. Throws InputError with file and
// line: a cell is no number, or a point is outside of its image.
std::vector<TipPlace> ReadTipPlaces(const CalibrateOptions& options, const StereoRig& rig) {
  const bool is_pair = rig.baseline() > 0;
  CsvTable table(options.tip_places, {{"x", true, Quantity::kLength},
                                      {"y", true, Quantity::kLength},
                                      {"z", true, Quantity::kLength},
                                      {"u"},
                                      {"v"},
                                      {"u_right", is_pair},
                                      {"v_right", is_pair}});
  std::vector<TipPlace> places;
  while (table.Next()) {
    TipPlace& place = places.emplace_back();
    place.p_S = {table.Number("x"), table.Number("y"), table.Number("z")};
    place.left_I = ImagePoint(table, "u", "v", rig.left.size);
    if (is_pair) place.right_I = ImagePoint(table, "u_right", "v_right", rig.right.size);
    if (!options.plane) continue;
    const auto straight = Straight(rig.left, place.left_I);
    if (!straight) table.Fail("u, v: outside of the undistorted image");
    place.left_I = *straight;
  }
  return places;
}

std::string Words(const CameraRegistration& found) {
  std::string words = "row  error [mm]\n";
  for (std::size_t i = 0; i < found.residuals.size(); ++i) {
    words += fmt::format("{:5}  {:.4f}{}\n", i + 1, 1e3 * found.residuals[i],
                         found.used[i] ? "" : "  not used");
  }
  words += fmt::format(
      "rms {:.4f} mm; one sigma of the direction {:.3g} deg, of the camera position {:.3g} mm\n",
      1e3 * found.rms, found.sigma_angle * 180 / std::numbers::pi, 1e3 * found.sigma_place);
  constexpr double kMaxPixel = 5e-3;  // [m]
  if (found.pixel > kMaxPixel) {
    words += fmt::format("calibrate: pixel of {:.4g} mm: x, y, z of --register are in metres\n",
                         1e3 * found.pixel);
  }
  for (const std::string& reason : found.reasons) words += "rejected: " + reason + "\n";
  return words;
}

// The cameras. Throws std::invalid_argument.
StereoRig CamerasOf(const CalibrateOptions& options) {
  StereoRig rig;
  rig.left.size = options.size;
  if (!options.rig.empty()) {
    rig = ReadRig(options.rig);
    if (options.plane == (rig.baseline() > 0)) {
      throw std::invalid_argument("--plane: expected with the rig of one camera, and only then");
    }
  } else if (options.size[0] == 0) {
    throw std::invalid_argument(
        "--register: expected --rig, or --size of a camera that looks straight down on z = 0");
  }
  return rig;
}

}  // namespace

int RunRegister(const CalibrateOptions& options) {
  const StereoRig rig = CamerasOf(options);
  const bool is_pair = rig.baseline() > 0;
  RequireOtherThan("--out", options.out, std::vector{options.rig, options.tip_places});
  const std::vector<TipPlace> places = ReadTipPlaces(options, rig);
  const CameraRegistration found =
      is_pair ? RegisterPair(rig, places) : RegisterPlane(rig.left.size, places);
  std::fputs(Words(found).c_str(), stderr);
  if (!found.reasons.empty()) {
    std::fputs("calibrate: rejected, no lines are written\n", stderr);
    return 1;
  }
  std::string lines = "# for sense.camera\n";
  if (options.plane) {
    lines += "intrinsics: " + options.rig.string() + "  # relative to the scene's folder\n";
  }
  if (!is_pair) lines += fmt::format("pixel: {:.8g} mm\n", 1e3 * found.pixel);
  lines += ScenePose(found.X_SC) + "\n";
  std::fputs(lines.c_str(), stdout);
  if (!options.out.empty()) WriteWholeFile(options.out, lines);
  return 0;
}

}  // namespace palpate
