// Exports a slave's recording for other tools: tables, NumPy arrays, images.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct RecordingCounts {
  std::uint64_t states = 0, pictures = 0, tactile = 0;
  std::string damage;  // unreadable parts of the recording, as text; empty: none
};

// Writes into `out`, created if missing; SI, frame S:
//
//   numpy/*.npy         one row per state: t since the first sample [s], sample, p_S_tip (3),
//                       force (3, NaN: unknown), sigma (NaN), moment (3, NaN: unknown),
//                       moment_sigma (NaN), validity and check (their numbers in palpate.v1)
//   left/, right/       NNNNNN.png: the images, by their number
//   numpy/tactile.npy   one row per sample: t, then for each fingertip 19 electrodes, pac, pdc
//                       (NaN: no sample)
//   scene/              the scene's files
//
// Throws InputError: not a slave's recording, or damaged; std::runtime_error: not writable.
RecordingCounts ExportRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                                const std::stop_token& stop);

}  // namespace palpate
