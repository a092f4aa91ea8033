#include "slave/mechanics/bem3d/greens_store.h"

#include <algorithm>
#include <bit>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Part = GreensStore::Part;

// Names format and byte order: of another machine it does not compare equal.
constexpr std::uint64_t kMagic = 0x31'44'33'6e'65'65'72'47;

struct SectionHead {
  std::uint64_t magic = kMagic;
  std::uint64_t tag = 0;
  std::uint64_t count = 0;
  std::uint64_t checksum = 0;
};

std::uint64_t Tag(Part part, int index) {
  return static_cast<std::uint64_t>(part) << 32U | static_cast<std::uint32_t>(index);
}

// Every step can be undone, so that no change of a single word goes unseen.
std::uint64_t Mixed(std::uint64_t hash, std::uint64_t word) {
  hash = (hash ^ word) * 0x9e37'79b9'7f4a'7c15;
  return hash ^ hash >> 32U;
}

std::uint64_t Checksum(std::uint64_t tag, std::span<const double> values) {
  std::uint64_t hash = Mixed(tag + 1, values.size());
  for (const double value : values) hash = Mixed(hash, std::bit_cast<std::uint64_t>(value));
  return hash;
}

bool WriteSection(std::FILE* file, std::uint64_t tag, std::span<const double> values) {
  const SectionHead head{kMagic, tag, values.size(), Checksum(tag, values)};
  return std::fwrite(&head, sizeof head, 1, file) == 1 &&
         std::fwrite(values.data(), sizeof(double), values.size(), file) == values.size() &&
         std::fflush(file) == 0;
}

// Bytes from here to the end: nothing larger is asked of memory than the file can fill.
std::uint64_t Remaining(std::FILE* file) {
  const long here = std::ftell(file);
  if (here < 0 || std::fseek(file, 0, SEEK_END) != 0) return 0;
  const long end = std::ftell(file);
  if (std::fseek(file, here, SEEK_SET) != 0) return 0;
  return static_cast<std::uint64_t>(end - here);
}

std::optional<std::vector<double>> ReadSection(std::FILE* file, std::uint64_t tag) {
  SectionHead head;
  if (std::fread(&head, sizeof head, 1, file) != 1) return std::nullopt;
  if (head.magic != kMagic || head.tag != tag) return std::nullopt;
  if (head.count > Remaining(file) / sizeof(double)) return std::nullopt;
  std::vector<double> values(head.count);
  if (std::fread(values.data(), sizeof(double), values.size(), file) != values.size() ||
      Checksum(tag, values) != head.checksum) {
    return std::nullopt;
  }
  return values;
}

std::string Hexadecimal(std::uint64_t hash) {
  std::string digits(16, '0');
  for (auto digit = digits.rbegin(); digit != digits.rend(); ++digit, hash >>= 4U) {
    *digit = "0123456789abcdef"[hash & 15U];
  }
  return digits;
}

}  // namespace

GreensStore::GreensStore(std::filesystem::path folder, std::vector<double> inputs)
    : folder_(std::move(folder)), inputs_(std::move(inputs)) {
  const std::string name = "bem3d-" + Hexadecimal(Checksum(Tag(Part::kInputs, 0), inputs_));
  result_ = folder_ / (name + ".greens");
  log_path_ = folder_ / (name + ".partial");
}

std::optional<GreensData> GreensStore::Load() const {
  if (folder_.empty()) return std::nullopt;
  const File file(std::fopen(result_.c_str(), "rb"));
  if (!file) return std::nullopt;
  const auto read = [&](Part part) { return ReadSection(file.get(), Tag(part, 0)); };
  if (read(Part::kInputs) != inputs_) return std::nullopt;
  auto blocks = read(Part::kBlocks);
  if (!blocks) return std::nullopt;
  auto reactions = read(Part::kReactions);
  if (!reactions) return std::nullopt;
  const auto condition = read(Part::kCondition);
  if (!condition || condition->size() != 1 || Remaining(file.get()) != 0) return std::nullopt;
  return GreensData{std::move(*blocks), std::move(*reactions), condition->front()};
}

std::optional<std::vector<double>> GreensStore::Resume(Part part, int index) {
  if (!OpenLog() || !resuming_) return std::nullopt;
  const long here = std::ftell(log_.get());
  auto values = ReadSection(log_.get(), Tag(part, index));
  if (!values) ForgetRest(here);
  return values;
}

void GreensStore::Keep(Part part, int index, std::span<const double> values) {
  if (!OpenLog()) return;
  if (resuming_) ForgetRest(std::ftell(log_.get()));
  if (!log_) return;
  if (WriteSection(log_.get(), Tag(part, index), values)) return;
  CannotWrite();
  log_.reset();
}

void GreensStore::Finish(const GreensData& data) {
  if (!OpenLog()) return;
  const auto write = [&](std::FILE* file) {
    const auto put = [&](Part part, std::span<const double> values) {
      return WriteSection(file, Tag(part, 0), values);
    };
    return put(Part::kInputs, inputs_) && put(Part::kBlocks, data.blocks) &&
           put(Part::kReactions, data.reactions) && put(Part::kCondition, {&data.condition, 1}) &&
           ::fsync(::fileno(file)) == 0;
  };
  if (!TryReplace(result_, write, Links::kReplace)) return CannotWrite();  // the parts stay
  std::error_code ignored;
  std::filesystem::remove(log_path_, ignored);
  log_.reset();
}

// Opens the log and reads its inputs once; a log of other inputs is emptied. False: nothing can be
// kept.
bool GreensStore::OpenLog() {
  if (tried_) return log_ != nullptr;
  tried_ = true;
  if (folder_.empty()) return false;
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  const int descriptor = ::open(log_path_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (descriptor >= 0) log_.reset(::fdopen(descriptor, "r+b"));
  if (!log_) {
    CannotWrite();
    return false;
  }
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    remark_ = "another process computes the same functions";
    log_.reset();
    return false;
  }
  resuming_ = ReadSection(log_.get(), Tag(Part::kInputs, 0)) == inputs_;
  if (resuming_) return true;
  ForgetRest(0);
  Keep(Part::kInputs, 0, inputs_);
  return log_ != nullptr;
}

void GreensStore::ForgetRest(long from) {
  resuming_ = false;
  std::clearerr(log_.get());
  if (std::fseek(log_.get(), from, SEEK_SET) == 0 && ::ftruncate(::fileno(log_.get()), from) == 0) {
    return;
  }
  CannotWrite();
  log_.reset();
}

}  // namespace palpate
