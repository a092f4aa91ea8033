// The same small meshes in every format and form, written by hand here rather than by the writers
// under test.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "shared/mesh/solid_mesh.h"

namespace palpate::samples {

// Two tetrahedra on a common face, coordinates that a float holds.
inline SolidMesh Pair() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1.5, 0}, {0, 0, 2}, {1, 1, -0.25}},
          {{0, 1, 2, 3}, {0, 2, 1, 4}}};
}
// The tetrahedron's boundary.
inline SurfaceMesh Tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1.5, 0}, {0, 0, 2}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

inline std::string Text(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.17g", value);
  return text.data();
}

// Numbers as bytes.
class Bytes {
 public:
  explicit Bytes(bool little = true) : little_(little) {}
  template <class T>
  Bytes& Add(T value) {
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (little_ != (std::endian::native == std::endian::little)) std::ranges::reverse(raw);
    bytes_.append(raw.data(), raw.size());
    return *this;
  }
  Bytes& Add(const std::string& text) {
    bytes_ += text;
    return *this;
  }
  [[nodiscard]] const std::string& str() const { return bytes_; }

 private:
  bool little_;
  std::string bytes_;
};

inline std::string Node(const SolidMesh& mesh, int first) {
  std::string text = std::to_string(mesh.nodes.size()) + "  3  1  1\n";
  int number = first;
  for (const auto& p : mesh.nodes) {
    text += std::to_string(number++) + "  " + Text(p.x()) + " " + Text(p.y()) + " " + Text(p.z()) +
            "  7.5  1  # attribute, marker\n";
  }
  return text + "# the end\n";
}
inline std::string Ele(const SolidMesh& mesh, int first) {
  std::string text = "# tetrahedra\n\n" + std::to_string(mesh.tets.size()) + "  4  1\n";
  int number = first;
  for (const auto& tet : mesh.tets) {
    text += std::to_string(number++);
    for (const int i : tet) text += " " + std::to_string(i + first);
    text += " 3\r\n";
  }
  return text;
}
// Also contains a line, a point and a triangle, which a reader of volumes ignores, and numbering
// with gaps.
inline std::string Gmsh2Text(const SolidMesh& mesh) {
  std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"foam\"\n$EndPhysicalNames\n"
      "$Nodes\n" +
      std::to_string(mesh.nodes.size()) + "\n";
  int number = 10;
  for (const auto& p : mesh.nodes) {
    text +=
        std::to_string(number) + " " + Text(p.x()) + " " + Text(p.y()) + " " + Text(p.z()) + "\n";
    number += 10;
  }
  text += "$EndNodes\n$Elements\n" + std::to_string(mesh.tets.size() + 3) +
          "\n1 15 2 0 1 10\n2 1 2 0 1 10 20\n3 2 2 0 1 10 20 30\n";
  number = 4;
  for (const auto& tet : mesh.tets) {
    text += std::to_string(number++) + " 4 2 1 1";
    for (const int i : tet) text += " " + std::to_string(10 * (i + 1));
    text += "\n";
  }
  return text + "$EndElements\n";
}
inline std::string Gmsh2Binary(const SolidMesh& mesh, bool little) {
  Bytes b(little);
  b.Add(std::string("$MeshFormat\n2.2 1 8\n")).Add(std::int32_t{1});
  b.Add("\n$EndMeshFormat\n$Nodes\n" + std::to_string(mesh.nodes.size()) + "\n");
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    b.Add(static_cast<std::int32_t>(10 * (i + 1)));
    for (const double c : mesh.nodes[i]) b.Add(c);
  }
  b.Add("\n$EndNodes\n$Elements\n" + std::to_string(mesh.tets.size() + 1) + "\n");
  for (const std::int32_t i : {2, 1, 2, 3, 0, 1, 10, 20, 30}) b.Add(i);  // a triangle
  for (const std::int32_t i : {4, static_cast<int>(mesh.tets.size()), 2}) b.Add(i);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    b.Add(static_cast<std::int32_t>(4 + t)).Add(std::int32_t{1}).Add(std::int32_t{1});
    for (const int i : mesh.tets[t]) b.Add(static_cast<std::int32_t>(10 * (i + 1)));
  }
  return b.Add(std::string("\n$EndElements\n")).str();
}
inline std::string Gmsh4Text(const SolidMesh& mesh) {
  const std::string nodes = std::to_string(mesh.nodes.size());
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 0\n$EndEntities\n" +
                     ("$Nodes\n2 " + nodes) + " 10 1000\n0 1 0 1\n10\n" + Text(mesh.nodes[0].x()) +
                     " " + Text(mesh.nodes[0].y()) + " " + Text(mesh.nodes[0].z()) + "\n3 1 0 " +
                     std::to_string(mesh.nodes.size() - 1) + "\n";
  for (std::size_t i = 1; i < mesh.nodes.size(); ++i) text += std::to_string(10 * (i + 1)) + "\n";
  for (std::size_t i = 1; i < mesh.nodes.size(); ++i) {
    const auto& p = mesh.nodes[i];
    text += Text(p.x()) + " " + Text(p.y()) + " " + Text(p.z()) + "\n";
  }
  text += "$EndNodes\n$Elements\n2 " + std::to_string(mesh.tets.size() + 1) +
          " 1 9\n2 1 2 1\n3 10 20 30\n3 1 4 " + std::to_string(mesh.tets.size()) + "\n";
  int number = 4;
  for (const auto& tet : mesh.tets) {
    text += std::to_string(number++);
    for (const int i : tet) text += " " + std::to_string(10 * (i + 1));
    text += "\n";
  }
  return text + "$EndElements\n";
}
inline std::string Gmsh4Binary(const SolidMesh& mesh, bool little) {
  using U = std::uint64_t;
  Bytes b(little);
  b.Add(std::string("$MeshFormat\n4.1 1 8\n")).Add(std::int32_t{1});
  b.Add(std::string("\n$EndMeshFormat\n$Nodes\n"));
  for (const U i : {U{1}, U{mesh.nodes.size()}, U{10}, U{1000}}) b.Add(i);
  for (const std::int32_t i : {2, 1, 1}) b.Add(i);  // a parametric surface: two parameters each
  b.Add(U{mesh.nodes.size()});
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) b.Add(U{10 * (i + 1)});
  for (const auto& p : mesh.nodes) {
    for (const double c : p) b.Add(c);
    b.Add(0.25).Add(0.75);
  }
  b.Add(std::string("\n$EndNodes\n$Elements\n"));
  for (const U i : {U{1}, U{mesh.tets.size()}, U{4}, U{9}}) b.Add(i);
  for (const std::int32_t i : {3, 1, 4}) b.Add(i);
  b.Add(U{mesh.tets.size()});
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    b.Add(U{4 + t});
    for (const int i : mesh.tets[t]) b.Add(U{10 * (static_cast<U>(i) + 1)});
  }
  return b.Add(std::string("\n$EndElements\n")).str();
}

