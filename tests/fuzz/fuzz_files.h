// Writes the fuzzer's bytes to files, since the readers under test take paths.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <unistd.h>

namespace palpate::fuzz {

// Returns a private folder of this process, in memory if the system has such a file system.
inline const std::filesystem::path& Folder() {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path shared = "/dev/shm";
    const auto base = exists(shared) ? shared : std::filesystem::temp_directory_path();
    auto made = base / ("palpate-fuzz." + std::to_string(getpid()));
    create_directories(made);
    std::atexit([] {
      std::error_code ignored;
      remove_all(Folder(), ignored);
    });
    return made;
  }();
  return folder;
}

inline std::filesystem::path Write(const std::string& name, std::string_view bytes) {
  const auto file = Folder() / name;
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  return file;
}

// The fuzzer's input: the first byte selects one of `kinds` readers, the rest is the file's
// content.
struct Input {
  std::size_t kind = 0;
  std::string_view bytes;

  Input(const std::uint8_t* data, std::size_t size, std::size_t kinds) {
    if (size == 0) return;
    kind = data[0] % kinds;
    bytes = {reinterpret_cast<const char*>(data) + 1, size - 1};
  }
};

// Runs `read`. An exception of type `Refusal` is expected; any other one ends the fuzzer.
template <class Refusal, class Read>
void Try(const Read& read) {
  try {
    read();
  } catch (const Refusal&) {
    return;
  }
}

}  // namespace palpate::fuzz
