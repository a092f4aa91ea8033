#include "slave/commands/calibrate/calibrate.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/commands/calibrate/calibrate_pictures.h"
#include "slave/commands/calibrate/calibrate_report.h"
#include "slave/scene/scene_loader.h"
#include "slave/scene/units.h"
#include "slave/vision/calibration/registration.h"

namespace palpate {
namespace {

Board::Pattern PatternOf(const std::string& name) {
  const auto* found = std::ranges::find(kPatternNames, name);
  if (found != kPatternNames.end()) {
    return static_cast<Board::Pattern>(found - kPatternNames.begin());
  }
  throw std::invalid_argument("--pattern " + name +
                              ": expected chessboard, circles or asymmetric-circles");
}

double Length(const char* option, const std::string& text, double most) {
  const auto length = ParseQuantity(text, Dimension::kLength);
  if (!length || !(*length >= 1e-6 && *length <= most)) {
    const std::string range = fmt::format("1 um to {:g} m", most);
    throw std::invalid_argument(fmt::format("{} {}: expected {}", option, text,
                                            ExpectedQuantity(Dimension::kLength, range)));
  }
  return *length;
}

// `9x6`. Throws std::invalid_argument naming the option.
std::array<int, 2> TwoCounts(const std::string& option, const std::string& text, int least,
                             int most, const char* example) {
  const auto cross = text.find_first_of("xX");
  if (cross != std::string::npos) {
    const auto a = ParseInteger(text.substr(0, cross)), b = ParseInteger(text.substr(cross + 1));
    if (a && b && *a >= least && *a <= most && *b >= least && *b <= most) {
      return {static_cast<int>(*a), static_cast<int>(*b)};
    }
  }
  throw std::invalid_argument(fmt::format("{} {}: expected two counts of {} to {}, for example {}",
                                          option, text, least, most, example));
}

Board BoardOf(const CalibrateOptions& options) {
  if (options.board.empty() || options.square.empty()) {
    throw std::invalid_argument(
        "--left: needs --board, for example 9x6, and --square, for example 25mm");
  }
  Board board;
  board.pattern = PatternOf(options.pattern);
  const auto counts = TwoCounts("--board", options.board, 3, 100, "9x6");
  board.columns = counts[0], board.rows = counts[1];
  board.square = Length("--square", options.square, 1);
  return board;
}

void RequireUsable(const CalibrateOptions& options) {
  const auto require = [](bool usable, const char* words) {
    if (!usable) throw std::invalid_argument(words);
  };
  if (!options.unquoted.empty()) {
    throw std::invalid_argument(options.unquoted.front() +
                                ": expected options only; put the patterns of --left and "
                                "--right in quotes, otherwise the shell expands them");
  }
  const bool has_left = !options.left.empty(), registers = !options.tip_places.empty();
  require(has_left || registers, "calibrate: expected --left, --register, or both");
  require(has_left || options.right.empty(),
          "--right: only with --left; for a single camera use --left");
  require(has_left || options.distance.empty(), "--distance: only with --left");
  require(has_left || options.corners.empty(), "--corners: only with --left");
  require(!has_left || !options.out.empty(), "--left: needs --out, the file to write");
  require(!has_left || options.rig.empty(), "--rig: only without --left, which computes a rig");
  require(!has_left || options.size.empty(),
          "--size: only without --left, whose images have a size");
  require(options.rig.empty() || options.size.empty(),
          "--size: only without --rig, which has a size");
  require(registers || (options.rig.empty() && options.size.empty() && !options.plane),
          "--rig, --size, --plane: only with --register");
  if (has_left) BoardOf(options);  // before any picture is looked for
}

// What is read is not written over.
void RequireOtherThanInputs(const CalibrateOptions& options) {
  std::vector<std::filesystem::path> inputs{options.rig, options.tip_places};
  const auto add = [&](const char* option, const std::string& pattern) {
    if (!pattern.empty())
      std::ranges::move(ListedPictures(option, pattern), std::back_inserter(inputs));
  };
  add("--left", options.left), add("--right", options.right);
  RequireOtherThan("--out", options.out, inputs);
}

StereoRig RigOf(const std::filesystem::path& file) {
  try {
    return ReadRig(file);
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(std::string("--rig ") + error.what());
  }
}

void WriteCorners(const std::filesystem::path& file, const BoardPictures& side) {
  const BoardPicture& last = side.pictures.back();
  if (!last.corners) throw std::runtime_error(last.name + ": " + last.why_not);
  std::string table = "u,v\n";
  for (const cv::Point2f& p : *last.corners) table += fmt::format("{},{}\n", p.x, p.y);
  WriteWholeFile(file, table);
}

CalibrationReport Calibrate(const CalibrateOptions& options, const std::stop_token& stop) {
  const Board board = BoardOf(options);
  ProgressBar bar("calibrate", stop);
  const BoardPictures left = FindBoards("--left", options.left, board, &bar);
  if (!options.corners.empty()) WriteCorners(options.corners, left);
  if (options.right.empty()) {
    bar.Report("lens", 0);
    return CalibrateOneCamera(board, left);
  }
  const BoardPictures right = FindBoards("--right", options.right, board, &bar);
  bar.Report("rig", 0);
  return CalibrateTwoCameras(board, left, right);
}

std::vector<TipPlace> ReadTipPlaces(const std::filesystem::path& file) {
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

void WarnOfUnit(const std::vector<TipPlace>& places) {
  constexpr double kLargest = 2, kSmallest = 2e-5;  // [m]
  Eigen::AlignedBox3d box;
  for (const TipPlace& place : places) box.extend(place.p_S);
  const double span = places.empty() ? 0 : box.sizes().maxCoeff();
  if (!(span > kLargest) && !(span < kSmallest && span > 0)) return;
  std::fprintf(stderr,
               "calibrate: the positions of --register span %.4g m: x, y, z are in metres, these "
               "look like %s\n",
               span, span > kLargest ? "millimetres" : "another unit");
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
        "--register: only with --left, --rig, or --size of a camera that looks straight "
        "down on z = 0");
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
    throw std::invalid_argument("--plane: only with one camera; this rig has two");
  }
  if (in_both && !is_pair) {
    throw std::invalid_argument(
        "--register: u_right, v_right: only with a rig of two "
        "cameras");
  }
  Registered out;
  if (options.plane) {
    out.registration = RegisterLensPlane(rig->left, places);
    out.lines = "intrinsics: " + lens_file.string() + "  # relative to the scene's folder\n" +
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
    out.lines =
        "# for a depth camera; a planar scene needs the lines that --plane prints\n" + out.lines;
  }
  return out;
}

// `rig`: the cameras, nullptr: only the picture's size is known; `lens_file`: of the one camera,
// for the scene's `intrinsics`. The table goes to standard error, the lines to standard output and
// to `out` (empty: not). As RunCalibrate.
int RunRegister(const CalibrateOptions& options, const StereoRig* rig,
                const std::filesystem::path& lens_file, const std::filesystem::path& out) {
  std::vector<TipPlace> places;
  try {
    places = ReadTipPlaces(options.tip_places);
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
  WarnOfUnit(places);
  const Registered found = RegisterWith(options, rig, lens_file, places);
  std::fputs(Words(found.registration).c_str(), stderr);
  if (constexpr double kLargestPixel = 5e-3; found.registration.pixel > kLargestPixel) {
    std::fprintf(stderr, "calibrate: pixel of %.4g mm: larger than 5 mm\n",
                 1e3 * found.registration.pixel);
  }
  const bool is_trusted = found.registration.reasons.empty();
  if (!is_trusted && !options.force) {
    std::fputs("calibrate: rejected, no lines are written; --force writes them\n", stderr);
    return 1;
  }
  const std::string lines = "# for sense.camera\n" + found.lines;
  std::fputs(lines.c_str(), stdout);
  if (!out.empty()) WriteWholeFile(out, lines);
  return is_trusted ? 0 : 1;
}

}  // namespace

int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop) {
  RequireUsable(options);
  RequireOtherThanInputs(options);
  RequireWritable(options.out);  // found now, not after minutes of work
  if (options.left.empty()) {
    if (options.rig.empty()) return RunRegister(options, nullptr, {}, options.out);
    const StereoRig rig = RigOf(options.rig);
    return RunRegister(options, &rig, options.rig, options.out);
  }
  const double distance = options.distance.empty() ? 0 : Length("--distance", options.distance, 10);
  CalibrationReport report = Calibrate(options, stop);
  report.distance = distance;
  report.verdict = EvaluateCalibration(report.question);
  std::fputs(Words(report).c_str(), stdout);
  const bool is_trusted = report.verdict.reasons.empty();
  if (!is_trusted && !options.force) {
    std::fprintf(stderr, "calibrate: rejected, %s is not written (--force writes it): %s\n",
                 options.out.c_str(), report.verdict.reasons.front().c_str());
    return 1;
  }
  WriteRig(options.out, report.rig, !report.is_pair,
           report.is_pair ? Rectification(report.rig) : std::vector<NamedMatrix>());
  if (!options.tip_places.empty()) {
    const int registered = RunRegister(options, &report.rig, options.out, {});
    if (registered != 0) return registered;
  }
  return is_trusted ? 0 : 1;
}

}  // namespace palpate
