#include "shared/recording/recording_reader.h"

#include "shared/recording/recording.h"
#include "shared/text/text.h"

namespace palpate {

bool RecordingReader::Next() {
  while (reader_.Next(&message_)) {
    channel_ = reader_.channel(message_.channel);
    if (at() >= skip_before_) return true;
  }
  return false;
}

Time RecordingReader::at() const {
  return FromNanoseconds(message_.time);
}

void RecordingReader::SkipBefore(Time at) {
  skip_before_ = at;
  reader_.SkipBefore(Nanoseconds(at));
}

void RecordingReader::Read(google::protobuf::Message* message) const {
  const McapSchema* schema = reader_.schema(channel_->schema);
  const std::string name = message->GetTypeName();
  if (schema == nullptr || schema->name != name) {
    throw InputError(file_.string() + ": " + Shown(channel_->topic) + " is of " +
                     (schema == nullptr ? "no type" : Shown(schema->name)) + ": accepted is " +
                     name);
  }
  if (!message->ParseFromArray(message_.data.data(), static_cast<int>(message_.data.size()))) {
    throw InputError(file_.string() + ": a message of " + Shown(channel_->topic) + " is damaged");
  }
}

}  // namespace palpate
