#include "slave/mechanics/fem/green/fem_green_model.h"

#include <algorithm>

#include "slave/mechanics/footprint/rim_share.h"
#include "slave/mechanics/mesh_resolution.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

// Error of a disc that is narrower than the mesh resolves, see SurfaceFootprints [-]. [measured:
// PatchResolution.ANarrowDiscOnACoarseMeshIsWithinItsStatedError]
constexpr double kOfWiderDisc = 0.05;
constexpr double kMostByOthers = 2;  // ratio of works

// A coarse patch is the weakest reason for a flag: other reasons replace it.
bool MayReplaceReason(const ContactResponse& response) {
  return response.validity == Validity::kValid ||
         (response.validity == Validity::kExtrapolated && response.flag_reason == kCoarsePatch);
}

std::string_view RemarkOf(const RestStiffness& stiffness) {
  if (stiffness.elements.nodes_per_element == 4) {
    return "linear tetrahedra are stiff in bending; small strains only";
  }
  return stiffness.has_pressure() ? "mixed pressure; small strains only" : "small strains only";
}

}  // namespace

FemGreenModel::FemGreenModel(const SolidMesh& mesh, const HeldNodes& held, double young_modulus,
                             double poisson_ratio, const Options& options, Progress* progress)
    : surface_(SurfaceOf(mesh)),
      columns_(AssembleAtRest(mesh, held, poisson_ratio, options.element), options.memory_limit,
               options.cache, progress),
      places_(columns_.stiffness().elements, columns_.length_unit(), columns_.place_of_node(),
              UnevenNodes(columns_.stiffness())),
      solver_(columns_, places_,
              {.young_modulus = young_modulus,
               .larger_side = columns_.length_unit(),
               .range = options.range,
               .contact = options.contact,
               .poisson_ratio = poisson_ratio,
               .springs =
                   columns_.stiffness().kind() == Elements::kFourNodesMixed ? kSpringOfMixed : 1}),
      bending_(columns_.stiffness(), columns_.layout(), options.width, options.cache),
      displacement_unit_(1 / (young_modulus * columns_.length_unit())) {
  field_mesh_ = {.vertices = mesh.nodes, .tets = mesh.tets};
  // New contacts need the factor to assess the mesh there, so it is made in advance.
  if (!bending_.is_complete()) columns_.Factorise(progress);
  Describe(options, mesh.tets.size());
}

void FemGreenModel::Describe(const Options& options, std::size_t tets) {
  info_.kind = "fem-green";
  info_.dof = Index(columns_.order());
  info_.elements = static_cast<int>(tets);
  info_.range = options.range;
  info_.remark = RemarkOf(columns_.stiffness());
  info_.update_us = MeasureUpdate();
  info_.memory_bytes = columns_.memory_bytes();
  NotePrecompute();
}

// Measures the time of an update by moving two neighbours alternately [us]; 0: no two can be moved.
double FemGreenModel::MeasureUpdate() {
  const auto last = static_cast<int>(surface_.triangles.size()) - 1;
  const auto corner = [&](std::size_t k) {
    return surface_.nodes[Index(surface_.triangles[Index(last)][k])];
  };
  return ComplianceSolver::MeasureUpdate(
      columns_, places_, solver_.params(),
      {Contact{.p_O = corner(0), .element = last}, Contact{.p_O = corner(1), .element = last}});
}

void FemGreenModel::ComputeResponses(std::span<const Contact> contacts,
                                     std::span<ContactResponse> responses) noexcept {
  failure_ = {};
  solver_.Respond(contacts, responses);
  try {
    if (solver_.failure().empty()) AssessMesh(contacts, responses);
  } catch (const std::exception&) {
    failure_ = "out of memory";
    std::ranges::fill(responses, ContactResponse{});
  }
}

