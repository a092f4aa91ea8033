#include "slave/mechanics/fem/zone/fem_zone_model.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>

#include "shared/geometry/index.h"
#include "shared/mesh/disc_patch.h"
#include "shared/mesh/mesh_census.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAbsurd = 1e6;       // larger sides
constexpr double kLocks = 0.49;       // Poisson ratio
constexpr double kLeastRadius = 2.5;  // of a zone [edges]
constexpr double kMargin = 0.5;       // of a zone beyond that or the contact's width [edges]
constexpr double kConverged = 5e-4;   // what steps will still change, by the force
constexpr int kMostSteps = 60;
constexpr double kForSteps = 0.6;    // of the deadline; the rest is for the errors [-]
constexpr double kZoneExtent = 1.3;  // of a zone's nodes from its centre [radii]
constexpr double kIncrement = 0.1;   // of a tool between two accepted states [edges]
constexpr int kFewestPoints = 3;     // of a round tool on its mesh
constexpr int kMostPortions = 64;    // of what is prescribed, from rest
constexpr double kSmall = 1e-9;      // displacement at which bending is judged, of the larger side

constexpr std::string_view kTooNonlinear =
    "the body outside the contact's zone is not linear enough for the tolerance";

std::vector<double> EdgesAround(const SurfaceMesh& surface) {
  std::vector<double> sum(surface.nodes.size(), 0), count(surface.nodes.size(), 0);
  for (const auto& triangle : surface.triangles) {
    for (std::size_t v = 0; v < 3; ++v) {
      const auto a = Index(triangle[v]), b = Index(triangle[(v + 1) % 3]);
      const double length = (surface.nodes[a] - surface.nodes[b]).norm();
      for (const std::size_t node : {a, b}) sum[node] += length, ++count[node];
    }
  }
  for (std::size_t n = 0; n < sum.size(); ++n) sum[n] /= std::max(1.0, count[n]);
  return sum;
}

// Mean of the triangles around, by their areas.
std::vector<Vector3d> NormalsAround(const SurfaceMesh& surface) {
  std::vector<Vector3d> normals(surface.nodes.size(), Vector3d::Zero());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const int triangle = static_cast<int>(t);
    const Vector3d area = Area(surface, triangle) * Normal(surface, triangle);
    for (const int node : surface.triangles[t]) normals[Index(node)] += area;
  }
  for (Vector3d& normal : normals) {
    if (normal.norm() > 0) normal.normalize();
  }
  return normals;
}

double Positive(const char* key, double value) {
  if (!(value > 0 && std::isfinite(value))) RefuseValue(key, value, "a finite number > 0");
  return value;
}

}  // namespace

FemZoneModel::FemZoneModel(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
                           double poisson_ratio, const Options& options, Progress* progress)
    : young_modulus_(Positive("young_modulus", young_modulus)),
      poisson_ratio_(poisson_ratio),
      options_(options),
      mesh_((Positive("tolerance", options.tolerance),
             ReportProgress(progress, "factorising stiffness", 0), mesh)),
      held_(held),
      green_(mesh_, held_, poisson_ratio, options.memory_limit, options.cache),
      unit_(green_.length_unit()),
      elements_(MakeElementMesh(mesh_, FemOptions::Element::kTet4, unit_)),
      used_(UsedNodes(mesh_.tets, mesh_.nodes.size())),
      contacts_(elements_, used_, unit_),
      strain_(mesh_, held_, poisson_ratio, 4),
      edge_(EdgesAround(SurfaceOf(mesh_))),
      normal_(NormalsAround(SurfaceOf(mesh_))) {
  ReportProgress(progress, "factorising stiffness", 1);
  field_mesh_ = {.vertices = mesh_.nodes, .tets = mesh_.tets};
  keeps_displacements_ = true;
  info_.kind = "fem-zone";
  info_.dof = 3 * mesh_.nodes.size();
  info_.elements = static_cast<int>(mesh_.tets.size());
  info_.memory_bytes = green_.memory_bytes();
  info_.remark = poisson_ratio >= kLocks
                     ? "linear tetrahedra lock near nu = 0.5: the model is much too stiff"
                     : "tet4, nonlinear around contacts only; the first touch of a region is slow";
  NotePrecompute();
}

void FemZoneModel::Reset() {
  if (set_) set_->Reset();
  for (Vector3d& moved : moved_) moved.setZero();
  inverted_ = false;
}

