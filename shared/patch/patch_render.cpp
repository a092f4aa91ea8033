#include "shared/patch/patch_render.h"

namespace palpate {

void PatchRender::Take(const SurfacePatch& patch, const PatchLaw& law, double at,
                       double now) noexcept {
  if (patch.epoch == newest_.patch().epoch) {
    newest_.TakeLaw(law, at, now);
    return;
  }
  const bool first = !known();
  before_ = newest_;
  newest_.Take(patch, law, at, now);
  newest_.Resume(before_);
  if (!first) since_ = now;
}

void PatchRender::LetGo() noexcept {
  newest_.LetGo();
  before_.LetGo();
}

void PatchRender::Forget() noexcept {
  LetGo();
  newest_.Forget();
  since_ = -1e9;
}

Eigen::Vector3d PatchRender::ForceAt(const Eigen::Vector3d& p_S, double now, double then) noexcept {
  const Eigen::Vector3d force = newest_.ForceAt(p_S, now, then);
  if (!IsBlending(now)) return force;
  const double share = (now - since_) / kBlendTime;
  const Eigen::Vector3d before = before_.ForceAt(p_S, now, then);
  return before + share * (force - before);
}

void PatchRender::set_stiffest(double stiffest) noexcept {
  newest_.set_stiffest(stiffest);
  before_.set_stiffest(stiffest);
}

}  // namespace palpate
