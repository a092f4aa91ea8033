// Writes and reads the fields of a message by number, so that a table can state each field once:
// see state_message.cpp.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <google/protobuf/message.h>

#include "shared/state/clock.h"
#include "shared/state/slave_state.h"
#include "shared/wire/fields.h"

namespace palpate {

template <class T>
concept WireEnumeration = std::is_enum_v<T>;

// How a field is absent. kOptional: at zero, and an absent one is read as zero. kWritten: as
// kOptional, but zero is written. kRequired: never, and an absent one is rejected.
enum class Presence : std::uint8_t { kOptional, kWritten, kRequired };

// Sets fields of `message`, which must outlive the writer and be clear. Numbers that are not finite
// are left out. Values beyond single precision become its largest.
class MessageWriter {
 public:
  explicit MessageWriter(google::protobuf::Message* message) : message_(*message) {}

  void operator()(int field, std::uint64_t value) const;
  void operator()(int field, std::uint32_t value) const;
  void operator()(int field, bool value) const;
  void operator()(int field, double value, double limit) const;
  void operator()(int field, Time value, Presence presence) const;
  void operator()(int field, const std::optional<Time>& value) const;
  void operator()(int field, const Eigen::Vector3d& value, double limit,
                  Presence presence = Presence::kOptional) const;
  void operator()(int field, const std::optional<Eigen::Vector3d>& value, double limit) const;
  void operator()(int field, const std::optional<Eigen::Quaterniond>& value) const;
  void operator()(int field, const Events& value) const;
  template <WireEnumeration E>
  void operator()(int field, E value) const {
    WriteEnumeration(field, static_cast<int>(ToProto(value)));
  }

 private:
  [[nodiscard]] const google::protobuf::FieldDescriptor* Field(int number) const;
  void WriteEnumeration(int field, int value) const;
  void WriteVector(int field, const Eigen::Vector3d& value) const;

  google::protobuf::Message& message_;
};

// Reads fields of `message`. `reader` keeps the first rejection; rejected values become zero.
class MessageReader {
 public:
  // Message and reader must outlive this object.
  MessageReader(const google::protobuf::Message& message, FieldReader* reader)
      : message_(message), reader_(*reader) {}

  void operator()(int field, std::uint64_t& value) const;
  void operator()(int field, std::uint32_t& value) const;
  void operator()(int field, bool& value) const;
  // 0 <= value <= limit.
  void operator()(int field, double& value, double limit) const;
  void operator()(int field, Time& value, Presence presence) const;
  void operator()(int field, std::optional<Time>& value) const;
  void operator()(int field, Eigen::Vector3d& value, double limit,
                  Presence presence = Presence::kOptional) const;
  void operator()(int field, std::optional<Eigen::Vector3d>& value, double limit) const;
  void operator()(int field, std::optional<Eigen::Quaterniond>& value) const;
  void operator()(int field, Events& value) const;
  template <WireEnumeration E>
  void operator()(int field, E& value) const {
    value = FromProto(static_cast<decltype(ToProto(E{}))>(ReadEnumeration(field)));
  }

 private:
  [[nodiscard]] const google::protobuf::FieldDescriptor* Field(int number) const;
  [[nodiscard]] bool IsPresent(int field, Presence presence, const char* accepted) const;
  [[nodiscard]] int ReadEnumeration(int field) const;

  const google::protobuf::Message& message_;
  FieldReader& reader_;
};

}  // namespace palpate
