// How a file numbers a mesh's nodes and elements, so that messages name them as the file does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpate {

// The file's number of node or element i; empty: the file counts from 0, or there is no file.
struct MeshNumbers {
  std::vector<std::int64_t> nodes, elements;

  [[nodiscard]] std::string Node(int i) const { return "node " + Name(nodes, i); }
  [[nodiscard]] std::string Element(int i) const { return "element " + Name(elements, i); }

 private:
  static std::string Name(const std::vector<std::int64_t>& numbers, int i) {
    return std::to_string(numbers.empty() ? i : numbers[static_cast<std::size_t>(i)]);
  }
};

}  // namespace palpate
