#include "shared/wire/message_fields.h"

#include <cmath>

#include <google/protobuf/descriptor.h>

namespace palpate {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

const google::protobuf::Reflection& AccessTo(const Message& message) {
  return *message.GetReflection();
}

// The repeated doubles of a quaternion.
google::protobuf::RepeatedField<double> Doubles(const Message& message,
                                                const FieldDescriptor* field) {
  google::protobuf::RepeatedField<double> numbers;
  for (int i = 0; i < AccessTo(message).FieldSize(message, field); ++i) {
    numbers.Add(AccessTo(message).GetRepeatedDouble(message, field, i));
  }
  return numbers;
}

}  // namespace

const FieldDescriptor* MessageWriter::Field(int number) const {
  return message_.GetDescriptor()->FindFieldByNumber(number);
}

void MessageWriter::operator()(int field, std::uint64_t value) const {
  AccessTo(message_).SetUInt64(&message_, Field(field), value);
}

void MessageWriter::operator()(int field, std::uint32_t value) const {
  AccessTo(message_).SetUInt32(&message_, Field(field), value);
}

void MessageWriter::operator()(int field, bool value) const {
  AccessTo(message_).SetBool(&message_, Field(field), value);
}

void MessageWriter::operator()(int field, double value, double /*limit*/) const {
  if (!std::isfinite(value)) return;
  const auto* descriptor = Field(field);
  if (descriptor->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    AccessTo(message_).SetDouble(&message_, descriptor, value);
  } else {
    AccessTo(message_).SetFloat(&message_, descriptor, Narrow(value));
  }
}

void MessageWriter::operator()(int field, Time value, Presence presence) const {
  if (presence == Presence::kOptional && value == Time{}) return;
  auto* message = AccessTo(message_).MutableMessage(&message_, Field(field));
  ToProto(value, static_cast<google::protobuf::Timestamp*>(message));
}

void MessageWriter::operator()(int field, const std::optional<Time>& value) const {
  if (value) (*this)(field, *value, Presence::kOptional);
}

void MessageWriter::operator()(int field, const Eigen::Vector3d& value, double /*limit*/,
                               Presence presence) const {
  if (presence == Presence::kOptional && value.isZero(0)) return;
  WriteVector(field, value);
}

void MessageWriter::operator()(int field, const std::optional<Eigen::Vector3d>& value,
                               double /*limit*/) const {
  if (value && value->allFinite()) WriteVector(field, *value);
}

void MessageWriter::WriteVector(int field, const Eigen::Vector3d& value) const {
  auto* message = AccessTo(message_).MutableMessage(&message_, Field(field));
  if (message->GetDescriptor() == v1::Vec3::descriptor()) {
    ToProto(value, static_cast<v1::Vec3*>(message));
  } else {
    ToProto(value, static_cast<v1::Vec3f*>(message));
  }
}

void MessageWriter::operator()(int field, const std::optional<Eigen::Quaterniond>& value) const {
  if (!value) return;
  for (const double number : {value->w(), value->x(), value->y(), value->z()}) {
    AccessTo(message_).AddDouble(&message_, Field(field), number);
  }
}

void MessageWriter::operator()(int field, const Events& value) const {
  google::protobuf::RepeatedField<int> events;
  ToProto(value, &events);
  for (const int event : events) AccessTo(message_).AddEnumValue(&message_, Field(field), event);
}

void MessageWriter::WriteEnumeration(int field, int value) const {
  AccessTo(message_).SetEnumValue(&message_, Field(field), value);
}

const FieldDescriptor* MessageReader::Field(int number) const {
  return message_.GetDescriptor()->FindFieldByNumber(number);
}

void MessageReader::operator()(int field, std::uint64_t& value) const {
  value = AccessTo(message_).GetUInt64(message_, Field(field));
}

void MessageReader::operator()(int field, std::uint32_t& value) const {
  value = AccessTo(message_).GetUInt32(message_, Field(field));
}

void MessageReader::operator()(int field, bool& value) const {
  value = AccessTo(message_).GetBool(message_, Field(field));
}

void MessageReader::operator()(int field, double& value, double limit) const {
  const auto* descriptor = Field(field);
  const bool is_double = descriptor->cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  const double number = is_double ? AccessTo(message_).GetDouble(message_, descriptor)
                                  : AccessTo(message_).GetFloat(message_, descriptor);
  value = reader_.NonNegative(descriptor->name(), number, limit);
}

bool MessageReader::IsPresent(int field, Presence presence, const char* accepted) const {
  const auto* descriptor = Field(field);
  if (AccessTo(message_).HasField(message_, descriptor)) return true;
  if (presence == Presence::kRequired) {
    reader_.Require(false, descriptor->name() + " is absent", accepted);
  }
  return false;
}

void MessageReader::operator()(int field, Time& value, Presence presence) const {
  if (!IsPresent(field, presence, "a time")) return;
  const auto& message = AccessTo(message_).GetMessage(message_, Field(field));
  value =
      reader_.Stamp(Field(field)->name(), static_cast<const google::protobuf::Timestamp&>(message));
}

void MessageReader::operator()(int field, std::optional<Time>& value) const {
  Time time{};
  (*this)(field, time, Presence::kOptional);
  if (AccessTo(message_).HasField(message_, Field(field))) value = time;
}

void MessageReader::operator()(int field, Eigen::Vector3d& value, double limit,
                               Presence presence) const {
  if (!IsPresent(field, presence, "a vector")) return;
  const auto* descriptor = Field(field);
  const auto& message = AccessTo(message_).GetMessage(message_, descriptor);
  if (message.GetDescriptor() == v1::Vec3::descriptor()) {
    value = reader_.Vector(descriptor->name(), static_cast<const v1::Vec3&>(message), limit);
  } else {
    value = reader_.Vector(descriptor->name(), static_cast<const v1::Vec3f&>(message), limit);
  }
}

void MessageReader::operator()(int field, std::optional<Eigen::Vector3d>& value,
                               double limit) const {
  if (!AccessTo(message_).HasField(message_, Field(field))) return;
  value.emplace(Eigen::Vector3d::Zero());
  (*this)(field, *value, limit);
}

void MessageReader::operator()(int field, std::optional<Eigen::Quaterniond>& value) const {
  value = reader_.Rotation(Field(field)->name(), Doubles(message_, Field(field)));
}

void MessageReader::operator()(int field, Events& value) const {
  const auto* descriptor = Field(field);
  google::protobuf::RepeatedField<int> events;
  for (int i = 0; i < AccessTo(message_).FieldSize(message_, descriptor); ++i) {
    events.Add(AccessTo(message_).GetRepeatedEnumValue(message_, descriptor, i));
  }
  value = FromProto(events);
}

int MessageReader::ReadEnumeration(int field) const {
  return AccessTo(message_).GetEnumValue(message_, Field(field));
}

}  // namespace palpate
