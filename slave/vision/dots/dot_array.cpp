#include "slave/vision/dots/dot_array.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "shared/geometry/index.h"
#include "shared/text/text.h"
#include "slave/vision/dots/dot_growth.h"

namespace palpate {
namespace {

constexpr std::size_t kMostAnchors = 5;
constexpr std::size_t kMostCandidates = 256;
constexpr std::size_t kNeighbours = 8;  // [-] [tuned: FindsItselfTurnedShiftedAndTilted]
constexpr double kFarNearer = 4;
constexpr double kSamePlace = 25;  // [px^2]
// Of an affine map, to the array's extent: perspective and bend. [-] [tuned:
// FindsItselfTurnedShiftedAndTilted]
constexpr double kResidual = 0.15;
constexpr double kResidualWeight = 9;  // against the distance from the hint

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// So many spurious dots may look as if they belonged.
int Slack(std::size_t dots) {
  return static_cast<int>(dots / 12);
}

bool Alike(double area, double other, double ratio) {
  return area < ratio * other && other < ratio * area;
}

}  // namespace

DotArray::DotArray(std::vector<Eigen::Vector2d> layout, const Params& params)
    : layout_(std::move(layout)), params_(params) {
  const std::size_t n = layout_.size();
  if (n < 3 || n > 400) {
    throw std::invalid_argument(std::to_string(n) + " dots: accepted is 3 to 400");
  }
  for (const Eigen::Vector2d& p : layout_) {
    if (!p.allFinite()) throw std::invalid_argument("a dot of the layout has no finite position");
  }
  Require(params.gate > 0 && params.gate < 0.5, "gate", params.gate, "0 < gate < 0.5");
  if (!(params.least_seen > 0 && params.least_seen <= 1 && params.area_ratio > 1)) {
    throw std::invalid_argument("least_seen = " + std::to_string(params.least_seen) +
                                ", area_ratio = " + std::to_string(params.area_ratio) +
                                ": accepted is 0 < least_seen <= 1, area_ratio > 1");
  }
  least_ = std::max(3, static_cast<int>(std::ceil(params.least_seen * static_cast<double>(n))));
  neighbours_ = NearestNeighbours(layout_, kNeighbours);
  for (std::size_t k = 0; k < n; ++k) {
    if (!(Spacing(k, layout_) > 0)) {
      throw std::invalid_argument("two dots of the layout have the same position");
    }
  }
  for (const std::size_t anchor : SpreadAnchors(layout_, kMostAnchors)) {
    growths_.push_back(GrowthFrom(layout_, anchor));
  }
  places_.resize(n);
  trial_.resize(n);
}

int DotArray::Match(std::span<const Dot> dots, std::span<const Eigen::Vector2d> hint,
                    std::vector<int>* picks) noexcept {
  picks->assign(size(), kNobody);
  if (hint.size() != size()) hint = {};
  Choose(dots, hint);
  index_.Build(dots, candidates_);
  FindNeighbours(dots);
  taken_.assign(dots.size(), 0);
  round_ = 0;
  int best = 0;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const Growth& growth : growths_) {
    if (best == static_cast<int>(size())) break;
    for (std::size_t c = 0; c < candidates_.size(); ++c) {
      const auto& around = around_[c];
      for (int j = 0; j < around.count; ++j) {
        for (int k = 0; k < around.count; ++k) {
          if (j == k) continue;
          const std::array<int, 3> seeds{candidates_[c], around.dots[Index(j)],
                                         around.dots[Index(k)]};
          if (!SeedsFit(growth, dots, seeds)) continue;
          const int to_beat = std::max(least_, best - Slack(size()));
          const int found = Grow(growth, dots, seeds, to_beat);
          if (found < to_beat) continue;
          const double cost = Cost(dots, hint);
          if (!Better(found, cost, best, best_cost, !hint.empty())) continue;
          best = found;
          best_cost = cost;
          *picks = trial_;
        }
      }
    }
  }
  return best;
}

// Too many candidates: those nearest to where the array was.
void DotArray::Choose(std::span<const Dot> dots, std::span<const Eigen::Vector2d> hint) noexcept {
  order_.clear();
  for (std::size_t i = 0; i < dots.size(); ++i) {
    double nearest = hint.empty() ? 0 : std::numeric_limits<double>::infinity();
    for (const Eigen::Vector2d& place : hint) {
      nearest = std::min(nearest, (place - dots[i].centre).squaredNorm());
    }
    order_.emplace_back(nearest, static_cast<int>(i));
  }
  if (order_.size() > kMostCandidates) {
    std::nth_element(order_.begin(), order_.begin() + kMostCandidates, order_.end());
    order_.resize(kMostCandidates);
  }
  candidates_.clear();
  for (const auto& [distance, dot] : order_) candidates_.push_back(dot);
}

