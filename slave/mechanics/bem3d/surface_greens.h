// Green's functions of a solid's free surface by boundary elements: displacement of every
// triangle's centroid under a unit force, spread evenly over one triangle, with the fixed
// components at zero (paper A, eqs. 3-6; James and Pai 2003).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/mesh/solid_mesh.h"
#include "shared/text/progress.h"
#include "slave/mechanics/bem3d/greens_layout.h"
#include "slave/mechanics/bem3d/greens_store.h"
#include "slave/mechanics/bem3d/reference_system.h"
#include "slave/mechanics/capacitance/compliance.h"

namespace palpate {

// Places are triangles; those that are fixed have zero blocks. Not symmetric: collocation keeps
// Betti's reciprocity only as the mesh gets finer. A body that is free to move answers loads that
// balance, with zero mean displacement and turn of its surface, weighted by area; to a load that
// does not it adds the tractions, linear in space, that balance it.
class SurfaceGreens final : public Compliance {
 public:
  struct Options {
    std::filesystem::path cache{};                     // folder; empty: nothing is kept
    std::size_t memory_limit = std::size_t{8} << 30U;  // of the computation [bytes]
  };

  // O(N^3): LU and as many solutions as there are components; 144 N^2 bytes. Looks into the cache
  // first. Throws std::invalid_argument: see ReferenceSystem; more memory than the limit; a system
  // that is singular to working precision. Interrupted: finished blocks are in the cache.
  SurfaceGreens(const SurfaceMesh& mesh, HeldNodes held, double nu, const Options& options,
                Progress* progress = nullptr);

  [[nodiscard]] int places() const override { return system_.triangles(); }
  const double* Column(int place) override { return column(place); }
  [[nodiscard]] double length_unit() const override { return system_.surface().length_unit; }
  [[nodiscard]] std::size_t memory_bytes() const override {
    return (data_.blocks.size() + data_.reactions.size()) * sizeof(double);
  }

  [[nodiscard]] const double* column(int place) const {
    return data_.blocks.data() +
           9 * static_cast<std::size_t>(place) * static_cast<std::size_t>(places());
  }
  // Traction over E at the fixed components of `triangle` (zero at others) by `force`, over E and
  // the length unit squared, on `place`.
  [[nodiscard]] Eigen::Vector3d Reaction(int triangle, int place,
                                         const Eigen::Vector3d& force) const;

  [[nodiscard]] const ReferenceSystem& system() const { return system_; }
  [[nodiscard]] double condition() const { return data_.condition; }  // of A_0, 1-norm estimate
  [[nodiscard]] bool from_cache() const { return from_cache_; }
  // What went wrong with the cache, one clause; empty: nothing.
  [[nodiscard]] const std::string& remark() const { return remark_; }

 private:
  void RequireMemory(std::size_t limit) const;
  void Compute(GreensStore* store, Progress* progress);

  ReferenceSystem system_;
  GreensLayout layout_;
  GreensData data_;
  bool from_cache_ = false;
  std::string remark_;
};

}  // namespace palpate