void FemGreenModel::AssessMesh(std::span<const Contact> contacts,
                               std::span<ContactResponse> responses) {
  for (std::size_t k = 0; k < responses.size(); ++k) {
    AssessMesh(solver_.slots()[k], contacts[k], &responses[k]);
  }
}

void FemGreenModel::AssessMesh(const ContactSlot& slot, const Contact& contact,
                               ContactResponse* response) {
  const double width = WidthOfTouch(contact);
  const bool is_point = width == 0;
  const Eigen::Vector3d& force = response->force_O;
  const double largest = force.cwiseAbs().maxCoeff();
  if (!(largest > 0) || (is_point && !bending_.body_bends())) return;
  const Bending& bending = BendingOf(slot.footprint.triangle, width);
  // The means over the axes, weighted with the work of the force along each axis.
  const Eigen::Array3d squared = (force / largest).array().square();
  Eigen::Array3d work = squared * bending.compliance.array();
  if (!(work.sum() > 0)) return;
  work /= work.sum();
  if ((work * bending.softness.array()).sum() > kMaxSoftness && MayReplaceReason(*response)) {
    response->validity = Validity::kExtrapolated;
    response->flag_reason = kStiffInBending;
  }
  if (is_point) return;
  const double part = MeshPart(slot, bending, *response);
  const MeshShare share{part * (work * bending.shear.array()).sum(),
                        part * (work * bending.volume.array()).sum()};
  if (slot.load >= 0) {
    response->displacement_error = response->mesh_error =
        EffectOnLoad(share).error * response->displacement_O.norm();
  } else {
    MeshEffect effect =
        EffectOf(share, {response->spring_share, response->touching}, columns_.stiffness().kind());
    if (slot.footprint.narrower != 0) effect.error += kOfWiderDisc;
    Correct(effect, response);
  }
}

// Work of a force on the body at its own contact, relative to the response's [-]: other contacts
// change the response, and of a disc that a wider one represents the rest is known exactly.
double FemGreenModel::MeshPart(const ContactSlot& slot, const Bending& bending,
                               const ContactResponse& response) const {
  const double whole = response.force_O.dot(response.displacement_O);
  const bool is_alone = solver_.slots().size() == 1;
  if ((is_alone && slot.footprint.narrower == 0) || !(whole > 0)) return 1;
  const double of_mesh =
      displacement_unit_ * (response.force_O.array().square() * bending.compliance.array()).sum();
  return std::min(is_alone ? 1.0 : kMostByOthers, of_mesh / whole);
}

const Bending& FemGreenModel::BendingOf(int triangle, double width) {
  const Bending* known = bending_.Find(triangle, width);
  return known != nullptr ? *known : bending_.Learn(triangle, width, &columns_.Factor());
}

void FemGreenModel::ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) {
  std::vector<PlaceForce> forces;
  solver_.Forces(&forces);
  std::vector<int> places;
  std::vector<Eigen::Vector3d> forces_O;
  for (const auto& [place, force_O] : forces) {
    places.push_back(place);
    forces_O.push_back(force_O);
  }
  if (forces.empty()) {
    u_O->assign(surface_.nodes.size(), Eigen::Vector3d::Zero());
    return;
  }
  columns_.Solve(places, forces_O, u_O);
  u_O->resize(surface_.nodes.size());  // without mid-edge nodes
  for (auto& u : *u_O) u *= displacement_unit_;
}

void FemGreenModel::Prefetch(std::span<const Contact> contacts) {
  std::vector<int> wanted;
  for (const Contact& contact : contacts) {
    ContactFootprint footprint;
    if (!contact.p_O.allFinite() || !(contact.width >= 0)) continue;
    if (!places_.Find(contact, &footprint).empty()) continue;
    for (const auto& touched : footprint.places) wanted.push_back(touched.place);
    const double width = WidthOfTouch(contact);
    if (width > 0 || bending_.body_bends()) BendingOf(footprint.triangle, width);
  }
  columns_.Prefetch(wanted, nullptr);
}

}  // namespace palpate
