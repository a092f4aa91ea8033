#include "slave/mechanics/fem/solid/pressure_update.h"

namespace palpate {
namespace {

SparseMatrix MassOf(const ElasticBody& body) {
  SparseMatrix mass = body.PressureMass();
  // Vertices that belong to no element have no mass.
  for (int i = 0; i < mass.cols(); ++i) {
    if (mass.coeff(i, i) == 0) mass.coeffRef(i, i) = 1;
  }
  mass.makeCompressed();
  return mass;
}

}  // namespace

PressureUpdate::PressureUpdate(const BlockLayout& layout, const ElasticBody& body)
    : layout_(layout),
      body_(body),
      mass_(MassOf(body)),
      solver_(mass_),
      change_(Eigen::VectorXd::Zero(mass_.cols())),
      pressure_(change_) {
  solver_.Allocate(mass_);
  solver_.Factorize(mass_, true);
}

void PressureUpdate::Update(Eigen::VectorXd* x) {
  body_.VolumeChange(*x, &change_);
  pressure_ = change_;
  solver_.Solve(&pressure_);
  for (int i = 0; i < pressure_.size(); ++i) {
    (*x)[layout_.pressure(i)] = pressure_[i] / body_.law().compressibility();
  }
}

}  // namespace palpate
