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

constexpr std::size_t kItemOverhead =
    100;  // memory of a waiting message beyond its content [bytes]

}  // namespace

McapSchema SchemaOf(const google::protobuf::Descriptor& message) {
  google::protobuf::FileDescriptorSet files;
  std::set<std::string> known;
  AddFile(*message.file(), &known, &files);
  return {message.full_name(), "protobuf", files.SerializeAsString()};
}

Recording::Recording(Options options)
    : options_([&] {
        options.file = UnusedFile(options.file);
        return std::move(options);
      }()),
      identity_(std::to_string(Nanoseconds(Clock::now()))),
      writer_(BeginPart(1)) {}

std::unique_ptr<McapWriter> Recording::BeginPart(int number) const {
  const bool is_whole = options_.part <= 0;
  auto writer = std::make_unique<McapWriter>(
      is_whole ? options_.file : PartFile(options_.file, number),
      McapWriter::Options{
          .library = options_.library, .limit = options_.limit, .before = bytes_before_});
  if (!is_whole) writer->Note(kPartNote, PartNote(identity_, number));
  for (const Beginning& step : beginning_) step(writer.get());
  return writer;
}

// If a part cannot be started, the recording ends, as if one cannot be continued. If only the
// beginning of a new part would be within the limit, the present part continues.
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

void Recording::RunFirst(Beginning step) {
  step(writer_.get());
  beginning_.push_back(std::move(step));
}

std::uint16_t Recording::Open(std::string_view topic, const google::protobuf::Message& example) {
  const auto open = [topic = std::string(topic), schema = SchemaOf(*example.GetDescriptor())](
                        McapWriter* writer) { return writer->AddChannel(topic, schema); };
  beginning_.push_back(open);  // so that the channel has the same number in each part
  return open(writer_.get());
}

void Recording::Attach(std::string_view name, std::string_view data) {
  RunFirst([name = std::string(name), data = std::string(data), at = Nanoseconds(Clock::now())](
               McapWriter* writer) { writer->Attach(name, "application/octet-stream", data, at); });
}

void Recording::Note(std::string_view name, const McapMap& values) {
  RunFirst([name = std::string(name), values](McapWriter* writer) { writer->Note(name, values); });
}

void Recording::Put(std::uint16_t channel, Time at, const google::protobuf::Message& message) {
  std::string bytes = message.SerializeAsString();
  const std::size_t size = bytes.size();
  PutWaiting(Waiting{channel, at, size, std::move(bytes), {}});
}

void Recording::PutStanding(std::uint16_t channel, Time at,
                            const google::protobuf::Message& message) {
  std::string bytes = message.SerializeAsString();
  const std::size_t size = bytes.size();
  PutWaiting(Waiting{channel, at, size, std::move(bytes), {}, true});
}

void Recording::Put(std::uint16_t channel, Time at, std::size_t size,
                    std::function<std::string()> make) {
  PutWaiting(Waiting{channel, at, size, {}, std::move(make)});
}

void Recording::PutWaiting(Waiting waiting) {
  const std::lock_guard lock(mutex_);
  if (is_closed_) return;
  if (!thread_.joinable()) {
    thread_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  if (waiting_ + waiting.size > options_.max_waiting) {
    is_closed_ = true;  // queued messages are still written
    stats_.failed = true;
    stats_.trouble = options_.file.string() +
                     ": the recording has ended: the disk or the processor is too slow, and " +
                     Formatted("%.4g MB", 1e-6 * static_cast<double>(options_.max_waiting)) +
                     " wait to be written";
    return;
  }
  // The clock decides, not the time stamps.
  const Time now = Clock::now();
  if (options_.part > 0 && SecondsBetween(part_began_, now) >= options_.part) {
    part_began_ = now;
    ++stats_.parts;
  }
  waiting.part = stats_.parts;
  waiting.queued_at = now;
  if (!oldest_unwritten_) oldest_unwritten_ = waiting.queued_at;
  waiting_ += waiting.size + kItemOverhead;
  queue_.push_back(std::move(waiting));
}

void Recording::Run(const std::stop_token& stop) {
  constexpr auto kPollPeriod = std::chrono::milliseconds(50);
  std::deque<Waiting> batch;
  for (bool is_last = false; !is_last && !stop.stop_requested();) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait_until(lock, stop, std::chrono::steady_clock::now() + kPollPeriod,
                          [] { return false; });
      batch.swap(queue_);
      is_last = is_closed_;
    }
    WriteBatch(&batch, is_last);
  }
}

void Recording::WriteBatch(std::deque<Waiting>* batch, bool is_last) {
  try {
    Drain(batch);
    FlushWhenDue(*batch);
    if (is_last) writer_->Close();
  } catch (const std::exception& error) {
    broken_ = options_.file.string() + ": the recording has ended: " + error.what();
    batch->clear();
    try {
      writer_->Close();  // the data written so far remain readable
    } catch (const std::exception&) {
      // On a full disk the index cannot be written either; the records remain.
    }
  }
  CheckEnd();
}

