#include "slave/mechanics/fem/zone/fem_zone_model.h"

#include <algorithm>
#include <cmath>
#include <exception>
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
constexpr int kModes = 80;            // of a zone's border
constexpr double kLeastRadius = 2.5;  // of a zone [edges]
constexpr double kMargin = 0.5;       // centres are nodes: at most so far from contacts [edges]
constexpr double kFarthest = 0.75;    // of a contact from the nearest node [edges]
constexpr double kReach = 1.5;        // of a triangle's corners from the one in the centre [edges]
constexpr double kShrink = 0.8;       // from one level of a zone's radius to the next
constexpr int kMostLevels = 8;
constexpr double kConverged = 1e-4;  // what steps will still change, by the force
constexpr int kStepsPerTangent = 10;
constexpr int kMostTangents = 8;
constexpr int kMostPortions = 64;  // of what is prescribed, from rest
constexpr double kSmall = 1e-9;    // displacement at which bending is judged, of the larger side

constexpr std::string_view kCrowded = "contacts are too near to each other for zones of their own";
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
      places_(mesh_, held_, poisson_ratio, kModes),
      unit_(places_.rest().length_unit()),
      elements_(MakeElementMesh(mesh_, FemOptions::Element::kTet4, unit_)),
      used_(UsedNodes(mesh_.tets, mesh_.nodes.size())),
      contacts_(elements_, used_, unit_),
      strain_(mesh_, held_, poisson_ratio, 4),
      edge_(EdgesAround(SurfaceOf(mesh_))) {
  ReportProgress(progress, "factorising stiffness", 1);
  field_mesh_ = {.vertices = mesh_.nodes, .tets = mesh_.tets};
  keeps_displacements_ = true;
  info_.kind = "fem-zone";
  info_.dof = 3 * mesh_.nodes.size();
  info_.elements = static_cast<int>(mesh_.tets.size());
  info_.memory_bytes = places_.rest().memory_bytes();
  info_.remark = poisson_ratio >= kLocks
                     ? "linear tetrahedra lock near nu = 0.5: the model is much too stiff"
                     : "tet4, nonlinear around contacts only; the first touch of a place is slow";
  NotePrecompute();
}

void FemZoneModel::Reset() {
  if (set_) set_->Reset();
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

// As wide as the contact in every direction; on higher levels smaller, down to what the contact's
// own elements take.
double FemZoneModel::RadiusAt(int node, double width, int level) const {
  const double edge = edge_[Index(node)];
  const double full = std::max(width, kLeastRadius * edge) + kMargin * edge;
  const double least = 0.5 * width + kMargin * edge;
  return std::max(least, std::pow(kShrink, level) * full);
}

// The first on which this zone and those of its neighbours divide the distance between them.
int FemZoneModel::LevelOf(std::span<const Contact> contacts, std::size_t contact) const {
  const Contact& own = contacts[contact];
  const int node = NodeNear(own.p_O);
  const double full = RadiusAt(node, own.width, 0);
  double room = full;
  for (std::size_t j = 0; j < contacts.size(); ++j) {
    const int other = j == contact ? -1 : NodeNear(contacts[j].p_O);
    if (other < 0) continue;
    const double distance = (mesh_.nodes[Index(node)] - mesh_.nodes[Index(other)]).norm();
    const double share = full / (full + RadiusAt(other, contacts[j].width, 0));
    room = std::min(room, share * (distance - edge_[Index(node)]));
  }
  int level = 0;
  while (level < kMostLevels && RadiusAt(node, own.width, level) > room) ++level;
  return level;
}

// Centred on a node, so that what was touched before does not matter.
std::shared_ptr<const ZonePlace> FemZoneModel::PlaceAt(const Key& key) {
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second.zone;
  if (known_bytes_ > options_.memory_limit) {  // those in use stay with used_places_
    known_.clear();
    known_bytes_ = 0;
  }
  const auto& [node, width, level] = key;
  Place place;
  place.zone = std::make_shared<ZonePlace>(places_.Make(
      mesh_.nodes[Index(node)], RadiusAt(node, width, level), NodesNear(node, 0.5 * width)));
  place.bytes = 8 * static_cast<std::size_t>(place.zone->body.rest.size()) +
                4 * static_cast<std::size_t>(place.zone->far.size());
  known_bytes_ += place.bytes;
  info_.memory_bytes = places_.rest().memory_bytes() + known_bytes_;
  return known_.emplace(key, std::move(place)).first->second.zone;
}

// Nodes that a disc of `radius` may touch whose centre is nearest to this node.
std::vector<int> FemZoneModel::NodesNear(int node, double radius) const {
  std::vector<int> near;
  const double edge = edge_[Index(node)];
  const double reach = std::max(radius + kFarthest * edge, kReach * edge);
  for (std::size_t n = 0; n < mesh_.nodes.size(); ++n) {
    const bool on_surface = edge_[n] > 0;
    if (on_surface && (mesh_.nodes[n] - mesh_.nodes[Index(node)]).norm() <= reach) {
      near.push_back(static_cast<int>(n));
    }
  }
  return near;
}

void FemZoneModel::Prefetch(std::span<const Contact> contacts) {
  for (const Contact& contact : contacts) {
    if (!contact.p_O.allFinite() || !(contact.width >= 0 && contact.width <= kAbsurd * unit_)) {
      continue;
    }
    const int node = NodeNear(contact.p_O);
    if (node >= 0) PlaceAt({node, contact.width, 0});
  }
}

// Which contacts lie in another's zone, which then has two.
void FemZoneModel::FindCrowded(const std::vector<ZoneSet::Touch>& touches) {
  crowded_.assign(touches.size(), 0);
  std::vector<int> owner(mesh_.nodes.size(), -1);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (const auto& point : touches[i].contact.points) {
      for (const auto& [node, weight] : point) {
        owner[Index(touches[i].place->body.zone.nodes[Index(node)])] = static_cast<int>(i);
      }
    }
  }
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (const int node : touches[i].place->body.zone.nodes) {
      const int other = owner[Index(node)];
      if (other >= 0 && other != static_cast<int>(i)) crowded_[i] = crowded_[Index(other)] = 1;
    }
  }
}

