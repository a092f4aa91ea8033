#include "tests/promises/devices.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "shared/state/driven_clock.h"
#include "shared/wire/fields.h"
#include "slave/capture/simulated_samples.h"
#include "slave/simulator/program/driver_messages.h"
#include "slave/vision/observation.h"

namespace palpate::promises {
namespace {

constexpr double kTick = 0.002;   // of manipulator and operator [s]
constexpr double kSynthetic = 5;  // duration of samples that are not simulated [s]
// An operator's stroke: largest speed at the tool [m/s] and duration [s].
constexpr double kStrokeSpeed = 0.040, kStroke = 0.1;
constexpr double kLateralFrom = 0.8;  // of a guard, from which strokes go along the surface

void PutTime(double t, google::protobuf::Timestamp* stamp) {
  ToProto(Time{} + Seconds(t), stamp);
}

Samples Simulated(const Scene& scene) {
  const auto simulation = StartSimulation(scene, {});
  Samples samples;
  while (const v1::SimulatedSample* sample = simulation->Next({})) {
    samples.push_back(*sample);
    samples.back().mutable_truth()->clear_membrane();  // large, and compared with nothing
  }
  return samples;
}

// The top of the box of depth-box.yaml, seen from above.
Samples DepthPlane(const Scene& scene, const DepthImages& depth) {
  constexpr int kWidth = 160, kHeight = 120;
  constexpr double kHalfSide = 0.04, kTop = 0.06;  // of the box [m]
  const double distance = depth.X_SD.translation().z() - kTop;
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.5e-3);
  Samples samples;
  for (int k = 0; k < kSynthetic * depth.rate; ++k) {
    v1::SimulatedSample sample;
    cv::Mat image(kHeight, kWidth, CV_16U);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const Eigen::Vector2d ray((x - depth.cx) / depth.fx, (y - depth.cy) / depth.fy);
        const bool is_box = (distance * ray).cwiseAbs().maxCoeff() < kHalfSide;
        const double seen = is_box ? distance + noise(random) : 0;
        image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(std::lround(seen / depth.unit));
      }
    }
    v1::Image* message = sample.mutable_images()->mutable_image();
    message->set_encoding(v1::Image::ENCODING_GREY16);
    message->set_width(kWidth);
    message->set_height(kHeight);
    message->set_data(image.data, image.total() * image.elemSize());
    sample.mutable_images()->set_sequence(static_cast<std::uint64_t>(k) + 1);
    PutTime(k / depth.rate, sample.mutable_images()->mutable_sensed_at());
    ToProto(scene.manipulator.home, sample.mutable_truth()->mutable_p_s_tip());
    samples.push_back(std::move(sample));
  }
  return samples;
}

// One press of 4 N per second after 1.5 s of rest.
Samples Channels(const Scene& scene, const Tactile& tactile) {
  constexpr double kRest = 1.5, kPeak = 4, kNoise = 0.01;
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, kNoise);
  Samples samples;
  for (int k = 0; k < kSynthetic * tactile.rate; ++k) {
    const double t = k / tactile.rate;
    const double swing = std::sin(std::numbers::pi * (t - kRest));
    const double force = t < kRest ? 0 : kPeak * swing * swing;
    v1::SimulatedSample sample;
    v1::TactileSample* message = sample.add_fingertips();
    message->set_sequence(static_cast<std::uint64_t>(k) + 1);
    PutTime(t, message->mutable_sensed_at());
    message->set_finger(tactile.fingers.front().name);
    for (int i = 0; i < tactile.channels.count; ++i) {
      message->add_electrodes(static_cast<float>(10 + i + force + noise(random)));
    }
    ToProto(scene.manipulator.home, sample.mutable_truth()->mutable_p_s_tip());
    sample.mutable_truth()->mutable_force()->set_z(force);
    samples.push_back(std::move(sample));
  }
  return samples;
}

int TypeOf(const v1::Image& image) {
  if (image.encoding() == v1::Image::ENCODING_BGR8) return CV_8UC3;
  return image.encoding() == v1::Image::ENCODING_GREY16 ? CV_16U : CV_8U;
}

double TimeOf(const v1::SimulatedSample& sample) {
  const auto& stamp =
      sample.has_images() ? sample.images().sensed_at() : sample.fingertips(0).sensed_at();
  return static_cast<double>(stamp.seconds()) + 1e-9 * stamp.nanos();
}

}  // namespace

