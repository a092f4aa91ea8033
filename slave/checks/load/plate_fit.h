// What the fit of a load on a flat membrane finds.
#pragma once

#include "slave/mechanics/plate/fit/load_fit.h"

namespace palpate {

struct PlateFit {
  LoadFit load;
  int points = 0;    // points on the plate, visible and selected
  int left_out = 0;  // of them: they contradict the others
  // The rim or the cameras have moved since rest; the load does not include it. Motion along the
  // plate is caused by no load: motion within limits is compensated.
  bool moved = false, put_right = false;
  // The points have moved apart or together along the plate by more than noise and a contact cause.
  bool grown = false;
  // Largest mean residual of neighbouring points beyond noise and model error, relative to the
  // largest deflection; 0: none.
  double cluster = 0;
  // LoadFitter::Seek for the plate's tension at rest, and the error of the plate model in it [N/m].
  LoadFitter::Sought tension;
  double sigma_of_law = 0;
  double off = 0;      // rms of the residuals of the used points [m]
  double deepest = 0;  // largest fitted deflection [m]
};

}  // namespace palpate