bool FemZoneModel::MakeTouch(std::span<const Contact> contacts, std::size_t i,
                             ZoneSet::Touch* touch) {
  const Contact& contact = contacts[i];
  const ContactPlace& at = contacts_.places()[i];
  const int centre = NodeNear(contact.p_O);
  if (centre < 0) return Fail("no surface at a contact point");
  used_places_.push_back(PlaceAt({centre, contact.width, LevelOf(contacts, i)}));
  touch->place = used_places_.back().get();
  const Zone& zone = touch->place->body.zone;
  bool inside = true;
  const auto number = [&](int node) {
    const int found = zone.Find(node);
    inside = inside && found >= 0 && found < zone.inner;
    return found;
  };
  touch->contact.loaded = contact.kind == Contact::Kind::kForce;
  if (touch->contact.loaded || at.moved.empty()) {
    ZoneContact::Point point;
    for (const auto& [node, weight] : at.weights) point.emplace_back(number(node), weight);
    touch->contact.points.push_back(std::move(point));
  } else {
    for (const int node : at.moved) touch->contact.points.push_back({{number(node), 1.0}});
  }
  if (!inside) return Fail("the contact reaches beyond its zone");
  for (const auto& point : touch->contact.points) {
    for (const auto& [node, weight] : point) {
      const auto& held = held_[Index(zone.nodes[Index(node)])];
      if (held[0] || held[1] || held[2]) return Fail("a contact touches fixed nodes");
    }
  }
  return true;
}

bool FemZoneModel::PrepareSet(std::span<const Contact> contacts) {
  if (!contacts_.Prepare(contacts)) return Fail(contacts_.failure());
  if (!contacts_.changed() && set_) return true;
  set_.reset();
  used_places_.clear();
  softness_.clear();
  inverted_ = false;
  std::vector<ZoneSet::Touch> touches(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (!MakeTouch(contacts, i, &touches[i])) return false;
  }
  prescribed_.clear();
  for (const auto& touch : touches) prescribed_.push_back(VectorXd::Zero(touch.contact.unknowns()));
  if (touches.empty()) return true;
  FindCrowded(touches);
  set_.emplace(places_, touches);
  LearnBending();
  return true;
}

