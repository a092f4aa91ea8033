#include "slave/mesh/mesh_census.h"

#include <numeric>
#include <tuple>
#include <utility>

#include "shared/mesh/node_merger.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSamePlace = 1e-9;                // of the diagonal
constexpr double kMaxUsual = 2, kMinUsual = 2e-5;  // diagonal [m]
constexpr std::size_t kMaxListed = 5;

template <class Name>
std::string List(const char* what, const std::vector<int>& indices, Name name) {
  std::string text = what;
  for (std::size_t i = 0; i < std::min(indices.size(), kMaxListed); ++i) {
    text += (i == 0 ? " " : ", ") + name(indices[i]);
  }
  if (indices.size() <= kMaxListed) return text;
  return text + " and " + std::to_string(indices.size() - kMaxListed) + " more";
}

// Returns the number without the word that List writes before it.
std::string Number(const std::string& named) {
  return named.substr(named.find(' ') + 1);
}

std::string Length(double metres) {
  const std::array<std::pair<double, const char*>, 5> units{
      {{1e3, " km"}, {1, " m"}, {1e-3, " mm"}, {1e-6, " um"}, {0, " nm"}}};
  for (const auto& [unit, name] : units) {
    if (metres >= unit) return Formatted("%.4g%s", metres / (unit > 0 ? unit : 1e-9), name);
  }
  return "0 m";
}

void FindDuplicates(const std::vector<Vector3d>& nodes, const MeshNumbers& numbers,
                    MeshReport* report) {
  const Vector3d low = report->low_O;
  NodeMerger merger(kSamePlace * (report->high_O - low).norm());
  std::vector<int> first;  // node of each place
  std::string example;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto place = static_cast<std::size_t>(merger.FindOrAdd(nodes[i] - low));
    const int node = static_cast<int>(i);
    if (place == first.size()) {
      first.push_back(node);
      continue;
    }
    if (report->duplicate_nodes.empty()) {
      example = numbers.Node(node) + " lies at " + numbers.Node(first[place]);
    }
    report->duplicate_nodes.push_back(node);
  }
  if (report->duplicate_nodes.empty()) return;
  report->warnings.push_back(std::to_string(report->duplicate_nodes.size()) + " duplicate nodes (" +
                             example + "): elements that use different ones are not connected");
}

void CheckSize(double diagonal, MeshReport* report) {
  if (diagonal > kMaxUsual) {
    report->warnings.push_back("diagonal of " + Length(diagonal) +
                               ": probably millimetres; if so, set unit: mm");
  } else if (diagonal < kMinUsual) {
    report->warnings.push_back("diagonal of " + Length(diagonal) +
                               ": smaller than a cell; is the file in metres? If not, set unit");
  }
}

}  // namespace

std::string ListElements(const MeshNumbers& numbers, const std::vector<int>& elements) {
  return List(elements.size() == 1 ? "element" : "elements", elements,
              [&](int i) { return Number(numbers.Element(i)); });
}

std::string ListNodes(const MeshNumbers& numbers, const std::vector<int>& nodes) {
  return List(nodes.size() == 1 ? "node" : "nodes", nodes,
              [&](int i) { return Number(numbers.Node(i)); });
}

void CountNodes(const std::vector<Vector3d>& nodes, const std::vector<bool>& used,
                const MeshNumbers& numbers, bool unit_given, MeshReport* report) {
  bool first = true;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!used[i]) {
      report->dangling_nodes.push_back(static_cast<int>(i));
      continue;
    }
    report->low_O = first ? nodes[i] : Vector3d(report->low_O.cwiseMin(nodes[i]));
    report->high_O = first ? nodes[i] : Vector3d(report->high_O.cwiseMax(nodes[i]));
    first = false;
  }
  if (!report->dangling_nodes.empty()) {
    report->warnings.push_back(
        std::to_string(report->dangling_nodes.size()) +
        " nodes belong to no element: " + ListNodes(numbers, report->dangling_nodes));
  }
  FindDuplicates(nodes, numbers, report);
  if (!unit_given) CheckSize((report->high_O - report->low_O).norm(), report);
}

