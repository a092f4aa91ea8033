#include "shared/recording/recording_reader.h"

#include <utility>

#include "shared/recording/recording.h"
#include "shared/text/text.h"

namespace palpate {

RecordingReader::RecordingReader(const std::filesystem::path& file)
    : parts_(PartsOf(file)),
      is_one_file_(parts_.front() == file),
      reader_(std::make_unique<McapReader>(parts_.front())) {}

bool RecordingReader::Next() {
  do {
    while (reader_->Next(&message_)) {
      if (std::exchange(is_new_, false) && !Belongs()) return false;
      channel_ = reader_->channel(message_.channel);
      if (at() >= skip_before_) return true;
    }
  } while (OpenNext());
  return false;
}

bool RecordingReader::OpenNext() {
  Damage(reader_->damage());
  if (part_ + 1 >= parts_.size() || (std::exchange(is_new_, false) && !Belongs())) return false;
  ++part_;
  try {
    reader_ = std::make_unique<McapReader>(parts_[part_]);
  } catch (const InputError& error) {
    Damage(error.what());  // the recorder was killed at the start
    return false;
  }
  is_new_ = true;
  reader_->SkipBefore(Nanoseconds(skip_before_));
  return true;
}

bool RecordingReader::Belongs() {
  if (is_one_file_) return true;
  const auto note = reader_->notes().find(kPartNote);
  const McapMap values = note == reader_->notes().end() ? McapMap{} : note->second;
  const auto value = [&](const char* key) {
    const auto found = values.find(key);
    return found == values.end() ? std::string() : found->second;
  };
  const std::string identity = value("recording");
  const int number = static_cast<int>(ParseFinite(value("number")).value_or(0));
  if (identity_.empty()) identity_ = identity;
  if (identity.empty() || identity != identity_) {
    Damage(parts_[part_].string() +
           ": is not a part of this recording: it and the following parts are ignored");
    return false;
  }
  if (number != number_ + 1) {
    Damage(parts_[part_].string() + ": earlier messages are missing: there is no part " +
           std::to_string(number_ + 1));
  }
  number_ = number;
  return true;
}

void RecordingReader::Damage(const std::string& what) {
  if (damage_.empty()) damage_ = what;
}

const std::string& RecordingReader::damage() const {
  return damage_.empty() ? reader_->damage() : damage_;
}

Time RecordingReader::at() const {
  return FromNanoseconds(message_.time);
}

void RecordingReader::SkipBefore(Time at) {
  skip_before_ = at;
  reader_->SkipBefore(Nanoseconds(at));
}

void RecordingReader::Read(google::protobuf::Message* message) const {
  const McapSchema* schema = reader_->schema(channel_->schema);
  const std::string name = message->GetTypeName();
  if (schema == nullptr || schema->name != name) {
    throw InputError(parts_[part_].string() + ": " + Shown(channel_->topic) + " is of " +
                     (schema == nullptr ? "no type" : Shown(schema->name)) + ": expected " + name);
  }
  if (!message->ParseFromArray(message_.data.data(), static_cast<int>(message_.data.size()))) {
    throw InputError(parts_[part_].string() + ": a message of " + Shown(channel_->topic) +
                     " is damaged");
  }
}

}  // namespace palpate
