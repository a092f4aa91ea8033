// Messages with every field set, and rows of malformed ones, for the tests of this folder.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <google/protobuf/text_format.h>
#include <gtest/gtest.h>

#include "shared/state/slave_state.h"
#include "shared/wire/state_message.h"

namespace palpate {

// All fields differ from their defaults and are exact on the wire. The text is the same message.
SlaveState FullState();
OperatorCommand FullCommand();
extern const char* const kFullStateText;
extern const char* const kFullCommandText;

// Reference: `text`, written by hand. `others`: number of fields that the link itself sets.
template <class Message, class Value>
void ExpectTravelsWhole(const Value& sent, const char* text, int others) {
  Message expected, message, again;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(text, &expected));
  ToProto(sent, &message);
  EXPECT_EQ(message.DebugString(), expected.DebugString());
  std::string reason;
  const auto got = FromProto(expected, &reason);
  ASSERT_TRUE(got.has_value()) << reason;
  ToProto(*got, &again);
  EXPECT_EQ(again.DebugString(), expected.DebugString());
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  Message::GetReflection()->ListFields(expected, &fields);
  EXPECT_EQ(static_cast<int>(fields.size()) + others, Message::GetDescriptor()->field_count())
      << "a field is missing in the sample";
}

template <class Message>
struct Malformation {
  const char* reason;  // word that the error message must contain
  std::function<void(Message*)> apply;
};

template <class Message>
void ExpectRefused(Message message, const Malformation<Message>& row) {
  row.apply(&message);
  std::string reason;
  EXPECT_FALSE(FromProto(message, &reason).has_value()) << row.reason;
  EXPECT_THAT(reason, testing::HasSubstr(row.reason));
  EXPECT_THAT(reason, testing::HasSubstr("expected"));
}

}  // namespace palpate
