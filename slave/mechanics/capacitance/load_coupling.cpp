#include "slave/mechanics/capacitance/load_coupling.h"

#include <algorithm>

namespace palpate {
namespace {

// Basis components of the displacement at `at` by the weighted load.
void AddToUnknown(const ForceUnknown& at, const double* column, double weight, double* row,
                  long stride) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int a = 0; a < at.share_count; ++a) {
    const auto& share = at.shares[static_cast<std::size_t>(a)];
    sum += weight * share.weight * BlockAt(column, share.place);
  }
  for (int k = 0; k < at.count; ++k) {
    for (int c = 0; c < 3; ++c) row[c * stride + at.row + k] += at.basis.col(k).dot(sum.col(c));
  }
}

// Displacement of a loaded place by the unknown's unit components.
void AddToLoad(const ForceUnknown& by, int place, double weight, double* row, long stride) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int b = 0; b < by.share_count; ++b) {
    const auto& share = by.shares[static_cast<std::size_t>(b)];
    sum += weight * share.weight * BlockAt(share.column, place);
  }
  for (int k = 0; k < by.count; ++k) {
    for (int c = 0; c < 3; ++c) row[c * stride + by.row + k] += sum.row(c).dot(by.basis.col(k));
  }
}

}  // namespace

bool LoadCoupling::Fill(const ContactSet& set, int padded_rows) {
  loads_ = set.loads();
  if (loads_ == 0) return true;
  stride_ = padded_rows;
  const auto size = static_cast<std::size_t>(3 * loads_ * stride_);
  if (size > room_) {
    room_ = size + size / 2;
    by_ = MakeAligned(room_);
    if (!compliance_.symmetric()) at_ = MakeAligned(room_);
  }
  std::fill_n(by_.get(), size, 0.0);
  if (!compliance_.symmetric()) std::fill_n(at_.get(), size, 0.0);
  between_.assign(static_cast<std::size_t>(loads_ * loads_), Eigen::Matrix3d::Zero());
  for (const auto& load : set.slots()) {
    if (load.load < 0) continue;
    const long first = 3 * load.load * stride_;
    for (const auto& [place, weight] : load.footprint.places) {
      const double* column = compliance_.Column(place);
      if (column == nullptr) return false;
      for (const auto& unknown : set.unknowns()) {
        AddToUnknown(unknown, column, weight, by_.get() + first, stride_);
        if (!compliance_.symmetric()) {
          AddToLoad(unknown, place, weight, at_.get() + first, stride_);
        }
      }
      for (const auto& other : set.slots()) {
        if (other.load < 0) continue;
        auto& block = between_[static_cast<std::size_t>(other.load * loads_ + load.load)];
        for (const auto& at : other.footprint.places) {
          block += weight * at.weight * BlockAt(column, at.place);
        }
      }
    }
  }
  return true;
}

}  // namespace palpate
