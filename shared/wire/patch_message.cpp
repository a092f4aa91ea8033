#include "shared/wire/patch_message.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "shared/geometry/symmetric_eigen.h"
#include "shared/patch/patch_place.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr double kMaxCompliance = 1e6;  // [m/N]
constexpr double kMaxRatio = 1e6, kMaxFriction = 1e3;
constexpr double kMinLength = 1e-9;  // smallest edge of a cell, and smallest depth [m]

std::size_t At(int i) {
  return static_cast<std::size_t>(i);
}

// Returns the number of entries in the lower triangle of a symmetric matrix.
constexpr int Triangle(int size) {
  return size * (size + 1) / 2;
}

// Calls `each` for every entry that is sent, in order.
template <class Each>
void ForEachEntry(int nodes, int directions, bool coupled, const Each& each) {
  const int block = coupled ? nodes * directions : directions;
  for (int begin = 0; begin < nodes * directions; begin += block) {
    for (int i = 0; i < block; ++i) {
      for (int j = 0; j <= i; ++j) each(begin + i, begin + j);
    }
  }
}

void ReadVertices(const v1::SurfacePatch& message, FieldReader* reader, SurfacePatch* patch) {
  const int count = message.vertices_size() / 3;
  reader->Require(message.vertices_size() % 3 == 0 && count >= 1 && count <= kPatchVertices,
                  "vertices", "three numbers each, of 1 to 204");
  if (!reader->ok()) return;
  patch->vertex_count = count;
  for (int i = 0; i < 3 * count; ++i) {
    patch->vertices[At(i / 3)][i % 3] =
        static_cast<float>(reader->Number("vertices", message.vertices(i), kMaxLength));
  }
}

void ReadCells(const v1::SurfacePatch& message, FieldReader* reader, SurfacePatch* patch) {
  const int corners = static_cast<int>(std::min(message.vertices_per_cell(), 4U));
  const int count = corners > 0 ? message.cells_size() / corners : 0;
  const bool is_plane = corners == 1 && patch->vertex_count == 1 && message.cells_size() == 0;
  const bool fits = (corners == 2 || corners == 3) && message.cells_size() % corners == 0 &&
                    count >= 1 && count <= kPatchCells;
  reader->Require(is_plane || fits, "cells", "1 to 200 lines or triangles, or a plane");
  if (!reader->ok()) return;
  patch->vertices_per_cell = corners;
  patch->cell_count = is_plane ? 0 : count;
  for (int i = 0; i < message.cells_size(); ++i) {
    const bool is_vertex = message.cells(i) < static_cast<std::uint32_t>(patch->vertex_count);
    reader->Require(is_vertex, "cells", "numbers of vertices");
    if (!reader->ok()) return;
    patch->cells[At(i / corners)][At(i % corners)] = static_cast<std::uint8_t>(message.cells(i));
  }
}

// Requires that every cell has a length or an area.
void RequireShape(const SurfacePatch& patch, FieldReader* reader) {
  for (int cell = 0; cell < patch.cell_count; ++cell) {
    const auto vertex = [&](int k) -> Eigen::Vector3d {
      return patch.vertices[At(VertexOf(patch, cell, k))].cast<double>();
    };
    const Eigen::Vector3d side = vertex(1) - vertex(0);
    const bool is_line = side.head<2>().norm() > kMinLength;
    const bool is_area = patch.vertices_per_cell == 3 &&
                         side.cross(vertex(2) - vertex(0)).norm() > kMinLength * kMinLength;
    reader->Require(patch.vertices_per_cell == 2 ? is_line : is_area, "cells",
                    "lines and triangles with an extent");
  }
}

void ReadNodes(const v1::SurfacePatch& message, FieldReader* reader, SurfacePatch* patch) {
  reader->Require(message.nodes_size() == patch->vertex_count, "nodes", "one per vertex");
  if (!reader->ok()) return;
  for (int i = 0; i < patch->vertex_count; ++i) {
    reader->Require(message.nodes(i) < static_cast<std::uint32_t>(kPatchNodes), "nodes", "0 to 31");
    if (!reader->ok()) return;
    patch->node_of[At(i)] = static_cast<std::uint8_t>(message.nodes(i));
    patch->node_count = std::max(patch->node_count, patch->node_of[At(i)] + 1);
  }
}

