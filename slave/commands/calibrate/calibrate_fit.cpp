#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slave/commands/calibrate/calibrate_report.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

CalibrationRow RowOf(const BoardPicture& picture) {
  CalibrationRow row;
  row.name = picture.name;
  row.why_not = picture.why_not;
  row.used = picture.corners.has_value();
  return row;
}

// Fitting a rig takes the middle of a circle's picture for the picture of its middle.
void NoteCircles(CalibrationReport* report) {
  if (report->board.pattern == Board::Pattern::kChessboard) return;
  const double radius = report->board.square / 4;
  double most = 0;
  for (const CalibrationRow& row : report->rows) {
    if (!row.used) continue;
    for (const cv::Point3f& p : BoardPoints(report->board)) {
      const Eigen::Vector3d p_C = row.X_LB * Eigen::Vector3d(p.x, p.y, p.z);
      const auto bias = CircleCentroidBias(report->rig.left, p_C, row.X_LB.linear().col(2), radius);
      if (bias) most = std::max(most, bias->norm());
    }
  }
  report->notes.push_back(
      fmt::format("perspective shifts the image centres of circles by up to {:.2g} px if they are "
                  "{:.3g} mm wide: use smaller circles or a chessboard",
                  most, 2e3 * radius));
}

CalibrationEvidence QuestionOf(const Board& board, const CameraCalibration& camera,
                               const std::vector<Corners>& views, const std::array<int, 2>& size) {
  const Lens& lens = camera.fit.lens;
  CalibrationEvidence question;
  question.quantity = "focal length";
  question.things = "images";
  question.used = camera.used.size();
  question.given = camera.used.size() + camera.dropped.size();
  question.rms_px = camera.fit.rms_px;
  question.sigma_focal = camera.fit.sigma_focal;
  question.halves = CheckHalves(board, views, size, std::sqrt(lens.fx * lens.fy));
  question.coverage = {CoverageOf(views, size)};
  return question;
}

// Which pictures the pairs are of, and why some are none.
struct MatchedPairs {
  std::vector<PairView> views;
  std::vector<std::size_t> rows;  // of each view
};

// Names of the pictures of `side` that are not `matched`; what is no picture is noted.
std::vector<std::string> PicturesBut(const std::set<std::size_t>& matched,
                                     const BoardPictures& side, CalibrationReport* report) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < side.pictures.size(); ++i) {
    if (matched.count(i) > 0) continue;
    const BoardPicture& picture = side.pictures[i];
    if (picture.is_readable) {
      names.push_back(picture.name);
    } else {
      report->notes.push_back("not used: " + picture.why_not);
    }
  }
  return names;
}

MatchedPairs Match(const BoardPictures& left, const BoardPictures& right,
                   CalibrationReport* report) {
  MatchedPairs out;
  const auto matches = MatchPictures(left, right);
  for (const auto& [i, j] : matches) {
    const BoardPicture &a = left.pictures[i], &b = right.pictures[j];
    CalibrationRow row = RowOf(a);
    row.right_name = b.name;
    if (a.corners && b.corners) {
      out.views.push_back({*a.corners, *b.corners});
      out.rows.push_back(report->rows.size());
    } else {
      row.used = false;
      row.why_not = a.corners ? b.name + ": " + b.why_not : a.name + ": " + a.why_not;
    }
    report->rows.push_back(std::move(row));
  }
  std::set<std::size_t> of_left, of_right;
  for (const auto& [i, j] : matches) of_left.insert(i), of_right.insert(j);
  std::vector<std::string> alone = PicturesBut(of_left, left, report);
  for (std::string& name : PicturesBut(of_right, right, report)) alone.push_back(std::move(name));
  if (!alone.empty()) {
    report->notes.push_back(fmt::format("images without a partner on the other side: {} ({})",
                                        alone.size(), fmt::join(alone, ", ")));
  }
  return out;
}

void RequireEnough(const MatchedPairs& matched, const CalibrationReport& report) {
  if (matched.views.size() >= 3) return;
  std::string words = fmt::format(
      "{} of {} pairs show the board in both images: expected 3 or more, 4 or more to be "
      "trusted",
      matched.views.size(), report.rows.size());
  for (const CalibrationRow& row : report.rows) {
    if (!row.used) words += "; " + row.why_not;
  }
  for (const std::string& note : report.notes) words += "; " + note;
  throw std::runtime_error(words);
}

// Size of a pixel on the board [m], from the distance of neighbouring corners.
double PixelOnBoard(const Corners& corners, const Board& board) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) {
    if (i % static_cast<std::size_t>(board.columns) == 0) continue;
    sum += std::hypot(corners[i].x - corners[i - 1].x, corners[i].y - corners[i - 1].y);
    ++count;
  }
  return sum > 0 ? board.square * count / sum : 0;
}

