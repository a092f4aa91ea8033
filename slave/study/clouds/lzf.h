// LZF, the compression of PCD files.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::study {

// The stream is a row of runs. A control byte below 32 is followed by that many and one more bytes
// as they are; any other says in its upper three bits how many bytes, and in its lower five and the
// next byte from how far back, are repeated (seven: one more byte adds to the length).
// nullopt: the stream does not make exactly `size` bytes. Allocates no more than `size`.
std::optional<std::string> DecompressLzf(std::string_view stream, std::size_t size);

}  // namespace palpate::study