int FemZoneModel::NodeNear(const Vector3d& p_O) const {
  const auto found = FindPlace(elements_.surface, p_O / unit_);
  if (!found) return -1;
  if (found->node >= 0) return found->node;
  int nearest = 0;
  found->weights.maxCoeff(&nearest);
  return elements_.surface.triangles[Index(found->triangle)][Index(nearest)];
}

void FemZoneModel::Prefetch(std::span<const Contact> contacts) {
  try {
    if (!PrepareSet(contacts)) contacts_.Forget();
  } catch (const std::exception&) {
    contacts_.Forget();  // Respond tells
  }
}

bool FemZoneModel::PrefetchSurface(double width, Progress* progress) {
  std::vector<double> distance(mesh_.nodes.size(), std::numeric_limits<double>::infinity());
  double radius = options_.least_radius;
  for (std::size_t s = 0; s < mesh_.nodes.size(); ++s) {
    const auto& held = held_[s];
    if (!(edge_[s] > 0) || (held[0] && held[1] && held[2])) continue;
    radius = std::max(radius, std::max(width, kLeastRadius * edge_[s]) + edge_[s]);
    for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
      distance[n] = std::min(distance[n], (mesh_.nodes[n] - mesh_.nodes[s]).squaredNorm());
    }
  }
  const double extent = kZoneExtent * radius;
  std::vector<int> nodes;
  for (std::size_t n = 0; n < distance.size(); ++n) {
    if (distance[n] <= extent * extent) nodes.push_back(static_cast<int>(n));
  }
  const bool all = green_.Prepare(nodes, ZoneSet::ReachOf(radius, extent) / unit_, progress);
  info_.memory_bytes = green_.memory_bytes();
  if (!all) {
    info_.remark =
        "tet4, nonlinear around contacts only; without memory for the whole surface, the "
        "first touch of a region is slow";
  }
  NotePrecompute();
  return all;
}

bool FemZoneModel::IsTool(const Contact& contact) const {
  if (contact.kind == Contact::Kind::kForce) return false;
  const bool round = options_.tool.shape != RigidTool::Shape::kFlat;
  return round || (contact.width > 0 && options_.contact != ContactLaw::kBonded);
}

// Of the part of the surface that the tool may touch at such a depth: half its width, or where a
// sphere would cut the undeformed surface, which is farther out than it touches.
double FemZoneModel::ToolRadius(const Contact& contact, double depth) const {
  const RigidTool& tool = options_.tool;
  if (tool.shape == RigidTool::Shape::kFlat) return 0.5 * contact.width;
  const double capped = std::clamp(depth, 0.0, tool.radius);
  const double cut = std::sqrt(capped * (2 * tool.radius - capped));
  return cut + (tool.shape == RigidTool::Shape::kCapsule ? 0.5 * tool.length : 0);
}

Vector3d FemZoneModel::NormalAt(int node) const {
  return normal_[Index(node)];
}

void FemZoneModel::AddToolPoints(const Contact& contact, ZoneSet::Touch* touch) const {
  const Vector3d normal = touch->contact.placement.normal;
  const double edge = edge_[Index(NodeNear(contact.p_O))];
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
    if (!(edge_[n] > 0) || normal_[n].dot(normal) <= 0) continue;
    const auto& held = held_[n];
    if (held[0] || held[1] || held[2]) continue;
    if ((mesh_.nodes[n] - touch->centre_O).norm() > touch->radius - 0.8 * edge) continue;
    touch->contact.points.push_back({{static_cast<int>(touch->nodes.size()), 1.0}});
    touch->nodes.push_back(static_cast<int>(n));
  }
}

