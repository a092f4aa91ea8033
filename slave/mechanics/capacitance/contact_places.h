// Which places of a compliance a contact touches, and with what share: the conventions of a model's
// boundary (nodes or triangles), kept out of the solver.
#pragma once

#include <string_view>
#include <utility>
#include <vector>

#include "slave/mechanics/footprint/contact_footprint.h"

namespace palpate {

class ContactPlaces {
 public:
  virtual ~ContactPlaces() = default;
  ContactPlaces() = default;
  ContactPlaces(const ContactPlaces&) = delete;
  ContactPlaces& operator=(const ContactPlaces&) = delete;

  // Finds what `contact` touches; its kind, p_O, element and width count, its value does not.
  // Empty: found; otherwise why not, one clause that lives on. Allocates nothing where `footprint`
  // has room already. Called only for contacts that changed; the contact is finite.
  virtual std::string_view Find(const Contact& contact, ContactFootprint* footprint) = 0;
};

// Places are the surface's nodes (fem-green).
class SurfaceNodePlaces final : public ContactPlaces {
 public:
  // `place_of_node`: -1 for nodes that are none.
  SurfaceNodePlaces(SurfaceMesh surface, std::vector<int> place_of_node)
      : footprints_(std::move(surface)), place_of_node_(std::move(place_of_node)) {}
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override;

 private:
  SurfaceFootprints footprints_;
  std::vector<int> place_of_node_;
};

// Places are the surface's triangles (bem3d).
class SurfaceTrianglePlaces final : public ContactPlaces {
 public:
  explicit SurfaceTrianglePlaces(SurfaceMesh surface) : footprints_(std::move(surface)) {}
  std::string_view Find(const Contact& contact, ContactFootprint* footprint) override {
    return footprints_.OnTriangles(contact, footprint);
  }

 private:
  SurfaceFootprints footprints_;
};

}  // namespace palpate
