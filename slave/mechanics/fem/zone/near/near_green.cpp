#include "slave/mechanics/fem/zone/near/near_green.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "slave/mechanics/fem/zone/near/field_samples.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3f;
using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::Vector3d;

constexpr std::size_t kVersion = 2;  // of what is kept on disk
constexpr double kStep = 1.1;        // from one reach to the next
// Up to which gap between groups numbers have three bytes [of reach]. [tuned:
// ForcesAreThoseOfTheFullModelWithinTheirBound]
constexpr double kThreeBytes = 0.3;
constexpr int kAnchors = 512;                                                   // of the body
constexpr std::size_t kNodes = NearGreen::kGroup, kTile = 9 * kNodes * kNodes;  // numbers
constexpr double kLargest = 127;                                                // number
constexpr float kPart = 0x1p-8;  // of a number: what the next byte counts

// For groups that lie after each other, halves along the longer side, again and again.
void Halve(const std::vector<Vector3d>& positions, std::span<int> nodes) {
  if (nodes.size() <= kNodes) {
    std::ranges::sort(nodes);
    return;
  }
  Vector3d low = positions[Index(nodes.front())], high = low;
  for (const int node : nodes) {
    low = low.cwiseMin(positions[Index(node)]);
    high = high.cwiseMax(positions[Index(node)]);
  }
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::size_t half = (nodes.size() / 2 + kNodes - 1) / kNodes * kNodes;
  std::ranges::nth_element(nodes, nodes.begin() + static_cast<std::ptrdiff_t>(half), {},
                           [&](int node) { return std::pair(positions[Index(node)][axis], node); });
  Halve(positions, nodes.first(half));
  Halve(positions, nodes.subspan(half));
}

std::size_t BytesOf(int per_number) {
  return Index(per_number) * kTile;
}

float NumberAt(const std::int8_t* number, int bytes) {
  float value = number[0];
  if (bytes > 1) value += kPart * number[kTile];
  if (bytes > 2) value += kPart * kPart * number[2 * kTile];
  return value;
}

double RoundedReach(double least) {
  return std::pow(kStep, std::ceil(std::log(least) / std::log(kStep)));
}

std::size_t InDoubles(std::size_t bytes) {
  return (bytes + sizeof(double) - 1) / sizeof(double);
}

}  // namespace

void SpreadNodes(const std::vector<Vector3d>& positions, std::span<const int> from, int count,
                 std::vector<int>* chosen) {
  std::vector<double> distance(from.size(), std::numeric_limits<double>::infinity());
  const auto come_nearer = [&](int node) {
    const Vector3d& p = positions[Index(node)];
    for (std::size_t i = 0; i < from.size(); ++i) {
      distance[i] = std::min(distance[i], (positions[Index(from[i])] - p).squaredNorm());
    }
  };
  for (const int node : *chosen) come_nearer(node);
  while (!from.empty() && static_cast<int>(chosen->size()) < count) {
    const auto next =
        static_cast<std::size_t>(std::ranges::max_element(distance) - distance.begin());
    if (!(distance[next] > 0)) break;
    chosen->push_back(from[next]);
    come_nearer(from[next]);
  }
}

// Nodes of one group in a list: each one's place in the order, and its number in the list.
struct NearGreen::Bucket {
  int group = 0;
  std::vector<std::array<int, 2>> members;
};

