// What the fingertips feel and how far the object gives way, in lines.
#pragma once

#include <string>
#include <vector>

#include "master/haptics/session.h"
#include "master/link/remote_mesh.h"
#include "master/link/slave_link.h"

namespace palpate {

// One line per fingertip and one for the object, for example
//   `  ff       touches    0.412 N  (-0.410 +0.030 +0.020) N`
//   `  th       free`
//   `  object   moved by up to 4.20 mm`
// The vector is the force of the object on the fingertip, frame S. A lone tool, which the status
// line already tells of, has no line of its own. `mesh`: null, nobody watches it or none came.
std::vector<std::string> FingerTable(const std::vector<NamedFinger>& fingers,
                                     const RemoteMesh* mesh);

// The same in one line: `  ff 0.41 N  th free  moved 4.2 mm`.
std::string FingerBrief(const std::vector<NamedFinger>& fingers, const RemoteMesh* mesh);

// Who they are: `fingertips ff (rnn_21; polarity-free), th (no network: its force stays unknown)`.
std::string FingertipsInWords(const std::vector<RemoteFingertip>& fingertips);

}  // namespace palpate
