#include "tests/campaigns/robustness/case.h"

#include <algorithm>

#include <spdlog/fmt/fmt.h>

namespace palpate::robustness {

std::string Case::title() const {
  if (severity == 0) return name;
  return fmt::format("{}: {:g}{}{}", name, severity, unit.empty() ? "" : " ", unit);
}

std::function<std::size_t(const Moment&)> Frozen(When when) {
  return [when](const Moment& moment) {
    Moment last = moment;
    while (last.index > 0 && IsSo(when, last)) --last.index;
    return last.index;
  };
}

std::function<std::size_t(const Moment&)> Doubled() {
  return [](const Moment& moment) { return moment.index - moment.index % 2; };
}

std::function<std::size_t(const Moment&)> NowAndThenOld(std::size_t samples) {
  return [samples](const Moment& moment) {
    return moment.index - (moment.index % 5 == 4 ? std::min(samples, moment.index) : 0);
  };
}

std::function<std::size_t(const Moment&)> Late(std::size_t samples, int side) {
  return [=](const Moment& moment) {
    const bool is_late = side < 0 || side == moment.side;
    return moment.index - (is_late ? std::min(samples, moment.index) : 0);
  };
}

}  // namespace palpate::robustness
