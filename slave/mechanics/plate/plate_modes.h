// Bending modes and membrane stress modes of the clamped plate, and their coupling: all parts of
// the von Karman plate that do not depend on the load.
//
// Nondimensional: lengths along the plate are divided by its radius a, deflections by its
// thickness. D is the bending stiffness, N0 the tension at rest. Deflections are polynomials times
// (1 - r^2)^2, by Fourier's modes in the angle, orthonormal in the bending energy: int (Laplace
// f_i)(Laplace f_j) = d_ij. Stresses come from Airy functions, free polynomials, orthonormal in the
// complementary energy of plane stress: the immovable edge is then a natural condition. So the
// plate's energy is
//
//   U(a) = D / 2 |a|^2 + N0 / 2 a^T P a + 1 / 2 sum_k c_k^2,   c_k = 1 / 2 a^T G_k a
//
// for the coefficients a_i of the deflections f_i, with P_ij = int grad f_i grad f_j and
// G_k,ij = int N_k (grad f_i, grad f_j), N_k being the membrane stresses of Airy function k: the
// von Karman equations in Galerkin's form.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/green.h"

namespace palpate::plate {

// The modes in use: only axisymmetric ones, those symmetric to the x axis, or all. The modes are
// sorted in this order.
enum class Symmetry { kRound, kMirror, kNone };

class PlateModes {
 public:
  // Deflections of degree `order` times (1 - r^2)^2, 2 <= order <= 40, or up to 120 with
  // `widest` kRound. `order` is even. -1 < nu <= 0.5. `widest`: only modes of this symmetry. Throws
  // std::invalid_argument.
  PlateModes(int order, double nu, Symmetry widest = Symmetry::kNone);

  [[nodiscard]] int order() const { return order_; }
  [[nodiscard]] int deflections(Symmetry symmetry) const { return Count(deflections_, symmetry); }
  [[nodiscard]] int stresses(Symmetry symmetry) const { return Count(stresses_, symmetry); }
  // Deflections at `x`, |x| <= 1, as many as `values` has rows. No allocation.
  void Evaluate(const Eigen::Vector2d& x, Eigen::Ref<Eigen::VectorXd> values) const noexcept;
  // Computes the modes' means over a disc. No allocation.
  void Mean(const Disc& disc, Eigen::Ref<Eigen::VectorXd> values) const noexcept;

  // The G_k of one Fourier mode of stresses between two of deflections, with k changing fastest,
  // then j, then i. Deflections of the first mode never come after those of the second.
  struct Block {
    int first_i = 0, count_i = 0, first_j = 0, count_j = 0, first_k = 0, count_k = 0;
    std::vector<double> values;
  };
  [[nodiscard]] const std::vector<Block>& blocks() const { return blocks_; }
  // Number of leading blocks that act on deflections of this symmetry.
  [[nodiscard]] std::size_t blocks(Symmetry symmetry) const;
  // P: int grad f_i grad f_j.
  [[nodiscard]] const Eigen::MatrixXd& slope_energy() const { return slope_energy_; }
  [[nodiscard]] std::size_t memory_bytes() const;

 private:
  struct Family {  // one Fourier mode
    int m = 0;
    bool sine = false;
    int first = 0, count = 0;
  };
  struct Radial;  // values at the points of the radial quadrature

  void Number(std::vector<Family>* families, int degree, bool is_stress) const;
  static int Count(const std::vector<Family>& families, Symmetry symmetry);
  void AppendBlocks(Symmetry symmetry, const Radial& radial);
  void AppendBlock(const Family& k, const Family& i, const Family& j, const Radial& radial);
  void MeasureSlopes(const Radial& radial);

  int order_;
  Symmetry widest_;
  std::vector<Family> deflections_, stresses_;  // cosines from m = 0 on, then sines from m = 1 on
  std::vector<Eigen::MatrixXd> orthonormal_;    // per m: from Jacobi's polynomials to the modes
  std::vector<Block> blocks_;
  std::size_t round_blocks_ = 0, mirror_blocks_ = 0;
  Eigen::MatrixXd slope_energy_;
};

}  // namespace palpate::plate