NearGreen::NearGreen(const SolidMesh& mesh, const HeldNodes& held, double nu,
                     std::size_t memory_limit, const std::filesystem::path& cache)
    : stiffness_(AssembleAtRest(mesh, held, nu, FemOptions::Element::kTet4)),
      factor_(stiffness_.lower),
      order_(mesh.nodes.size()),
      place_(mesh.nodes.size()),
      interpolations_(mesh.nodes.size()),
      memory_limit_(memory_limit),
      cache_(cache) {
  for (const auto& p : mesh.nodes) positions_.push_back(p / length_unit());
  std::iota(order_.begin(), order_.end(), 0);
  SpreadNodes(positions_, order_, kAnchors, &anchors_);
  Halve(positions_, order_);
  for (std::size_t i = 0; i < order_.size(); ++i) place_[Index(order_[i])] = static_cast<int>(i);
  std::ranges::sort(anchors_, {}, [&](int node) { return place_[Index(node)]; });
  for (int n = 0; n < static_cast<int>(order_.size()); ++n) Interpolate(n);
  groups_.resize((order_.size() + kNodes - 1) / kNodes);
  for (int g = 0; g < static_cast<int>(groups_.size()); ++g) {
    const std::span<const int> nodes = NodesOf(g);
    Vector3d centre = Vector3d::Zero();
    double radius = 0;
    for (const int n : nodes) centre += positions_[Index(n)] / static_cast<double>(nodes.size());
    for (const int n : nodes) radius = std::max(radius, (positions_[Index(n)] - centre).norm());
    centres_.push_back(centre);
    radii_.push_back(radius);
  }
}

int NearGreen::AnchorTiles() const {
  return (static_cast<int>(anchors_.size()) + kGroup - 1) / kGroup;
}

std::span<const int> NearGreen::NodesOf(int group) const {
  const std::span<const int> nodes = group < 0 ? anchors_ : order_;
  const std::size_t first = Index(group < 0 ? group + AnchorTiles() : group) * kNodes;
  return nodes.subspan(first, std::min(kNodes, nodes.size() - first));
}

void NearGreen::Interpolate(int node) {
  Interpolation& made = interpolations_[Index(node)];
  std::vector<std::pair<double, int>> near;
  for (std::size_t a = 0; a < anchors_.size(); ++a) {
    const Vector3d& p = positions_[Index(anchors_[a])];
    near.emplace_back((p - positions_[Index(node)]).squaredNorm(), static_cast<int>(a));
  }
  const std::size_t count = std::min(near.size(), made.anchors.size());
  std::ranges::partial_sort(near, near.begin() + static_cast<std::ptrdiff_t>(count));
  std::vector<Vector3d> samples;
  for (std::size_t k = 0; k < count; ++k) {
    made.anchors[k] = near[k].second;
    samples.push_back(positions_[Index(anchors_[Index(near[k].second)])]);
  }
  const MatrixXf weights = SampleWeights(samples, std::span(&positions_[Index(node)], 1));
  for (std::size_t k = 0; k < count; ++k) made.weights[k] = weights(0, static_cast<int>(k));
}

std::size_t NearGreen::memory_bytes() const {
  return factor_.memory_bytes() + static_cast<std::size_t>(stiffness_.lower.nonZeros()) * 12 +
         sizeof(Interpolation) * interpolations_.size() + column_bytes_;
}

MatrixXd NearGreen::Solve(const MatrixXd& forces) {
  MatrixXd x(stiffness_.lower.rows(), forces.cols());
  const auto nodes = static_cast<int>(positions_.size());
  for (int n = 0; n < nodes; ++n) {
    for (int c = 0; c < 3; ++c) {
      if (Row(n, c) >= 0) x.row(Row(n, c)) = forces.row(3 * n + c);
    }
  }
  if (x.cols() > 0) factor_.Solve(x.data(), static_cast<int>(x.cols()));
  MatrixXd u = MatrixXd::Zero(forces.rows(), forces.cols());
  for (int n = 0; n < nodes; ++n) {
    for (int c = 0; c < 3; ++c) {
      if (Row(n, c) >= 0) u.row(3 * n + c) = x.row(Row(n, c));
    }
  }
  return u;
}

std::vector<int> NearGreen::GroupsToCompute(std::span<const int> nodes, double least) const {
  std::vector<int> groups;
  for (const int node : nodes) {
    if (!IsReady(node, least)) groups.push_back(GroupOf(node));
  }
  std::ranges::sort(groups);
  groups.erase(std::unique(groups.begin(), groups.end()), groups.end());
  return groups;
}

bool NearGreen::Prepare(std::span<const int> nodes, double least, Progress* progress) {
  const double reach = RoundedReach(least);
  const std::vector<int> groups = GroupsToCompute(nodes, least);
  for (std::size_t i = 0; i < groups.size(); ++i) {
    ReportProgress(progress, "Green's functions",
                   static_cast<double>(i) / static_cast<double>(groups.size()));
    if (column_bytes_ > memory_limit_) return false;
    ComputeGroup(groups[i], reach);
  }
  if (!groups.empty()) ReportProgress(progress, "Green's functions", 1);
  return true;
}

