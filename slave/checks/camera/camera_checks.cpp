#include "slave/checks/camera/camera_checks.h"

#include "slave/checks/camera/encoders.h"
#include "slave/checks/camera/frozen_image.h"
#include "slave/checks/camera/image_quality.h"
#include "slave/checks/camera/indentation.h"
#include "slave/checks/camera/interlace.h"
#include "slave/checks/camera/object_in_place.h"
#include "slave/checks/camera/regained.h"
#include "slave/checks/camera/tool_at_start.h"

namespace palpate {

Checks<CameraSample> MakeCameraChecks(const Scene& scene, const FirstImage& first) {
  Checks<CameraSample> checks;
  checks.Add("object_in_place", std::make_unique<ObjectInPlaceCheck>());
  checks.Add("image_quality", std::make_unique<ImageQualityCheck>());
  checks.Add("indentation", std::make_unique<IndentationCheck>());
  checks.Add("encoders", std::make_unique<EncoderCheck>());
  if (first.p_I_tip) {
    checks.Add("tool_at_start", std::make_unique<ToolAtStartCheck>(
                                    scene, first.image, *first.p_I_tip, first.d_I, first.width_px));
  }
  checks.Add("regained", std::make_unique<RegainedCheck>());
  checks.Add("frozen_image", std::make_unique<FrozenImageCheck>(first.noise));
  checks.Add("interlace", std::make_unique<InterlaceCheck>(first.image));
  return checks;
}

}  // namespace palpate