// Replaces the compliance by the nearest passive one.
void MakePassive(SurfacePatch* patch) {
  const int size = patch->node_count * patch->directions;
  const int block = patch->coupled ? size : patch->directions;
  for (int begin = 0; begin < size; begin += block) {
    const Eigen::MatrixXd C = patch->compliance.block(begin, begin, block, block).cast<double>();
    const SymmetricEigen modes = EigenOf(C);
    if (modes.values.minCoeff() >= 0) continue;
    const Eigen::MatrixXd kept =
        modes.vectors * modes.values.cwiseMax(0).asDiagonal() * modes.vectors.transpose();
    patch->compliance.block(begin, begin, block, block) = kept.cast<float>();
  }
}

void ReadCompliance(const v1::SurfacePatch& message, FieldReader* reader, SurfacePatch* patch) {
  reader->Require(message.directions() == 1 || message.directions() == 3, "directions", "1 or 3");
  if (!reader->ok()) return;
  patch->directions = static_cast<int>(message.directions());
  const int size = patch->node_count * patch->directions;
  const int own = patch->node_count * Triangle(patch->directions);
  const int sent = message.compliance_size();
  reader->Require(sent == own || sent == Triangle(size), "compliance",
                  "the lower triangle of all nodes, or each node's own");
  if (!reader->ok()) return;
  patch->coupled = sent != own;
  patch->compliance.setZero(size, size);
  int i = 0;
  ForEachEntry(patch->node_count, patch->directions, patch->coupled, [&](int row, int column) {
    const double value = reader->Number("compliance", message.compliance(i++), kMaxCompliance);
    patch->compliance(row, column) = patch->compliance(column, row) = static_cast<float>(value);
    reader->Require(row != column || value >= 0, "compliance of a node", "0 or more");
  });
  // A fixed node has none, but a surface without any would be a wall.
  reader->Require(patch->compliance.trace() > 0, "compliance", "one node that gives way");
  if (reader->ok()) MakePassive(patch);
}

void ReadTools(const v1::SurfacePatch& message, FieldReader* reader, SurfacePatch* patch) {
  reader->Require(message.tools_size() >= 1 && message.tools_size() <= kPatchTools, "tools",
                  "1 to 5");
  if (!reader->ok()) return;
  patch->tool_count = message.tools_size();
  for (int i = 0; i < patch->tool_count; ++i) {
    PatchTool& tool = patch->tools[At(i)];
    tool.centre = reader->Vector("tools.centre", message.tools(i).centre(), kMaxLength);
    tool.radius = reader->NonNegative("tools.radius", message.tools(i).radius(), kMaxLength);
  }
}

void ReadNormal(const v1::SurfacePatch& message, FieldReader* reader, SurfacePatch* patch) {
  if (patch->vertices_per_cell != 1) return;
  patch->normal = reader->Vector("normal", message.normal(), 1 + kUnitTolerance);
  reader->Require(std::abs(patch->normal.norm() - 1) <= kUnitTolerance, "normal", "a unit vector");
  if (reader->ok()) patch->normal.normalize();
}

double Depth(std::string_view name, double value, FieldReader* reader) {
  reader->Require(value >= kMinLength, name, "a length above 1 nm");
  return reader->NonNegative(name, value, kMaxLength);
}

// Resamples the ratios at kLawPoints points, whatever number was sent.
void ReadRatios(const v1::PatchLaw& message, FieldReader* reader, PatchLaw* law) {
  const int sent = message.ratios_size();
  reader->Require(sent >= 1 && sent <= kLawPoints, "ratios", "1 to 16 numbers");
  if (!reader->ok()) return;
  for (int i = 0; i < kLawPoints; ++i) {
    const double at = static_cast<double>(i) / (kLawPoints - 1) * (sent - 1);
    const int below = std::clamp(static_cast<int>(at), 0, std::max(sent - 2, 0));
    const double low = reader->NonNegative("ratios", message.ratios(below), kMaxRatio);
    const double high =
        reader->NonNegative("ratios", message.ratios(std::min(below + 1, sent - 1)), kMaxRatio);
    law->ratios[At(i)] = low + (at - below) * (high - low);
  }
}

}  // namespace