// Between the nodes of the one and those of the other.
double NearGreen::Gap(int a, int b) const {
  double gap = std::numeric_limits<double>::infinity();
  for (const int n : NodesOf(a)) {
    for (const int m : NodesOf(b)) {
      gap = std::min(gap, (positions_[Index(n)] - positions_[Index(m)]).squaredNorm());
    }
  }
  return std::sqrt(gap);
}

const NearGreen::Tile* NearGreen::Group::Find(int group) const {
  const auto found = std::ranges::lower_bound(tiles, group, {}, &Tile::group);
  return found == tiles.end() || found->group != group ? nullptr : &*found;
}

void NearGreen::Group::Add(Tile tile) {
  tile.first = numbers.size();
  numbers.resize(numbers.size() + BytesOf(tile.bytes));
  tiles.push_back(tile);
}

CacheFilling NearGreen::FillCache(std::span<const int> nodes, double least, const CacheShare& share,
                                  Progress* progress) {
  const double reach = RoundedReach(least);
  const ColumnCache cache = CacheFor(reach);
  const std::vector<int> groups = GroupsToCompute(nodes, least);
  CacheFilling filling;
  for (std::size_t i = share.first; i < groups.size(); i += share.step) {
    ReportProgress(progress, "Green's functions",
                   static_cast<double>(i) / static_cast<double>(groups.size()));
    ++filling.groups;
    Group made = EmptyGroup(groups[i], reach);
    if (Load(groups[i], &made)) continue;
    SolveGroup(groups[i], &made);
    cache.Keep(groups[i], Packed(made));
    ++filling.computed;
  }
  ReportProgress(progress, "Green's functions", 1);
  return filling;
}

NearGreen::Group NearGreen::EmptyGroup(int group, double reach) const {
  Group made;
  made.reach = reach;
  for (int a = -AnchorTiles(); a < 0; ++a) made.Add({.group = a});
  for (int other = 0; other < static_cast<int>(groups_.size()); ++other) {
    const double apart = (centres_[Index(group)] - centres_[Index(other)]).norm();
    if (apart > reach + radii_[Index(group)] + radii_[Index(other)]) continue;
    const double gap = Gap(group, other) / reach;
    if (gap > 1) continue;
    made.Add({.group = other, .bytes = gap < kThreeBytes ? 3 : 2});
  }
  return made;
}

void NearGreen::ComputeGroup(int group, double reach) {
  Group made = EmptyGroup(group, reach);
  if (!Load(group, &made)) {
    SolveGroup(group, &made);
    if (!cache_.empty()) CacheFor(reach).Save(group, Packed(made));
  }
  Keep(group, made);
}

void NearGreen::SolveGroup(int group, Group* made) {
  const std::span<const int> nodes = NodesOf(group);
  MatrixXd x = MatrixXd::Zero(stiffness_.lower.rows(), 3L * kGroup);
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    for (int c = 0; c < 3; ++c) {
      const int row = Row(nodes[j], c);
      if (row >= 0) x(row, 3 * static_cast<int>(j) + c) = 1;
    }
  }
  factor_.Solve(x.data(), static_cast<int>(x.cols()));
  columns_solved_ += static_cast<int>(x.cols());
  for (Tile& tile : made->tiles) Fill(x, &tile, &made->numbers[tile.first]);
}