const Samples& SamplesOf(const Scene& scene) {
  static std::map<std::string, Samples> made;
  std::string key = scene.file.string();
  for (const std::string& one : scene.overrides) key += "|" + one;
  const auto found = made.find(key);
  if (found != made.end()) return found->second;
  const auto* depth = scene.sense.Find<DepthImages>();
  const auto* tactile = scene.sense.Find<Tactile>();
  if (IsSimulated(scene)) return made[key] = Simulated(scene);
  if (depth != nullptr) return made[key] = DepthPlane(scene, *depth);
  if (tactile != nullptr) return made[key] = Channels(scene, *tactile);
  throw std::invalid_argument(key + ": nothing here makes samples of this scene");
}

Site::Site(const Scene& scene) : scene_(scene), environment_(MakeSimulatedEnvironment(scene)) {
  environment_->MoveTool(scene.manipulator.home);
  if (scene.sense.Find<Tactile>() != nullptr) {
    fingertips_ = environment_->OpenFingertips(scene, {});
  } else if (HasStereoOrDepth(scene.sense)) {
    pairs_ = environment_->OpenPair(scene, {});
  } else {
    frames_ = environment_->OpenCamera(scene, {});
  }
}

v1::SimulatedTruth Site::MoveTool(const Eigen::Vector3d& p_S_tip) {
  environment_->MoveTool(p_S_tip);
  const Truth truth = environment_->truth();
  v1::SimulatedTruth message;
  ToProto(truth.p_S_tip, message.mutable_p_s_tip());
  ToProto(truth.force, message.mutable_force());
  message.set_in_contact(truth.in_contact);
  message.set_solved(truth.solved);
  return message;
}

v1::SimulatedSample Site::Take(double t) {
  v1::SimulatedSample sample;
  const auto stamped = [t](auto source) {
    source->sensed_at = Time{} + Seconds(t);
    return *source;
  };
  if (fingertips_) {
    const auto messages =
        ToMessages(stamped(fingertips_->Next({})), scene_.sense.Find<Tactile>()->fingers);
    sample.mutable_fingertips()->Assign(messages.begin(), messages.end());
  } else {
    *sample.mutable_images() =
        pairs_ ? ToMessage(stamped(pairs_->Next({}))) : ToMessage(stamped(frames_->Next({})));
  }
  return sample;
}

void Devices::Begin(const Disturbance& event) {
  events_.push_back(event);
  if (event.encoders_scale) p_S_scaled_from_ = VectorOf(reported_.p_s_tip());
  if (event.reset) {
    std::string answer = "accepted";
    std::string why;
    try {
      slave_.ReinitializeTracking();
    } catch (const std::logic_error& error) {
      answer = "refused";
      why = error.what();
    }
    if (answer != *event.reset) throw std::runtime_error("the reset is " + answer + ": " + why);
  }
  command_.p_M = event.command_m.value_or(command_.p_M);
  command_.velocity = event.device_m_s.value_or(command_.velocity);
  if (event.reconnects.value_or(false)) slave_.driven_arm()->Leave(SimulatedDrivers::kId);
  if (event.stop.value_or(false)) {
    slave_.EmergencyStop("by the table");
    stops_.push_back(slave_.Status().stops);
  }
  if (event.stop && !*event.stop) slave_.Reset(stops_.back());
  if (event.reset_of) {
    try {
      slave_.Reset(stops_.at(static_cast<std::size_t>(*event.reset_of) - 1));
    } catch (const std::logic_error&) {  // the phase shows it
    }
  }
  if (!event.operates) return;
  if (operates_.empty()) slave_.BeginOperating();
  if (*event.operates == "engage") ++command_.epoch;
  operates_ = *event.operates;
  pause_ = event.pause_s.value_or(0.02);
  tick_ = 0;
  is_near_ = false;
  if (operates_ != "leave") return;
  slave_.EndOperating();
  operates_.clear();
}

