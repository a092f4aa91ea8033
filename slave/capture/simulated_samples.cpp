#include "slave/capture/simulated_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <unistd.h>

#include "shared/program/program.h"
#include "shared/text/text.h"
#include "shared/wire/fields.h"
#include "slave/program/private_folder.h"
#include "slave/program/run_program.h"

namespace palpate {
namespace {

constexpr const char* kProgram = "palpate-simulator";
constexpr int kUnusable = 2;  // exit code for a scene or argument that is rejected

Eigen::Vector3d VectorFrom(const v1::Vec3& message) {
  return {message.x(), message.y(), message.z()};
}

Time StampFrom(const google::protobuf::Timestamp& message) {
  return Time(std::chrono::seconds(message.seconds()) + std::chrono::nanoseconds(message.nanos()));
}

Eigen::Isometry3d PoseFrom(const v1::Vec3& position,
                           const google::protobuf::RepeatedField<double>& orientation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = VectorFrom(position);
  if (orientation.size() == 4) {
    pose.linear() =
        Eigen::Quaterniond(orientation[0], orientation[1], orientation[2], orientation[3])
            .toRotationMatrix();
  }
  return pose;
}

cv::Mat PixelsFrom(const v1::Image& message) {
  const int type = message.encoding() == v1::Image::ENCODING_GREY16 ? CV_16UC1
                   : message.encoding() == v1::Image::ENCODING_BGR8 ? CV_8UC3
                                                                    : CV_8UC1;
  cv::Mat image(static_cast<int>(message.height()), static_cast<int>(message.width()), type);
  if (image.total() * image.elemSize() != message.data().size()) {
    throw std::runtime_error(fmt::format("{}: an image of {} x {} px has {} bytes", kProgram,
                                         message.width(), message.height(), message.data().size()));
  }
  std::ranges::copy(message.data(), reinterpret_cast<char*>(image.data));
  return image;
}

Truth TruthFrom(const v1::SimulatedTruth& message) {
  Truth truth;
  truth.p_S_tip = VectorFrom(message.p_s_tip());
  truth.in_contact = message.in_contact();
  truth.force = VectorFrom(message.force());
  truth.depth = message.depth();
  truth.solved = message.solved();
  truth.punctured = message.punctured();
  const int fingers = std::min(message.fingertips_size(), static_cast<int>(kMaxFingers));
  for (int i = 0; i < fingers; ++i) {
    const v1::SimulatedFingertip& one = message.fingertips(i);
    truth.fingers[static_cast<std::size_t>(i)] = {PoseFrom(one.p_s_finger(), one.orientation()),
                                                  one.in_contact(), VectorFrom(one.p_s_contact()),
                                                  VectorFrom(one.force()), one.depth()};
  }
  return truth;
}

TactileFrame TactileFrom(const v1::SimulatedSample& message) {
  TactileFrame frame;
  const int fingers = std::min(message.fingertips_size(), static_cast<int>(kMaxFingers));
  for (int i = 0; i < fingers; ++i) {
    const v1::TactileSample& one = message.fingertips(i);
    FingerReading& reading = frame.fingers[static_cast<std::size_t>(i)];
    frame.sequence = one.sequence();
    frame.sensed_at = StampFrom(one.sensed_at());
    reading.present = one.electrodes_size() == kElectrodeCount && one.pressure_size() == 2;
    if (!reading.present) continue;
    std::ranges::copy(one.electrodes(), reading.channels.begin());
    reading.pdc = one.pressure(0);
    reading.pac = one.pressure(1);
  }
  return frame;
}

// Linear between the grid's points; zero outside.
Eigen::Vector3d Interpolated(const v1::DisplacementGrid& grid, const Eigen::Vector2d& p_O) {
  const auto& values = grid.displacements();
  const int side = static_cast<int>(std::lround(std::sqrt(values.size() / 3)));
  const Eigen::Vector2d place =
      (p_O.array() / grid.half_width() + 1) * (0.5 * static_cast<double>(side - 1));
  if (!(place.minCoeff() >= 0 && place.maxCoeff() <= side - 1)) return Eigen::Vector3d::Zero();
  const Eigen::Vector2i cell = place.cast<int>().cwiseMin(side - 2);
  const Eigen::Vector2d share = place - cell.cast<double>();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < 4; ++k) {
    const int x = k % 2, y = k / 2;
    const double weight = (x ? share.x() : 1 - share.x()) * (y ? share.y() : 1 - share.y());
    const float* value = values.data() + 3 * ((cell.y() + y) * side + cell.x() + x);
    sum += weight * Eigen::Map<const Eigen::Vector3f>(value).cast<double>();
  }
  return sum;
}

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("no pipe to palpate-simulator");
    read = ends[0], write = ends[1];
  }
};

std::filesystem::path Simulator() {
  std::filesystem::path program = FindPart(kProgram);
  if (program.empty()) {
    throw std::runtime_error(
        fmt::format("{}: expected beside this program, because the scene is simulated", kProgram));
  }
  return program;
}

std::vector<std::string> Arguments(const Scene& scene, const SimulationOptions& options) {
  std::vector<std::string> words{std::filesystem::absolute(scene.file).string(), "--record", "-"};
  for (const std::string& one : scene.overrides) {
    words.emplace_back("--override");
    words.push_back(one);
  }
  if (options.duration > 0) words.push_back(fmt::format("--duration={}", options.duration));
  if (options.presses > 1) words.push_back(fmt::format("--presses={}", options.presses));
  if (options.surface) words.emplace_back("--surface");
  return words;
}

