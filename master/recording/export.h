// A master's recording for other tools: tables, NumPy arrays, pictures and meshes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct ExportCounts {
  std::uint64_t ticks = 0, states = 0, pictures = 0, meshes = 0;
  std::string damage;  // what of the recording cannot be read, in words; empty: nothing
};

// Writes into `out`, made if missing; t [s] is since the first tick, SI throughout:
//
//   log.csv            the ticks, with the columns of `connect --log`
//   states.csv         the slave's states as they came
//   numpy/*.npy        a row per tick, to learn from: t, p_M (3), p_S (3), force (3, what the
//   device
//                      got, M), estimated (3, NaN: unknown), sigma (NaN), validity, check and phase
//                      (their numbers in palpate.v1), reasons (bits, the lowest is FORCE_REASON 1),
//                      state_sequence, age and sensed_age (NaN), picture (index of the newest
//                      picture shown then, -1: none)
//   numpy/picture_t.npy, pictures/NNNNNN.jpg   when each was taken, and it
//   meshes/NNNNNN.vtu, meshes.pvd              the object's shape for ParaView: displacement [m]
//                                              and, where it is told, traction [Pa]
//
// Throws InputError: no master's recording, damaged; std::runtime_error: not writable.
ExportCounts ExportSession(const std::filesystem::path& file, const std::filesystem::path& out,
                           const std::stop_token& stop);

}  // namespace palpate
