#include "master/view/finger_table.h"

#include <array>
#include <cstdio>

#include "master/view/finger_layer.h"
#include "master/view/scale.h"

namespace palpate {
namespace {

constexpr int kLongestName = 8;  // characters

std::string Name(const std::string& name) {
  std::string padded = name.substr(0, kLongestName);
  padded.resize(kLongestName, ' ');
  return "  " + padded + " ";
}

bool IsTold(const FingerState& finger) {
  return finger.force && IsForceKnown(finger.validity);
}

std::string Line(const NamedFinger& finger) {
  const FingerState& felt = finger.felt;
  if (!IsTold(felt)) return Name(finger.name) + InWords(felt);
  const Eigen::Vector3d f = felt.force->cast<double>();
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "%-8s %8.3g N  (%+.3g %+.3g %+.3g) N",
                felt.in_contact ? "touches" : "free", f.norm(), f.x(), f.y(), f.z());
  std::string line = Name(finger.name) + text.data();
  if (felt.validity != Validity::kValid) line += "  " + std::string(ToString(felt.validity));
  return line;
}

std::string Moved(const RemoteMesh& mesh) {
  return Readable(1e3 * mesh.LargestDeflection()) + " mm";
}

}  // namespace

std::vector<std::string> FingerTable(const std::vector<NamedFinger>& fingers,
                                     const RemoteMesh* mesh) {
  std::vector<std::string> lines;
  if (fingers.size() > 1) {
    for (const NamedFinger& finger : fingers) lines.push_back(Line(finger));
  }
  if (mesh == nullptr) return lines;
  lines.push_back(Name("object") + "moved by up to " + Moved(*mesh));
  if (mesh->validity != Validity::kValid) {
    lines.back() += "  " + std::string(ToString(mesh->validity));
  }
  return lines;
}

std::string FingerBrief(const std::vector<NamedFinger>& fingers, const RemoteMesh* mesh) {
  std::string line;
  if (fingers.size() > 1) {
    for (const NamedFinger& finger : fingers)
      line += "  " + finger.name + " " + InWords(finger.felt);
  }
  if (mesh != nullptr) line += "  moved " + Moved(*mesh);
  return line;
}

std::string FingertipsInWords(const std::vector<RemoteFingertip>& fingertips) {
  std::string words;
  for (const RemoteFingertip& tip : fingertips) {
    const std::string network =
        tip.network.empty() ? "no network: its force stays unknown" : tip.network;
    const std::string localiser = tip.localiser.empty() ? "" : "; " + tip.localiser;
    words += (words.empty() ? "fingertips " : ", ") + tip.name + " (" + network + localiser + ")";
  }
  return words;
}

}  // namespace palpate
