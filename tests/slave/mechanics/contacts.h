// Contacts and the answers of models.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "slave/mechanics/deformation_model.h"

namespace palpate::contacts {

// A displacement [m] of a point, or of a disc of `width` [m].
inline Contact Move(const Eigen::Vector3d& p_O, const Eigen::Vector3d& displacement_O,
                    double width = 0) {
  return {.kind = Contact::Kind::kDisplacement,
          .p_O = p_O,
          .width = width,
          .prescribed_O = displacement_O};
}

// A force [N] on a point, or over a disc of `width` [m].
inline Contact Push(const Eigen::Vector3d& p_O, const Eigen::Vector3d& force_O, double width = 0) {
  return {.kind = Contact::Kind::kForce, .p_O = p_O, .width = width, .prescribed_O = force_O};
}

inline std::vector<ContactResponse> Respond(DeformationModel& model,
                                            const std::vector<Contact>& contacts,
                                            Solution* solution = nullptr) {
  Solution room;
  Solution& answer = solution != nullptr ? *solution : room;
  model.Solve(contacts, &answer);
  return answer.responses();
}

inline ContactResponse Answer(DeformationModel& model, const Contact& contact) {
  return Respond(model, {contact}).front();
}

// The same at rest, after a Reset; a failure fails the test.
inline ContactResponse Query(DeformationModel& model, const Contact& contact) {
  model.Reset();
  const ContactResponse response = Answer(model, contact);
  EXPECT_NE(response.validity, Validity::kFailed) << model.failure();
  return response;
}

inline std::vector<Eigen::Vector3d> Displacement(DeformationModel& model,
                                                 const Solution& solution) {
  std::vector<Eigen::Vector3d> u_O;
  model.Displacements(solution, &u_O);
  return u_O;
}

}  // namespace palpate::contacts
