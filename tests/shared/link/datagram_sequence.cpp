#include "tests/shared/link/datagram_sequence.h"

#include <algorithm>

#include "shared/link/datagram_seal.h"

namespace palpate {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct Sent {
  Bytes plain, sealed;
};

Bytes Drawn(Choices* choices, std::size_t size) {
  Bytes bytes(size);
  for (std::uint8_t& byte : bytes) byte = choices->Byte();
  return bytes;
}

Bytes Damaged(Bytes bytes, Choices* choices) {
  const std::size_t at = 256U * choices->Byte() + choices->Byte();
  switch (choices->Below(3)) {
    case 0:
      bytes.resize(at % (2 * kMaxDatagram), 0);
      break;
    case 1:
      bytes[at % bytes.size()] ^= static_cast<std::uint8_t>(1U << choices->Below(8));
      break;
    default:
      bytes.push_back(choices->Byte());
  }
  return bytes;
}

}  // namespace

void RunDatagrams(Choices choices) {
  constexpr DatagramKey kKey{1, 2, 3};
  DatagramSealer sealer(kKey);
  DatagramOpener opener(kKey);
  std::vector<Sent> line;
  // Number of opened datagrams, including earlier sessions; none of them may be accepted again.
  std::size_t opened = 0;
  while (!choices.over()) {
    const std::size_t kind = choices.Below(4);
    if (kind == 0 || line.empty()) {
      const Bytes plain = Drawn(&choices, 1 + choices.Below(64));
      const auto sealed = sealer.Seal(plain);
      line.push_back({plain, {sealed.begin(), sealed.end()}});
      continue;
    }
    const std::size_t which = choices.Below(line.size());
    const Bytes arrives = kind == 1   ? line[which].sealed
                          : kind == 2 ? Damaged(line[which].sealed, &choices)
                                      : Drawn(&choices, choices.Byte());
    const auto plain = opener.Open(arrives);
    const auto of = std::ranges::find(line, arrives, &Sent::sealed);
    const bool is_newer = of != line.end() && of >= line.begin() + static_cast<long>(opened);
    Demand(!plain.empty() == is_newer, is_newer ? "the newest was not opened" : "a lie was opened");
    if (!is_newer) continue;
    Demand(std::ranges::equal(plain, of->plain), "it says something else");
    opened = static_cast<std::size_t>(of - line.begin()) + 1;
    Demand(opener.newest() == opened, "the count is another");
  }
}

}  // namespace palpate
