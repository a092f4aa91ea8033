// stability_map: maps where a simulated operator's contact over a network link is stable. It runs
// the haptic loop itself and compares with theory. Scale, stiffness, rate, delay and device are
// varied.
//
//   stability_map --out stability.csv; draw.py stability.csv deploy/readme/stability.svg
//
// The simulated operator presses 3 mm into a wall and holds. Results: calm: the device comes to
// rest. Damped: it comes to rest because the passivity control removes energy. Restless: it keeps
// moving in spite of that.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "master/device/sim_hand.h"
#include "shared/program/command_line.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

constexpr double kDepth = 0.003;     // at the hand [m]
constexpr double kSurface = -0.004;  // position of the wall's surface, at the device [m]
constexpr double kSettled = 0.45,
                 // Time after the first contact at which the device is held at depth [s].
    kHeld = 1;
constexpr double kMaxTime = 6;                    // [s]
constexpr double kMoves = 0.2;                    // of the depth, to and fro meanwhile: restless
constexpr double kStiffest = 2e5, kSoftest = 10;  // at the hand [N/m]
constexpr int kAcross = 14, kUp = 14;

enum class Calm { kCalm, kDamped, kRestless };

struct Hand {
  std::string name;
  Arm arm;
};
const std::array<Hand, 2> kHands{
    {{"firm hand, b = 21.7 N s/m", {}}, {"light hand, b = 4 N s/m", {0.3, 800, 4.0}}}};

struct Wire {
  double delay = 0, rate = 60;  // delay in each direction [s]; rate of the samples [Hz]
  double scale = 1;             // of positions: the object is as much stiffer
};

// `K`: stiffness at the device [N/m].
Calm TryPress(double K, const Wire& line, RenderMode mode, const Arm& arm) {
  VirtualSlave::Options options;
  options.transform.position_scale = line.scale;
  options.K = K / line.scale;
  options.surface = kSurface * line.scale;
  options.delay = line.delay;
  options.sensor_rate = line.rate;
  Rig rig(options, mode, 12, 1);
  SimHand hand(kDepth, 0.020, arm);
  double path = 0, last = 0, first = 0, touched = kMaxTime;
  int damped = 0;
  while (rig.t() < std::min(touched + kHeld, kMaxTime)) {
    const TickRecord& record = rig.Tick(hand);
    const double y = record.p_M.y();
    if (y < kSurface) touched = std::min(touched, rig.t());
    const bool is_held = rig.t() > touched + kSettled;
    if (is_held) path += std::abs(y - last);
    if (!is_held) first = y;
    damped += record.chain.reasons.Has(Reason::kPassivity) ? 1 : 0;
    last = y;
  }
  if (path - std::abs(last - first) > kMoves * kDepth) return Calm::kRestless;
  return damped > 5 ? Calm::kDamped : Calm::kCalm;
}

double Between(double low, double high, int i, int count) {
  return low * std::pow(high / low, (i + 0.5) / count);
}

// One panel of the map: the vertical axis is the stiffness, the horizontal axis another quantity.
struct Panel {
  std::string title, across;
  double low = 0, high = 0;  // range of the horizontal axis
  RenderMode mode = RenderMode::kLocal;
  Arm arm;
  Wire (*line)(double) = nullptr;
  // Largest stiffness that theory has stable, for the damping b there is.
  double (*bound)(const Wire&, double b) = nullptr;
  std::string theory;
};

// Returns the largest passive stiffness for a force held for T with a delay: b / (T / 2 + delay)
// (Colgate and Schenkel 1994).
double HeldBound(const Wire& line, double b) {
  constexpr double kSending = 0.005;  // additional delay of sampling and sending [s]
  return b / (0.5 / line.rate + 2 * line.delay + kSending);
}
// The bound for a contact law that is solved locally at 1 kHz; it does not depend on rate or delay.
double LocalBound(const Wire&, double b) {
  return 2 * b / 1e-3;
}

std::vector<Panel> Panels() {
  const auto delayed = [](double x) { return Wire{.delay = x}; };
  const auto sampled = [](double x) { return Wire{.rate = x}; };
  const auto scaled = [](double x) { return Wire{.scale = x}; };
  std::vector<Panel> panels;
  for (const Hand& device : kHands) {
    const auto add = [&](const std::string& what, const std::string& across, double low,
                         double high, RenderMode mode, Wire (*line)(double)) {
      const bool local = mode == RenderMode::kLocal;
      panels.push_back({what + ", " + device.name, across, low, high, mode, device.arm, line,
                        local ? LocalBound : HeldBound,
                        local ? "K = 2b/T, T = 1 ms" : "K = b / (T/2 + delay)"});
    };
    add("model solved at 1 kHz", "delay each way [s]", 1e-3, 0.5, RenderMode::kLocal, delayed);
    add("force held", "delay each way [s]", 1e-3, 0.5, RenderMode::kHold, delayed);
    add("force held", "samples a second", 15, 500, RenderMode::kHold, sampled);
    add("model solved at 1 kHz", "position scale", 1e-6, 10, RenderMode::kLocal, scaled);
  }
  return panels;
}

// Counts of a panel's presses by outcome, and of those that theory has passive.
struct Counts {
  std::array<int, 3> outcomes{};
  int passive = 0, wrong = 0;  // wrong: passive in theory but unstable
};

constexpr std::array<const char*, 3> kOutcomes{"calm", "damped", "restless"};

Counts TryPanel(const Panel& panel, std::ofstream* table) {
  Counts counts;
  for (int i = 0; i < kAcross; ++i) {
    const double x = Between(panel.low, panel.high, i, kAcross);
    const Wire line = panel.line(x);
    const double bound = panel.bound(line, panel.arm.damping);
    for (int k = 0; k < kUp; ++k) {
      const double K = Between(kSoftest, kStiffest, k, kUp);
      const auto outcome = static_cast<std::size_t>(TryPress(K, line, panel.mode, panel.arm));
      ++counts.outcomes[outcome];
      if (K < bound) ++counts.passive, counts.wrong += outcome == 2 ? 1 : 0;
      *table << fmt::format("\"{}\",\"{}\",\"{}\",{:.6g},{:.6g},{},{:.6g},{:g}\n", panel.title,
                            panel.across, panel.theory, x, K, kOutcomes[outcome], bound,
                            PassivityControl::kMaxStiffness);
    }
  }
  return counts;
}

int Main(int argc, char** argv) {
  std::string out;
  CLI::App app{"Tries where an operator is stable and writes it beside theory."};
  app.add_option("--out", out, "CSV file, which draw.py draws")->required();
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::ofstream table(out);
  table << "panel,across,theory,x,K,outcome,bound_K,counted_K\n";
  int passive = 0, wrong = 0;
  for (const Panel& panel : Panels()) {
    const Counts counts = TryPanel(panel, &table);
    passive += counts.passive;
    wrong += counts.wrong;
    std::printf("%-48s %-20s calm %3d, damped %3d, restless %3d\n", panel.title.c_str(),
                panel.across.c_str(), counts.outcomes[0], counts.outcomes[1], counts.outcomes[2]);
  }
  if (!table.flush()) return 2;
  std::printf("%d presses that theory has passive, %d of them restless\n", passive, wrong);
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
