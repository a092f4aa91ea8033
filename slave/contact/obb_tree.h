// A tree of oriented bounding boxes over the elements of a boundary (paper A, 3.5, after Gottschalk
// et al. 1996), for two questions: where does a path first enter the body, and which place is the
// nearest. Planar; frame O [m]. Answers do not depend on how the elements are numbered.
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/outline.h"

namespace palpate {

// A place on one element.
struct ElementPlace {
  int element = -1;
  double s = 0;               // along the element [0, 1] from a to b
  Eigen::Vector2d p_O{0, 0};  // [m]
};

class ObbTree {
 public:
  // Throws std::invalid_argument: fewer than three elements, an element without length or not
  // finite.
  explicit ObbTree(const BoundaryMesh& mesh);

  // Where the straight path first crosses the boundary from outside to inside. A path that only
  // touches the boundary, runs along it or ends on it does not enter; one that starts on it and
  // leads inwards does. No allocation, O(log N) where the path crosses few boxes.
  [[nodiscard]] std::optional<ElementPlace> FirstEntry(const Eigen::Vector2d& from,
                                                       const Eigen::Vector2d& to) const noexcept;

  // The nearest place to `p`. Of equally near elements, which two are that share the nearest node,
  // the one that `p` lies farther in front of or behind: its side tells whether `p` is inside.
  // Looks first around element `near`, the last answer if there is one (neighbourhood watch), then
  // wherever the tree could hold something nearer. No allocation.
  [[nodiscard]] ElementPlace Nearest(const Eigen::Vector2d& p, int near = -1) const noexcept;

  // Signed distance of `p` from the element's line [m], positive on the outer side.
  [[nodiscard]] double HeightOver(int element, const Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] const Eigen::Vector2d& normal(int element) const noexcept;
  // Largest distance of the boundary from the origin [m].
  [[nodiscard]] double reach() const { return reach_; }

 private:
  struct Element {
    Eigen::Vector2d a, b, normal;
    int next, previous;
  };
  // Axes: `axis` and the same turned by 90 degrees. Leaves own elements, others two boxes.
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
  [[nodiscard]] double LeastDistanceSquared(const Box& box,
                                            const Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] Candidate Project(int element, const Eigen::Vector2d& p) const noexcept;
  [[nodiscard]] bool IsNearer(const Candidate& one, const Candidate& other) const noexcept;
  [[nodiscard]] const Element& At(int element) const noexcept {
    return elements_[static_cast<std::size_t>(element)];
  }

  std::vector<Element> elements_;
  std::vector<int> order_;  // element indices, sorted into the leaves
  std::vector<Box> boxes_;  // boxes_[0] is the root
  double reach_ = 0;
};

}  // namespace palpate
