// stability_map: where a hand on the far side of a line stays calm, tried with the haptic loop
// itself, beside what theory predicts. Scale, stiffness, rate, delay and device, end to end.
//
//   stability_map --out deploy/readme/stability.svg
//
// A hand presses 3 mm into a wall; it is calm where it rests once it is in, damped where the
// passivity control has to take energy out for that, restless where it moves on all the same.
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
#include "slave/report/svg.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kDepth = 0.003;     // at the hand [m]
constexpr double kSurface = -0.004;  // where the wall begins, at the hand [m]
constexpr double kSettled = 0.45,
                 kHeld = 1;     // after the first touch: the hand is in, and holds [s]
constexpr double kLongest = 6;  // [s]
constexpr double kMoves = 0.2;  // of the depth, to and fro meanwhile: restless
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
  double delay = 0, rate = 60;  // each way [s]; of the samples [Hz]
  double scale = 1;             // of positions: the object is as much stiffer
};

// `K`: at the hand [N/m].
Calm TryPress(double K, const Wire& line, RenderMode mode, const Arm& arm) {
  VirtualSlave::Options options;
  options.transform.position_scale = line.scale;
  options.K = K / line.scale;
  options.surface = kSurface * line.scale;
  options.delay = line.delay;
  options.sensor_rate = line.rate;
  Rig rig(options, mode, 12, 1);
  SimHand hand(kDepth, 0.020, arm);
  double path = 0, last = 0, first = 0, touched = kLongest;
  int damped = 0;
  while (rig.t() < std::min(touched + kHeld, kLongest)) {
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

// One square of the map: stiffness upwards, something else across.
struct Panel {
  std::string title, across;
  double low = 0, high = 0;  // of what goes across
  RenderMode mode = RenderMode::kLocal;
  Arm arm;
  Wire (*line)(double) = nullptr;
  // Largest stiffness that theory has stable, for the damping b there is.
  double (*bound)(const Wire&, double b) = nullptr;
  std::string theory;
};

// A force held for T, `delay` old: passive up to b / (T / 2 + delay) (Colgate and Schenkel 1994).
double HeldBound(const Wire& line, double b) {
  constexpr double kSending = 0.005;  // sampling and sending take besides [s]
  return b / (0.5 / line.rate + 2 * line.delay + kSending);
}
// The same of a law that is solved at 1 kHz: neither rate nor delay is in it.
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

constexpr double kSide = 250, kGap = 78, kTop = 96, kLeft = 70;
constexpr std::string_view kStyle = R"(
svg { font-family: system-ui, "DejaVu Sans", sans-serif; font-size: 12px; }
.paper { fill: #ffffff; } .ink { fill: #1d2430; } .soft { fill: #5b6576; }
.heading { font-size: 17px; font-weight: 600; } .small { font-size: 11px; }
.calm { fill: #b8dfc4; } .damped { fill: #f3d38a; } .restless { fill: #e58a8a; }
.counted { stroke: #1d2430; stroke-width: 1; }
.theory { fill: none; stroke: #1d2430; stroke-width: 2; stroke-dasharray: 6 4; }
)";
constexpr std::array<std::string_view, 3> kColours{"calm", "damped", "restless"};

class Map {
 public:
  Map() : panels_(Panels()), svg_(Width(), Height(), "Where a hand stays calm", kStyle) {}

  std::string Draw() {
    svg_.Rectangle({0, 0}, {Width(), Height()}, "paper");
    svg_.Text({kLeft, 30},
              "Where a hand stays calm: stiffness at the hand, delay, rate, scale, "
              "device",
              "ink heading");
    double x = kLeft;
    for (std::size_t i = 0; i < kColours.size(); ++i, x += 190) {
      constexpr std::array<const char*, 3> kWords{"calm", "calm, energy taken out", "restless"};
      svg_.Rectangle({x, 46}, {16, 12}, kColours[i]);
      svg_.Text({x + 22, 57}, kWords[i], "ink");
    }
    svg_.Text({x, 57},
              "dashed: theory, passive below (b: the hand's damping); thin: 2b/T of the 1 N s/m "
              "counted on",
              "ink");
    for (std::size_t i = 0; i < panels_.size(); ++i) {
      const auto column = static_cast<double>(i % 4), row = static_cast<double>(i / 4);
      DrawPanel(panels_[i], {kLeft + column * (kSide + kGap), kTop + row * (kSide + kGap)});
    }
    return svg_.Document();
  }
  // Cells that theory has passive, and of these the restless ones.
  [[nodiscard]] int passive() const { return passive_; }
  [[nodiscard]] int wrong() const { return wrong_; }

 private:
  static double Width() { return kLeft + 4 * (kSide + kGap); }
  static double Height() { return kTop + 2 * (kSide + kGap); }
  static double Y(double K) {
    const double share = std::log(K / kSoftest) / std::log(kStiffest / kSoftest);
    return kSide * (1 - std::clamp(share, 0.0, 1.0));
  }

  void DrawPanel(const Panel& panel, const Vector2d& corner) {
    svg_.Text(corner + Vector2d(0, -8), panel.title, "ink small");
    std::vector<Vector2d> bound;
    std::array<int, 3> counts{};
    for (int i = 0; i < kAcross; ++i) {
      const Wire line = panel.line(Between(panel.low, panel.high, i, kAcross));
      const double most = panel.bound(line, panel.arm.damping);
      bound.emplace_back(corner + Vector2d(kSide * (i + 0.5) / kAcross, Y(most)));
      for (int k = 0; k < kUp; ++k) {
        const double K = Between(kSoftest, kStiffest, k, kUp);
        const Calm calm = TryPress(K, line, panel.mode, panel.arm);
        ++counts[static_cast<std::size_t>(calm)];
        if (K < most) ++passive_, wrong_ += calm == Calm::kRestless ? 1 : 0;
        const Vector2d cell(kSide / kAcross, kSide / kUp);
        svg_.Rectangle(corner + Vector2d(cell.x() * i, kSide - cell.y() * (k + 1)), cell,
                       kColours[static_cast<std::size_t>(calm)]);
      }
    }
    svg_.Polyline(bound, "theory");
    const double counted = Y(PassivityControl::kMaxStiffness);
    svg_.Line(corner + Vector2d(0, counted), corner + Vector2d(kSide, counted), "counted");
    for (double K = kSoftest; K <= kStiffest; K *= 10) {
      svg_.Text(corner + Vector2d(-6, Y(K) + 4), fmt::format("{:g}", K), "soft small",
                Svg::Anchor::kEnd);
    }
    svg_.Text(corner + Vector2d(0, kSide + 16), fmt::format("{:g}", panel.low), "soft small");
    svg_.Text(corner + Vector2d(kSide / 2, kSide + 30), panel.across, "ink small",
              Svg::Anchor::kMiddle);
    svg_.Text(corner + Vector2d(kSide, kSide + 16), fmt::format("{:g}", panel.high), "soft small",
              Svg::Anchor::kEnd);
    svg_.Text(corner + Vector2d(kSide - 4, 14), panel.theory, "ink small", Svg::Anchor::kEnd);
    std::printf("%-48s %-20s calm %3d, damped %3d, restless %3d\n", panel.title.c_str(),
                panel.across.c_str(), counts[0], counts[1], counts[2]);
  }

  std::vector<Panel> panels_;
  Svg svg_;
  int passive_ = 0, wrong_ = 0;
};

int Main(int argc, char** argv) {
  std::string out;
  CLI::App app{"Tries where a hand stays calm and draws it beside theory."};
  app.add_option("--out", out, "SVG file")->required();
  CLI11_PARSE(app, argc, argv);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Map map;
  if (!(std::ofstream(out) << map.Draw() << std::flush)) return 2;
  std::printf("%d presses that theory has passive, %d of them restless\n", map.passive(),
              map.wrong());
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