class RunningSimulation final : public Simulation {
 public:
  RunningSimulation(const Scene& scene, const SimulationOptions& options)
      : description_(fmt::format("simulated by {}", kProgram)),
        program_(Simulator(), Arguments(scene, options), folder_.path(), pipe_.write),
        stream_(pipe_.read) {
    stream_.SetCloseOnDelete(true);
    close(pipe_.write);
    has_first_ = ReadNext();
    if (!has_first_) RequireSuccess();
    Swap();
    const auto& triangles = now_.truth().surface_triangles();
    for (int i = 0; i + 2 < triangles.size(); i += 3) {
      triangles_.push_back({triangles[i], triangles[i + 1], triangles[i + 2]});
    }
  }

  [[nodiscard]] Truth truth() const override { return TruthFrom(now_.truth()); }
  [[nodiscard]] std::optional<TargetTruth> target() const override {
    if (!now_.truth().has_target()) return std::nullopt;
    const v1::SimulatedTarget& target = now_.truth().target();
    return TargetTruth{target.seconds(), PoseFrom(target.p_s_first(), target.orientation_first()),
                       PoseFrom(target.p_s(), target.orientation())};
  }
  [[nodiscard]] std::optional<Eigen::Vector3d> goal() const override {
    if (!now_.truth().has_goal()) return std::nullopt;
    return VectorFrom(now_.truth().goal());
  }
  [[nodiscard]] Eigen::Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const override {
    if (!now_.truth().has_membrane()) return Eigen::Vector3d::Zero();
    return Interpolated(now_.truth().membrane(), p_O);
  }

  [[nodiscard]] SurfaceMesh TrueSurface() const override {
    SurfaceMesh surface{.triangles = triangles_};
    const auto& nodes = now_.truth().surface_nodes();
    for (int i = 0; i + 2 < nodes.size(); i += 3) {
      surface.nodes.push_back(Eigen::Map<const Eigen::Vector3f>(nodes.data() + i).cast<double>());
    }
    return surface;
  }

  const v1::SimulatedSample* Next(const std::stop_token& stop) override {
    return Advance(stop) ? &now_ : nullptr;
  }
  std::unique_ptr<FrameSource> OpenFrames() override {
    return Open<FrameSource, Frame>([](const v1::SimulatedSample& sample) {
      const v1::ImageSample& images = sample.images();
      return Frame{PixelsFrom(images.image()), images.sequence(), StampFrom(images.sensed_at())};
    });
  }
  std::unique_ptr<StereoSource> OpenPairs() override {
    return Open<StereoSource, StereoPair>([](const v1::SimulatedSample& sample) {
      const v1::ImageSample& images = sample.images();
      return StereoPair{PixelsFrom(images.image()),
                        images.has_right() ? PixelsFrom(images.right()) : cv::Mat(),
                        images.sequence(), StampFrom(images.sensed_at()), 0};
    });
  }
  std::unique_ptr<TactileSource> OpenFingertips() override {
    return Open<TactileSource, TactileFrame>(TactileFrom);
  }

 private:
  template <typename Source, typename Sample>
  class Player final : public Source {
   public:
    using Convert = Sample (*)(const v1::SimulatedSample&);
    Player(RunningSimulation* simulation, Convert convert)
        : simulation_(*simulation), convert_(convert) {}
    std::optional<Sample> Next(const std::stop_token& stop) override {
      if (!simulation_.Advance(stop)) return std::nullopt;
      return convert_(simulation_.now_);
    }
    [[nodiscard]] std::string description() const override { return simulation_.description_; }

   private:
    RunningSimulation& simulation_;
    Convert convert_;
  };
  template <typename Source, typename Sample>
  std::unique_ptr<Source> Open(typename Player<Source, Sample>::Convert convert) {
    return std::make_unique<Player<Source, Sample>>(this, convert);
  }

  // Returns false if the simulation has ended or `stop` was requested, which kills it.
  bool Advance(const std::stop_token& stop) {
    if (stop.stop_requested()) return false;
    if (std::exchange(is_first_, false)) return has_first_;
    const std::stop_callback kill(stop, [this] { program_.Kill(); });
    if (!ReadNext()) {
      if (!stop.stop_requested()) RequireSuccess();
      return false;
    }
    Swap();
    return true;
  }
  bool ReadNext() {
    next_.Clear();
    bool at_end = false;
    return google::protobuf::util::ParseDelimitedFromZeroCopyStream(&next_, &stream_, &at_end);
  }
  void Swap() { now_.Swap(&next_); }
  void RequireSuccess() {
    const ProgramEnd end = program_.Wait();
    if (end.status == 0) return;
    std::string why = end.output.substr(0, end.output.find_last_not_of('\n') + 1);
    why = why.substr(why.find_last_of('\n') + 1);
    if (end.status == kUnusable) throw std::invalid_argument(why);
    throw std::runtime_error(fmt::format("{} ended with status {}: {}", kProgram, end.status, why));
  }

  std::string description_;
  PrivateFolder folder_;
  Pipe pipe_;
  RunningProgram program_;
  google::protobuf::io::FileInputStream stream_;
  v1::SimulatedSample now_, next_;             // `now_` is the sample that was returned last
  std::vector<std::array<int, 3>> triangles_;  // of the true surface
  bool has_first_ = false, is_first_ = true;
};

}  // namespace

std::unique_ptr<Simulation> StartSimulation(const Scene& scene, const SimulationOptions& options) {
  return std::make_unique<RunningSimulation>(scene, options);
}

}  // namespace palpate
