// Response of a fixed body to a unit force on its free surface: the Green's functions that answer
// contacts (James and Pai 2003; paper A, eqs. 5-7, in the form of a compliance); and the unknown
// contact forces, with the blocks of a compliance between them.
//
// Nondimensional: lengths are divided by length_unit(), forces by E times its square, for a plane
// body by E times the length unit and the thickness.
#pragma once

#include <array>

#include <Eigen/Core>

#include "slave/mechanics/footprint/contact_footprint.h"
#include "slave/mesh/index.h"

namespace palpate {

// An unknown force, distributed over at most three places; frame O, nondimensional.
struct ForceUnknown {
  struct Share {
    const double* column = nullptr;  // of the compliance
    int place = -1;
    double weight = 0;
  };
  std::array<Share, kMaxPointPlaces> shares;
  int share_count = 0;
  int row = 0;         // of its first component in the capacitance matrix
  int count = 3;       // components that are unknown
  bool plain = false;  // one place, all components of the body's displacements
  int hold = -1;       // of a tool: in its footprint's holds
  double measure = 1;  // force by amplitude (Compliance::measure)
  Eigen::Matrix3d basis = Eigen::Matrix3d::Identity();  // columns 0 to count: their directions
};

class Compliance {
 public:
  // Displacements of a plane body have two components, since z is fixed.
  explicit Compliance(int components = 3) : components_(components) {}
  virtual ~Compliance() = default;
  Compliance(const Compliance&) = delete;
  Compliance& operator=(const Compliance&) = delete;

  // Points of contact: surface nodes (fem-green) or nodes of boundary elements
  // (bem2d), called places.
  [[nodiscard]] virtual int places() const = 0;
  // Number of additional places after places(): their amplitudes are the free rigid motions of the
  // body, and their displacements are the unbalanced forces, which must vanish if a contact
  // prescribes a displacement.
  [[nodiscard]] virtual int motions() const { return 0; }
  // components() squared numbers per place i: entry components() c + r is the displacement along r
  // at i for a unit amplitude along c at `place`; entries of fixed components have another meaning,
  // see FreeBlock. Columns may be computed at the first request, which takes milliseconds and
  // memory; nullptr: out of memory. The pointer stays valid.
  virtual const double* Column(int place) = 0;
  // The force of a unit amplitude: where amplitudes are tractions, the length they act on.
  [[nodiscard]] virtual double measure(int /*place*/) const { return 1; }
  // Young's modulus around a place, relative to the body's.
  [[nodiscard]] virtual double modulus(int /*place*/) const { return 1; }
  // Returns the components fixed by a support at a place; in the base class those with zero
  // compliance.
  [[nodiscard]] virtual std::array<bool, 3> Held(int place) {
    const Eigen::Vector3d own = BlockAt(Column(place), place).diagonal();
    return {!(own[0] > 0), !(own[1] > 0), !(own[2] > 0)};
  }
  // Returns the block of a column `by` at the place `at`, with zeros along fixed components.
  [[nodiscard]] virtual Eigen::Matrix3d FreeBlock(const double* column, int /*by*/, int at) {
    return BlockAt(column, at);
  }
  [[nodiscard]] virtual double length_unit() const = 0;  // [m]
  [[nodiscard]] virtual std::size_t memory_bytes() const = 0;

  [[nodiscard]] int components() const { return components_; }
  // Returns the block of a column at a place, with zeros beyond components().
  [[nodiscard]] Eigen::Matrix3d BlockAt(const double* column, int place) const {
    if (components_ == 3) return Eigen::Map<const Eigen::Matrix3d>(column + 9L * place);
    Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
    block.topLeftCorner<2, 2>() = Eigen::Map<const Eigen::Matrix2d>(column + 4L * place);
    return block;
  }
  // Weighted displacement at the places of `at` by unit amplitudes `by`, all components.
  [[nodiscard]] Eigen::Matrix3d FullBlock(const ForceUnknown& at, const ForceUnknown& by) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (int b = 0; b < by.share_count; ++b) {
      const auto& from = by.shares[Index(b)];
      for (int a = 0; a < at.share_count; ++a) {
        const auto& to = at.shares[Index(a)];
        sum += to.weight * from.weight * BlockAt(from.column, to.place);
      }
    }
    return sum;
  }
  // The capacitance matrix's rows and columns of two unknowns: `to` is the entry at their first
  // ones.
  void FillBlock(const ForceUnknown& at, const ForceUnknown& by, double* to, int stride) const {
    if (!at.plain || !by.plain) {
      const Eigen::Matrix3d block = at.basis.transpose() * FullBlock(at, by) * by.basis;
      for (int r = 0; r < at.count; ++r, to += stride) {
        for (int c = 0; c < by.count; ++c) to[c] = block(r, c);
      }
      return;
    }
    const double* from = by.shares[0].column + Entry(at.shares[0].place);
    if (components_ == 2) {
      to[0] = from[0];
      to[1] = from[2];
      to[stride] = from[1];
      to[stride + 1] = from[3];
      return;
    }
    for (int r = 0; r < 3; ++r, to += stride) {
      to[0] = from[r];
      to[1] = from[3 + r];
      to[2] = from[6 + r];
    }
  }
  // Prefetches the memory that FillBlock will read, because columns are long and distant in memory.
  void PrefetchBlock(const ForceUnknown& at, const ForceUnknown& by) const {
    const double* entry = by.shares[0].column + Entry(at.shares[0].place);
    __builtin_prefetch(entry);
    __builtin_prefetch(entry + components_ * components_ - 1);
  }

 private:
  [[nodiscard]] long Entry(int place) const { return long{components_} * components_ * place; }

  int components_;
};

}  // namespace palpate
