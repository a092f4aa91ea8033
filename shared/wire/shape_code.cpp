#include "shared/wire/shape_code.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <zstd.h>

namespace palpate {
namespace {

constexpr int kLevel = 1;          // of zstd: others take longer and gain a few percent
constexpr int kMostExponent = 20;  // steps beyond a million units tell nothing
constexpr std::int64_t kMost = 1 << 30;
constexpr int kNear = 2, kSymbols = 2 * kNear + 1;  // steps along one axis in one symbol
constexpr unsigned char kFar = 255;                 // its three numbers follow
constexpr std::size_t kLongestNode = 16;            // a symbol and three numbers of five bytes

using Move = std::array<std::int64_t, 3>;  // [steps]

void PutNumber(std::int64_t value, std::string* out) {
  auto rest = static_cast<std::uint64_t>(value < 0 ? -2 * value - 1 : 2 * value);
  for (; rest >= 0x80; rest >>= 7) out->push_back(static_cast<char>(rest | 0x80));
  out->push_back(static_cast<char>(rest));
}

// False: none ends before `end`, or it is too large.
bool TakeNumber(const unsigned char** at, const unsigned char* end, std::int64_t* value) {
  std::uint64_t rest = 0;
  for (int shift = 0; *at != end && shift < 35; shift += 7) {
    const unsigned char byte = *(*at)++;
    rest |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
    if ((byte & 0x80) != 0) continue;
    const auto half = static_cast<std::int64_t>(rest >> 1);
    *value = (rest & 1) != 0 ? -half - 1 : half;
    return true;
  }
  return false;
}

// Symbols first, numbers behind them.
class Moves {
 public:
  explicit Moves(std::size_t nodes) { symbols_.reserve(nodes); }
  void Put(const Move& move) {
    const auto is_near = [](std::int64_t r) { return std::abs(r) <= kNear; };
    if (std::all_of(move.begin(), move.end(), is_near)) {
      std::int64_t symbol = 0;
      for (const std::int64_t r : move) symbol = kSymbols * symbol + r + kNear;
      symbols_.push_back(static_cast<char>(symbol));
    } else {
      symbols_.push_back(static_cast<char>(kFar));
      for (const std::int64_t r : move) PutNumber(r, &numbers_);
    }
  }
  [[nodiscard]] std::string Compressed() const {
    const std::string plain = symbols_ + numbers_;
    std::string packed(ZSTD_compressBound(plain.size()), '\0');
    packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kLevel));
    return packed;
  }

 private:
  std::string symbols_, numbers_;
};

// The bytes of a code of `nodes` nodes; empty: invalid.
std::string Unpacked(const std::string& packed, std::size_t nodes) {
  std::string plain(kLongestNode * nodes, '\0');
  const std::size_t size =
      ZSTD_decompress(plain.data(), plain.size(), packed.data(), packed.size());
  plain.resize(ZSTD_isError(size) == 0 && size >= nodes ? size : 0);
  return plain;
}

bool TakeMove(unsigned char symbol, const unsigned char** at, const unsigned char* end,
              Move* move) {
  if (symbol == kFar) {
    return std::all_of(move->begin(), move->end(),
                       [&](std::int64_t& r) { return TakeNumber(at, end, &r); });
  }
  for (int axis = 2; axis >= 0; --axis, symbol /= kSymbols) {
    (*move)[static_cast<std::size_t>(axis)] = symbol % kSymbols - kNear;
  }
  return symbol == 0;
}

constexpr int kMostSteps = 255;     // of the largest
constexpr double kMostUnit = 1e15;  // no material bears as much [Pa]
constexpr double kLeast = 1e-9;     // below it there is none [Pa]

NodeTraction InSteps(const std::vector<double>& pascals, double largest, int steps) {
  NodeTraction traction{largest > kLeast ? largest / steps : 1, {}};
  for (const double p : pascals) {
    traction.steps.push_back(static_cast<std::uint8_t>(std::lround(p / traction.unit)));
  }
  return traction;
}

}  // namespace

void ShapeEncoder::Restart(std::size_t nodes, double unit) {
  sent_.assign(3 * nodes, 0);
  unit_ = unit;
  exponent_ = 0;
  fine_ = 0;
}

std::int64_t ShapeEncoder::Steps(double units, std::size_t i, const Plan& plan) const {
  const double off = units - sent_[i];
  const bool may_stay =
      i / 3 >= plan.rough_from && std::abs(off) <= std::ldexp(0.5, plan.tolerance);
  return may_stay ? 0 : std::llround(std::ldexp(off, -plan.exponent));
}