void ToProto(const SurfacePatch& patch, v1::SurfacePatch* message) {
  message->Clear();
  message->set_epoch(patch.epoch);
  message->set_settings_revision(patch.settings_revision);
  for (int i = 0; i < patch.vertex_count; ++i) {
    for (int k = 0; k < 3; ++k) message->add_vertices(patch.vertices[At(i)][k]);
    message->add_nodes(patch.node_of[At(i)]);
  }
  message->set_vertices_per_cell(static_cast<std::uint32_t>(patch.vertices_per_cell));
  for (int cell = 0; cell < patch.cell_count; ++cell) {
    for (int k = 0; k < patch.vertices_per_cell; ++k) {
      message->add_cells(patch.cells[At(cell)][At(k)]);
    }
  }
  message->set_directions(static_cast<std::uint32_t>(patch.directions));
  ForEachEntry(patch.node_count, patch.directions, patch.coupled, [&](int row, int column) {
    message->add_compliance(Narrow(static_cast<double>(patch.compliance(row, column))));
  });
  for (int i = 0; i < patch.tool_count; ++i) {
    auto* tool = message->add_tools();
    ToProto(patch.tools[At(i)].centre, tool->mutable_centre());
    tool->set_radius(Narrow(patch.tools[At(i)].radius));
  }
  message->set_full_depth(Narrow(patch.full_depth));
  message->set_valid_depth(Narrow(patch.valid_depth));
  if (patch.vertices_per_cell == 1) ToProto(patch.normal, message->mutable_normal());
}

void ToProto(const PatchLaw& law, v1::PatchLaw* message) {
  message->Clear();
  message->set_epoch(law.epoch);
  message->set_revision(law.revision);
  const bool is_one = std::ranges::all_of(law.ratios, [&](double r) { return r == law.ratios[0]; });
  for (int i = 0; i < (is_one ? 1 : kLawPoints); ++i) {
    message->add_ratios(Narrow(law.ratios[At(i)]));
  }
  if (law.friction) message->set_friction(Narrow(*law.friction));
  if (!law.offset.isZero(0)) ToProto(law.offset, message->mutable_offset());
  if (!law.velocity.isZero(0)) ToProto(law.velocity, message->mutable_velocity());
  message->set_velocity_error(Narrow(law.velocity_error));
  ToProto(law.sensed_at, message->mutable_sensed_at());
}

std::optional<SurfacePatch> FromProto(const v1::SurfacePatch& message, std::string* reason) {
  FieldReader reader(reason);
  SurfacePatch patch;
  reader.Require(message.epoch() > 0, "epoch = 0", "1 or more");
  patch.epoch = message.epoch();
  patch.settings_revision = message.settings_revision();
  if (reader.ok()) ReadVertices(message, &reader, &patch);
  if (reader.ok()) ReadCells(message, &reader, &patch);
  if (reader.ok()) RequireShape(patch, &reader);
  if (reader.ok()) ReadNodes(message, &reader, &patch);
  if (reader.ok()) ReadCompliance(message, &reader, &patch);
  if (reader.ok()) ReadTools(message, &reader, &patch);
  if (reader.ok()) ReadNormal(message, &reader, &patch);
  patch.full_depth = Depth("full_depth", message.full_depth(), &reader);
  patch.valid_depth = Depth("valid_depth", message.valid_depth(), &reader);
  if (!reader.ok()) return std::nullopt;
  MarkRim(&patch);
  return patch;
}

std::optional<PatchLaw> FromProto(const v1::PatchLaw& message, std::string* reason) {
  FieldReader reader(reason);
  PatchLaw law;
  reader.Require(message.epoch() > 0, "epoch = 0", "1 or more");
  reader.Require(message.revision() > 0, "revision = 0", "1 or more");
  law.epoch = message.epoch();
  law.revision = message.revision();
  ReadRatios(message, &reader, &law);
  if (message.has_friction()) {
    law.friction = reader.NonNegative("friction", message.friction(), kMaxFriction);
  }
  law.offset = reader.Vector("offset", message.offset(), kMaxLength);
  law.velocity = reader.Vector("velocity", message.velocity(), kMaxSpeed);
  law.velocity_error = reader.NonNegative("velocity_error", message.velocity_error(), kMaxSpeed);
  law.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  if (!reader.ok()) return std::nullopt;
  return law;
}

}  // namespace palpate
