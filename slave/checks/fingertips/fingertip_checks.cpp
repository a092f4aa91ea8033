#include "slave/checks/fingertips/fingertip_checks.h"

#include "slave/checks/fingertips/electrodes.h"
#include "slave/checks/fingertips/encoders.h"
#include "slave/checks/fingertips/model_force.h"
#include "slave/checks/fingertips/pose.h"
#include "slave/checks/fingertips/response.h"
#include "slave/checks/fingertips/rest_contact.h"

namespace palpate {

Checks<FingertipSample> MakeFingertipChecks() {
  Checks<FingertipSample> checks;
  checks.Add("electrodes", std::make_unique<ElectrodesCheck>());
  checks.Add("response", std::make_unique<ResponseCheck>());
  checks.Add("rest_contact", std::make_unique<RestContactCheck>());
  checks.Add("pose", std::make_unique<PoseCheck>());
  checks.Add("model_force", std::make_unique<ModelForceCheck>());
  checks.Add("encoders", std::make_unique<FingerEncoderCheck>());
  return checks;
}

}  // namespace palpate
