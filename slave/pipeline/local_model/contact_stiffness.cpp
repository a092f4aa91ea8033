#include "slave/pipeline/local_model/contact_stiffness.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <spdlog/spdlog.h>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPatchEdges = 2.2;      // patch diameter in mean edges: a node and its neighbours
constexpr double kSmall = 1e-3;          // displacement relative to the patch, in the linear range
constexpr std::size_t kAheadUpTo = 400;  // surface nodes

double MeanEdge(const SurfaceMesh& surface) {
  double sum = 0;
  for (const auto& [a, b, c] : surface.triangles) {
    const Vector3d &pa = surface.nodes[Index(a)], &pb = surface.nodes[Index(b)],
                   &pc = surface.nodes[Index(c)];
    sum += (pb - pa).norm() + (pc - pb).norm() + (pa - pc).norm();
  }
  return sum / (3 * static_cast<double>(surface.triangles.size()));
}

Matrix3d Compliance(const Material& material, double radius, const Vector3d& n) {
  return DiscStiffness(material, radius, n).inverse();
}

bool IsStiffness(const Matrix3d& K) {
  return K.allFinite() && K(0, 0) > 0 && K.topLeftCorner<2, 2>().determinant() > 0 &&
         K.determinant() > 0;
}

std::optional<Matrix3d> Symmetric(const Matrix3d& K, Validity validity) {
  const Matrix3d half = 0.5 * (K + K.transpose());
  if (validity == Validity::kFailed || !IsStiffness(half)) return std::nullopt;
  return half;
}

}  // namespace

Matrix3d DiscStiffness(const Material& material, double radius, const Vector3d& n) noexcept {
  const double E = material.young_modulus, nu = material.poisson_ratio;
  const double G = E / (2 * (1 + nu));
  const double normal = 2 * E * radius / (1 - nu * nu);
  const double across = 32 * (1 - nu) * G * radius / (7 - 8 * nu);
  return normal * n * n.transpose() + across * (Matrix3d::Identity() - n * n.transpose());
}

double DiscOfSphere(double sphere_radius, double depth) noexcept {
  return 2.0 / 3.0 * std::sqrt(sphere_radius * depth);
}

struct ContactStiffness::Greens {
  std::unique_ptr<DeformationModel> model;
};

ContactStiffness::ContactStiffness(const Scene& scene, const SurfaceMesh& surface,
                                   const SolidMesh* solid, std::vector<Companion> companions)
    : object_(scene.object),
      surface_(surface),
      companions_(std::move(companions)),
      nodes_(surface.nodes.size()) {
  node_area_.resize(surface.nodes.size());
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    for (const int node : surface.triangles[Index(t)])
      node_area_[Index(node)] += Area(surface, t) / 3;
  }
  patch_width_ = kPatchEdges * MeanEdge(surface);
  if (solid == nullptr || scene.object.fixed.empty()) return;
  Scene green = scene;
  green.model = {};
  green.model.kind = "fem-green";
  green.model.fem.element = scene.model.fem.element;
  green.model.cache = scene.model.cache;
  green.model.range = 1;
  // A tick of the master is shorter than every relaxation time.
  green.object.material.relaxation.clear();
  try {
    greens_ = std::make_unique<Greens>(Greens{MakeModel(green, *solid)});
  } catch (const std::invalid_argument& error) {
    spdlog::info("the local stiffness is that of an elastic half-space: {}", error.what());
    return;
  }
  std::size_t on_surface = 0;
  for (const double area : node_area_) on_surface += area > 0 ? 1 : 0;
  if (on_surface > kAheadUpTo) return;
  for (std::size_t i = 0; i < node_area_.size(); ++i) {
    if (node_area_[i] > 0) Node(static_cast<int>(i));
  }
}

ContactStiffness::~ContactStiffness() = default;

// Reciprocity makes it symmetric; rounding does not. nullopt: the result is no valid stiffness.
std::optional<Matrix3d> ContactStiffness::Alone(const Contact& contact) const {
  ContactResponse response;
  greens_->model->Respond(std::span(&contact, 1), std::span(&response, 1));
  return Symmetric(response.stiffness_O, response.validity);
}

// The force on one finger of several has no potential, so its matrix is not symmetric. The result
// is symmetric, and exact for displacements along the normal. nullopt: the patches overlap, or the
// result is no stiffness.
std::optional<Matrix3d> ContactStiffness::Together(const Contact& contact) const {
  const double by = kSmall * patch_width_;
  std::vector<Contact> contacts{contact};
  for (const Companion& other : companions_) {
    contacts.push_back({.p_O = other.p_O, .element = other.triangle, .width = patch_width_});
  }
  std::vector<ContactResponse> responses(contacts.size());
  Matrix3d K;
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const double sense = i == 0 ? 1 : companions_[i - 1].sense;
      contacts[i].prescribed_O = sense * by * Vector3d::Unit(axis);
      contacts[i].wants_stiffness = false;
    }
    greens_->model->Respond(contacts, responses);
    if (responses[0].validity == Validity::kFailed) return std::nullopt;
    K.col(axis) = responses[0].force_O / by;
  }
  const Vector3d n = Normal(surface_, contact.element), pressed = K * n;
  const Matrix3d across = Matrix3d::Identity() - n * n.transpose();
  return Symmetric(across * K * across + pressed * n.transpose() + n * pressed.transpose() -
                       n.dot(pressed) * n * n.transpose(),
                   Validity::kValid);
}

const ContactStiffness::NodeCompliance& ContactStiffness::Node(int node) {
  NodeCompliance& known = nodes_[Index(node)];
  if (known.asked || !greens_) return known;
  known.asked = true;
  const Vector3d& p_O = surface_.nodes[Index(node)];
  const auto place = FindPlace(surface_, p_O);
  if (!place) return known;
  const Contact contact{.p_O = p_O, .element = place->triangle, .width = patch_width_};
  const auto alone = Alone(contact);
  if (!alone) return known;
  const auto together = companions_.empty() ? alone : Together(contact);
  known.C_O = together.value_or(*alone).inverse();
  known.patch_radius = patch_width_ / 2;
  return known;
}

bool ContactStiffness::Knows(int triangle) const {
  return !greens_ || std::ranges::all_of(surface_.triangles[Index(triangle)],
                                         [&](int node) { return nodes_[Index(node)].asked; });
}

Matrix3d ContactStiffness::At(int triangle, const Vector3d& weights, double radius) {
  const Vector3d n = Normal(surface_, triangle);
  Matrix3d C = Matrix3d::Zero();
  for (int k = 0; k < 3; ++k) {
    if (!(weights[k] > 0)) continue;
    const int at = surface_.triangles[Index(triangle)][Index(k)];
    const NodeCompliance& node = Node(at);
    const double modulus = RelativeModulus(object_, surface_.nodes[Index(at)]);
    Matrix3d C_node = Compliance(object_.material, radius, n) / modulus;
    if (node.patch_radius > 0) {
      C_node -= Compliance(object_.material, std::max(node.patch_radius, radius), n) / modulus;
      C_node += node.C_O;
    }
    C += weights[k] * C_node;
  }
  return C.inverse();
}

}  // namespace palpate
