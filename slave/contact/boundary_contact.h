// Contact of the tool with the boundary (paper A, 3.5): an OBB tree finds where the tip's path
// crosses it, and a neighbourhood watch tracks the contact point. A round end is its centre and its
// radius: it touches where the boundary is nearer to the centre than the radius. Planar; frame O
// [m].
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slave/mesh/index.h"
#include "slave/mesh/outline.h"

namespace palpate {

// A point on one element.
struct ElementPlace {
  int element = -1;
  double s = 0;               // along the element [0, 1] from a to b
  Eigen::Vector2d p_O{0, 0};  // [m]
};

// A tree of oriented bounding boxes over the elements of a boundary (paper A, 3.5, after Gottschalk
// et al. 1996). It finds where a path first enters the body, and the nearest boundary point.
// Results do not depend on the numbering of the elements.
class ObbTree {
 public:
  // Throws std::invalid_argument: fewer than three elements, an element without length or not
  // finite.
  explicit ObbTree(const BoundaryMesh& mesh);

  // Where the straight path first crosses the boundary from outside to inside. A path that only
  // touches the boundary, runs along it or ends on it does not enter; a path that starts on it and
  // leads inwards does. No allocation, O(log N) if the path crosses few boxes.
  [[nodiscard]] std::optional<ElementPlace> FirstEntry(const Eigen::Vector2d& from,
                                                       const Eigen::Vector2d& to) const noexcept;

  // The boundary point nearest to `p`. Of two equally near elements that share the nearest node,
  // the one from whose line `p` is farther: its side decides whether `p` is inside. Searches first
  // around element `near`, the last result if there is one (neighbourhood watch), then wherever the
  // tree could contain something nearer. No allocation.
  [[nodiscard]] ElementPlace Nearest(const Eigen::Vector2d& p, int near = -1) const noexcept;

  // Signed distance of `p` from the element's line [m], positive on the outer side.
  [[nodiscard]] double HeightOver(int element, const Eigen::Vector2d& p) const noexcept {
    return (p - At(element).a).dot(At(element).normal);
  }
  [[nodiscard]] const Eigen::Vector2d& normal(int element) const noexcept {
    return At(element).normal;
  }
  // Largest distance of the boundary from the origin [m].
  [[nodiscard]] double reach() const { return reach_; }

 private:
  struct Element {
    Eigen::Vector2d a, b, normal;
    int next, previous;
  };
  // Axes: `axis` and the same rotated by 90 degrees. Leaves own elements, inner boxes two boxes.
  struct Box {
    Eigen::Vector2d centre, axis, half;
    int begin, end;  // range of order_
    int left = -1, right = -1;
  };
  struct Candidate {
    ElementPlace place;
    double distance_squared = 0, height = 0;
  };

  int Build(int begin, int end);
  [[nodiscard]] Box Fit(int begin, int end) const;
  [[nodiscard]] bool MayMeet(const Box& box, const Eigen::Vector2d& from,
                             const Eigen::Vector2d& to) const noexcept;
  [[nodiscard]] double MinDistanceSquared(const Box& box, const Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] Candidate Project(int element, const Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] bool IsNearer(const Candidate& one, const Candidate& other) const noexcept;
  [[nodiscard]] const Element& At(int element) const noexcept { return elements_[Index(element)]; }

  std::vector<Element> elements_;
  std::vector<int> order_;  // element indices, sorted into the leaves
  std::vector<Box> boxes_;  // boxes_[0] is the root
  double reach_ = 0;
};

// A point on the boundary at rest: the ideal haptic interface point.
struct BoundaryPlace {
  int element = -1;                // index into the mesh; -1: none
  double s = 0;                    // along the element [0, 1] from a to b
  Eigen::Vector2d p_O{0, 0};       // position of the point [m]
  Eigen::Vector2d normal_O{0, 1};  // outward unit normal [-]; to the centre of a round end
  double gap = 0;  // signed distance of the tool's end along the normal [m]; negative: inside
};

// One tool's contact with one boundary.
class BoundaryContact {
 public:
  // Copies all that it needs. `radius` of the tool's end [m]; 0: its tip is a point. Throws
  // std::invalid_argument: fewer than three elements.
  BoundaryContact(const BoundaryMesh& mesh, double radius) : tree_(mesh), radius_(radius) {}

  // Moves the tip, or the centre of a round end, to `p_O` and returns the contact point, or the
  // nearest point while out of contact. Contact begins where the path from the last tip crosses the
  // boundary inwards, or where a round end touches first on its path. It stays at this point
  // (bonded) until the tool crosses the plane of the point outwards. The first call only sets the
  // tip; a tool that is inside at first is in contact at the nearest point. Not finite: nothing
  // changes. No allocation.
  const BoundaryPlace& Move(const Eigen::Vector2d& p_O) noexcept;
  [[nodiscard]] bool in_contact() const { return in_contact_; }
  // Forget the tip and the contact.
  void Reset() noexcept;

 private:
  [[nodiscard]] double GapOf(const Eigen::Vector2d& p) const noexcept {
    return (p - place_.p_O).dot(place_.normal_O) - radius_;
  }
  [[nodiscard]] std::optional<double> WayToTouch(const Eigen::Vector2d& from,
                                                 const Eigen::Vector2d& path) const noexcept;
  void Touch(const ElementPlace& at, const Eigen::Vector2d& tool,
             const Eigen::Vector2d& to) noexcept;
  void Approach(const Eigen::Vector2d& from, const Eigen::Vector2d& to) noexcept;
  [[nodiscard]] Eigen::Vector2d NormalTo(const Eigen::Vector2d& centre,
                                         const ElementPlace& at) const noexcept;

  ObbTree tree_;
  double radius_;
  BoundaryPlace place_;
  std::optional<Eigen::Vector2d> last_;
  bool in_contact_ = false;
};

}  // namespace palpate