void CountQuality(std::vector<double> quality, const MeshNumbers& numbers, MeshReport* report) {
  for (std::size_t i = 0; i < quality.size(); ++i) {
    if (quality[i] < MeshReport::kSliver) report->slivers.push_back(static_cast<int>(i));
  }
  if (!report->slivers.empty()) {
    report->warnings.push_back(
        std::to_string(report->slivers.size()) +
        " slivers, quality below 0.05: " + ListElements(numbers, report->slivers));
  }
  std::ranges::sort(quality);
  const std::size_t n = quality.size();
  report->quality_min = quality.front();
  report->quality_median = 0.5 * (quality[(n - 1) / 2] + quality[n / 2]);
}

template <std::size_t N>
std::vector<int> PartsOf(const std::vector<std::array<int, N>>& elements, std::size_t nodes,
                         int* parts) {
  std::vector<int> parent(nodes);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    auto k = static_cast<std::size_t>(i);
    while (parent[k] != static_cast<int>(k)) {
      parent[k] = parent[static_cast<std::size_t>(parent[k])];
      k = static_cast<std::size_t>(parent[k]);
    }
    return k;
  };
  for (const auto& element : elements) {
    for (const int i : element) parent[root(i)] = static_cast<int>(root(element[0]));
  }
  std::vector<int> number(nodes, -1), part(nodes, -1);
  *parts = 0;
  for (const auto& element : elements) {
    int& own = number[root(element[0])];
    if (own < 0) own = (*parts)++;
    for (const int i : element) part[static_cast<std::size_t>(i)] = own;
  }
  return part;
}

template <std::size_t N>
bool IsReadable(const std::vector<Vector3d>& nodes, const std::vector<std::array<int, N>>& elements,
                const MeshNumbers& numbers, MeshReport* report) {
  if (elements.empty()) report->refusals.emplace_back("no element: expected one or more");
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (nodes[i].allFinite()) continue;
    report->refusals.push_back(numbers.Node(static_cast<int>(i)) +
                               " is not finite: expected finite coordinates");
    break;
  }
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto [low, high] = std::ranges::minmax(elements[i]);
    if (low >= 0 && high < static_cast<int>(nodes.size())) continue;
    report->refusals.push_back(numbers.Element(static_cast<int>(i)) +
                               " has a node that does not exist: expected the " +
                               std::to_string(nodes.size()) + " nodes of the mesh");
    break;
  }
  return report->refusals.empty();
}

template <std::size_t N>
void RefuseDuplicates(const std::vector<std::array<int, N>>& elements, const MeshNumbers& numbers,
                      MeshReport* report) {
  struct Sorted {
    std::array<int, N> nodes;
    int element;
    bool operator<(const Sorted& other) const {
      return std::tie(nodes, element) < std::tie(other.nodes, other.element);
    }
  };
  std::vector<Sorted> sorted;
  sorted.reserve(elements.size());
  for (const auto& element : elements) {
    sorted.push_back({element, static_cast<int>(sorted.size())});
    std::ranges::sort(sorted.back().nodes);
  }
  std::sort(sorted.begin(), sorted.end());
  int count = 0;
  std::string example;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].nodes != sorted[i - 1].nodes) continue;
    if (count++ > 0) continue;
    example = numbers.Element(sorted[i].element) + " has the nodes of " +
              numbers.Element(sorted[i - 1].element);
  }
  if (count == 0) return;
  report->refusals.push_back(example + " (" + std::to_string(count) +
                             " such): expected every element once");
}

template <std::size_t N>
std::vector<bool> UsedNodes(const std::vector<std::array<int, N>>& elements, std::size_t nodes) {
  std::vector<bool> used(nodes, false);
  for (const auto& element : elements) {
    for (const int i : element) used[static_cast<std::size_t>(i)] = true;
  }
  return used;
}

using Nodes = std::vector<Vector3d>;
using Tets = std::vector<std::array<int, 4>>;
using Triangles = std::vector<std::array<int, 3>>;
template std::vector<int> PartsOf(const Tets&, std::size_t, int*);
template std::vector<int> PartsOf(const Triangles&, std::size_t, int*);
template bool IsReadable(const Nodes&, const Tets&, const MeshNumbers&, MeshReport*);
template bool IsReadable(const Nodes&, const Triangles&, const MeshNumbers&, MeshReport*);
template void RefuseDuplicates(const Tets&, const MeshNumbers&, MeshReport*);
template void RefuseDuplicates(const Triangles&, const MeshNumbers&, MeshReport*);
template std::vector<bool> UsedNodes(const Tets&, std::size_t);
template std::vector<bool> UsedNodes(const Triangles&, std::size_t);

}  // namespace palpate
