#include "tests/campaigns/robustness/mixed.h"

#include <random>
#include <set>
#include <utility>

namespace palpate::robustness {
namespace {

// Returns a function that calls both functions in turn; either may be empty.
template <typename... Args>
std::function<void(Args...)> Then(const std::function<void(Args...)>& first,
                                  const std::function<void(Args...)>& second) {
  if (!first || !second) return first ? first : second;
  return [first, second](Args... args) {
    first(args...);
    second(args...);
  };
}

}  // namespace

Alteration Both(const Alteration& first, const Alteration& second) {
  Alteration both;
  both.paint = Then(first.paint, second.paint);
  both.shows = first.shows ? first.shows : second.shows;
  both.stale = Then(first.stale, second.stale);
  both.touch = Then(first.touch, second.touch);
  both.tell = Then(first.tell, second.tell);
  both.swapped = first.swapped ? first.swapped : second.swapped;
  both.arm_error = first.arm_error + second.arm_error;
  if (first.object_moves && second.object_moves) {
    both.object_moves = [first, second](const Moment& moment) -> Eigen::Vector2d {
      return first.object_moves(moment) + second.object_moves(moment);
    };
  } else {
    both.object_moves = first.object_moves ? first.object_moves : second.object_moves;
  }
  if (first.loses && second.loses) {
    both.loses = [first, second](const Moment& moment) {
      return first.loses(moment) || second.loses(moment);
    };
  } else {
    both.loses = first.loses ? first.loses : second.loses;
  }
  return both;
}

std::vector<Case> Mixed(const std::vector<Case>& cases, std::size_t count, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_int_distribution<std::size_t> any(0, cases.size() - 1);
  std::vector<Case> mixed;
  std::set<std::pair<std::size_t, std::size_t>> drawn;
  for (std::size_t tries = 0; mixed.size() < count && tries < 100 * count; ++tries) {
    const std::size_t i = any(random), j = any(random);
    const Case &one = cases[i], &other = cases[j];
    if (i == j || one.stage != other.stage || (one.alteration.shows && other.alteration.shows)) {
      continue;
    }
    if (!drawn.insert({i, j}).second) continue;
    Case both;
    both.name = one.title() + " + " + other.title();
    both.stage = one.stage;
    both.alteration = Both(one.alteration, other.alteration);
    mixed.push_back(std::move(both));
  }
  return mixed;
}

}  // namespace palpate::robustness