bool FemZoneModel::MakeTouch(std::span<const Contact> contacts, std::size_t i,
                             ZoneSet::Touch* touch) {
  const Contact& contact = contacts[i];
  const ContactPlace& at = contacts_.places()[i];
  const int near = NodeNear(contact.p_O);
  if (near < 0) return Fail("no surface at a contact point");
  const double edge = edge_[Index(near)];
  touch->centre_O = contact.p_O;
  touch->radius =
      std::max({contact.width, kLeastRadius * edge, options_.least_radius}) + kMargin * edge;
  touch->contact.loaded = contact.kind == Contact::Kind::kForce;
  if (IsTool(contact)) {
    touch->contact.tool = options_.tool;
    touch->contact.tool->radius /= unit_;
    touch->contact.tool->length /= unit_;
    touch->contact.placement = {contact.p_O / unit_, NormalAt(near), contact.width / unit_};
    touch->contact.friction =
        options_.contact == ContactLaw::kBonded
            ? std::numeric_limits<double>::infinity()
            : (options_.contact == ContactLaw::kFriction ? options_.friction : 0);
    const double depth = -contact.prescribed_O.dot(NormalAt(near));
    touch->radius =
        std::max({2 * ToolRadius(contact, depth), kLeastRadius * edge, options_.least_radius}) +
        edge;
    AddToolPoints(contact, touch);
    if (touch->nodes.empty()) return Fail("no free surface at a contact point");
    return true;
  }
  if (touch->contact.loaded || at.moved.empty()) {
    ZoneContact::Point point;
    for (const auto& [node, weight] : at.weights) {
      point.emplace_back(static_cast<int>(touch->nodes.size()), weight);
      touch->nodes.push_back(node);
    }
    touch->contact.points.push_back(std::move(point));
  } else {
    touch->nodes = at.moved;
    for (int k = 0; k < static_cast<int>(at.moved.size()); ++k) {
      touch->contact.points.push_back({{k, 1.0}});
    }
  }
  for (const int node : touch->nodes) {
    const auto& held = held_[Index(node)];
    if (held[0] || held[1] || held[2]) return Fail("a contact touches fixed nodes");
  }
  return true;
}

bool FemZoneModel::PrepareSet(std::span<const Contact> contacts) {
  if (!contacts_.Prepare(contacts)) return Fail(contacts_.failure());
  if (!contacts_.changed() && set_) return true;
  set_.reset();
  softness_.clear();
  inverted_ = false;
  std::vector<ZoneSet::Touch> touches(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!MakeTouch(contacts, i, &touches[i])) return false;
  }
  prescribed_.clear();
  for (const auto& touch : touches) {
    prescribed_.push_back(VectorXd::Zero(touch.contact.tool ? 3 : touch.contact.unknowns()));
  }
  moved_.assign(touches.size(), Vector3d::Zero());
  touches_ = touches;
  if (touches.empty()) return true;
  set_.emplace(green_, mesh_, poisson_ratio_, touches);
  info_.memory_bytes = green_.memory_bytes();
  LearnBending();
  return true;
}

// Where a part bends, the mean over the axes is taken by the work that the force does along each.
void FemZoneModel::LearnBending() {
  softness_.assign(Index(set_->size()), Vector3d::Zero());
  if (!strain_.body_bends()) return;
  const Eigen::MatrixXd duals = set_->DualDisplacements();
  std::vector<Vector3d> u(mesh_.nodes.size());
  std::vector<int> touched;
  for (const ContactPlace& place : contacts_.places()) {
    touched.insert(touched.end(), place.moved.begin(), place.moved.end());
    for (const auto& [node, weight] : place.weights) touched.push_back(node);
  }
  for (int i = 0; i < set_->size(); ++i) {
    Vector3d softness = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      const VectorXd dual = duals.col(3 * i + c);
      const double size = dual.cwiseAbs().maxCoeff();
      for (std::size_t n = 0; size > 0 && n < u.size(); ++n) {
        u[n] = kSmall * unit_ / size * dual.segment<3>(3 * static_cast<int>(n));
      }
      if (size > 0) softness[c] = strain_.Softness(u, touched);
    }
    softness_[Index(i)] = softness;
  }
}

bool FemZoneModel::Prescribe(std::span<const Contact> contacts, double part) {
  const double force_unit = young_modulus_ * unit_ * unit_;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const bool loaded = contacts[i].kind == Contact::Kind::kForce;
    const Vector3d value = contacts[i].prescribed_O / (loaded ? force_unit : unit_);
    if (!(value.cwiseAbs().maxCoeff() <= kAbsurd)) {
      return Fail("a value is not finite or too large");
    }
    for (int k = 0; k < prescribed_[i].size(); ++k) prescribed_[i][k] = part * value[k % 3];
  }
  return true;
}

