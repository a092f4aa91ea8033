#include "tests/slave/service/fake_slave.h"

#include <algorithm>
#include <stdexcept>
#include <thread>

#include "slave/program/progress.h"

namespace palpate {
namespace {

constexpr double kReach = 1;  // [m]; positions beyond it are refused
constexpr std::size_t kRemembered = 10'000;

}  // namespace

FakeSlave::FakeSlave() {
  state_.p_S_tip = {0, kHome, 0};
  state_.sensed_at = started_at_;
  state_.force = state_.true_force = Eigen::Vector3d::Zero();
  state_.validity = Validity::kValid;
  state_.local_model.stiffness(1, 1) = kStiffness;
  state_.local_model.valid_radius = 0.01;
  state_.local_model.revision = state_.sample = 1;
  estimate_.Put(state_);
}

void FakeSlave::TakeSample() {
  const std::scoped_lock lock(mutex_);
  ++state_.sample;
  const Time at = state_.sensed_at = std::max(Clock::now(), state_.sensed_at + Clock::duration(1));
  const double depth = std::max(0.0, -state_.p_S_tip.y());
  state_.force = state_.true_force = Eigen::Vector3d(0, kStiffness * depth, 0);
  state_.local_model.in_contact = depth > 0;
  estimate_.Put(state_, {state_.sample, at, at, at, at});
}

void FakeSlave::TakeTactile(const std::vector<std::string>& fingers) {
  const std::scoped_lock lock(mutex_);
  Tactile& tactile = tactile_.emplace();
  tactile.source = Tactile::Source::kStream;
  tactile.network = "nets/rnn_21/";
  for (const std::string& name : fingers) tactile.fingers.emplace_back().name = name;
  tactile.fingers.front().X_SF.translation() = Eigen::Vector3d(0.1, 0.2, 0.3);
  inbox_ = std::make_unique<TactileInbox>(tactile);
}

TactileInbox* FakeSlave::tactile_inbox() {
  const std::scoped_lock lock(mutex_);
  return inbox_.get();
}

void FakeSlave::TakeImages() {
  Scene scene;
  Camera camera;
  camera.source = Camera::Source::kStream;
  camera.size = {64, 48};
  camera.rate = 30;
  scene.sense.Set(CameraOptions{.camera = camera});
  pushed_ = std::make_unique<ImageInbox>(scene);
}

void FakeSlave::TakeArm(const ManipulatorOptions& options) {
  arm_ = std::make_unique<StreamedManipulator>(options);
}

void FakeSlave::BeginOperating() {
  const std::scoped_lock lock(mutex_);
  ++begins_;
  commands_.clear();
  state_.command_sequence = 0;
  state_.echo.reset();
  state_.epoch = 0;
}

bool FakeSlave::Command(const OperatorCommand& command) noexcept {
  const std::scoped_lock lock(mutex_);
  ++came_;
  if (!command.p_M.allFinite() || command.p_M.norm() > kReach) {
    ++refused_;
    estimate_.Add(Event::kCommandRefused);
    return false;
  }
  if (command.sequence <= state_.command_sequence) return true;
  if (commands_.size() < kRemembered) commands_.push_back(command);
  state_.command_sequence = command.sequence;
  state_.echo = command.sent_at;
  command_at_ = Clock::now();
  if (state_.phase == Phase::kEstop) return true;
  state_.phase = command.engaged ? Phase::kFollowing : Phase::kClutched;
  if (!command.engaged) return true;
  if (command.epoch != state_.epoch) transform_.ZeroOffset(command.p_M, state_.p_S_tip);
  state_.epoch = command.epoch;
  state_.offset = transform_.offset;
  state_.p_S_tip = transform_.ToSlave(command.p_M);
  return true;
}

void FakeSlave::EndOperating() {
  const std::scoped_lock lock(mutex_);
  ++ends_;
  if (state_.phase != Phase::kEstop) state_.phase = Phase::kReady;
}

SlaveState FakeSlave::Compose(Time now) {
  const std::scoped_lock lock(mutex_);
  SlaveState state = state_;
  state.sent_at = now;
  state.details = {.score = 0.75, .camera_motion = 1.5};
  state.moment = Eigen::Vector3d(0, 0, 2e-3);
  state.moment_sigma = 1e-4;
  if (state.echo) state.echo_delay = std::max(0.0, SecondsBetween(command_at_, now));
  if (!tactile_) return state;
  state.finger_count = static_cast<int>(tactile_->fingers.size());
  FingerState estimate;  // the estimate of each finger
  estimate.p_S_contact = state.p_S_tip.cast<float>();
  if (state.force) estimate.force = state.force->cast<float>();
  estimate.in_contact = state.local_model.in_contact;
  estimate.validity = state.validity;
  state.fingers.fill(estimate);
  return state;
}

SlaveDescription FakeSlave::Describe() const {
  const std::scoped_lock lock(mutex_);
  SlaveDescription description;
  description.scene.name = "spring-surface";
  description.settings_revision = state_.settings_revision;
  description.scene.manipulator.source = manipulator_;
  description.scene.object.geometry = RectangleGeometry{0.088, 0.088, 0.009};
  description.scene.object.material = {127e3, 0.49, 1050, 0};
  if (!tactile_) description.scene.sense.Set(CameraOptions{.camera = Camera{}});
  if (tactile_) description.scene.sense.Set(*tactile_);
  description.scene.operator_options.force_limit = parameters_.force_limit.value_or(3.3);
  description.sense.model.kind = "spring";
  description.sense.model.dof = 1;
  description.sense.model.elements = 4;
  description.sense.model.range = 0.05;
  description.sense.reason = "it is a fake";
  description.sense.source = "none";
  description.simulated = true;
  return description;
}

SlaveStatus FakeSlave::Status() const {
  const std::scoped_lock lock(mutex_);
  SlaveStatus status;
  status.phase = state_.phase;
  status.stops = state_.stops;
  status.validity = state_.validity;
  status.commands = came_;
  status.commands_refused = refused_;
  status.started_at = started_at_;
  status.stages = {{"total", 10, 20, 30}};
  return status;
}

void FakeSlave::SetModel(const ModelChange& change, Progress* progress) {
  while (makes_for_ever_) {
    is_making_ = true;
    try {
      ReportProgress(progress, "factorising", 0.25);
    } catch (const Interrupted&) {
      is_making_ = false;
      throw;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  const std::scoped_lock lock(mutex_);
  if (!change.kind.empty() && change.kind != "bem2d") {
    throw std::invalid_argument("kind = " + change.kind + ": expected bem2d");
  }
  if (state_.phase == Phase::kFollowing) throw std::logic_error("an operator follows");
}

void FakeSlave::SetParameters(const ParameterChange& change, Progress* /*progress*/) {
  const std::scoped_lock lock(mutex_);
  parameters_ = change;
  ++state_.settings_revision;
}

void FakeSlave::Reset(std::uint64_t stops) {
  const std::scoped_lock lock(mutex_);
  if (state_.phase == Phase::kEstop && stops != state_.stops) throw std::logic_error("newer stop");
  state_.phase = Phase::kReady;
}

void FakeSlave::StopTool() noexcept {
  const std::scoped_lock lock(mutex_);
  state_.phase = Phase::kEstop;
  ++state_.stops;
}

void FakeSlave::RecordStop(const std::string& reason) {
  const std::scoped_lock lock(mutex_);
  stop_reason_ = reason;
}

BoundaryShape FakeSlave::Shape(const ShapeParts& parts) {
  const std::scoped_lock lock(mutex_);
  ++shapes_;
  BoundaryShape shape;
  shape.sensed_at = state_.sensed_at;
  shape.validity = state_.validity;
  shape.elements = {0, 1, 1, 2, 2, 0};
  if (tactile_) {
    shape.nodes_per_element = 3;
    shape.elements = {0, 1, 2};
  }
  shape.rest = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  shape.positions = {0, 0.5F, 0, 1, 0, 0, 0, 1, 0};
  shape.fixed_nodes = {2};
  if (parts.nodal_forces) shape.nodal_forces.assign(9, 0.25F);
  if (parts.field) {
    shape.field = DisplacementField{{0, 1, 2}, shape.rest, {0, 0.5F, 0, 0, 0, 0, 0, 0, 0}, {}};
    shape.field->image = {10, 20, 30, 20, 10, 0};
  }
  return shape;
}

std::optional<EncodedImage> FakeSlave::Image(bool overlays, int quality) {
  const std::scoped_lock lock(mutex_);
  ++images_;
  if (images_ == 1) return std::nullopt;  // nothing seen yet
  return EncodedImage{state_.sensed_at,
                      std::string(overlays ? "overlays " : "plain ") + std::to_string(quality), 640,
                      480};
}

}  // namespace palpate