void NearGreen::Fill(const MatrixXd& x, Tile* tile, std::int8_t* numbers) const {
  const std::span<const int> nodes = NodesOf(tile->group);
  std::array<double, kTile> values{};
  double largest = 0;
  for (std::size_t k = 0; k < 9 * kNodes * nodes.size(); ++k) {
    const std::size_t pair = k / 9, c = k % 9 / 3, r = k % 3;
    const int row = Row(nodes[pair / kNodes], static_cast<int>(r));
    if (row < 0) continue;
    values[k] = x(row, static_cast<int>(3 * (pair % kNodes) + c));
    largest = std::max(largest, std::abs(values[k]));
  }
  tile->step = static_cast<float>(largest / kLargest);
  const double last = tile->step * std::pow(kPart, tile->bytes - 1);
  for (std::size_t k = 0; last > 0 && k < kTile; ++k) {
    long rest = std::lrint(values[k] / last);
    for (int byte = tile->bytes - 1; byte >= 0; --byte) {
      const auto number = static_cast<std::int8_t>(rest);  // its last eight bits
      numbers[BytesOf(byte) + k] = number;
      rest = (rest - number) / 256;
    }
  }
}

// Less the tiles that the other group has as precisely.
void NearGreen::Keep(int group, const Group& made) {
  Group kept;
  kept.reach = made.reach;
  std::vector<Tile> tiles;
  std::size_t count = 0;
  for (const Tile& tile : made.tiles) {
    const bool own = tile.group < 0 || tile.group == group;
    const Tile* other = own ? nullptr : groups_[Index(tile.group)].Find(group);
    if (other != nullptr && other->bytes >= tile.bytes) continue;
    tiles.push_back(tile);
    count += BytesOf(tile.bytes);
  }
  kept.tiles.reserve(tiles.size());
  kept.numbers.reserve(count);
  for (const Tile& tile : tiles) {
    kept.Add(tile);
    std::copy_n(&made.numbers[tile.first], BytesOf(tile.bytes),
                &kept.numbers[kept.tiles.back().first]);
  }
  column_bytes_ += kept.bytes() - groups_[Index(group)].bytes();
  groups_[Index(group)] = std::move(kept);
}

ColumnCache NearGreen::CacheFor(double reach) const {
  return {cache_,
          Hash().Add(kVersion).Add(kGroup).Add(kAnchors).Add(stiffness_.inputs).Add(reach).value()};
}

bool NearGreen::Load(int group, Group* made) const {
  if (cache_.empty()) return false;
  const std::size_t bytes = made->numbers.size();
  std::vector<double> values(InDoubles(bytes) + made->tiles.size());
  if (!CacheFor(made->reach).Load(group, values)) return false;
  std::memcpy(made->numbers.data(), values.data(), bytes);
  for (std::size_t t = 0; t < made->tiles.size(); ++t) {
    made->tiles[t].step = static_cast<float>(values[InDoubles(bytes) + t]);
  }
  return true;
}

// All tiles, whichever group keeps them, so that any groups can be loaded without others.
std::vector<double> NearGreen::Packed(const Group& made) {
  const std::size_t bytes = made.numbers.size();
  std::vector<double> values(InDoubles(bytes), 0);
  std::memcpy(values.data(), made.numbers.data(), bytes);
  for (const Tile& tile : made.tiles) values.push_back(tile.step);
  return values;
}

std::vector<NearGreen::Bucket> NearGreen::Buckets(std::span<const int> nodes) const {
  std::vector<std::array<int, 2>> members;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    members.push_back({place_[Index(nodes[i])], static_cast<int>(i)});
  }
  std::ranges::sort(members);
  std::vector<Bucket> buckets;
  for (const auto& member : members) {
    const int group = member[0] / kGroup;
    if (buckets.empty() || buckets.back().group != group) buckets.push_back({group, {}});
    buckets.back().members.push_back(member);
  }
  return buckets;
}

bool NearGreen::GatherTile(const Bucket& to, const Bucket& from, MatrixXf* G) const {
  const Group &causes = groups_[Index(from.group)], &moved = groups_[Index(to.group)];
  const Tile *tile = causes.Find(to.group), *other = moved.Find(from.group);
  const bool turned = tile == nullptr || (other != nullptr && other->bytes > tile->bytes);
  if (turned) tile = other;
  if (tile == nullptr) return false;
  const std::int8_t* numbers = &(turned ? moved : causes).numbers[tile->first];
  const int along = turned ? 3 : 1, by = turned ? 1 : 3;
  for (const auto& [column, j] : from.members) {
    for (const auto& [row, i] : to.members) {
      const int a = row % kGroup, b = column % kGroup;
      const std::int8_t* block = numbers + 9 * (turned ? kGroup * b + a : kGroup * a + b);
      float* target = G->data() + 3 * (j * G->rows() + i);
      for (int c = 0; c < 3; ++c, target += G->rows()) {
        for (int r = 0; r < 3; ++r) {
          target[r] = tile->step * NumberAt(block + by * c + along * r, tile->bytes);
        }
      }
    }
  }
  return true;
}