// Of every contact, by its own force and a little of the largest.
bool FemZoneModel::HasConverged(bool* finite) const {
  double largest = 0;
  *finite = true;
  const auto size_of = [&](const ZonePart& part) {
    return part.contact().loaded ? part.MeanDisplacement().norm() : part.Force().norm();
  };
  for (int i = 0; i < set_->size(); ++i) {
    *finite = *finite && set_->part(i).IsFinite();
    if (!set_->part(i).contact().loaded) largest = std::max(largest, size_of(set_->part(i)));
  }
  for (int i = 0; i < set_->size(); ++i) {
    const ZonePart& part = set_->part(i);
    const double scale = size_of(part) + (part.contact().loaded ? 0 : 0.01 * largest);
    if (!(part.Remaining() <= kConverged * scale)) return false;
  }
  return true;
}

bool FemZoneModel::Converge() {
  set_->Restart();
  for (int step = 0; step < kMostSteps; ++step) {
    set_->Step(prescribed_);
    bool finite = true;
    const bool converged = HasConverged(&finite);
    if (!finite) return false;
    if (converged || IsLate()) return true;
  }
  return false;
}

// What the steps still lack is part of the bound.
bool FemZoneModel::IsLate() const {
  return options_.deadline > 0 && SecondsSince(begun_) > kForSteps * options_.deadline;
}

// From the last state, else from rest in parts.
bool FemZoneModel::SolveState(std::span<const Contact> contacts) {
  if (inverted_) Reset();  // such states may be traps
  if (!Prescribe(contacts, 1)) return false;
  if (std::ranges::any_of(touches_,
                          [](const auto& touch) { return touch.contact.tool.has_value(); })) {
    return MoveTools(contacts) || Fail("no equilibrium was found");
  }
  if (Converge()) return true;
  for (int parts = 4; parts <= kMostPortions; parts *= 4) {
    set_->Reset();
    bool solved = true;
    for (int k = 1; solved && k <= parts; ++k) {
      Prescribe(contacts, static_cast<double>(k) / parts);
      solved = Converge();
    }
    if (solved) return true;
  }
  return Fail("no equilibrium was found");
}

// Zones go with tools that slide, and grow with those that go deeper.
void FemZoneModel::FollowTools(std::span<const Contact> contacts) {
  for (int i = 0; i < set_->size(); ++i) {
    ZoneSet::Touch& touch = touches_[Index(i)];
    const ToolContact* tool = set_->part(i).tool();
    if (tool == nullptr) continue;
    const Vector3d& n = touch.contact.placement.normal;
    const Vector3d moved = unit_ * (tool->apex() - touch.contact.placement.p);
    const double depth = -moved.dot(n);
    const Vector3d at = contacts[Index(i)].p_O + moved + depth * n - unit_ * tool->Dragged(n);
    int nearest = -1;
    double least = std::numeric_limits<double>::infinity();
    for (const int node : touch.nodes) {
      const double distance = (mesh_.nodes[Index(node)] - at).squaredNorm();
      if (distance < least) least = distance, nearest = node;
    }
    const double edge = edge_[Index(nearest)];
    const bool away = (mesh_.nodes[Index(nearest)] - touch.centre_O).norm() > 1.01 * edge;
    const double needed = std::max(2 * ToolRadius(contacts[Index(i)], depth), kLeastRadius * edge);
    if (!away && needed <= touch.radius) continue;
    ZoneSet::Touch next = touch;
    next.nodes.clear();
    next.contact.points.clear();
    if (away) next.centre_O = mesh_.nodes[Index(nearest)];
    next.radius = needed + edge;
    AddToolPoints(contacts[Index(i)], &next);
    if (next.nodes.empty()) continue;
    set_->Replace(i, next);
    touch = std::move(next);
  }
}

// In increments, each accepted, so that friction follows the way.
bool FemZoneModel::MoveTools(std::span<const Contact> contacts) {
  double parts = 1;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const double edge = edge_[Index(touches_[i].nodes.front())];
    const double way = (contacts[i].prescribed_O - unit_ * moved_[i]).norm();
    if (touches_[i].contact.tool) parts = std::max(parts, std::ceil(way / (kIncrement * edge)));
  }
  if (!(parts < 1e4)) return false;
  const std::vector<Vector3d> from = moved_;
  const auto place = [&](double part) {
    for (std::size_t i = 0; i < touches_.size(); ++i) {
      if (!touches_[i].contact.tool) continue;
      moved_[i] = from[i] + part * (contacts[i].prescribed_O / unit_ - from[i]);
      prescribed_[i] = moved_[i];
    }
  };
  for (int k = 1; k < static_cast<int>(parts); ++k) {
    place(k / parts);
    set_->Restart();
    for (int step = 0; step < 2; ++step) set_->Step(prescribed_);
    set_->Accept();
    FollowTools(contacts);
  }
  place(1);
  set_->RefreshDuals();
  if (!Converge()) return false;
  set_->Accept();
  FollowTools(contacts);
  set_->RefreshDuals();
  return true;
}

