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

std::uint64_t Begun(std::uint64_t tag, std::uint64_t count) {
  return Mixed(tag + 1, count);
}

std::uint64_t Continued(std::uint64_t hash, std::span<const double> values) {
  for (const double value : values) hash = Mixed(hash, std::bit_cast<std::uint64_t>(value));
  return hash;
}

std::uint64_t Checksum(std::uint64_t tag, std::span<const double> values) {
  return Continued(Begun(tag, values.size()), values);
}

// The head with the checksum last: an interrupted section is not a sound one.
bool WriteSection(std::FILE* file, std::uint64_t tag, const GreensStore::Pieces& pieces) {
  SectionHead head{kMagic, tag, pieces.count, 0};
  const long begin = std::ftell(file);
  const auto write_head = [&] { return std::fwrite(&head, sizeof head, 1, file) == 1; };
  if (begin < 0 || !write_head()) return false;
  head.checksum = Begun(tag, pieces.count);
  for (std::size_t left = pieces.count; left > 0;) {
    const std::span<const double> values = pieces.next();
    if (values.empty() || values.size() > left) return false;
    if (std::fwrite(values.data(), sizeof(double), values.size(), file) != values.size()) {
      return false;
    }
    head.checksum = Continued(head.checksum, values);
    left -= values.size();
  }
  return std::fseek(file, begin, SEEK_SET) == 0 && write_head() &&
         std::fseek(file, 0, SEEK_END) == 0 && std::fflush(file) == 0;
}

GreensStore::Pieces Whole(std::span<const double> values) {
  return {values.size(), [values] { return values; }};
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

// Whether a sound section of `count` numbers follows; moves behind it.
bool CheckSection(std::FILE* file, std::uint64_t tag, std::size_t count) {
  constexpr std::size_t kPiece = 1 << 17;
  SectionHead head;
  if (std::fread(&head, sizeof head, 1, file) != 1) return false;
  if (head.magic != kMagic || head.tag != tag || head.count != count) return false;
  std::uint64_t hash = Begun(tag, count);
  std::vector<double> values(std::min(count, kPiece));
  for (std::size_t left = count; left > 0; left -= values.size()) {
    values.resize(std::min(left, kPiece));
    if (std::fread(values.data(), sizeof(double), values.size(), file) != values.size()) {
      return false;
    }
    hash = Continued(hash, values);
  }
  return hash == head.checksum;
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

bool GreensStore::Has(std::size_t blocks, std::size_t reactions) const {
  const File file(folder_.empty() ? nullptr : std::fopen(result_.c_str(), "rb"));
  if (!file) return false;
  const auto check = [&](Part part, std::size_t count) {
    return CheckSection(file.get(), Tag(part, 0), count);
  };
  return ReadSection(file.get(), Tag(Part::kInputs, 0)) == inputs_ &&
         check(Part::kBlocks, blocks) && check(Part::kReactions, reactions) &&
         check(Part::kCondition, 1) && Remaining(file.get()) == 0;
}

std::optional<std::vector<double>> GreensStore::Resume(Part part, int index) {
  if (!OpenLog() || !resuming_) return std::nullopt;
  const long here = std::ftell(log_.get());
  auto values = ReadSection(log_.get(), Tag(part, index));
  if (!values) ForgetRest(here);
  if (values) kept_[Tag(part, index)] = here;
  return values;
}

std::optional<std::vector<double>> GreensStore::Again(Part part, int index) {
  const auto found = kept_.find(Tag(part, index));
  if (found == kept_.end() || !log_) return std::nullopt;
  if (std::fseek(log_.get(), found->second, SEEK_SET) != 0) return std::nullopt;
  return ReadSection(log_.get(), found->first);
}

void GreensStore::Keep(Part part, int index, std::span<const double> values) {
  if (!OpenLog()) return;
  if (resuming_) ForgetRest(std::ftell(log_.get()));
  if (!log_) return;
  kept_[Tag(part, index)] = std::ftell(log_.get());
  if (WriteSection(log_.get(), Tag(part, index), Whole(values))) return;
  CannotWrite();
  log_.reset();
}

void GreensStore::Finish(const GreensData& data) {
  Finish(Whole(data.blocks), Whole(data.reactions), data.condition);
}

void GreensStore::Finish(const Pieces& blocks, const Pieces& reactions, double condition) {
  if (!OpenLog()) return;
  const auto write = [&](std::FILE* file) {
    const auto put = [&](Part part, const Pieces& values) {
      return WriteSection(file, Tag(part, 0), values);
    };
    return put(Part::kInputs, Whole(inputs_)) && put(Part::kBlocks, blocks) &&
           put(Part::kReactions, reactions) && put(Part::kCondition, Whole({&condition, 1})) &&
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
