// `extruded`: an outline with its thickness under a rigid flat tool that reaches through a part of
// it, glued. Linear. Contacts and displacements are those of a planar model: the outline is the
// front edge of the body, which a camera sees.
//
// Each tool position needs a finite element solution (pressed_prism.h) at its first query. Later
// queries there use a 2 x 2 stiffness. With SolveAside another thread solves, also for the
// neighbours of the last position.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <thread>
#include <vector>

#include <Eigen/Core>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/mechanics/deformation_model.h"
#include "slave/mesh/outline.h"

namespace palpate {

// Accepts one contact at a time, moved or loaded; its width is that of the tool. kFailed: more than
// one contact, or a tool on a fixed part. Preparing a place takes tenths of a second and allocates.
class ExtrudedModel final : public DeformationModel {
 public:
  struct Params {
    double young_modulus = 0;  // E [Pa]
    double poisson_ratio = 0;  // nu [-], < 0.5
    double thickness = 0;      // [m]
    double front = 0;          // of the tool, behind the front face [m]
    double depth = 0;          // of the tool, from there on [m]
    double range = 0.1;        // largest |displacement| / larger side before `extrapolated` [-]
  };

  // `held`: components x, y of each element. Throws std::invalid_argument: a parameter beyond its
  // range, nothing is held.
  ExtrudedModel(BoundaryMesh mesh, std::vector<std::array<bool, 2>> held, const Params& params);
  ~ExtrudedModel() override;

  void Prefetch(std::span<const Contact> contacts) override;
  void SolveAside() override;

 private:
  struct Place;
  // Where a tool is.
  struct Position {
    int element = 0;
    Eigen::Vector2d p_O{0, 0};
    double width = 0;  // [m]
    bool operator==(const Position&) const = default;
  };

  void ComputeResponses(std::span<const Contact> contacts,
                        std::span<ContactResponse> responses) noexcept override;
  void ComputeDisplacements(std::vector<Eigen::Vector3d>* u_O) override;
  [[nodiscard]] PlanarCover MakeCover() const override { return CoverOf(mesh_, kCoverPlaces); }
  void ComputeInside(const std::vector<Eigen::Vector2d>& places,
                     std::vector<Eigen::Vector3d>* u_O) override;
  // The displacements at places of the outline and then inside, from `first` on.
  void AppendFront(std::size_t first, std::size_t count, std::vector<Eigen::Vector3d>* u_O) const;
  // nullopt: there is no element at the contact.
  [[nodiscard]] std::optional<Position> PositionOf(const Contact& contact) const;
  // Returns the place, or with SolveAside the nearest known one until it is solved; null: none.
  const Place* Find(const Position& at);
  [[nodiscard]] std::unique_ptr<Place> Prepare(const Position& at) const;
  void Keep(std::unique_ptr<Place> place);
  // Call the functions below with places_mutex_ locked.
  [[nodiscard]] const Place* Known(const Position& at) const;
  [[nodiscard]] const Place* NearestKnown(const Position& at) const;
  // The position to solve next: the wanted one, then its neighbours; nullopt: all are known.
  [[nodiscard]] std::optional<Position> Unsolved() const;
  void SolveWanted(const std::stop_token& stop);

  BoundaryMesh mesh_;
  std::vector<std::array<bool, 2>> held_;
  Params params_;
  double larger_side_ = 0;                // [m]
  std::vector<Eigen::Vector2d> shown_O_;  // where displacements are computed: outline, then inside
  mutable PriorityInheritanceMutex places_mutex_;  // guards the next two members
  std::vector<std::unique_ptr<const Place>> places_;
  std::optional<Position> wanted_;
  // Position of the last query.
  const Place* shown_ = nullptr;
  Eigen::Vector2d moved_O_{0, 0};  // the tool [m]

  PriorityInheritanceCondition asked_;
  std::jthread solver_;  // of SolveAside; last, because it uses all of the above
};

}  // namespace palpate