void FemZoneModel::ComputeResponses(std::span<const Contact> contacts,
                                    std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  begun_ = std::chrono::steady_clock::now();
  bool answered = false;
  try {
    answered = responses.size() == contacts.size() && TryRespond(contacts, responses);
  } catch (const std::exception&) {
    failure_ = "out of memory, or a zone that cannot be condensed";
  }
  if (answered) return;
  if (failure_.empty()) failure_ = "the number of responses and contacts must be equal";
  std::ranges::fill(responses, ContactResponse{});
  contacts_.Forget();
  set_.reset();
}

bool FemZoneModel::TryRespond(std::span<const Contact> contacts,
                              std::span<ContactResponse> responses) {
  if (!PrepareSet(contacts)) return false;
  if (!set_) return true;
  if (!SolveState(contacts)) return false;
  Fill(contacts, responses);
  return true;
}

std::string_view FemZoneModel::DoubtOf(std::size_t contact, const ContactResponse& response) const {
  if (inverted_) return "elements are inside out";
  if (poisson_ratio_ >= kLocks) return "linear tetrahedra lock at this Poisson ratio";
  const ToolContact* tool = set_->part(static_cast<int>(contact)).tool();
  if (tool != nullptr) {
    const int touching = tool->touching();
    if (touching == 0) return {};
    if (touching < kFewestPoints) return kCoarsePatch;
  } else if (contacts_.places()[contact].coarse) {
    return kCoarsePatch;
  }
  const bool loaded = set_->part(static_cast<int>(contact)).contact().loaded;
  const double size = loaded ? response.displacement_O.norm() : response.force_O.norm();
  const double bound = loaded ? response.displacement_bound : response.force_bound;
  if (!(bound <= options_.tolerance * size)) return kTooNonlinear;
  const Eigen::Array3d work = response.force_O.array() * response.displacement_O.array();
  const double whole = work.abs().sum();
  if (whole > 0 && (work.abs() * softness_[contact].array()).sum() > kMostSoftness * whole) {
    return kStiffInBending;
  }
  return {};
}

void FemZoneModel::Fill(std::span<const Contact> contacts, std::span<ContactResponse> responses) {
  const double force_unit = young_modulus_ * unit_ * unit_;
  inverted_ = set_->SmallestJacobian() <= 0;
  set_->EstimateErrors();
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const int number = static_cast<int>(i);
    const ZonePart& part = set_->part(number);
    const double bound = set_->bound(number) + part.Remaining();
    ContactResponse response;
    if (part.contact().loaded) {
      response.force_O = contacts[i].prescribed_O;
      response.displacement_O = unit_ * part.MeanDisplacement();
      response.displacement_bound = unit_ * bound;
    } else {
      response.displacement_O = contacts[i].prescribed_O;
      response.force_O = force_unit * part.Force();
      response.force_bound = force_unit * bound;
    }
    const ContactPlace& place = contacts_.places()[i];
    const auto force_at = [&](std::size_t k) -> Vector3d {
      if (place.moved.empty() || part.contact().loaded) {
        return unit_ * place.weights[k].second * response.force_O;
      }
      return unit_ * force_unit * part.forces().segment<3>(3 * static_cast<int>(k));
    };
    if (!touches_[i].contact.tool) SetMoment(place.arms, contacts[i].width, force_at, &response);
    response.doubt = DoubtOf(i, response);
    response.validity = response.doubt.empty() ? Validity::kValid : Validity::kExtrapolated;
    responses[i] = response;
  }
}

void FemZoneModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->assign(mesh_.nodes.size(), Vector3d::Zero());
  if (!set_) return;
  const VectorXd u = set_->Displacements().col(0);
  for (std::size_t n = 0; n < u_O->size(); ++n) {
    (*u_O)[n] = unit_ * u.segment<3>(3 * static_cast<int>(n));
  }
}

}  // namespace palpate
