#include "shared/wire/fields.h"

#include <cmath>
#include <sstream>

namespace palpate {
namespace {

constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
constexpr std::int64_t kLatestSecond = std::int64_t{1} << 33;  // fits nanoseconds in 64 bits

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

double FieldReader::Number(std::string_view name, double value, double limit) {
  if (std::abs(value) <= limit) return value;  // so written, NaN is refused too
  std::ostringstream reason;
  reason << name << " = " << value << ": accepted is a finite number, at most " << limit
         << " in size";
  Refuse(reason.str());
  return 0;
}

double FieldReader::NonNegative(std::string_view name, double value, double limit) {
  if (value >= 0 && value <= limit) return value;
  std::ostringstream reason;
  reason << name << " = " << value << ": accepted is 0 to " << limit;
  Refuse(reason.str());
  return 0;
}

Eigen::Vector3d FieldReader::Vector(std::string_view name, const v1::Vec3& value, double limit) {
  return Components(this, name, value, limit);
}

Eigen::Vector3d FieldReader::Vector(std::string_view name, const v1::Vec3f& value, double limit) {
  return Components(this, name, value, limit);
}

Time FieldReader::Stamp(std::string_view name, const google::protobuf::Timestamp& value) {
  if (value.seconds() >= 0 && value.seconds() < kLatestSecond && value.nanos() >= 0 &&
      value.nanos() < kNanosPerSecond) {
    return Time(Clock::duration(value.seconds() * kNanosPerSecond + value.nanos()));
  }
  std::ostringstream reason;
  reason << name << " = " << value.seconds() << " s " << value.nanos()
         << " ns: accepted is a time from 1970 to 2242";
  Refuse(reason.str());
  return Time{};
}

void FieldReader::Require(bool condition, std::string_view name, std::string_view accepted) {
  if (condition) return;
  Refuse(std::string(name) + ": accepted is " + std::string(accepted));
}

void FieldReader::Refuse(const std::string& reason) {
  if (ok_) *reason_ = reason;
  ok_ = false;
}

}  // namespace palpate