// For the anchors, nine numbers each.
std::vector<float> NearGreen::AtAnchors(int node) const {
  const Group& group = groups_[Index(GroupOf(node))];
  const std::size_t in_group = Index(place_[Index(node)]) % kNodes;
  std::vector<float> values;
  values.reserve(9 * anchors_.size());
  for (std::size_t a = 0; a < anchors_.size(); ++a) {
    const Tile& tile = group.tiles[a / kNodes];
    const std::int8_t* numbers =
        &group.numbers[tile.first + 9 * (kNodes * (a % kNodes) + in_group)];
    for (int n = 0; n < 9; ++n) values.push_back(tile.step * NumberAt(numbers + n, tile.bytes));
  }
  return values;
}

// Along what is held the body does not move.
Matrix3f NearGreen::FarBlock(int node, const std::vector<float>& at_anchors) const {
  const Interpolation& by = interpolations_[Index(node)];
  Matrix3f block = Matrix3f::Zero();
  for (std::size_t k = 0; k < by.anchors.size(); ++k) {
    const float* values = &at_anchors[9 * Index(by.anchors[k])];
    for (int n = 0; n < 9; ++n) block.data()[n] += by.weights[k] * values[n];
  }
  for (int r = 0; r < 3; ++r) {
    if (Row(node, r) < 0) block.row(r).setZero();
  }
  return block;
}

bool NearGreen::GatherFar(std::span<const Bucket* const> to, const Bucket& from,
                          MatrixXf* G) const {
  if (!(groups_[Index(from.group)].reach > 0)) return to.empty();
  for (const auto& [column, j] : from.members) {
    if (to.empty()) break;
    const std::vector<float> at_anchors = AtAnchors(order_[Index(column)]);
    for (const Bucket* bucket : to) {
      for (const auto& [row, i] : bucket->members) {
        G->block<3, 3>(3 * i, 3 * j) = FarBlock(order_[Index(row)], at_anchors);
      }
    }
  }
  return true;
}

bool NearGreen::Gather(std::span<const int> to, std::span<const int> from, MatrixXf* G,
                       std::vector<std::array<int, 2>>* missed) {
  G->setZero(3 * static_cast<int>(to.size()), 3 * static_cast<int>(from.size()));
  bool complete = true;
  const std::vector<Bucket> rows = Buckets(to);
  std::vector<const Bucket*> far;
  for (const Bucket& column : Buckets(from)) {
    far.clear();
    for (const Bucket& row : rows) {
      if (!GatherTile(row, column, G)) far.push_back(&row);
    }
    if (GatherFar(far, column, G)) continue;
    complete = false;
    if (missed == nullptr) continue;
    for (const Bucket* row : far) {
      for (const auto& [place, i] : row->members) {
        for (const auto& [other, j] : column.members) missed->push_back({i, j});
      }
    }
  }
  return complete;
}

bool NearGreen::GatherAtAnchors(std::span<const int> anchors, std::span<const int> from,
                                MatrixXf* G) {
  G->setZero(3 * static_cast<int>(anchors.size()), 3 * static_cast<int>(from.size()));
  bool complete = true;
  for (std::size_t j = 0; j < from.size(); ++j) {
    const bool ready = groups_[Index(GroupOf(from[j]))].reach > 0;
    complete = complete && ready;
    if (!ready) continue;
    const std::vector<float> at_anchors = AtAnchors(from[j]);
    for (std::size_t i = 0; i < anchors.size(); ++i) {
      const Eigen::Map<const Matrix3f> block(&at_anchors[9 * Index(anchors[i])]);
      G->block<3, 3>(3 * static_cast<int>(i), 3 * static_cast<int>(j)) = block;
    }
  }
  return complete;
}

}  // namespace palpate
