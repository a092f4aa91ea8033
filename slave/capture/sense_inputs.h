// SenseInputs replace the scene's own source of samples.
#pragma once

#include "slave/capture/sample_tap.h"

namespace palpate {

class Progress;
class ImageInbox;

struct SenseInputs {
  ImageInbox* images = nullptr;    // receiver of streamed samples, which must outlive the source
  SampleTap* tap = nullptr;        // tap that gets each sample, and outlives the source
  SamplePlayer* player = nullptr;  // player of recorded samples, which outlives the source
  FrameOpener open = {};           // opens the images of one camera; empty: as the scene has them
  Progress* progress = nullptr;    // of the model of one camera while it is built; null: none
  bool solves_aside = false;       // see DeformationModel::SolveAside; for samples in real time
};

}  // namespace palpate
