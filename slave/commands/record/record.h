// Recordings (FILE.mcap) as inputs: `palpate-slave process FILE.mcap` and `palpate-slave export`.
#pragma once

#include <filesystem>
#include <stop_token>

namespace palpate {

// By its name.
bool IsRecording(const std::filesystem::path& file);

// Recomputes the states of the recording `file`. Writes them to the folder `out` and prints how
// they differ from the recorded ones. 0: done, whatever differs. Throws std::invalid_argument (an
// unusable recording) and std::exception.
int RunProcessRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                        const std::stop_token& stop);

// `palpate-slave export FILE.mcap`.
struct RecordingExport {
  std::filesystem::path file, out;
};

// Runs ExportRecording. 0: done. Throws as RunProcessRecording.
int RunExportRecording(const RecordingExport& options, const std::stop_token& stop);

}  // namespace palpate