// Moves the device by a tick. Returns whether to send a command: during a stroke, and once when it
// ends.
bool Devices::Stroke() {
  if (!surface_) return false;
  const Eigen::Vector3d in = -surface_->normal;
  const Eigen::Vector3d along =
      std::abs(in.x()) > std::abs(in.y()) ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const auto stroke = std::lround(kStroke / kTick);
  std::vector<Eigen::Vector3d> ways{in};
  if (operates_ == "zigzag") ways = {0.7 * (in + along), 0.7 * (in - along)};
  if (operates_ == "sideways" && is_near_) {
    ways = {along, along, along, -along, -along, -along, in};
  } else if (operates_ == "sideways") {
    is_near_ = force_ > kLateralFrom * scene_.manipulator.force_guard ||
               depth_ > kLateralFrom * scene_.manipulator.depth_guard;
    if (is_near_ || tick_ == stroke) tick_ = is_near_ ? stroke : 1;
  }
  if (tick_ == 0) ++command_.epoch;
  command_.engaged = tick_ < stroke;
  const TeleopTransform& transform = scene_.operator_options.transform;
  command_.velocity = std::min(kStrokeSpeed, scene_.manipulator.max_speed) /
                      transform.position_scale * transform.R_SM.transpose() *
                      ways[command_.epoch % ways.size()];
  if (!command_.engaged) command_.velocity.setZero();
  command_.p_M += kTick * command_.velocity;
  const bool sends = tick_ <= stroke;
  tick_ = (tick_ + 1) % (stroke + std::lround(pause_ / kTick));
  return sends;
}

void Devices::SendCommand() {
  ++command_.sequence;
  command_.sent_at = Clock::now();
  command_.state_sequence = states_;
  slave_.Command(command_);
  sent_.push_back(command_);
  std::size_t back = 0;
  for (const Disturbance& event : events_) {
    back = static_cast<std::size_t>(event.resent.value_or(static_cast<int>(back)));
  }
  if (back > 0 && sent_.size() > back) slave_.Command(sent_[sent_.size() - 1 - back]);
  if (sent_.size() > 100) sent_.pop_front();
}

void Devices::Operate() {
  const bool strokes = operates_ == "inwards" || operates_ == "zigzag" || operates_ == "sideways";
  if (operates_ != "blind") ++states_;
  if (!operates_.empty() && operates_ != "silence" && (!strokes || Stroke())) {
    if (!strokes) {
      command_.engaged = operates_ != "clutch";
      command_.p_M += kTick * command_.velocity;
    }
    SendCommand();
  }
  CompareTarget();
  int every = 1;
  for (const Disturbance& event : events_) every = event.watch_every.value_or(every);
  if (++ticks_ % every == 0) slave_.Watch();
}

void Devices::CompareTarget() {
  if (slave_.Status().phase != Phase::kFollowing) return engaged_at_.reset();
  const Eigen::Vector3d p_S_tip = VectorOf(reported_.p_s_tip());
  if (!engaged_at_ || engaged_epoch_ != command_.epoch) engaged_at_ = {command_.p_M, p_S_tip};
  engaged_epoch_ = command_.epoch;
  const TeleopTransform& transform = scene_.operator_options.transform;
  const Eigen::Vector3d led =
      transform.position_scale * transform.R_SM * (command_.p_M - (*engaged_at_)[0]);
  off_target_ = std::max(off_target_, ((*engaged_at_)[1] + led - p_S_tip).norm());
}

Eigen::Vector3d Devices::EncoderOffset() const {
  Eigen::Vector3d offset(0, 0, 0);
  for (const Disturbance& event : events_) offset = event.encoders_m.value_or(offset);
  return offset;
}

// What the encoders of the manipulator report.
void Devices::Report(double t, v1::SimulatedTruth truth) {
  const Eigen::Vector3d offset = EncoderOffset();
  double scale = 1;
  bool reports = true;
  for (const Disturbance& event : events_) {
    scale = event.encoders_scale.value_or(scale);
    reports = event.driver.value_or(reports);
  }
  if (!reports) return;
  const Eigen::Vector3d tip = VectorOf(truth.p_s_tip()), from = p_S_scaled_from_.value_or(tip);
  ToProto(Eigen::Vector3d(from + scale * (tip - from) + offset), truth.mutable_p_s_tip());
  drivers_.SendReports(truth, Time{} + Seconds(t));
}

void Devices::Await(double t, const std::function<v1::SimulatedTruth(double)>& truth_at) {
  force_ = depth_ = off_target_ = 0;
  for (double at = before_.empty() ? t : t_ + kTick;; at += kTick) {
    if (at > t - kTick / 2) at = t;
    DrivenClock::Reach(DrivenClock::kBegin + Seconds(at));
    reported_ = truth_at(at);
    force_ = std::max(force_, VectorOf(reported_.force()).norm());
    if (surface_) depth_ = std::max(depth_, surface_->Penetration(VectorOf(reported_.p_s_tip())));
    Report(at, reported_);
    Operate();
    if (at >= t) break;
  }
  t_ = t;
}

