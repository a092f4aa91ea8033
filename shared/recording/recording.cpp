#include "shared/recording/recording.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

void AddFile(const google::protobuf::FileDescriptor& file, std::set<std::string>* known,
             google::protobuf::FileDescriptorSet* files) {
  if (!known->insert(file.name()).second) return;
  for (int i = 0; i < file.dependency_count(); ++i) AddFile(*file.dependency(i), known, files);
  file.CopyTo(files->add_file());
}

constexpr std::size_t kItself = 100;  // of what waits, beside its bytes

}  // namespace

McapSchema SchemaOf(const google::protobuf::Descriptor& message) {
  google::protobuf::FileDescriptorSet files;
  std::set<std::string> known;
  AddFile(*message.file(), &known, &files);
  return {message.full_name(), "protobuf", files.SerializeAsString()};
}

Recording::Recording(Options options)
    : options_(std::move(options)),
      identity_(std::to_string(Nanoseconds(Clock::now()))),
      writer_(BeginPart(1)) {}

std::unique_ptr<McapWriter> Recording::BeginPart(int number) const {
  const bool is_whole = options_.part <= 0;
  if (!is_whole && number == 1 && std::filesystem::exists(options_.file)) {
    throw std::runtime_error(
        options_.file.string() +
        ": exists already and would be mistaken for the parts of the recording: move "
        "it, or record to another name");
  }
  auto writer = std::make_unique<McapWriter>(
      is_whole ? options_.file : PartFile(options_.file, number),
      McapWriter::Options{
          .library = options_.library, .limit = options_.limit, .before = bytes_before_});
  if (!is_whole) writer->Note(kPartNote, PartNote(identity_, number));
  for (const Beginning& step : beginning_) step(writer.get());
  return writer;
}

// Where a part cannot begin the recording ends, as where one cannot go on. Where only its beginning
// would be within the limit, the one before goes on.
void Recording::GoOnIn(int part, Time at) {
  if (writer_->ended() || !writer_->LeavesRoom()) return;
  writer_->Close();
  written_part_ = part;
  if (!writer_->trouble().empty()) return;
  bytes_before_ += writer_->bytes();
  messages_before_ += writer_->messages();
  try {
    writer_ = BeginPart(part);
    for (const auto& [channel, bytes] : standing_) writer_->Write(channel, Nanoseconds(at), bytes);
  } catch (const std::runtime_error& error) {
    bytes_before_ -= writer_->bytes();
    messages_before_ -= writer_->messages();
    broken_ = error.what();
  }
}

void Recording::Begin(Beginning step) {
  step(writer_.get());
  beginning_.push_back(std::move(step));
}

std::uint16_t Recording::Open(std::string_view topic, const google::protobuf::Message& example) {
  const auto open = [topic = std::string(topic), schema = SchemaOf(*example.GetDescriptor())](
                        McapWriter* writer) { return writer->AddChannel(topic, schema); };
  beginning_.push_back(open);  // where it is given the same number
  return open(writer_.get());
}

void Recording::Attach(std::string_view name, std::string_view data) {
  Begin([name = std::string(name), data = std::string(data), at = Nanoseconds(Clock::now())](
            McapWriter* writer) { writer->Attach(name, "application/octet-stream", data, at); });
}

void Recording::Note(std::string_view name, const McapMap& values) {
  Begin([name = std::string(name), values](McapWriter* writer) { writer->Note(name, values); });
}

void Recording::Put(std::uint16_t channel, Time at, const google::protobuf::Message& message) {
  std::string bytes = message.SerializeAsString();
  const std::size_t size = bytes.size();
  Put(Waiting{channel, at, size, std::move(bytes), {}});
}

void Recording::PutStanding(std::uint16_t channel, Time at,
                            const google::protobuf::Message& message) {
  std::string bytes = message.SerializeAsString();
  const std::size_t size = bytes.size();
  Put(Waiting{channel, at, size, std::move(bytes), {}, true});
}

void Recording::Put(std::uint16_t channel, Time at, std::size_t size,
                    std::function<std::string()> make) {
  Put(Waiting{channel, at, size, {}, std::move(make)});
}

void Recording::Put(Waiting waiting) {
  const std::lock_guard lock(mutex_);
  if (is_closed_) return;
  if (waiting_ + waiting.size > options_.most_waiting) {
    ++stats_.dropped;
    return;
  }
  if (!thread_.joinable()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  // By the clock, whatever the stamps say.
  const Time now = Clock::now();
  if (options_.part > 0 && SecondsBetween(part_began_, now) >= options_.part) {
    part_began_ = now;
    ++stats_.parts;
  }
  waiting.part = stats_.parts;
  waiting_ += waiting.size + kItself;
  queue_.push_back(std::move(waiting));
}

void Recording::Run(const std::stop_token& stop) {
  constexpr auto kNap = std::chrono::milliseconds(50);
  Time flushed = Clock::now();
  std::deque<Waiting> batch;
  while (!stop.stop_requested()) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait_until(lock, stop, std::chrono::steady_clock::now() + kNap,
                          [] { return false; });
      batch.swap(queue_);
    }
    Drain(&batch);
    if (SecondsBetween(flushed, Clock::now()) >= kFlushEvery) {
      writer_->Flush();
      flushed = Clock::now();
    }
    CheckLoss();
    CheckEnd();
  }
}

