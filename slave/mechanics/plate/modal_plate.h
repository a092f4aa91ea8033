// The von Karman plate in its modes under several contacts: Newton's method on the amplitudes and
// the contact forces together. Nondimensional as in round_press.h.
//
//   D a + N0 P a + sum_k c_k G_k a = sum_s F_s l_s          (l_s: means of the modes over the load)
//   w_s = f_s^T a + sum_t g_st F_t + d_s(sum_t h_st F_t)    (f_s: the modes at its centre)
//
// g is the deflection that the shapes beyond the modes add in bending, known in closed form: the
// plate's Green's function less that of the modes. So the linear answer is exact whatever the
// order. d is what stretching takes from it (ShortWaves), of the load at s and those so near
// that they share its short waves: h_st is g for points, by g_ss; one for loads in one place.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "slave/mechanics/plate/contacts.h"
#include "slave/mechanics/plate/green.h"
#include "slave/mechanics/plate/plate_modes.h"

namespace palpate::plate {

// What stretching does to the shapes beyond a plate's modes, by comparison with a press at the
// centre that is solved without modes.
//
// Around a small load the plate looks the same wherever it is pressed: the tension there comes from
// the load itself (in Schwerin's membrane slope and tension depend on the force and the distance
// from it alone, not on the plate's size). So the modes' error at the same force is taken from the
// centre, where it is known: d(F) = w_exact(F) - w_modes(F), with as many modes there as resolve
// the load as finely as it is resolved where it is. d vanishes with the cube of the force where the
// plate bends only; a press at the centre becomes exact.
class ShortWaves {
 public:
  struct Share {
    double deflection = 0, compliance = 0;  // d(F), d'(F)
  };

  // For loads over discs of one radius on a plate with modes of this order, up to deflections of
  // about 200 thicknesses. Tens of milliseconds. Throws std::runtime_error: no convergence.
  ShortWaves(int order, double nu, double prestress, double load_radius);
  // The same, computed once for all equal plates of this program; the sixteen that were last
  // requested are kept. Thread-safe.
  static std::shared_ptr<const ShortWaves> Of(int order, double nu, double prestress,
                                              double load_radius);

  // `resolution`: what the shapes beyond the modes add to the compliance under a point load there,
  // by 1 / D. Odd in the force. No allocation.
  [[nodiscard]] Share At(double force, double resolution) const noexcept;
  [[nodiscard]] double load_radius() const { return load_radius_; }

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
  std::vector<Level> levels_;  // from coarse to fine; the last has no share
};

class ModalPlate {
 public:
  struct Press {
    Disc disc;
    bool is_force = false;
    double value = 0;                   // deflection at the centre, or load
    const ShortWaves* waves = nullptr;  // nullptr: d = 0
  };

  // Keeps a reference to the modes. D: bending stiffness; prestress N0 >= 0.
  ModalPlate(const PlateModes& modes, double D, double prestress);

  // Positions of the loads, in a frame in which `symmetry` holds.
  void Place(std::span<const Press> presses, Symmetry symmetry);
  // Newton from the last solution, else in steps from rest. `values`: as many as were placed.
  // False: no solution; then at rest. Allocation-free for known sizes.
  bool Solve(std::span<const double> values) noexcept;
  void Reset() noexcept;

  [[nodiscard]] const Eigen::VectorXd& forces() const { return forces_; }
  // At the contacts' centres.
  [[nodiscard]] const Eigen::VectorXd& deflections() const { return deflections_; }
  // d deflection at a contact / d force at another, at the solution.
  [[nodiscard]] const Eigen::MatrixXd& compliance() const { return compliance_; }
  // d force / d deflection of one contact with the prescribed values of the others fixed; 0: it
  // cannot move.
  [[nodiscard]] double Stiffness(Eigen::Index contact) const noexcept {
    return moved_.Stiffness(compliance_, contact);
  }
  // At a position, in the frame of Place(). No allocation.
  [[nodiscard]] double Deflection(const Eigen::Vector2d& x) noexcept;

 private:
  bool Newton(double share) noexcept;
  bool Linearise() noexcept;
  void Stretch() noexcept;
  void Comply() noexcept;
  void AddForces(double share) noexcept;
  void Demand(double share) noexcept;
  void Answer(double share) noexcept;
  // What the shapes beyond the modes add at a contact.
  [[nodiscard]] double ShortWavesAt(Eigen::Index contact) const noexcept;

  const PlateModes& modes_;
  double D_, prestress_;
  Symmetry symmetry_ = Symmetry::kRound;
  std::vector<Press> presses_;
  MovedContacts moved_;
  Eigen::MatrixXd at_, load_, short_;  // f and l, column per contact; g
  Eigen::VectorXd resolution_;         // g_ss for points, by 1 / D
  Eigen::MatrixXd near_;               // h
  Eigen::VectorXd amplitudes_, forces_, deflections_;
  Eigen::VectorXd stress_, gradient_, step_, point_;
  Eigen::MatrixXd pull_;     // column i: sum_j G_k,ij a_j, row per stress
  Eigen::MatrixXd tangent_;  // of the amplitudes, lower half; then its factor
  Eigen::LLT<Eigen::MatrixXd> factor_;
  Eigen::MatrixXd by_load_;  // tangent^-1 load_
  Eigen::MatrixXd compliance_;
  Eigen::VectorXd more_;  // of the moved contacts' forces
};

}  // namespace palpate::plate
