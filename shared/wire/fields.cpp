#include "shared/wire/fields.h"

#include <array>
#include <cmath>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
constexpr std::int64_t kLatestSecond = std::int64_t{1} << 33;  // fits nanoseconds in 64 bits

// The values in the order of Validity.
constexpr std::array<v1::Validity, 6> kValidities{
    v1::VALIDITY_VALID, v1::VALIDITY_EXTRAPOLATED,  v1::VALIDITY_PUNCTURED,
    v1::VALIDITY_STALE, v1::VALIDITY_TRACKING_LOST, v1::VALIDITY_FAILED};

template <class Message>
Eigen::Vector3d Components(FieldReader* reader, std::string_view name, const Message& value,
                           double limit) {
  if (std::abs(value.x()) <= limit && std::abs(value.y()) <= limit &&
      std::abs(value.z()) <= limit) {
    return {value.x(), value.y(), value.z()};
  }
  const std::string prefix(name);
  return {reader->Number(prefix + ".x", value.x(), limit),
          reader->Number(prefix + ".y", value.y(), limit),
          reader->Number(prefix + ".z", value.z(), limit)};
}

}  // namespace

void ToProto(const Eigen::Vector3d& vector, v1::Vec3* message) {
  message->set_x(vector.x());
  message->set_y(vector.y());
  message->set_z(vector.z());
}

void ToProto(const Eigen::Vector3d& vector, v1::Vec3f* message) {
  message->set_x(Narrow(vector.x()));
  message->set_y(Narrow(vector.y()));
  message->set_z(Narrow(vector.z()));
}

void ToProto(const std::optional<Eigen::Quaterniond>& rotation,
             google::protobuf::RepeatedField<double>* message) {
  message->Clear();
  if (!rotation) return;
  for (const double value : {rotation->w(), rotation->x(), rotation->y(), rotation->z()}) {
    message->Add(value);
  }
}

void ToProto(Time time, google::protobuf::Timestamp* message) {
  const std::int64_t nanos = time.time_since_epoch().count();
  std::int64_t seconds = nanos / kNanosPerSecond;
  std::int64_t rest = nanos % kNanosPerSecond;
  if (rest < 0) {
    --seconds;
    rest += kNanosPerSecond;
  }
  message->set_seconds(seconds);
  message->set_nanos(static_cast<std::int32_t>(rest));
}

void ToProto(const DatagramCount& count, v1::DatagramCount* message) {
  message->set_newest(count.newest);
  message->set_received(count.received);
}

DatagramCount FromProto(const v1::DatagramCount& count) {
  return {count.newest(), count.received()};
}

double FieldReader::Number(std::string_view name, double value, double limit) {
  if (std::abs(value) <= limit) return value;  // so written, NaN is refused too
  Refuse(std::string(name) +
         Formatted(" = %g: expected a finite number, at most %g in size", value, limit));
  return 0;
}

double FieldReader::NonNegative(std::string_view name, double value, double limit) {
  if (value >= 0 && value <= limit) return value;
  Refuse(std::string(name) + Formatted(" = %g: expected 0 to %g", value, limit));
  return 0;
}

Eigen::Vector3d FieldReader::Vector(std::string_view name, const v1::Vec3& value, double limit) {
  return Components(this, name, value, limit);
}

Eigen::Vector3d FieldReader::Vector(std::string_view name, const v1::Vec3f& value, double limit) {
  return Components(this, name, value, limit);
}

std::optional<Eigen::Quaterniond> FieldReader::Rotation(
    std::string_view name, const google::protobuf::RepeatedField<double>& value) {
  if (value.empty()) return std::nullopt;
  Eigen::Quaterniond rotation(0, 0, 0, 0);
  if (value.size() == 4) rotation = {value[0], value[1], value[2], value[3]};
  const bool is_unit = std::abs(rotation.norm() - 1) <= kUnitTolerance;  // NaN is refused too
  Require(is_unit, name, "a unit quaternion w, x, y, z within 1e-3, or none");
  if (!is_unit) return std::nullopt;
  return rotation.normalized();
}

Time FieldReader::Stamp(std::string_view name, const google::protobuf::Timestamp& value) {
  if (value.seconds() >= 0 && value.seconds() < kLatestSecond && value.nanos() >= 0 &&
      value.nanos() < kNanosPerSecond) {
    return Time(Clock::duration(value.seconds() * kNanosPerSecond + value.nanos()));
  }
  Refuse(std::string(name) + " = " + std::to_string(value.seconds()) + " s " +
         std::to_string(value.nanos()) + " ns: expected a time from 1970 to 2242");
  return Time{};
}

void FieldReader::Require(bool condition, std::string_view name, std::string_view accepted) {
  if (condition) return;
  Refuse(std::string(name) + ": expected " + std::string(accepted));
}

void FieldReader::Refuse(const std::string& reason) {
  if (ok_) *reason_ = reason;
  ok_ = false;
}

static_assert(static_cast<int>(Event::kContact) == v1::EVENT_CONTACT);
static_assert(static_cast<int>(Event::kCommandRefused) == v1::EVENT_COMMAND_REFUSED);
static_assert(static_cast<int>(Event::kCommandRefused) == v1::Event_MAX);
static_assert(kValidities.size() == v1::Validity_MAX);
static_assert(kFailedChecks == v1::FailedCheck_MAX + 1);
static_assert(static_cast<int>(FailedCheck::kArmFault) == v1::FAILED_CHECK_ARM_FAULT);
static_assert(static_cast<int>(Phase::kReady) == v1::PHASE_READY);
static_assert(static_cast<int>(Phase::kEstop) == v1::PHASE_ESTOP);
static_assert(static_cast<int>(Phase::kSetup) == v1::PHASE_SETUP);
static_assert(static_cast<int>(Phase::kSetup) == v1::Phase_MAX);

v1::Validity ToProto(Validity validity) {
  return kValidities[static_cast<std::size_t>(validity)];
}

Validity FromProto(v1::Validity validity) {
  const auto* found = std::find(kValidities.begin(), kValidities.end(), validity);
  return found == kValidities.end() ? Validity::kFailed
                                    : static_cast<Validity>(found - kValidities.begin());
}

v1::FailedCheck ToProto(FailedCheck check) {
  return static_cast<v1::FailedCheck>(check);
}

FailedCheck FromProto(v1::FailedCheck check) {
  return v1::FailedCheck_IsValid(check) ? static_cast<FailedCheck>(check) : FailedCheck::kNone;
}

v1::Phase ToProto(Phase phase) {
  return static_cast<v1::Phase>(phase);
}

Phase FromProto(v1::Phase phase) {
  if (phase < v1::PHASE_READY || phase > v1::Phase_MAX) return Phase::kHold;
  return static_cast<Phase>(phase);
}

v1::Event ToProto(Event event) {
  return static_cast<v1::Event>(event);
}

void ToProto(const Events& events, google::protobuf::RepeatedField<int>* message) {
  message->Clear();
  if (events.empty()) return;
  for (int event = v1::EVENT_CONTACT; event <= v1::Event_MAX; ++event) {
    if (events.Has(static_cast<Event>(event))) message->Add(event);
  }
}

Events FromProto(const google::protobuf::RepeatedField<int>& message) {
  Events events;
  for (const int event : message) {
    if (event >= v1::EVENT_CONTACT && event <= v1::Event_MAX) events.Add(static_cast<Event>(event));
  }
  return events;
}

}  // namespace palpate
