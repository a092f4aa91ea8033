// Exports a master's recording as tables, NumPy arrays, images and meshes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct ExportCounts {
  std::uint64_t ticks = 0, states = 0, pictures = 0, meshes = 0;
  std::string damage;  // unreadable parts of the recording, as text; empty: none
};

// Writes into `out`, which is created if missing. t [s] starts at the first tick; all values are
// SI:
//
//   log.csv            the ticks, with the columns of `connect --log`
//   states.csv         the received states of the slave
//   numpy/*.npy        one row per tick: t, p_M (3), p_S (3), force (3, on the device, M),
//   estimated
//                      (3, NaN: unknown), sigma (NaN), validity, check and phase (numbers of
//                      palpate.v1), reasons (bits, the lowest is FORCE_REASON 1), state_sequence,
//                      age and sensed_age (NaN), picture (index of the newest image, -1: none)
//   numpy/picture_t.npy, pictures/NNNNNN.jpg   time of each image, and the images
//   meshes/NNNNNN.vtu, meshes.pvd              shapes for ParaView: displacement [m] and, if known,
//                                              traction [Pa]
//
// Throws InputError for a file that is damaged or no master's recording, and std::runtime_error if
// it cannot write.
ExportCounts ExportSession(const std::filesystem::path& file, const std::filesystem::path& out,
                           const std::stop_token& stop);

}  // namespace palpate