void Recording::Drain(std::deque<Waiting>* batch) {
  for (; !batch->empty(); batch->pop_front()) {
    Waiting& next = batch->front();
    if (next.part != written_part_) GoOnIn(next.part, next.at);
    if (next.is_standing) standing_[next.channel] = next.bytes;
    if (next.make && !writer_->ended()) next.bytes = next.make();
    writer_->Write(next.channel, Nanoseconds(next.at), next.bytes);
    const std::lock_guard lock(mutex_);
    waiting_ -= next.size + kItself;
  }
}

void Recording::CheckLoss() {
  {
    const std::lock_guard lock(mutex_);
    if (is_loss_reported_ || stats_.dropped == 0) return;
    is_loss_reported_ = true;
  }
  if (!options_.tell) return;
  options_.tell(options_.file.string() +
                ": the disk is too slow: messages are missing in the recording from now on");
}

void Recording::CheckEnd() {
  std::string news;
  {
    const std::lock_guard lock(mutex_);
    stats_.bytes = bytes_before_ + writer_->bytes();
    stats_.messages = messages_before_ + writer_->messages();
    stats_.failed = writer_->failed() || !broken_.empty();
    const std::string& trouble = broken_.empty() ? writer_->trouble() : broken_;
    if (is_reported_ || trouble.empty()) return;
    is_reported_ = is_closed_ = true;
    news = stats_.trouble = trouble;
    queue_.clear();
  }
  if (options_.tell) options_.tell(news);
}

void Recording::Finish() {
  {
    const std::lock_guard lock(mutex_);
    is_closed_ = true;
  }
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  Drain(&queue_);  // nobody else is left
  const std::uint64_t dropped = stats().dropped;
  if (dropped > 0) writer_->Note("dropped", {{"messages", std::to_string(dropped)}});
  writer_->Close();
  CheckEnd();
}

int Recording::part() const {
  const std::lock_guard lock(mutex_);
  return stats_.parts;
}

Recording::Stats Recording::stats() const {
  const std::lock_guard lock(mutex_);
  Stats stats = stats_;
  if (stats.trouble.empty() && stats.dropped > 0) {
    stats.trouble = options_.file.string() + ": " + std::to_string(stats.dropped) +
                    " messages are missing: the disk was too slow";
  }
  return stats;
}

std::uint64_t ParseRecordLimit(std::string_view text) {
  constexpr double kLeast = 1e5, kMost = 1e15;  // [bytes]
  struct Unit {
    std::string_view name;
    double bytes;
  };
  constexpr Unit kUnits[] = {{"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}, {"", 1}};
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    const auto number = ParseFinite(Trimmed(text.substr(0, text.size() - unit.name.size())));
    const double bytes = number ? *number * unit.bytes : 0;
    if (bytes >= kLeast && bytes <= kMost) return static_cast<std::uint64_t>(bytes);
    break;
  }
  throw std::invalid_argument("--record-limit = " + Shown(text) +
                              ": expected a size from 100 kB to 1000 TB, such as 500 MB or 8 GB");
}

std::filesystem::path PartFile(const std::filesystem::path& file, int number) {
  return file.parent_path() /
         (file.stem().string() + Formatted("-%04d", number) + file.extension().string());
}

McapMap PartNote(const std::string& identity, int number) {
  return {{"recording", identity}, {"number", std::to_string(number)}};
}

std::vector<std::filesystem::path> PartsOf(const std::filesystem::path& file) {
  constexpr std::size_t kLeastDigits = 4, kMostDigits = 9;
  std::error_code none;
  if (std::filesystem::exists(file, none)) return {file};
  const std::string begin = file.stem().string() + "-", end = file.extension().string();
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  std::map<int, std::filesystem::path> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < begin.size() + end.size() + kLeastDigits || !name.starts_with(begin) ||
        !name.ends_with(end)) {
      continue;
    }
    const std::string digits = name.substr(begin.size(), name.size() - begin.size() - end.size());
    const bool is_number = digits.size() <= kMostDigits && std::ranges::all_of(digits, [](char c) {
                             return std::isdigit(static_cast<unsigned char>(c)) != 0;
                           });
    if (is_number) parts.emplace(std::stoi(digits), entry.path());
  }
  if (parts.empty()) return {file};
  std::vector<std::filesystem::path> files;
  for (const auto& [number, part] : parts) files.push_back(part);
  return files;
}

}  // namespace palpate