void FillRows(const PairCalibration& pair, const MatchedPairs& matched, CalibrationReport* report) {
  for (std::size_t k = 0; k < pair.used.size(); ++k) {
    CalibrationRow& row = report->rows[matched.rows[pair.used[k]]];
    row.left_px = pair.fit.left_px[k];
    row.right_px = pair.fit.right_px[k];
    row.X_LB = pair.fit.X_LB[k];
    row.pixel = PixelOnBoard(pair.views[k].left, report->board);
    row.right_pixel = PixelOnBoard(pair.views[k].right, report->board);
  }
  for (const auto& dropped : pair.dropped) {
    CalibrationRow& row = report->rows[matched.rows[dropped.pair]];
    row.used = false;
    row.why_not = fmt::format(
        "deviates by {:.2f} px from the other pairs: the board moved between the two exposures, or "
        "the images are not of one pair",
        dropped.miss_px);
  }
}

void ExchangeSides(CalibrationReport* report) {
  std::swap(report->question.coverage[0], report->question.coverage[1]);
  const Eigen::Isometry3d X_RL = report->rig.X_RL;
  report->rig = Exchanged(report->rig);
  for (CalibrationRow& row : report->rows) {
    std::swap(row.name, row.right_name);
    std::swap(row.left_px, row.right_px);
    row.X_LB = X_RL * row.X_LB;
    std::swap(row.pixel, row.right_pixel);
  }
  report->notes.emplace_back(
      "left and right are exchanged: the camera given as --left is to the right of the other (or "
      "both are upside down). The rig is written with corrected sides: exchange the images in the "
      "scene as well");
}

}  // namespace

CalibrationReport CalibrateOneCamera(const Board& board, const BoardPictures& side) {
  CalibrationReport report;
  report.board = board;
  std::vector<Corners> views;
  std::vector<std::size_t> rows;  // of each view
  for (const BoardPicture& picture : side.pictures) {
    report.rows.push_back(RowOf(picture));
    if (!picture.corners) continue;
    views.push_back(*picture.corners);
    rows.push_back(report.rows.size() - 1);
  }
  if (views.size() < 3) {
    throw std::runtime_error(fmt::format(
        "{} of {} images show the board: expected 3 or more for a lens, 4 or more for one that "
        "can be checked. Pixel size on the board of {}, if the view is perpendicular: {:.5g} mm",
        views.size(), side.pictures.size(), report.rows[rows.front()].name,
        1e3 * PixelOnBoard(views.front(), board)));
  }
  const CameraCalibration camera = CalibrateCamera(board, views, side.size);
  report.rig.left = camera.fit.lens;
  report.rig.rms_px = camera.fit.rms_px;
  std::vector<Corners> used;
  for (std::size_t k = 0; k < camera.used.size(); ++k) {
    CalibrationRow& row = report.rows[rows[camera.used[k]]];
    row.left_px = camera.fit.view_rms_px[k];
    row.X_LB = camera.fit.X_CB[k];
    row.pixel = PixelOnBoard(views[camera.used[k]], board);
    used.push_back(views[camera.used[k]]);
  }
  for (const auto& dropped : camera.dropped) {
    CalibrationRow& row = report.rows[rows[dropped.view]];
    row.used = false;
    row.why_not = fmt::format(
        "its corners deviate by {:.2f} px from the other images: blurred, bent, or of another "
        "board or camera",
        dropped.miss_px);
  }
  report.question = QuestionOf(board, camera, used, side.size);
  NoteCircles(&report);
  return report;
}

CalibrationReport CalibrateTwoCameras(const Board& board, const BoardPictures& left,
                                      const BoardPictures& right) {
  CalibrationReport report;
  report.board = board;
  report.is_pair = true;
  const MatchedPairs matched = Match(left, right, &report);
  RequireEnough(matched, report);
  const PairCalibration pair = CalibratePair(board, matched.views, {left.size, right.size});
  report.rig = pair.fit.rig;
  FillRows(pair, matched, &report);
  std::vector<Corners> lefts, rights;
  for (const PairView& view : pair.views) {
    lefts.push_back(view.left);
    rights.push_back(view.right);
  }
  CalibrationEvidence& question = report.question;
  question.used = pair.used.size();
  question.given = matched.views.size();
  question.rms_px = report.rig.rms_px;
  question.sigma_focal = pair.fit.sigma_focal;
  question.halves = CheckHalves(board, pair.views, report.rig);
  question.coverage = {CoverageOf(lefts, left.size), CoverageOf(rights, right.size)};
  if (EvaluateCalibration(question).reasons.empty() && AreSidesExchanged(report.rig)) {
    ExchangeSides(&report);
  }
  NoteCircles(&report);
  return report;
}

}  // namespace palpate
