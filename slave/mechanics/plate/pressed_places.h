// Places at which contacts press on a plate, and the forces at the places of moved or rigid bodies.
//
//   w = w0 + C f              (deflections w, forces f at the places; C: the plate's compliance)
//   a moved place              w = d
//   a rigid flat face         f >= 0,  w >= d,  f (w - d) = 0   at each of its places (a negative
//                             depth d or load pulls: all signs turned)
//
// A rigid flat face is not glued and does not tilt. On a plate that bends it touches with its rim:
// at the plate's centre with the whole rim, beside it with an outer arc. Contact without adhesion
// is a quadratic programme; active set method of Lawson and Hanson (Solving Least Squares Problems,
// ch. 23), which ends after finitely many steps.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/dense_factor.h"
#include "slave/mechanics/plate/green.h"

namespace palpate::plate {

// Where a contact presses: over a disc, or at two points that mirror each other.
struct PressedPlace {
  Disc disc;
  Eigen::Vector2d twin{0, 0};
  bool has_twin = false;

  explicit PressedPlace(const Disc& at) : disc(at) {}
  PressedPlace(const Eigen::Vector2d& one, const Eigen::Vector2d& other)
      : disc{one, 0}, twin(other), has_twin(true) {}
};

// Returns the deflection at `x` under a unit load at a place.
double Deflection(const PressedPlace& load, const Eigen::Vector2d& x) noexcept;

// How a contact presses: over its disc evenly, or as a rigid flat face.
enum class Face : std::uint8_t { kEven, kRigid };
// Number of places of a rigid face: pairs of points on its rim that are mirror images about the
// diameter through the plate's centre. They are denser outwards, where an eccentric face touches.
// [measured: on 12 pairs within 0.1 % of 97, 0.5 % where the face is 0.05 from the rim of the
// plate]
constexpr int kPairs = 12;
// Appends the places of a contact, which are pairs if `paired`, else single points.
void AppendPlaces(const Disc& disc, Face face, bool paired, std::vector<PressedPlace>* places);

class PressedPlaces {
 public:
  // A contact with unknown forces; its places are consecutive.
  struct Body {
    Eigen::Index first = 0, count = 1;
    bool is_rigid = false;  // false: a moved contact with one place
    bool is_force = false;  // for a rigid one: the load is prescribed, not the depth
  };
  void Clear();
  void Add(const Body& body);
  [[nodiscard]] const std::vector<Body>& bodies() const { return bodies_; }
  // Call if the compliance has changed.
  void Renew() { factored_ = false; }

  // Replaces the bodies' part of `forces`, from which the search for the places that touch starts.
  // `free`: deflections without that part; `values`: of each body, its deflection or load. False:
  // singular to working precision (condition beyond 1e12 after scaling): places too close to be
  // distinguished, or one that cannot move. No allocation for known sizes.
  bool Solve(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free,
             std::span<const double> values, Eigen::VectorXd* forces) noexcept;
  // Solution of the last Solve.
  [[nodiscard]] double deflection(std::size_t body) const { return depths_[body]; }
  // d load / d deflection of one body while the prescribed values of the others stay; 0: it does
  // not touch.
  [[nodiscard]] double Stiffness(std::size_t body) const noexcept;
  // Returns d load / d deflection of a uniform load at `place`; 0: it cannot move.
  [[nodiscard]] double StiffnessAt(const Eigen::MatrixXd& compliance,
                                   Eigen::Index place) const noexcept;

 private:
  struct Touching {
    Eigen::Index place = 0;
    std::size_t body = 0;
    friend bool operator==(const Touching&, const Touching&) = default;
  };
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  void Start(const Eigen::VectorXd& free, std::span<const double> values, Eigen::VectorXd* forces);
  bool Factorise(const Eigen::MatrixXd& compliance) noexcept;
  bool Invert() noexcept;
  void Seek(const Eigen::VectorXd& free, std::span<const double> values) noexcept;
  bool Approach(Eigen::VectorXd* forces);
  bool TouchNext(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free,
                 const Eigen::VectorXd& forces);
  // The row of a loaded body's depth.
  [[nodiscard]] int BorderOf(std::size_t body) const {
    int row = static_cast<int>(factored_for_.size());
    for (std::size_t b = 0; b < body; ++b) row += bodies_[b].is_force ? 1 : 0;
    return row;
  }
  [[nodiscard]] auto Inverse() const {
    return Eigen::Map<const Rows, 0, Eigen::OuterStride<>>(inverse_.data(), size_, size_,
                                                           Eigen::OuterStride<>(PaddedTo8(size_)));
  }

  std::vector<Body> bodies_;
  std::vector<double> signs_;   // signs of the bodies' forces; 0: no load
  std::vector<double> depths_;  // of the bodies
  Eigen::Index places_ = 0;     // up to the last one of a body
  std::vector<Touching> touching_, factored_for_;
  bool factored_ = false;
  // Unknowns: forces at the places that touch, then depths of loaded bodies. Scaled so that a
  // place's own compliance is one.
  int size_ = 0;
  DenseFactor factor_;
  std::vector<double> inverse_;  // of the matrix before it was scaled, in rows of PaddedTo8(size_)
  Eigen::VectorXd scale_, right_, wanted_;
};

}  // namespace palpate::plate
