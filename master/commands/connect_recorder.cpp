#include "master/commands/connect_recorder.h"

#include <cstdio>
#include <utility>

#include "shared/program/program.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kMegabytes = 1e-6;  // in a byte

Recording::Options FileOptions(const std::filesystem::path& file, const std::string& limit,
                               double part) {
  Recording::Options options;
  options.file = file;
  options.limit = ParseRecordLimit(limit);
  options.part = part;
  options.library = std::string("palpate-master ") + Version();
  options.tell = [](const std::string& why) { std::fprintf(stderr, "\n%s\n", why.c_str()); };
  return options;
}

}  // namespace

ConnectRecorder::ConnectRecorder(const std::filesystem::path& file, const std::string& limit,
                                 double part, SlaveLink::Options* link)
    : recording_(FileOptions(file, limit, part)) {
  link->on_received = [this](const StateRecord& state) { recording_.OnState(state); };
  link->on_sent = [this](const OperatorCommand& command) { recording_.OnCommand(command); };
}

void ConnectRecorder::Begin(const std::string& target, McapMap session) {
  session["version"] = Version();
  session["target"] = target;
  recording_.Begin(session);
}

void ConnectRecorder::AddTickObserver(Recorder::TickObserver* observer) {
  *observer = [this, before = *observer](const TickRecord& tick) {
    if (before) before(tick);
    recording_.OnTick(tick);
  };
}

RecordingMoment ConnectRecorder::moment() const {
  const Recording::Stats stats = recording_.stats();
  RecordingMoment moment{recording_.is_on(), kMegabytes * static_cast<double>(stats.bytes),
                         stats.trouble, stats.falls_behind};
  std::error_code failed;
  const auto space =
      std::filesystem::space(std::filesystem::absolute(file()).parent_path(), failed);
  if (!failed) moment.room = kMegabytes * static_cast<double>(space.available);
  return moment;
}

bool ConnectRecorder::Finish(Console* console, Report* report) {
  recording_.Finish();
  const Recording::Stats stats = recording_.stats();
  console->Print(Formatted("recorded %.1f MB to ", kMegabytes * static_cast<double>(stats.bytes)) +
                 file().string() +
                 (stats.parts > 1 ? Formatted(", in %d parts", stats.parts) : std::string()));
  if (!stats.trouble.empty()) report->trouble.push_back(stats.trouble);
  return !stats.failed;
}

}  // namespace palpate