void DotArray::FindNeighbours(std::span<const Dot> dots) noexcept {
  around_.resize(candidates_.size());
  for (std::size_t c = 0; c < candidates_.size(); ++c) {
    const Eigen::Vector2d& centre = dots[Index(candidates_[c])].centre;
    order_.clear();
    for (const int other : candidates_) {
      if (other == candidates_[c]) continue;
      order_.emplace_back((dots[Index(other)].centre - centre).squaredNorm(), other);
    }
    // In a small crowd anyone may be a neighbour.
    const std::size_t most = candidates_.size() <= Around::kMost + 1 ? Around::kMost : kNeighbours;
    const std::size_t count = std::min(order_.size(), most);
    std::partial_sort(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(count),
                      order_.end());
    around_[c].count = static_cast<int>(count);
    for (std::size_t k = 0; k < count; ++k) around_[c].dots[k] = order_[k].second;
  }
}

// The three dots turn as they should, and are not in line.
bool DotArray::SeedsFit(const Growth& growth, std::span<const Dot> dots,
                        const std::array<int, 3>& seeds) const noexcept {
  std::array<const Dot*, 3> dot{};
  for (std::size_t i = 0; i < 3; ++i) dot[i] = &dots[Index(seeds[i])];
  if (!Alike(dot[0]->area, dot[1]->area, params_.area_ratio)) return false;
  if (!Alike(dot[0]->area, dot[2]->area, params_.area_ratio)) return false;
  const auto at = [&](std::size_t i) { return layout_[Index(growth[i].dot)]; };
  const Eigen::Vector2d a = dot[1]->centre - dot[0]->centre, b = dot[2]->centre - dot[0]->centre;
  const double turn = Cross(a, b);
  if (std::abs(turn) < 0.1 * a.norm() * b.norm()) return false;
  if (params_.handedness == Handedness::kEither) return true;
  const bool same = (turn > 0) == (Cross(at(1) - at(0), at(2) - at(0)) > 0);
  return same == (params_.handedness == Handedness::kAsDrawn);
}

int DotArray::Grow(const Growth& growth, std::span<const Dot> dots, const std::array<int, 3>& seeds,
                   int to_beat) noexcept {
  ++round_;
  std::fill(trial_.begin(), trial_.end(), kNobody);
  const auto take = [&](int k, int dot) {
    trial_[Index(k)] = dot;
    taken_[Index(dot)] = round_;
    places_[Index(k)] = dots[Index(dot)].centre;
  };
  for (std::size_t i = 0; i < 3; ++i) take(growth[i].dot, seeds[i]);
  int found = 3;
  const int n = static_cast<int>(size());
  for (int i = 3; i < n; ++i) {
    const GrowthStep& step = growth[Index(i)];
    Eigen::Vector2d place(0, 0);
    for (std::size_t p = 0; p < Index(step.parents); ++p) {
      place += step.weight[p] * places_[Index(step.parent[p])];
    }
    places_[Index(step.dot)] = place;
    const int parent = step.parent[0];
    const double reach = params_.gate * (place - places_[Index(parent)]).norm();
    const int dot = index_.Nearest(dots, place, reach);
    const int next_to = trial_[Index(parent)];
    const bool takes = dot >= 0 && taken_[Index(dot)] != round_ &&
                       (next_to < 0 || Alike(dots[Index(dot)].area, dots[Index(next_to)].area,
                                             params_.area_ratio));
    if (takes) {
      take(step.dot, dot);
      ++found;
    } else if (found + n - 1 - i < to_beat) {
      return 0;
    }
  }
  return found;
}

// More dots are better, but a few spurious ones do not outweigh a place far nearer to the hint.
bool DotArray::Better(int found, double cost, int best, double best_cost,
                      bool hinted) const noexcept {
  if (!std::isfinite(cost)) return false;
  if (found == best) return cost < best_cost;
  const bool close = hinted && std::abs(found - best) <= Slack(size());
  if (found > best) return !(close && kFarNearer * (best_cost + kSamePlace) < cost);
  return close && kFarNearer * (cost + kSamePlace) < best_cost;
}

