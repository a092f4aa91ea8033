// Linear tetrahedra of the stable neo-Hookean law, eight per instruction. Nondimensional: lengths
// in some unit L, stresses in Young's moduli E.
//
//   P = a F + s cof F,   a = m (1 - 1 / (I_C + 1)),   s = k (J - 1) - 3/4 m
//
// with m = 4/3 mu and k = lambda + 5/6 mu: the law of material_law.h (Smith, de Goes and Kim 2018,
// eq. 14).
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/linear/lanes.h"

namespace palpate {

class NeoHookeanTets {
 public:
  // `corners`: numbers of positions at rest, in units of length. Positive volumes, checked by the
  // caller; -1 < nu < 0.5. `moduli` per tetrahedron [E]; empty: 1.
  NeoHookeanTets(std::span<const std::array<int, 4>> corners,
                 const std::vector<Eigen::Vector3d>& nodes, double nu,
                 std::span<const double> moduli = {});

  // Adds to `force` the internal force at displacements `u`, three numbers per node each.
  void AddForce(const double* u, double* force) const noexcept;
  // The same without that of the law's linearisation at rest. Returns the smallest det F.
  double AddNonlinearForce(const double* u, double* force) const noexcept;

  [[nodiscard]] int size() const { return static_cast<int>(corners_.size()); }

  // Eight tetrahedra side by side; the last group repeats its first with volume zero.
  struct Group {
    std::array<std::array<int, 8>, 4> node{};               // offsets of the corners' x
    std::array<std::array<fem::Double8, 3>, 3> gradient{};  // of corners 1 to 3
    fem::Double8 volume{};
  };
  struct Law {
    double m = 0, k = 0;        // of the nonlinear law
    double lambda = 0, mu = 0;  // of the linear one
  };

 private:
  Law law_;
  std::vector<std::array<int, 4>> corners_;
  std::vector<Group> groups_;
};

}  // namespace palpate
