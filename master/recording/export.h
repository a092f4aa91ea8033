// Exports images and meshes of a master's recording. deploy/python reads the rest.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct ExportCounts {
  std::uint64_t images = 0, meshes = 0;
  std::string damage;  // unreadable parts of the recording, as text; empty: none
};

// Writes into `out`, which is created if missing. t [s] starts at the first tick:
//
//   images.csv, images/NNNNNN.jpg   number and t of each image, and the images
//   meshes.pvd, meshes/NNNNNN.vtu       shapes for ParaView: displacement [m] and, if known,
//                                       traction [Pa]
//
// Throws InputError for a file that is damaged or no master's recording, and std::runtime_error if
// it cannot write.
ExportCounts ExportSession(const std::filesystem::path& file, const std::filesystem::path& out,
                           const std::stop_token& stop);

}  // namespace palpate
