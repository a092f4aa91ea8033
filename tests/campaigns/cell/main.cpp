// The program `campaign_cell` simulates presses and plays altered samples to a slave in its
// process, for tests/campaigns/cells.py. It reads requests from the standard input: a line of JSON,
// followed by the images, and answers in the same way.
//
//   run     simulates a press: {kind, scene, overrides, edits, counts, coarse, moves}. Answers with
//           the places in the images, the true forces and the samples
//   replay  {edits, arm_error, samples: [{index, shapes or fingers}]} with the images. Answers with
//           the estimates after rest and the refusal, if any
#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "shared/wire/enum_names.h"
#include "slave/scene/scene_loader.h"
#include "tests/campaigns/cell/edits.h"
#include "tests/campaigns/cell/replay.h"
#include "tests/campaigns/cell/run.h"
#include "tests/support/paths.h"

namespace palpate::campaign {
namespace {

using Eigen::Vector2d;
using nlohmann::json;

json ToJson(const Eigen::VectorXd& v) {
  return std::vector<double>(v.data(), v.data() + v.size());
}

json ToJson(const FingerReading& reading) {
  json out{{"present", reading.present},
           {"channels", std::vector<float>(reading.channels.begin(), reading.channels.end())},
           {"pac", reading.pac},
           {"pdc", reading.pdc}};
  if (reading.X_SF) {
    const Eigen::Matrix4d pose = reading.X_SF->matrix().transpose();
    out["pose"] = std::vector<double>(pose.data(), pose.data() + pose.size());
  }
  return out;
}

FingerReading ReadingOf(const json& in) {
  FingerReading reading;
  reading.present = in.at("present");
  const auto channels = in.at("channels").get<std::vector<float>>();
  reading.channels.resize(channels.size());
  std::ranges::copy(channels, reading.channels.begin());
  reading.pac = in.at("pac");
  reading.pdc = in.at("pdc");
  if (in.contains("pose")) {
    const auto pose = in.at("pose").get<std::vector<double>>();
    reading.X_SF.emplace();
    reading.X_SF->matrix() = Eigen::Matrix4d(pose.data()).transpose();
  }
  return reading;
}

void Answer(const json& line, const std::vector<cv::Mat>& images) {
  std::cout << line.dump() << '\n';
  for (const cv::Mat& image : images) {
    const cv::Mat whole = image.isContinuous() ? image : image.clone();
    std::cout.write(reinterpret_cast<const char*>(whole.data),
                    static_cast<std::streamsize>(whole.total() * whole.elemSize()));
  }
  std::cout.flush();
}

cv::Mat ReadImage(const json& shape, int type) {
  cv::Mat image(shape.at(0), shape.at(1), type);
  std::cin.read(reinterpret_cast<char*>(image.data),
                static_cast<std::streamsize>(image.total() * image.elemSize()));
  if (!std::cin) throw std::runtime_error("images are missing");
  return image;
}

Run Simulate(const json& request) {
  Scene scene =
      LoadScene(SourcePath("/deploy/scenes/" + request.at("scene").get<std::string>() + ".yaml"),
                request.at("overrides").get<std::vector<std::string>>());
  Edit(request.at("edits"), &scene);
  const auto c = request.at("counts").get<std::array<std::size_t, 5>>();
  const Counts counts{c[0], c[1], c[2], c[3], c[4]};
  const std::string kind = request.at("kind");
  if (kind == "pair") return RunOfPair(scene, counts);
  if (kind == "depth") return RunOfDepth(scene, counts);
  if (kind == "fingertips") return RunOfTouch(scene, counts, request.at("coarse"));
  std::vector<Vector2d> moves;
  for (const json& move : request.at("moves")) moves.emplace_back(move.at(0), move.at(1));
  return RunOfCamera(scene, counts, moves);
}

void Describe(const Run& run) {
  std::vector<cv::Mat> images;
  json shots = json::array();
  double peak = 0;
  const auto* tactile = run.scene.sense.Find<Tactile>();
  for (const Shot& shot : run.shots) {
    json out{{"touches", shot.truth.in_contact}, {"views", json::array()}};
    for (const View& view : shot.views) {
      out["views"].push_back(
          {ToJson(view.tip), ToJson(view.pressed), ToJson(view.shaft), view.width});
    }
    peak = std::max(peak, shot.truth.force.norm());
    for (const FingerTruth& finger : shot.truth.fingers) peak = std::max(peak, finger.force.norm());
    for (const cv::Mat& image : {shot.left, shot.right}) {
      if (!image.empty()) images.push_back(image);
    }
    for (std::size_t i = 0; tactile && i < shot.touch.fingers.size(); ++i) {
      out["fingers"].push_back(ToJson(shot.touch.fingers[i]));
    }
    shots.push_back(std::move(out));
  }
  json line{
      {"shots", std::move(shots)}, {"peak", peak}, {"pixel", run.pixel}, {"space", run.space}};
  if (!images.empty()) {
    line["shape"] = {images.front().rows, images.front().cols};
    line["bytes"] = images.front().elemSize();
    line["sides"] = images.size() / run.shots.size();
  }
  if (tactile) line["finger_radius"] = tactile->finger_radius;
  if (tactile) line["pose_tolerance"] = tactile->pose_tolerance;
  Answer(line, images);
}

void Play(const Run& run, const json& request) {
  std::vector<Altered> samples;
  for (const json& in : request.at("samples")) {
    Altered sample;
    sample.index = in.at("index");
    const json shapes = in.value("shapes", json::array());
    const int type = run.shots.front().left.empty() ? CV_8U : run.shots.front().left.type();
    if (!shapes.empty()) sample.left = ReadImage(shapes.at(0), type);
    if (shapes.size() > 1) sample.right = ReadImage(shapes.at(1), type);
    const json fingers = in.value("fingers", json::array());
    for (std::size_t i = 0; i < fingers.size(); ++i) {
      sample.touch.fingers[i] = ReadingOf(fingers[i]);
    }
    samples.push_back(std::move(sample));
  }
  Scene stated = run.scene;
  json rows = json::array(), refused;
  const auto take = [&](std::size_t index, const StateRow& row, const Eigen::Vector3d& truth) {
    rows.push_back({index, row.force ? ToJson(*row.force) : json(), row.sigma,
                    ToString(row.validity),
                    row.check == FailedCheck::kNone ? "" : ToString(row.check), ToJson(truth)});
  };
  try {
    Edit(request.at("edits"), &stated);
    Replay(run, stated, samples, request.at("rest"), request.at("arm_error"), take);
    // The sense refuses with a message; any other exception is a defect.
  } catch (const std::runtime_error& why) {
    refused = why.what();
  } catch (const std::invalid_argument& why) {
    refused = why.what();
  }
  Answer({{"rows", std::move(rows)}, {"refused", refused}}, {});
}

int Main() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("campaign_cell"));
  spdlog::set_level(spdlog::level::err);
  Run run;
  for (std::string line; std::getline(std::cin, line);) {
    const json request = json::parse(line);
    if (request.at("do") == "replay") {
      Play(run, request);
    } else {
      run = Simulate(request);
      Describe(run);
    }
  }
  return 0;
}

}  // namespace
}  // namespace palpate::campaign

int main() {
  try {
    return palpate::campaign::Main();
  } catch (const std::exception& why) {
    std::fprintf(stderr, "campaign_cell: %s\n", why.what());
    return 2;
  }
}