void Devices::Alter(v1::Image* message, int side, const v1::SimulatedTruth& truth) {
  cv::Mat shown(static_cast<int>(message->height()), static_cast<int>(message->width()),
                TypeOf(*message), message->mutable_data()->data());
  cv::Mat image = shown.clone();
  for (const Disturbance& event : events_) {
    if (event.side && *event.side != side) continue;
    if (event.shift_px) {
      const cv::Matx23d warp(1, 0, event.shift_px->x(), 0, 1, event.shift_px->y());
      cv::warpAffine(image, image, warp, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    }
    if (event.grow) {
      const cv::Point2f middle(0.5F * static_cast<float>(image.cols - 1),
                               0.5F * static_cast<float>(image.rows - 1));
      cv::warpAffine(image, image, cv::getRotationMatrix2D(middle, 0, *event.grow), {},
                     cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    }
    if (event.blur_px) cv::GaussianBlur(image, image, {}, *event.blur_px);
    if (event.light) image.convertTo(image, -1, *event.light);
    if (event.noise) {
      std::normal_distribution<double> normal(0, *event.noise);
      for (auto p = image.datastart; p < image.dataend; ++p) {
        auto& grey = const_cast<unsigned char&>(*p);
        grey = cv::saturate_cast<unsigned char>(grey + normal(random_));
      }
    }
  }
  std::string cover = "none";
  for (const Disturbance& event : events_) cover = event.cover.value_or(cover);
  if (cover == "image") image = cv::Scalar::all(255);
  if (cover == "tip" || cover == "contact" || cover == "object") {
    constexpr int kHalf = 30, kFarther = 90;  // [px]
    const CameraView view(*scene_.sense.Find<Camera>(), image.cols, image.rows);
    const Eigen::Vector2d tip = view.ToImage(VectorOf(truth.p_s_tip()));
    const int wide = cover != "contact" ? kHalf : kFarther;
    const int high = cover != "contact" ? kHalf : kHalf / 2;
    const cv::Rect patch(static_cast<int>(tip.x()) - wide, static_cast<int>(tip.y()) - high,
                         2 * wide, 2 * high);
    const cv::Rect seen = patch & cv::Rect({0, 0}, image.size());
    if (cover == "object") {
      const cv::Mat tool = image(seen).clone();
      image = cv::Scalar::all(90);
      tool.copyTo(image(seen));
    } else {
      image(seen) = cv::Scalar::all(90);
    }
  }
  image.copyTo(shown);
}

void Devices::Alter(v1::TactileSample* sample, const v1::SimulatedTruth& truth) {
  const v1::TactileSample read = *sample;
  bool is_stuck = false;
  for (const Disturbance& event : events_) {
    is_stuck = is_stuck || event.stuck.value_or(false);
    if (event.poses.value_or(false)) {
      const Eigen::Isometry3d& X_SF = scene_.sense.Find<Tactile>()->fingers.front().X_SF;
      const Eigen::Vector3d moved = VectorOf(truth.p_s_tip()) - scene_.manipulator.home;
      const Eigen::Quaterniond R_SF(X_SF.linear());
      ToProto(Eigen::Vector3d(X_SF.translation() + moved), sample->mutable_p_s_finger());
      sample->clear_orientation();
      for (const double q : {R_SF.w(), R_SF.x(), R_SF.y(), R_SF.z()}) sample->add_orientation(q);
    }
    for (int i = 0; i < sample->electrodes_size(); ++i) {
      if (event.channel && *event.channel != i) continue;
      float& e = sample->mutable_electrodes()->at(i);
      if (event.value) e = static_cast<float>(*event.value);
      if (event.add) e += static_cast<float>(*event.add);
      if (event.most) e = std::min(e, static_cast<float>(*event.most));
      if (event.stuck.value_or(false)) e = held_.electrodes(i);
    }
  }
  if (!is_stuck) held_ = read;
}

// Repeats the last sample of a camera or of all fingertips.
void Devices::Freeze(int side, v1::SimulatedSample* sample) const {
  const v1::SimulatedSample& last = before_.back();
  if (last.has_images()) {
    v1::ImageSample* images = sample->mutable_images();
    if (side == 0) *images->mutable_image() = last.images().image();
    if (side == 1 && images->has_right()) *images->mutable_right() = last.images().right();
  }
  for (int i = 0; i < sample->fingertips_size(); ++i) {
    *sample->mutable_fingertips(i)->mutable_electrodes() = last.fingertips(i).electrodes();
    *sample->mutable_fingertips(i)->mutable_pressure() = last.fingertips(i).pressure();
  }
}

Seen Devices::Send(v1::SimulatedSample sample) {
  const double t = TimeOf(sample), begin = t_;
  const Eigen::Vector3d from = VectorOf(reported_.p_s_tip());
  const Eigen::Vector3d to = VectorOf(sample.truth().p_s_tip());
  Await(t, [&](double at) {
    // Targets are sent while its stream is open.
    if (slave_.driven_arm() != nullptr) static_cast<void>(slave_.driven_arm()->Aim(Clock::now()));
    v1::SimulatedTruth truth = sample.truth();
    const double share = at < t ? (at - begin) / (t - begin) : 1;
    ToProto(Eigen::Vector3d(from + share * (to - from)), truth.mutable_p_s_tip());
    return truth;
  });
  return Sense(t, std::move(sample));
}

Seen Devices::Follow(double t, Site* site) {
  if (before_.empty()) p_S_tip_ = scene_.manipulator.home;
  Await(t, [&](double) {
    const ArmAim aim = slave_.driven_arm()->Aim(Clock::now());
    if (aim.motion == ArmAim::Motion::kFollow) p_S_tip_ = aim.p_S_tip - EncoderOffset();
    return site->MoveTool(p_S_tip_);
  });
  v1::SimulatedSample sample = site->Take(t);
  *sample.mutable_truth() = reported_;
  return Sense(t, std::move(sample));
}

Seen Devices::Sense(double t, v1::SimulatedSample sample) {
  const v1::SimulatedSample now = sample;
  bool is_silent = false, is_absent = false, is_exchanged = false;
  std::array<bool, 2> is_frozen{false, false};
  std::array<int, 2> late{0, 0};
  double delay = 0;
  for (const Disturbance& event : events_) {
    is_silent = event.silent.value_or(is_silent);
    is_absent = event.absent.value_or(is_absent);
    is_exchanged = event.exchanged.value_or(is_exchanged);
    delay = event.delay_s.value_or(delay);
    for (int side = 0; side < 2; ++side) {
      if (event.side.value_or(side) != side) continue;
      const auto k = static_cast<std::size_t>(side);
      is_frozen[k] = event.frozen.value_or(is_frozen[k]);
      late[k] = event.late.value_or(late[k]);
    }
  }
  const auto shown = [&](int back) -> const v1::SimulatedSample& {
    const auto n = static_cast<int>(before_.size());
    return back == 0 || n == 0 ? now : before_[static_cast<std::size_t>(std::max(0, n - back))];
  };
  if (sample.has_images()) {
    v1::ImageSample* images = sample.mutable_images();
    *images->mutable_image() = shown(late[0]).images().image();
    if (images->has_right()) *images->mutable_right() = shown(late[1]).images().right();
    Alter(images->mutable_image(), 0, sample.truth());
    if (images->has_right()) Alter(images->mutable_right(), 1, sample.truth());
    if (is_exchanged) images->mutable_image()->Swap(images->mutable_right());
    images->set_delay(delay);
  } else {
    Alter(sample.mutable_fingertips(0), sample.truth());
  }
  for (const int side : {0, 1}) {
    if (is_frozen[static_cast<std::size_t>(side)]) Freeze(side, &sample);
  }
  if (is_frozen == std::array{false, false}) {
    before_.push_back(now);
    if (before_.size() > 20) before_.pop_front();
  }
  if (!is_silent && sample.has_images()) drivers_.SendImages(sample.images());
  for (int i = is_absent ? 1 : 0; i < sample.fingertips_size() && !is_silent; ++i) {
    drivers_.SendTactile(sample.fingertips(i));
  }
  slave_.Step({});
  static_cast<void>(slave_.Patch());
  Seen seen{.t = t, .state = slave_.Compose(Clock::now()), .truth = sample.truth()};
  seen.force = force_;
  seen.depth = depth_;
  seen.off_target = off_target_;
  if (!surface_ && seen.state.local_model.known()) surface_ = seen.state.local_model;
  seen.events = slave_.TakeEvents();
  seen.alarms = slave_.Status().alarms;
  return seen;
}

}  // namespace palpate::promises
