// The von Karman plate in its modes under several contacts: Newton's method on the amplitudes and
// the contact forces together. Nondimensional as in round_press.h.
//
//   D a + N0 P a + sum_k c_k G_k a = sum_s F_s l_s          (l_s: means of the modes over the load)
//   w_s = f_s^T a + sum_t g_st F_t + d_s(sum_t h_st F_t)    (f_s: the modes at its centre)
//
// for places s, t. A uniform load has one place, a rigid face several (pressed_places.h), for which
// l_s = f_s is the modes' mean of the two points. g is the deflection in bending by the shapes
// beyond the modes, known in closed form: the plate's Green's function minus that of the modes. So
// the linear solution is exact for every order. d is the reduction of g by stretching (ShortWaves).
// It depends on the contact at s and on contacts so close that they share its short waves: h_st is
// g for points at the contacts' centres divided by g_ss, which is one for loads at the same place.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/plate/green.h"
#include "slave/mechanics/plate/plate_modes.h"
#include "slave/mechanics/plate/pressed_places.h"

namespace palpate::plate {

// Effect of stretching on the shapes beyond a plate's modes, by comparison with a load at the
// centre that is solved without modes.
//
// Around a small load the solution is nearly independent of its position, because the tension there
// is caused by the load itself (in Schwerin's membrane slope and tension depend only on the force
// and the distance from it, not on the plate's size). So the modes' error at the same force is
// taken from a load at the centre, where it is known: d(F) = w_exact(F) - w_modes(F), with so many
// modes that the load is resolved as finely as at its true position. d vanishes with the cube of
// the force while the plate only bends; a press at the centre becomes exact.
class ShortWaves {
 public:
  struct Share {
    double deflection = 0, compliance = 0;  // d(F), d'(F)
  };

  // For contacts of one radius and face on a plate with modes of this order, up to deflections of
  // about 200 thicknesses. Tens of milliseconds. Throws std::runtime_error: no convergence.
  ShortWaves(int order, double nu, double prestress, double load_radius, Face face = Face::kEven);
  // Returns the short waves of a plate. They are computed once for all equal plates of this
  // program; the sixteen that were requested last are kept. Thread-safe.
  static std::shared_ptr<const ShortWaves> Of(int order, double nu, double prestress,
                                              double load_radius, Face face = Face::kEven);

  // `resolution`: compliance that the shapes beyond the modes add under a point load there, in
  // units of 1 / D. Odd in the force. No allocation.
  [[nodiscard]] Share At(double force, double resolution) const noexcept;
  [[nodiscard]] double load_radius() const { return load_radius_; }
  [[nodiscard]] Face face() const { return face_; }

 private:
  struct Entry {
    double force = 0;
    Share share;
  };
  struct Level {  // one number of modes
    double resolution = 0;
    std::vector<Entry> entries;  // rising
  };
  static Share Interpolate(const Level& level, double force) noexcept;

  double load_radius_;
  Face face_;
  std::vector<Level> levels_;  // from coarse to fine; the last one has no effect
};

class ModalPlate {
 public:
  struct Press {
    Disc disc;
    Face face = Face::kEven;
    bool is_force = false;
    double value = 0;                   // deflection at the centre or of the face, or load
    const ShortWaves* waves = nullptr;  // nullptr: d = 0

    [[nodiscard]] bool is_sought() const { return !is_force || face == Face::kRigid; }
  };

  // Stores a reference to the modes. D: bending stiffness; prestress N0 >= 0.
  ModalPlate(const PlateModes& modes, double D, double prestress);

  // Positions of the loads, in a frame in which `symmetry` holds.
  void Place(std::span<const Press> presses, Symmetry symmetry);
  // Solves by Newton's method from the last solution, else in steps from rest. `values`: one per
  // placed press. False: no solution, and the plate is at rest. Allocation-free for known sizes.
  bool Solve(std::span<const double> values) noexcept;
  void Reset() noexcept;

  struct Answer {
    double force = 0, deflection = 0;  // deflection at the centre, or of the rigid face
    // d force / d deflection with the prescribed values of the others fixed; 0: it cannot move, or
    // does not touch.
    double stiffness = 0;
  };
  // Returns the answer of a contact at the solution.
  [[nodiscard]] Answer AnswerOf(std::size_t contact) const noexcept;
  // Returns the deflection at a position, in the frame of Place(). No allocation.
  [[nodiscard]] double Deflection(const Eigen::Vector2d& x) noexcept;

 private:
  void ListPlaces();
  void CompareShortWaves();
  bool Newton(double share) noexcept;
  bool Linearise() noexcept;
  void Stretch() noexcept;
  void Comply() noexcept;
  void AddForces(double share) noexcept;
  bool SeekForces(double share) noexcept;
  void NoteDeflections() noexcept;
  // Returns the deflection at a place caused by shapes beyond the modes.
  [[nodiscard]] double ShortWavesAt(Eigen::Index place) const noexcept;
  // Part of the forces that shares the short waves of a contact.
  [[nodiscard]] double ForceNear(std::size_t contact) const noexcept;
  [[nodiscard]] std::size_t ContactOf(Eigen::Index place) const {
    return contact_of_[static_cast<std::size_t>(place)];
  }

  const PlateModes& modes_;
  double D_, prestress_;
  Symmetry symmetry_ = Symmetry::kRound;
  std::vector<Press> presses_;
  std::vector<PressedPlace> places_;     // of the presses, one after another
  std::vector<Eigen::Index> firsts_;     // the first place of each press, and the end
  std::vector<std::size_t> contact_of_;  // per place
  PressedPlaces pressed_;
  std::vector<double> sought_;         // values of the contacts with unknown forces
  Eigen::MatrixXd at_, load_, short_;  // f and l, one column per place; g
  Eigen::MatrixXd centres_;            // the modes at the centres, column per contact
  Eigen::VectorXd resolution_;         // g_ss for points at the centres, by 1 / D
  Eigen::MatrixXd near_;               // h, of contacts
  Eigen::VectorXd amplitudes_, forces_, deflections_;  // the last two at the places
  Eigen::VectorXd stress_, gradient_, step_, point_;
  Eigen::MatrixXd pull_;     // column i: sum_j G_k,ij a_j, row per stress
  Eigen::MatrixXd tangent_;  // of the amplitudes, lower half; then its factor
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd by_load_;      // tangent^-1 load_
  Eigen::MatrixXd compliance_;   // of places
  Eigen::VectorXd free_, next_;  // deflections without the unknown forces; those forces
};

}  // namespace palpate::plate
