// Builds a MeshFile from nodes and cells in the order of a file.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/files/file_cursor.h"
#include "slave/mesh/files/mesh_file.h"

namespace palpate {

// A cell type of a format. The corners come first among its nodes.
struct CellKind {
  enum class Use : std::uint8_t { kTet, kTriangle, kQuad, kPassedOver, kRefused };
  int code = 0;   // the format's number
  int nodes = 0;  // 0: any
  Use use = Use::kRefused;
  std::string_view name;
};
const CellKind* FindKind(std::span<const CellKind> kinds, std::int64_t code);

class MeshBuilder {
 public:
  // Throws std::invalid_argument through `place`, which must outlive it.
  explicit MeshBuilder(const SourcePlace& place) : place_(&place) {}
  // Sets the position for cells from another file.
  void set_place(const SourcePlace& place) { place_ = &place; }

  void ReserveNodes(std::size_t count);
  // Numbers are the file's. Throws: a number twice.
  void AddNode(std::int64_t number, const Eigen::Vector3d& p);
  [[nodiscard]] std::size_t node_count() const { return mesh_nodes_.size(); }
  // Throws: nodes that do not exist, a cell that is refused. Quadrilaterals are cut in two along
  // their shorter diagonal.
  void AddCell(const CellKind& kind, std::int64_t number, std::span<const std::int64_t> nodes);
  void Remark(std::string remark) { remarks_.push_back(std::move(remark)); }

  // Throws: `largest`, a coordinate [m], is too large to compute with.
  void RequireNear(double largest) const;
  // The tetrahedra or, without any, the triangles, in metres. Throws: neither, coordinates too
  // large to compute with.
  MeshFile Finish(double unit);

 private:
  [[nodiscard]] int IndexOf(std::int64_t number) const;
  void AddQuad(std::int64_t number, const std::array<int, 4>& corners);
  void UseCorners(std::span<const int> corners);
  // Removes the mid-edge nodes of quadratic elements, which no linear element uses.
  void DropMiddles(std::vector<std::array<int, 4>>* tets,
                   std::vector<std::array<int, 3>>* triangles);

  const SourcePlace* place_;
  std::vector<Eigen::Vector3d> mesh_nodes_;  // in the file's unit
  std::vector<std::int64_t> node_numbers_;
  bool consecutive_ = true;                           // node numbers, each one above the last
  std::unordered_map<std::int64_t, int> node_index_;  // if they are not
  enum class Role : std::uint8_t { kNone, kMiddle, kCorner };
  std::vector<Role> roles_;
  std::vector<std::array<int, 4>> tets_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::int64_t> tet_numbers_, triangle_numbers_;
  std::size_t quads_ = 0;
  std::vector<std::string> remarks_;
};

}  // namespace palpate