// Mean square distance from the hint, or how far x runs from rightwards; and how badly an affine
// map takes the layout to the dots, which tells a few dots that are the array from a few that are
// not.
double DotArray::Cost(std::span<const Dot> dots,
                      std::span<const Eigen::Vector2d> hint) const noexcept {
  Eigen::Matrix2d MM = Eigen::Matrix2d::Zero(), PM = MM;
  Eigen::Vector2d m_sum(0, 0), p_sum(0, 0);
  double n = 0, squares = 0, from_hint = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    if (trial_[k] == kNobody) continue;
    const Eigen::Vector2d& m = layout_[k];
    const Eigen::Vector2d& p = dots[Index(trial_[k])].centre;
    MM += m * m.transpose();
    PM += p * m.transpose();
    m_sum += m, p_sum += p;
    squares += p.squaredNorm();
    if (!hint.empty()) from_hint += (p - hint[k]).squaredNorm();
    ++n;
  }
  MM -= m_sum * m_sum.transpose() / n;
  PM -= p_sum * m_sum.transpose() / n;
  squares -= p_sum.squaredNorm() / n;
  const double determinant = MM(0, 0) * MM(1, 1) - MM(0, 1) * MM(1, 0);
  const double none = std::numeric_limits<double>::infinity();
  if (!(determinant > 1e-6 * MM.trace() * MM.trace())) return none;
  Eigen::Matrix2d inverse;
  inverse << MM(1, 1), -MM(0, 1), -MM(1, 0), MM(0, 0);
  const Eigen::Matrix2d map = PM * inverse / determinant;
  const double residual = std::max(0.0, squares - map.cwiseProduct(PM).sum());
  if (!(residual < kResidual * kResidual * squares)) return none;
  const double astray = hint.empty() ? squares * (1 - map(0, 0) / map.col(0).norm()) : from_hint;
  return (astray + kResidualWeight * residual) / n;
}

int DotArray::Follow(std::span<const Dot> dots, std::span<const Eigen::Vector2d> places,
                     std::span<const double> areas, std::vector<int>* picks) noexcept {
  picks->assign(size(), kNobody);
  if (places.size() != size() || areas.size() != size()) return 0;
  candidates_.clear();
  for (std::size_t i = 0; i < dots.size(); ++i) candidates_.push_back(static_cast<int>(i));
  index_.Build(dots, candidates_);
  taken_.assign(dots.size(), kNobody);
  int found = 0;
  for (std::size_t k = 0; k < size(); ++k) {
    if (!places[k].allFinite()) continue;
    const int dot = index_.Nearest(dots, places[k], params_.gate * Spacing(k, places));
    if (dot < 0) continue;
    const Dot& seen = dots[Index(dot)];
    if (areas[k] > 0 && !Alike(seen.area, areas[k], 2.5)) continue;
    int& owner = taken_[Index(dot)];
    if (owner != kNobody) {  // the nearer one keeps it
      const Eigen::Vector2d& rival = places[Index(owner)];
      if ((rival - seen.centre).norm() <= (places[k] - seen.centre).norm()) continue;
      (*picks)[Index(owner)] = kNobody;
      --found;
    }
    owner = static_cast<int>(k);
    (*picks)[k] = dot;
    ++found;
  }
  return found;
}

Eigen::Vector2d DotArray::Expect(std::size_t k, std::span<const Eigen::Vector2d> before,
                                 std::span<const Eigen::Vector2d> now,
                                 std::span<const char> seen) const noexcept {
  AffineMove move(before[k]);
  for (const int j : neighbours_[k]) {
    const auto other = Index(j);
    if (seen[other] != 0) move.Add(before[other], now[other]);
  }
  if (move.count() < 3) {
    move = AffineMove(before[k]);
    for (std::size_t j = 0; j < size(); ++j) {
      if (j != k && seen[j] != 0) move.Add(before[j], now[j]);
    }
  }
  return move.Carry();
}

double DotArray::Spacing(std::size_t k, std::span<const Eigen::Vector2d> places) const noexcept {
  double nearest = std::numeric_limits<double>::infinity();
  for (const int j : neighbours_[k]) {
    const double distance = (places[Index(j)] - places[k]).norm();
    if (distance < nearest) nearest = distance;  // not finite: not less
  }
  return std::isfinite(nearest) ? nearest : 0;
}

}  // namespace palpate