// Where a part bends, the mean over the axes is taken by the work that the force does along each.
void FemZoneModel::LearnBending() {
  std::vector<Vector3d> u(mesh_.nodes.size());
  std::vector<int> touched;
  for (const ContactPlace& place : contacts_.places()) {
    touched.insert(touched.end(), place.moved.begin(), place.moved.end());
    for (const auto& [node, weight] : place.weights) touched.push_back(node);
  }
  for (int i = 0; i < set_->size(); ++i) {
    Vector3d softness = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      const VectorXd dual = set_->DualDisplacement(i, c);
      const double size = dual.cwiseAbs().maxCoeff();
      for (std::size_t n = 0; size > 0 && n < u.size(); ++n) {
        u[n] = kSmall * unit_ / size * dual.segment<3>(3 * static_cast<int>(n));
      }
      if (size > 0) softness[c] = strain_.Softness(u, touched);
    }
    softness_.push_back(softness);
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
  const auto size_of = [&](const ZoneSolver& solver) {
    return solver.contact().loaded ? MeanOf(solver.u(), solver.contact().points.front()).norm()
                                   : solver.Force().norm();
  };
  for (int i = 0; i < set_->size(); ++i) {
    const double size = size_of(set_->solver(i));
    *finite = *finite && std::isfinite(size) && set_->solver(i).u().allFinite();
    if (!set_->solver(i).contact().loaded) largest = std::max(largest, size);
  }
  for (int i = 0; i < set_->size(); ++i) {
    const ZoneSolver& solver = set_->solver(i);
    const double scale = size_of(solver) + (solver.contact().loaded ? 0 : 0.01 * largest);
    if (!(solver.Remaining() <= kConverged * scale)) return false;
  }
  return true;
}

bool FemZoneModel::Converge() {
  for (int tangent = 0; tangent < kMostTangents; ++tangent) {
    if (tangent > 0 && !set_->Refresh()) return false;
    for (int step = 0; step < kStepsPerTangent; ++step) {
      set_->Step(prescribed_);
      bool finite = true;
      const bool converged = HasConverged(&finite);
      if (!finite) return false;
      if (converged) return true;
    }
  }
  return false;
}

// From the last state, else from rest in parts.
bool FemZoneModel::SolveState(std::span<const Contact> contacts) {
  if (inverted_) Reset();  // such states may be traps
  if (!Prescribe(contacts, 1)) return false;
  if (Converge()) return true;
  for (int parts = 4; parts <= kMostPortions; parts *= 4) {
    set_->Reset();
    if (!set_->Refresh()) break;
    bool solved = true;
    for (int k = 1; solved && k <= parts; ++k) {
      Prescribe(contacts, static_cast<double>(k) / parts);
      solved = Converge();
    }
    if (solved) return true;
  }
  return Fail("no equilibrium was found");
}

void FemZoneModel::ComputeResponses(std::span<const Contact> contacts,
                                    std::span<ContactResponse> responses) noexcept {
  failure_ = {};
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
  if (contacts_.places()[contact].coarse) return kCoarsePatch;
  if (crowded_[contact]) return kCrowded;
  const bool loaded = set_->solver(static_cast<int>(contact)).contact().loaded;
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
    const ZoneSolver& solver = set_->solver(number);
    const double bound = set_->bound(number) + solver.Remaining();
    ContactResponse response;
    if (solver.contact().loaded) {
      response.force_O = contacts[i].prescribed_O;
      response.displacement_O = unit_ * MeanOf(solver.u(), solver.contact().points.front());
      response.displacement_bound = unit_ * bound;
    } else {
      response.displacement_O = contacts[i].prescribed_O;
      response.force_O = force_unit * solver.Force();
      response.force_bound = force_unit * bound;
    }
    const ContactPlace& place = contacts_.places()[i];
    const auto force_at = [&](std::size_t k) -> Vector3d {
      if (place.moved.empty() || solver.contact().loaded) {
        return unit_ * place.weights[k].second * response.force_O;
      }
      return unit_ * force_unit * solver.forces().segment<3>(3 * static_cast<int>(k));
    };
    SetMoment(place.arms, contacts[i].width, force_at, &response);
    response.doubt = DoubtOf(i, response);
    response.validity = response.doubt.empty() ? Validity::kValid : Validity::kExtrapolated;
    responses[i] = response;
  }
}

void FemZoneModel::ComputeDisplacements(std::vector<Vector3d>* u_O) {
  u_O->assign(mesh_.nodes.size(), Vector3d::Zero());
  if (!set_) return;
  const VectorXd u = set_->Displacements();
  for (std::size_t n = 0; n < u_O->size(); ++n) {
    (*u_O)[n] = unit_ * u.segment<3>(3 * static_cast<int>(n));
  }
}

}  // namespace palpate
