#include "master/view/finger_text.h"

#include <algorithm>

#include "shared/text/text.h"
#include "shared/wire/enum_names.h"

namespace palpate {
namespace {

std::string Words(Validity validity) {
  std::string words(ToString(validity));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

}  // namespace

std::string Readable(double value) {
  return Formatted("%.3g", value);
}

std::string InWords(const FingerState& finger) {
  if (!IsForceKnown(finger)) {
    return "force unknown (" + Words(finger.validity) + ")";
  }
  if (!finger.in_contact) return "free";
  std::string words = Readable(finger.force->cast<double>().norm()) + " N";
  if (finger.validity != Validity::kValid) words += ", " + Words(finger.validity);
  return words;
}

}  // namespace palpate