void Recording::Drain(std::deque<Waiting>* batch) {
  while (!batch->empty()) {
    Waiting& next = batch->front();
    if (next.part != written_part_) GoOnIn(next.part, next.at);
    if (next.is_standing) standing_[next.channel] = next.bytes;
    if (next.make && !writer_->ended()) next.bytes = next.make();
    writer_->Write(next.channel, Nanoseconds(next.at), next.bytes);
    {
      const std::lock_guard lock(mutex_);
      waiting_ -= next.size + kItemOverhead;
    }
    batch->pop_front();
    FlushWhenDue(*batch);
  }
}

void Recording::FlushWhenDue(const std::deque<Waiting>& batch) {
  if (SecondsBetween(flushed_at_, Clock::now()) < kFlushEvery) return;
  std::string behind;
  {
    const std::lock_guard lock(mutex_);
    behind = TextIfBehind();
  }
  if (!behind.empty() && !std::exchange(is_lag_reported_, true) && options_.tell) {
    options_.tell(behind);
  }
  writer_->Flush();
  flushed_at_ = Clock::now();
  const std::lock_guard lock(mutex_);
  oldest_unwritten_.reset();
  if (!batch.empty()) {
    oldest_unwritten_ = batch.front().queued_at;
  } else if (!queue_.empty()) {
    oldest_unwritten_ = queue_.front().queued_at;
  }
}

std::string Recording::TextIfBehind() const {
  if (!oldest_unwritten_) return {};
  const double age = SecondsBetween(*oldest_unwritten_, Clock::now());
  if (age <= kMaxBehind) return {};
  return options_.file.string() +
         Formatted(": the recording falls behind: the last %.0f s are not yet written", age);
}

void Recording::CheckEnd() {
  std::string news;
  {
    const std::lock_guard lock(mutex_);
    stats_.bytes = bytes_before_ + writer_->bytes();
    stats_.messages = messages_before_ + writer_->messages();
    const std::string& trouble = broken_.empty() ? writer_->trouble() : broken_;
    if (stats_.trouble.empty()) stats_.trouble = trouble;
    if (writer_->failed() || !broken_.empty()) stats_.failed = true;
    if (writer_->ended()) oldest_unwritten_.reset();
    if (stats_.trouble.empty()) return;
    is_closed_ = true;
    if (!trouble.empty()) queue_.clear();  // no more data can be written
    if (std::exchange(is_reported_, true)) return;
    news = stats_.trouble;
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
  WriteBatch(&queue_, true);  // no other thread is running
}

int Recording::part() const {
  const std::lock_guard lock(mutex_);
  return stats_.parts;
}

Recording::Stats Recording::stats() const {
  const std::lock_guard lock(mutex_);
  Stats stats = stats_;
  if (stats.trouble.empty()) {
    stats.trouble = TextIfBehind();
    stats.falls_behind = !stats.trouble.empty();
  }
  return stats;
}

std::uint64_t ParseRecordLimit(std::string_view text) {
  constexpr double kMinBytes = 1e5, kMaxBytes = 1e15;  // [bytes]
  struct Unit {
    std::string_view name;
    double bytes;
  };
  constexpr Unit kUnits[] = {{"kB", 1e3}, {"MB", 1e6}, {"GB", 1e9}, {"TB", 1e12}, {"", 1}};
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    const auto number = ParseFinite(Trimmed(text.substr(0, text.size() - unit.name.size())));
    const double bytes = number ? *number * unit.bytes : 0;
    if (bytes >= kMinBytes && bytes <= kMaxBytes) return static_cast<std::uint64_t>(bytes);
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
  constexpr std::size_t kMinDigits = 4, kMaxDigits = 9;
  std::error_code none;
  if (std::filesystem::exists(file, none)) return {file};
  const std::string begin = file.stem().string() + "-", end = file.extension().string();
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  std::map<int, std::filesystem::path> parts;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < begin.size() + end.size() + kMinDigits || !name.starts_with(begin) ||
        !name.ends_with(end)) {
      continue;
    }
    const std::string digits = name.substr(begin.size(), name.size() - begin.size() - end.size());
    const bool is_number = digits.size() <= kMaxDigits && std::ranges::all_of(digits, [](char c) {
                             return std::isdigit(static_cast<unsigned char>(c)) != 0;
                           });
    if (is_number) parts.emplace(std::stoi(digits), entry.path());
  }
  if (parts.empty()) return {file};
  std::vector<std::filesystem::path> files;
  for (const auto& [number, part] : parts) files.push_back(part);
  return files;
}

std::filesystem::path UnusedFile(const std::filesystem::path& file) {
  constexpr int kMaxNumber = 999;
  std::filesystem::path chosen = file;
  for (int number = 2; number <= kMaxNumber; ++number) {
    std::error_code none;
    const bool is_file = std::filesystem::is_regular_file(chosen, none);
    if (!is_file && PartsOf(chosen).front() == chosen) return chosen;
    chosen = file.parent_path() /
             (file.stem().string() + Formatted("-%d", number) + file.extension().string());
  }
  throw std::runtime_error(file.string() + ": recordings up to number " +
                           std::to_string(kMaxNumber) +
                           " exist: move them, or record to another name");
}

}  // namespace palpate