inline std::string StlText(const SurfaceMesh& mesh) {
  std::string text = "solid sample of nothing\n";
  for (const auto& triangle : mesh.triangles) {
    text += " facet normal 0 0 0\n  outer loop\n";
    for (const int i : triangle) {
      const auto& p = mesh.nodes[static_cast<std::size_t>(i)];
      text += "   vertex " + Text(p.x()) + " " + Text(p.y()) + " " + Text(p.z()) + "\n";
    }
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid sample\n";
}
// With the header that some programs write although it announces text.
inline std::string StlBinary(const SurfaceMesh& mesh) {
  std::string header = "solid binary";
  header.resize(80, ' ');
  Bytes b;
  b.Add(header).Add(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) b.Add(0.0F);
    for (const int i : triangle) {
      for (const double c : mesh.nodes[static_cast<std::size_t>(i)]) b.Add(static_cast<float>(c));
    }
    b.Add(std::uint16_t{0});
  }
  return b.str();
}

// `format`: ascii, binary_little_endian or binary_big_endian. Also contains properties and elements
// that the reader ignores.
inline std::string Ply(const SurfaceMesh& mesh, const std::string& format) {
  const bool text = format == "ascii", little = format == "binary_little_endian";
  Bytes b(little);
  b.Add("ply\nformat " + format + " 1.0\ncomment sample\nelement vertex " +
        std::to_string(mesh.nodes.size()) +
        "\nproperty float x\nproperty float y\nproperty double z\nproperty uchar red\n"
        "element edge 1\nproperty list uchar short ends\n"
        "element face " +
        std::to_string(mesh.triangles.size()) +
        "\nproperty char flag\nproperty list uchar int vertex_indices\nend_header\n");
  for (const auto& p : mesh.nodes) {
    if (text) {
      b.Add(Text(p.x()) + " " + Text(p.y()) + " " + Text(p.z()) + " 200\n");
    } else {
      b.Add(static_cast<float>(p.x())).Add(static_cast<float>(p.y())).Add(p.z());
      b.Add(std::uint8_t{200});
    }
  }
  if (text) {
    b.Add(std::string("2 0 1\n"));
  } else {
    b.Add(std::uint8_t{2}).Add(std::int16_t{0}).Add(std::int16_t{1});
  }
  for (const auto& t : mesh.triangles) {
    if (text) {
      b.Add("-1 3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " +
            std::to_string(t[2]) + "\n");
    } else {
      b.Add(std::int8_t{-1}).Add(std::uint8_t{3});
      for (const std::int32_t i : t) b.Add(i);
    }
  }
  return b.str();
}

}  // namespace palpate::samples
