#include "slave/commands/calibrate/calibrate_register.h"

#include <cstdio>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "shared/text/csv.h"
#include "slave/commands/calibrate/calibrate_report.h"
#include "slave/scene/scene_loader.h"
#include "slave/vision/calibration/registration.h"

namespace palpate {
namespace {

std::vector<TipPlace> ReadTipPlaces(const std::filesystem::path& file) {
  CsvTable table(file, {{"x"}, {"y"}, {"z"}, {"u"}, {"v"}, {"u_right", false}, {"v_right", false}});
  if (table.Has("u_right") != table.Has("v_right")) {
    table.Fail("accepted is u_right and v_right, or neither");
  }
  std::vector<TipPlace> places;
  while (table.Next()) {
    TipPlace& place = places.emplace_back();
    place.p_S = {table.Number("x"), table.Number("y"), table.Number("z")};
    place.left_I = {table.Number("u"), table.Number("v")};
    if (table.Has("u_right")) {
      place.right_I = Eigen::Vector2d(table.Number("u_right"), table.Number("v_right"));
    }
  }
  return places;
}

struct Registered {
  CameraRegistration registration;
  std::string lines;  // of `sense.camera`
};

std::string PlaneLines(const CameraRegistration& found) {
  return fmt::format("pixel: {:.8g} mm\n{}\n", 1e3 * found.pixel, ScenePose(found.X_SC));
}

Registered RegisterSize(const CalibrateOptions& options, const std::vector<TipPlace>& places) {
  if (options.size.empty()) {
    throw std::invalid_argument(
        "--register: accepted is with --left, --rig, or --size of a camera straight above z = 0");
  }
  Registered out{RegisterPlane(TwoCounts("--size", options.size, 1, 100000, "640x480"), places),
                 {}};
  out.lines = PlaneLines(out.registration);
  return out;
}

Registered RegisterWith(const CalibrateOptions& options, const StereoRig* rig,
                        const std::filesystem::path& lens_file,
                        const std::vector<TipPlace>& places) {
  if (rig == nullptr) return RegisterSize(options, places);
  const bool is_pair = rig->baseline() > 0;
  const bool in_both = !places.empty() && places.front().right_I;
  if (options.plane && is_pair) {
    throw std::invalid_argument("--plane: accepted is with one camera, this rig has two");
  }
  if (in_both && !is_pair) {
    throw std::invalid_argument(
        "--register: u_right, v_right: accepted is with a rig of two "
        "cameras");
  }
  Registered out;
  if (options.plane) {
    out.registration = RegisterLensPlane(rig->left, places);
    out.lines = "intrinsics: " + lens_file.string() + "  # from the scene's folder\n" +
                PlaneLines(out.registration);
    return out;
  }
  out.registration = in_both ? RegisterPair(*rig, places) : RegisterLens(rig->left, places);
  out.lines = "# " + StandingWords(out.registration.X_SC) + "\n";
  for (const std::string& warning : out.registration.warnings) {
    out.lines += "# check: " + warning + "\n";
  }
  out.lines += ScenePose(out.registration.X_SC) + "\n";
  if (!is_pair) {
    out.lines = "# of a depth camera; a planar scene takes what --plane prints\n" + out.lines;
  }
  return out;
}

}  // namespace

int RunRegister(const CalibrateOptions& options, const StereoRig* rig,
                const std::filesystem::path& lens_file, const std::filesystem::path& out) {
  std::vector<TipPlace> places;
  try {
    places = ReadTipPlaces(options.tip_places);
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
  const Registered found = RegisterWith(options, rig, lens_file, places);
  std::fputs(Words(found.registration).c_str(), stderr);
  const bool is_trusted = found.registration.reasons.empty();
  if (!is_trusted && !options.force) {
    std::fputs("calibrate: refused, no lines are written; --force writes them\n", stderr);
    return 1;
  }
  const std::string lines = "# for sense.camera\n" + found.lines;
  std::fputs(lines.c_str(), stdout);
  if (!out.empty()) WriteWholeFile(out, lines);
  return is_trusted ? 0 : 1;
}

}  // namespace palpate
