#include "slave/commands/record/record.h"

#include <array>
#include <stdexcept>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "shared/text/text.h"
#include "slave/recording/export_recording.h"
#include "slave/recording/recorded_run.h"

namespace palpate {
namespace {

// A recording that cannot be used is an unusable argument.
template <class Read>
auto Reading(const Read& read) {
  try {
    return read();
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
}

}  // namespace

bool IsRecording(const std::filesystem::path& file) {
  return file.extension() == ".mcap";
}

int RunProcessRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                        const std::stop_token& stop) {
  const std::array inputs{file};
  RequireOtherThan("--out", out, {"states.csv", "summary.json"}, inputs);
  const RecordedRun run = Reading([&] { return ProcessRecording(file, out, stop); });
  for (const std::string& line : InWords(run)) fmt::print("{}\n", line);
  return 0;
}

int RunExportRecording(const RecordingExport& options, const std::stop_token& stop) {
  const RecordingCounts counts =
      Reading([&] { return ExportRecording(options.file, options.out, stop); });
  fmt::print("{} states, {} images, {} tactile samples\n", counts.states, counts.pictures,
             counts.tactile);
  if (!counts.damage.empty()) fmt::print("incomplete: {}\n", counts.damage);
  fmt::print("written: {}\n", options.out.string());
  return 0;
}

}  // namespace palpate
