// A slave's recording for other tools: tables, NumPy arrays, pictures.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct RecordingCounts {
  std::uint64_t states = 0, pictures = 0, tactile = 0;
  std::string damage;  // what of the recording cannot be read, in words; empty: nothing
};

// Writes into `out`, made if missing; SI, frame S:
//
//   numpy/*.npy         a row per state: t since the first sample [s], sample, p_S_tip (3),
//                       force (3, NaN: unknown), sigma (NaN), validity and check (their numbers in
//                       palpate.v1)
//   left/, right/       NNNNNN.png: the pictures, by their number
//   numpy/tactile.npy   a row per sample: t, then for each fingertip 19 electrodes, pac, pdc (NaN:
//                       it has none)
//   scene/              the scene's files
//
// Throws InputError: no slave's recording, damaged; std::runtime_error: not writable.
RecordingCounts ExportRecording(const std::filesystem::path& file, const std::filesystem::path& out,
                                const std::stop_token& stop);

}  // namespace palpate
