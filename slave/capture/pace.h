// How a source of samples runs: live, or as fast as possible.
#pragma once

#include "slave/capture/sample_tap.h"

namespace palpate {

class Progress;

class PictureInbox;

// How samples come: in real time, while an operator moves the tool; or as fast as they are
// computed, on the simulator's own clock, with scripted motion.
struct Pace {
  bool is_live = true;
  double duration = 0;               // of a script that could go on for ever [s]; 0: its own choice
  int presses = 1;                   // scripted contacts of fingertips
  PictureInbox* pictures = nullptr;  // receiver of streamed samples, which must outlive the source
  SampleTap* tap = nullptr;          // tap that gets each sample, and outlives the source
  SamplePlayer* player = nullptr;    // player of recorded samples, which outlives the source
  FrameOpener open = {};             // opens the images of one camera; empty: as the scene has them
  Progress* progress = nullptr;      // of the model of one camera while it is built; null: none
};

}  // namespace palpate
