#include "slave/mechanics/plate/moved_contacts.h"

#include <algorithm>
#include <cmath>

namespace palpate::plate {
namespace {

using Eigen::Index;

constexpr double kWorstCondition = 1e12;

double Norm1(const Eigen::MatrixXd& matrix) {
  return matrix.cwiseAbs().colwise().sum().maxCoeff();
}

}  // namespace

bool MovedContacts::Factorise(const Eigen::MatrixXd& compliance) noexcept {
  const auto count = static_cast<Index>(contacts_.size());
  if (count == 0) return true;
  scale_.resize(count);
  scaled_.resize(count, count);
  solution_.resize(count);
  for (Index i = 0; i < count; ++i) {
    const Index contact = contacts_[static_cast<std::size_t>(i)];
    scale_[i] = 1 / std::sqrt(compliance(contact, contact));
  }
  if (!scale_.allFinite()) return false;
  for (Index j = 0; j < count; ++j) {
    for (Index i = 0; i < count; ++i) {
      scaled_(i, j) = scale_[i] * scale_[j] *
                      compliance(contacts_[static_cast<std::size_t>(i)],
                                 contacts_[static_cast<std::size_t>(j)]);
    }
  }
  factor_.compute(scaled_);
  inverse_ = factor_.inverse();
  return Norm1(scaled_) * Norm1(inverse_) < kWorstCondition;  // false for NaN too
}

void MovedContacts::Solve(Eigen::VectorXd& deflections) noexcept {
  if (contacts_.empty()) return;
  deflections = deflections.cwiseProduct(scale_);
  solution_ = factor_.solve(deflections);
  deflections = solution_.cwiseProduct(scale_);
}

double MovedContacts::Stiffness(const Eigen::MatrixXd& compliance, Index contact) const noexcept {
  const auto place = std::ranges::find(contacts_, contact);
  if (place != contacts_.end()) {
    const auto i = place - contacts_.begin();
    return scale_[i] * inverse_(i, i) * scale_[i];
  }
  double own = compliance(contact, contact);
  for (std::size_t m = 0; m < contacts_.size(); ++m) {
    for (std::size_t n = 0; n < contacts_.size(); ++n) {
      const auto i = static_cast<Index>(m);
      const auto j = static_cast<Index>(n);
      own -= compliance(contact, contacts_[m]) * scale_[i] * inverse_(i, j) * scale_[j] *
             compliance(contacts_[n], contact);
    }
  }
  return own > 0 ? 1 / own : 0;
}

}  // namespace palpate::plate