ShapeCode ShapeEncoder::CodeOf(const std::vector<double>& units, const Plan& plan) const {
  Moves moves(units.size() / 3);
  for (std::size_t i = 0; i < units.size(); i += 3) {
    moves.Put({Steps(units[i], i, plan), Steps(units[i + 1], i + 1, plan),
               Steps(units[i + 2], i + 2, plan)});
  }
  return {plan.exponent, moves.Compressed()};
}

ShapeEncoder::Plan ShapeEncoder::FinerInPart() const {
  constexpr std::size_t kParts = 4;
  const std::size_t nodes = sent_.size() / 3;
  return {exponent_ - 1, std::min(nodes, fine_ + nodes / kParts + 1), exponent_};
}

std::optional<ShapeCode> ShapeEncoder::Encode(const std::vector<float>& rest,
                                              const std::vector<float>& positions,
                                              std::size_t budget) {
  if (rest.size() != sent_.size() || positions.size() != sent_.size()) return std::nullopt;
  std::vector<double> units(sent_.size());
  for (std::size_t i = 0; i < units.size(); ++i) {
    units[i] = (static_cast<double>(positions[i]) - rest[i]) / unit_;
    if (!(std::abs(units[i]) < static_cast<double>(kMost))) return std::nullopt;  // nor NaN
  }
  // All of it finer than before, then a part of it, then as before, then coarser.
  const std::size_t all = sent_.size() / 3;
  Plan plan{std::max(0, exponent_ - 1), all, 0};
  ShapeCode code = CodeOf(units, plan);
  if (code.moves.size() > budget && exponent_ > 0) {
    plan = FinerInPart();
    code = CodeOf(units, plan);
  }
  while (code.moves.size() > budget && plan.exponent < kMostExponent) {
    plan = {plan.rough_from < all ? exponent_ : plan.exponent + 1, all, 0};
    code = CodeOf(units, plan);
  }
  for (std::size_t i = 0; i < units.size(); ++i) {
    sent_[i] += static_cast<std::int32_t>(Steps(units[i], i, plan) << plan.exponent);
  }
  fine_ = plan.rough_from < all ? plan.rough_from : 0;
  if (fine_ == 0) exponent_ = plan.exponent;
  return code;
}

bool Decode(const ShapeCode& code, ShapeUnits* units) {
  if (code.exponent < 0 || code.exponent > kMostExponent) return false;
  const std::size_t nodes = units->size() / 3;
  const std::string plain = Unpacked(code.moves, nodes);
  if (plain.size() < nodes || nodes == 0) return false;
  const auto* symbols = reinterpret_cast<const unsigned char*>(plain.data());
  const unsigned char *at = symbols + nodes, *end = symbols + plain.size();
  ShapeUnits moved = *units;
  for (std::size_t node = 0; node < nodes; ++node) {
    Move move{};
    if (!TakeMove(symbols[node], &at, end, &move)) return false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t sum = moved[3 * node + axis] + (move[axis] << code.exponent);
      if (std::abs(sum) > 2 * kMost - 1) return false;
      moved[3 * node + axis] = static_cast<std::int32_t>(sum);
    }
  }
  if (at != end) return false;
  *units = std::move(moved);
  return true;
}

NodeTraction Quantised(const std::vector<double>& pascals, std::size_t budget) {
  const auto is_one = [](double p) { return p >= 0 && p <= kMostUnit; };  // so written, NaN is none
  if (pascals.empty() || !std::ranges::all_of(pascals, is_one)) return {};
  const double largest = std::ranges::max(pascals);
  for (int steps = kMostSteps; steps > 0; steps /= 2) {
    NodeTraction traction = InSteps(pascals, largest, steps);
    if (Packed(traction).size() <= budget) return traction;
  }
  return {};
}

std::string Packed(const NodeTraction& traction) {
  std::string packed(ZSTD_compressBound(traction.steps.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), traction.steps.data(),
                              traction.steps.size(), kLevel));
  return packed;
}

std::optional<NodeTraction> Unpacked(double unit, const std::string& packed, std::size_t nodes) {
  if (!(unit > 0 && unit <= kMostUnit)) return std::nullopt;
  NodeTraction traction{unit, std::vector<std::uint8_t>(nodes)};
  const std::size_t size =
      ZSTD_decompress(traction.steps.data(), nodes, packed.data(), packed.size());
  if (ZSTD_isError(size) != 0 || size != nodes) return std::nullopt;
  return traction;
}

}  // namespace palpate
