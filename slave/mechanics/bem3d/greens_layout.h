// How Green's functions of a surface are computed in pieces and kept, whoever computes them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem3d/greens_store.h"
#include "slave/mechanics/bem3d/reference_system.h"

namespace palpate {

class GreensLayout {
 public:
  static constexpr int kTriangles = 64;  // whose columns are solved for together, and kept

  explicit GreensLayout(const ReferenceSystem& system);

  // All that the result depends on: see GreensStore.
  [[nodiscard]] static std::vector<double> Inputs(const ReferenceSystem& system);
  [[nodiscard]] bool Fits(const GreensData& data) const {
    return data.blocks.size() == blocks(places()) && data.reactions.size() == reactions(places());
  }

  [[nodiscard]] std::size_t places() const { return row_.size() / 3; }
  // Numbers of GreensData by loads on so many triangles.
  [[nodiscard]] std::size_t blocks(std::size_t loaded) const { return 9 * places() * loaded; }
  [[nodiscard]] std::size_t reactions(std::size_t loaded) const { return 3 * rows_ * loaded; }
  // Per component: its row among the reactions of a load; -1: it is free.
  [[nodiscard]] int row(std::size_t component) const { return row_[component]; }
  [[nodiscard]] std::size_t rows() const { return rows_; }

  // The blocks and the reactions of solutions for ReferenceSystem::Loads. What is unknown where a
  // component is free is its displacement, where it is held its traction.
  void Split(const Eigen::Ref<const Eigen::MatrixXd>& columns, double* blocks,
             double* reactions) const;

 private:
  std::vector<int> row_;
  std::size_t rows_ = 0;
};

// Throws std::invalid_argument unless `condition` is that of a system which can be solved.
void RequireRegular(double condition);
[[noreturn]] void RefuseSingular();

}  // namespace palpate
