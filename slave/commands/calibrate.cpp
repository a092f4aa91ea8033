#include "slave/commands/calibrate.h"

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/scene/units.h"
#include "slave/commands/calibrate_pictures.h"
#include "slave/commands/calibrate_report.h"
#include "slave/commands/csv_table.h"

namespace palpate {
namespace {

// `9x6`
std::array<int, 2> TwoCounts(const std::string& option, const std::string& text, int least,
                             int most) {
  const auto cross = text.find_first_of("xX");
  if (cross != std::string::npos) {
    const auto a = ParseInteger(text.substr(0, cross)), b = ParseInteger(text.substr(cross + 1));
    if (a && b && *a >= least && *a <= most && *b >= least && *b <= most) {
      return {static_cast<int>(*a), static_cast<int>(*b)};
    }
  }
  throw std::invalid_argument(fmt::format("{} {}: accepted is two counts of {} to {} as in {}x{}",
                                          option, text, least, most, least + 6, least + 3));
}

Board BoardOf(const CalibrateOptions& options) {
  Board board;
  if (options.pattern == "circles") {
    board.pattern = Board::Pattern::kCircles;
  } else if (options.pattern != "chessboard") {
    throw std::invalid_argument("--pattern " + options.pattern +
                                ": accepted is chessboard or circles");
  }
  if (options.board.empty() || options.square.empty()) {
    throw std::invalid_argument(
        "--left: accepted is with --board, 9x6 say, and --square, 25mm say");
  }
  const auto counts = TwoCounts("--board", options.board, 3, 100);
  board.columns = counts[0], board.rows = counts[1];
  const auto square = ParseQuantity(options.square, Dimension::kLength);
  if (!square || !(*square >= 1e-6 && *square <= 10)) {
    throw std::invalid_argument("--square " + options.square + ": accepted is " +
                                AcceptedUnits(Dimension::kLength) + ", 1 um to 10 m");
  }
  board.square = *square;
  return board;
}

void RequireUsable(const CalibrateOptions& options) {
  if (options.left.empty() && options.tip_places.empty()) {
    throw std::invalid_argument("calibrate: accepted is --left, --register, or both");
  }
  if (options.left.empty() && !options.right.empty()) {
    throw std::invalid_argument("--right: accepted is with --left; one camera alone is --left");
  }
  if (!options.left.empty() && options.out.empty()) {
    throw std::invalid_argument("--left: accepted is with --out, the file to write");
  }
  if (!options.left.empty() && !options.rig.empty()) {
    throw std::invalid_argument("--rig: accepted is without --left, which makes one");
  }
  if (!options.rig.empty() && !options.size.empty()) {
    throw std::invalid_argument("--size: accepted is without --rig, which says it");
  }
}

CalibrationRow RowOf(const std::string& name, const Corners& left, const Board& board) {
  CalibrationRow row;
  row.name = name;
  row.used = true;
  row.left = left;
  row.pixel = PixelOnBoard(left, board);
  return row;
}

CalibrationReport OneCamera(const Board& board, const BoardPictures& side) {
  CalibrationReport report;
  report.board = board;
  std::vector<Corners> views;
  for (const BoardPicture& picture : side.pictures) {
    CalibrationRow row;
    row.name = picture.name;
    row.why_not = picture.why_not;
    if (picture.corners) {
      row = RowOf(picture.name, *picture.corners, board);
      views.push_back(*picture.corners);
    }
    report.rows.push_back(std::move(row));
  }
  if (views.size() < 3) {
    throw std::runtime_error(fmt::format(
        "{} pictures show the board: accepted is 3 or more for a lens. Pixel size on the board of "
        "{}, if it is seen straight on: {:.5g} mm",
        views.size(), report.rows.front().name, 1e3 * PixelOnBoard(views.front(), board)));
  }
  const LensCalibration fit = CalibrateLens(board, views, side.size);
  report.rig.left = fit.lens;
  report.rig.rms_px = fit.rms_px;
  for (std::size_t i = 0, k = 0; i < report.rows.size(); ++i) {
    if (!report.rows[i].used) continue;
    report.rows[i].left_px = fit.view_rms_px[k];
    report.rows[i].X_LB = fit.X_CB[k++];
  }
  TrustQuestion& question = report.question;
  question.quantity = "focal length";
  question.used = question.given = views.size();
  question.rms_px = fit.rms_px;
  question.sigma_focal = fit.sigma_focal;
  question.halves = CheckHalves(board, views, side.size, std::sqrt(fit.lens.fx * fit.lens.fy));
  question.coverage = {CoverageOf(views, side.size)};
  return report;
}

// Which pictures the pairs are of, and why some are none.
struct MatchedPairs {
  std::vector<PairView> views;
  std::vector<std::size_t> rows;  // of each view
};

MatchedPairs Match(const BoardPictures& left, const BoardPictures& right,
                   CalibrationReport* report) {
  MatchedPairs out;
  const auto matches = MatchPictures(left, right);
  for (const auto& [i, j] : matches) {
    const BoardPicture &a = left.pictures[i], &b = right.pictures[j];
    CalibrationRow row;
    row.name = a.name + " " + b.name;
    if (a.corners && b.corners) {
      row = RowOf(row.name, *a.corners, report->board);
      row.right = *b.corners;
      out.views.push_back({row.left, row.right});
      out.rows.push_back(report->rows.size());
    } else {
      row.why_not = a.corners ? b.name + ": " + b.why_not : a.name + ": " + a.why_not;
    }
    report->rows.push_back(std::move(row));
  }
  const std::size_t alone = left.pictures.size() + right.pictures.size() - 2 * matches.size();
  if (alone > 0) {
    report->notes.push_back(fmt::format("pictures without a partner on the other side: {}", alone));
  }
  return out;
}

void FillRows(const PairCalibration& pair, const MatchedPairs& matched, CalibrationReport* report) {
  for (std::size_t k = 0; k < pair.used.size(); ++k) {
    CalibrationRow& row = report->rows[matched.rows[pair.used[k]]];
    row.left_px = pair.fit.left_px[k];
    row.right_px = pair.fit.right_px[k];
    row.X_LB = pair.fit.X_LB[k];
  }
  for (const auto& dropped : pair.dropped) {
    CalibrationRow& row = report->rows[matched.rows[dropped.pair]];
    row.used = false;
    row.why_not = fmt::format(
        "off by {:.2f} px from what the other pairs agree on: the board moved between the shots, "
        "or "
        "they do not belong together",
        dropped.miss_px);
  }
}

void PutSidesRight(CalibrationReport* report) {
  std::swap(report->question.coverage[0], report->question.coverage[1]);
  for (CalibrationRow& row : report->rows) {
    std::swap(row.left, row.right);
    std::swap(row.left_px, row.right_px);
    row.X_LB = report->rig.X_RL * row.X_LB;
  }
  report->rig = Exchanged(report->rig);
  report->notes.emplace_back(
      "left and right are exchanged: the camera given as --left stands right of the other. The rig "
      "is written with the sides put right; give a scene its pictures so, too");
}

CalibrationReport TwoCameras(const Board& board, const BoardPictures& left,
                             const BoardPictures& right) {
  CalibrationReport report;
  report.board = board;
  report.is_pair = true;
  const MatchedPairs matched = Match(left, right, &report);
  const PairSizes sizes{left.size, right.size};
  const PairCalibration pair = CalibratePair(board, matched.views, sizes);
  FillRows(pair, matched, &report);
  report.rig = pair.fit.rig;
  std::vector<Corners> lefts, rights;
  for (const PairView& view : pair.views) {
    lefts.push_back(view.left);
    rights.push_back(view.right);
  }
  TrustQuestion& question = report.question;
  question.used = pair.used.size();
  question.given = matched.views.size();
  question.rms_px = report.rig.rms_px;
  question.sigma_focal = pair.fit.sigma_focal;
  question.halves = CheckHalves(board, pair.views, report.rig);
  question.coverage = {CoverageOf(lefts, left.size), CoverageOf(rights, right.size)};
  if (AreSidesExchanged(report.rig)) PutSidesRight(&report);
  return report;
}

CalibrationReport Calibrate(const CalibrateOptions& options, const std::stop_token& stop) {
  const Board board = BoardOf(options);
  ProgressBar bar("calibrate", stop);
  const BoardPictures left = FindBoards("--left", options.left, board, &bar);
  if (options.right.empty()) {
    bar.Report("lens", 0);
    return OneCamera(board, left);
  }
  const BoardPictures right = FindBoards("--right", options.right, board, &bar);
  bar.Report("rig", 0);
  return TwoCameras(board, left, right);
}

std::vector<TipPlace> ReadTipPlaces(const std::filesystem::path& file) {
  constexpr CsvTable::Column kColumns[] = {
      {"x"}, {"y"}, {"z"}, {"u"}, {"v"}, {"u_right", false}, {"v_right", false}};
  const CsvTable table(file, kColumns);
  if (table.Has("u_right") != table.Has("v_right")) {
    throw InputError(file.string() + ":1: accepted is u_right and v_right, or neither");
  }
  std::vector<TipPlace> places(table.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    places[i].p_S = {table.Number(i, "x"), table.Number(i, "y"), table.Number(i, "z")};
    places[i].left_I = {table.Number(i, "u"), table.Number(i, "v")};
    if (table.Has("u_right")) {
      places[i].right_I = Eigen::Vector2d(table.Number(i, "u_right"), table.Number(i, "v_right"));
    }
  }
  return places;
}

// The lines of `sense.camera`.
std::string SceneLines(const CameraRegistration& registration) {
  std::string lines;
  if (registration.pixel > 0) lines = fmt::format("pixel: {:.8g} mm\n", 1e3 * registration.pixel);
  return lines + ScenePose(registration.X_SC) + "\n";
}

CameraRegistration RegisterWith(const CalibrateOptions& options, const StereoRig* rig,
                                const std::vector<TipPlace>& places) {
  const bool in_both = !places.empty() && places.front().right_I;
  if (rig == nullptr) {
    if (options.size.empty()) {
      throw std::invalid_argument(
          "--register: accepted is with --left, --rig, or --size of a camera straight above z = 0");
    }
    return RegisterPlane(TwoCounts("--size", options.size, 1, 100000), places);
  }
  if (!in_both) return RegisterLens(rig->left, places);
  if (!(rig->baseline() > 0)) {
    throw std::invalid_argument(
        "--register: u_right,v_right: accepted is with a rig of two cameras");
  }
  return RegisterPair(*rig, places);
}

// `out` empty: standard output only.
int Register(const CalibrateOptions& options, const StereoRig* rig,
             const std::filesystem::path& out) {
  std::vector<TipPlace> places;
  try {
    places = ReadTipPlaces(options.tip_places);
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
  const CameraRegistration registration = RegisterWith(options, rig, places);
  std::fputs(Words(registration).c_str(), stderr);
  if (!registration.reasons.empty() && !options.force) return 1;
  const std::string lines = SceneLines(registration);
  std::fputs(lines.c_str(), stdout);
  if (!out.empty()) {
    std::ofstream stream(out);
    stream << lines;
    stream.close();
    if (!stream) throw std::runtime_error(out.string() + ": cannot be written");
  }
  return registration.reasons.empty() ? 0 : 1;
}

}  // namespace

int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop) {
  RequireUsable(options);
  if (options.left.empty()) {
    if (options.rig.empty()) return Register(options, nullptr, options.out);
    const StereoRig rig = ReadRig(options.rig);
    return Register(options, &rig, options.out);
  }
  CalibrationReport report = Calibrate(options, stop);
  report.trust = Judge(report.question);
  std::fputs(Words(report).c_str(), stdout);
  if (!options.drawing.empty()) WriteDrawing(options.drawing, report);
  const bool is_trusted = report.trust.reasons.empty();
  if (!is_trusted && !options.force) {
    std::fprintf(stderr, "calibrate: refused, %s is not written: %s\n", options.out.c_str(),
                 report.trust.reasons.front().c_str());
    return 1;
  }
  WriteRig(options.out, report.rig, !report.is_pair);
  if (!options.tip_places.empty()) {
    const int registered = Register(options, &report.rig, {});
    if (registered != 0) return registered;
  }
  return is_trusted ? 0 : 1;
}

}  // namespace palpate
