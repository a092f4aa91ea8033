#include "master/link/remote_mesh.h"

#include <algorithm>
#include <cmath>

#include "palpate/v1/state.pb.h"

#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr int kLine = 2, kTriangle = 3;
constexpr double kSinglePrecision = 1e-7;  // of the object's size
constexpr double kMaxTraction = 1e15;      // [Pa], larger than any result of a model

using Floats = google::protobuf::RepeatedField<float>;

std::vector<Eigen::Vector3d> Points(std::string_view name, const Floats& numbers, double limit,
                                    FieldReader* reader) {
  reader->Require(numbers.size() % 3 == 0, name, "three numbers per node");
  std::vector<Eigen::Vector3d> points;
  if (!reader->ok()) return points;
  points.reserve(static_cast<std::size_t>(numbers.size() / 3));
  for (int i = 0; i < numbers.size() && reader->ok(); i += 3) {
    points.emplace_back(reader->Number(name, numbers[i], limit),
                        reader->Number(name, numbers[i + 1], limit),
                        reader->Number(name, numbers[i + 2], limit));
  }
  return points;
}

std::vector<float> Numbers(std::string_view name, const Floats& numbers, double limit,
                           FieldReader* reader) {
  for (const float number : numbers) reader->Number(name, number, limit);
  return {numbers.begin(), numbers.end()};
}

// A topology without a field is that of a reader who did not request one.
void ReadField(const v1::DisplacementField& field, const MeshTopology& topology,
               FieldReader* reader, RemoteMesh* mesh) {
  if (topology.field_rest.empty() || field.displacement().empty()) return;
  mesh->displacement = Numbers("field.displacement", field.displacement(), kMaxLength, reader);
  mesh->image.assign(field.image().begin(), field.image().end());
  const std::size_t numbers = topology.field_rest.size();
  reader->Require(mesh->displacement.size() == numbers, "field.displacement",
                  "three numbers per node of `field.rest`");
  reader->Require(mesh->image.empty() || 3 * mesh->image.size() == 2 * numbers, "field.image",
                  "none, or two numbers per node of `field.rest`");
}

template <std::size_t kNodes>
std::vector<std::array<int, kNodes>> Elements(const v1::MeshState& message) {
  std::vector<std::array<int, kNodes>> elements(static_cast<std::size_t>(message.elements_size()) /
                                                kNodes);
  int next = 0;
  for (auto& element : elements) {
    for (int& node : element) node = static_cast<int>(message.elements(next++));
  }
  return elements;
}

std::shared_ptr<const MeshTopology> Topology(const v1::MeshState& message, FieldReader* reader) {
  const auto nodes = static_cast<int>(message.nodes_per_element());
  reader->Require(nodes == kLine || nodes == kTriangle, "nodes_per_element", "2 or 3");
  if (!reader->ok()) return nullptr;
  reader->Require(message.elements_size() % nodes == 0, "elements",
                  "nodes_per_element indices each");
  auto topology = std::make_shared<MeshTopology>();
  topology->surface.nodes = Points("rest", message.rest(), kMaxLength, reader);
  const std::size_t count = topology->surface.nodes.size();
  reader->Require(std::all_of(message.elements().begin(), message.elements().end(),
                              [count](std::uint32_t node) { return node < count; }),
                  "elements", "indices of nodes in `rest`");
  topology->fixed_nodes.assign(message.fixed_nodes().begin(), message.fixed_nodes().end());
  reader->Require(std::ranges::all_of(topology->fixed_nodes,
                                      [count](std::uint32_t node) { return node < count; }),
                  "fixed_nodes", "indices of nodes in `rest`");
  const v1::DisplacementField& field = message.field();
  topology->field_rest = Numbers("field.rest", field.rest(), kMaxLength, reader);
  topology->field_triangles.assign(field.triangles().begin(), field.triangles().end());
  const bool are_nodes = std::ranges::all_of(field.triangles(), [&](std::uint32_t node) {
    return std::size_t{3} * node < topology->field_rest.size();
  });
  reader->Require(field.rest_size() % 3 == 0 && field.triangles_size() % 3 == 0 && are_nodes,
                  "field", "three numbers per node, and three nodes per triangle");
  if (!reader->ok()) return nullptr;
  if (nodes == kTriangle) {
    topology->surface.triangles = Elements<kTriangle>(message);
  } else {
    topology->lines = Elements<kLine>(message);
  }
  return topology;
}

}  // namespace

double RemoteMesh::LargestDeflection() const {
  double largest = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    largest = std::max(largest, (positions[i] - topology->surface.nodes[i]).squaredNorm());
  }
  const double resolution = kSinglePrecision * Diagonal(topology->surface.nodes);
  return largest > resolution * resolution ? std::sqrt(largest) : 0;
}

std::optional<RemoteMesh> FromProto(const v1::MeshState& message,
                                    const std::shared_ptr<const MeshTopology>& known,
                                    std::string* reason) {
  FieldReader reader(reason);
  RemoteMesh mesh;
  mesh.sequence = message.sequence();
  mesh.sensed_at = reader.Stamp("sensed_at", message.sensed_at());
  mesh.validity = FromProto(message.validity());
  mesh.topology = message.rest_size() > 0 ? Topology(message, &reader) : known;
  reader.Require(mesh.topology != nullptr, "rest is absent", "the topology in the first message");
  mesh.positions = Points("positions", message.positions(), kMaxLength, &reader);
  mesh.nodal_forces = Points("nodal_forces", message.nodal_forces(), kMaxForce, &reader);
  if (!reader.ok()) return std::nullopt;
  const std::size_t count = mesh.topology->surface.nodes.size();
  reader.Require(mesh.positions.size() == count, "positions", "one per node of `rest`");
  reader.Require(mesh.nodal_forces.empty() || mesh.nodal_forces.size() == count, "nodal_forces",
                 "none, or one per node of `rest`");
  for (const float pascals : message.traction()) {
    mesh.traction.push_back(static_cast<float>(reader.Number("traction", pascals, kMaxTraction)));
  }
  reader.Require(mesh.traction.empty() || mesh.traction.size() == count, "traction",
                 "none, or one per node of `rest`");
  ReadField(message.field(), *mesh.topology, &reader, &mesh);
  if (!reader.ok()) return std::nullopt;
  return mesh;
}

}  // namespace palpate
