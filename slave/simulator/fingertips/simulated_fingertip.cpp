#include "slave/simulator/fingertips/simulated_fingertip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "slave/tactile/localise/electrode_layout.h"

namespace palpate::simulation {
namespace {

using Eigen::Vector3d;

constexpr double kLength = 16e-3;  // length of the cylinder covered by skin [m]
// Upward component of the normal above which the skin is partly, and completely, bonded to the
// nail.
constexpr double kNailBegins = 0.1, kNail = 0.6;
// Signal of the pad's centre relative to that of its sides. Foam recording: the electrodes at the
// sides rise two to ten times as much as those at the centre.
constexpr double kPadBulge = 0.15;

double FreedomAt(const Vector3d& n_F) {
  return std::clamp((kNail - n_F.z()) / (kNail - kNailBegins), 0.0, 1.0);
}

double BulgeAt(const Vector3d& n_F) {
  return FreedomAt(n_F) * (kPadBulge + (1 - kPadBulge) * n_F.y() * n_F.y());
}

}  // namespace

SkinSurface MakeSkinSurface() {
  SkinSurface skin;
  std::size_t count = 0;
  const auto add = [&](const Vector3d& p_F, const Vector3d& n_F, double area) {
    skin.p_F[count] = p_F;
    skin.area[count] = area;
    skin.freedom[count] = FreedomAt(n_F);
    skin.bulge[count] = BulgeAt(n_F);
    ++count;
  };
  const FingerSurface finger{kSkinRadius};
  const ElectrodeLayout layout = SimulatedLayout(kSkinRadius);
  for (const Vector3d& core : layout.p_F) {
    const Vector3d p = finger.Project(core).value_or(Vector3d(kSkinRadius, 0, 0));
    add(p, finger.Normal(p), 0);
  }
  constexpr double kTurn = 2 * std::numbers::pi / static_cast<double>(SkinSurface::kAround);
  for (std::size_t around = 0; around < SkinSurface::kAround; ++around) {
    const double azimuth = (static_cast<double>(around) + 0.5) * kTurn;
    const Vector3d n(0, std::sin(azimuth), -std::cos(azimuth));
    const double ring = kLength / static_cast<double>(SkinSurface::kCylinderRings);
    for (std::size_t i = 0; i < SkinSurface::kCylinderRings; ++i) {
      const double x = -(static_cast<double>(i) + 0.5) * ring;
      add(kSkinRadius * n + Vector3d(x, 0, 0), n, ring * kTurn * kSkinRadius);
    }
    // Rings of equal height have equal areas on a sphere (Archimedes).
    const double height = 1.0 / static_cast<double>(SkinSurface::kSphereRings);
    for (std::size_t i = 0; i < SkinSurface::kSphereRings; ++i) {
      const double x = (static_cast<double>(i) + 0.5) * height;
      const Vector3d n_tip = std::sqrt(1 - x * x) * n + Vector3d(x, 0, 0);
      add(kSkinRadius * n_tip, n_tip, height * kTurn * kSkinRadius * kSkinRadius);
    }
  }
  return skin;
}

}  // namespace palpate::simulation

namespace palpate {
namespace {

using Eigen::Vector3d;
using simulation::SkinSurface;
using Field = std::array<double, SkinSurface::kCount>;

// Fitted to seed 001's recording of a ring finger on a foam bar ("foam": five fingers of which one
// presses, force measured, 0 to 0.92 N, first 15 s) and to a recording of a fingertip pressed
// against a plate ("plate": normal measured, force not). Counts are raw counts.

// Noise and rest values. Foam, the four fingers at rest: differences of neighbouring samples
// divided by sqrt 2 are 0.7 to 1.2 counts for electrodes with rounding, 0.8 to 1.8 for pdc, 9 to 16
// for pac0; means over 0.5 s wander by 0.33 to 0.70 counts in 10 s, of which 0.19 is noise. The
// five fingers' rest values: electrodes 3268 +- 150 over the layout, pdc 1863 to 2349, pac0 2014 to
// 2024.
constexpr double kElectrodeNoise = 0.87, kPdcNoise = 1.2, kPacNoise = 11;  // [counts]
constexpr double kElectrodeDrift = 0.15, kPdcDrift = 0.15;                 // [counts/sqrt(s)]
constexpr double kElectrodeRest = 3270, kElectrodeSpread = 150;            // [counts]
constexpr double kPdcRest = 2150, kPdcSpread = 190, kPacRest = 2018, kPacSpread = 4;
constexpr double kMinRest = 2700, kMaxRest = 3650;  // electrodes start between these
constexpr double kLastCount = 4095;                 // 12 bits

// Skin over fluid: closing of the gap under 1 N over a wide area A is kCompliance / (A / pi), parts
// of the gap. Foam: the electrode that rises most does so by 106 to 114 counts/N, all of them by 22
// to 26 counts/N in the mean. Plate, hard presses: falls to 720 counts on the pad and 1500 at the
// side, rises to 205.
constexpr double kCompliance = 12e-6;  // [m^2/N]
constexpr double kReach = 2e-3;        // radius over which the skin spreads a point load [m]
// Motion of the skin by tangential force relative to that by normal force. Foam: least squares over
// the three presses give 60 to 280 counts/N of tangential force for the electrodes of the sides.
constexpr double kShear = 1.5;
constexpr double kMaxRadius = 0.03;  // of contacts; wider ones press on all of the skin [m]
constexpr double kMaxForce = 100;    // [N]; more changes nothing

// Counts are those of a voltage divider of fluid (conductance as its gap) and a fixed resistor:
// kLastCount g / (g + kHalfGap), g in parts of the gap at rest. From rest values near 0.8 of full
// scale. The current flows through the surrounding fluid, so the bulge at other positions
// contributes with kPath.
constexpr double kHalfGap = 0.26, kPath = 0.6;

// Time. Foam, holds of 1.3 to 2.3 s: electrodes per force creep by 4 to 6 %, a tenth of their
// change is left 0.4 s after release and half of that seconds later; pdc per force falls by 1 to
// 1.5 %.
constexpr double kMaxStep = 60;                 // longer steps count as this [s]
constexpr double kCreep = 0.1, kCreepTime = 2;  // [-], [s]
constexpr double kRelaxation = 0.015;           // of the pressure [-]
// Foam: pdc has 144 to 150 counts/N and lags pac0 by two samples; pac0 changes by -0.9 to -1.0
// counts per count/s of pdc at contact and release.
constexpr double kPressure = 1800;                   // counts of pdc per mean bulge
constexpr double kPdcTime = 0.015, kPacTime = 0.01;  // [s]
constexpr double kPacGain = 1.0;                     // [counts s/count]

// Returns the closed share of a gap as a hyperbolic function, because fluid never leaves it
// completely. Below 0: widened.
double Closed(double strain) noexcept {
  return strain > 0 ? strain / (1 + strain) : strain;
}

double Divider(double gap) noexcept {
  return kLastCount * gap / (gap + kHalfGap);
}

float Rounded(double counts) noexcept {
  return static_cast<float>(std::clamp(std::round(counts), 0.0, kLastCount));
}

// Strain of the gap at every point of the skin under `load`, as if skin did not creep.
void Press(const SkinSurface& skin, const FingertipLoad& load, Field* strain) noexcept {
  const Vector3d n = FingerSurface{simulation::kSkinRadius}.Normal(load.p_F);
  const double size = load.f_F.stableNorm();
  const Vector3d f = load.f_F * (size > kMaxForce ? kMaxForce / size : 1);
  const double normal = std::max(-f.dot(n), 0.0);
  const Vector3d tangential = f - f.dot(n) * n;
  const double radius = std::clamp(load.radius, 0.0, kMaxRadius);
  const double width_squared = radius * radius + kReach * kReach;
  const Vector3d shear = kShear / std::sqrt(width_squared) * tangential;
  for (std::size_t i = 0; i < SkinSurface::kCount; ++i) {
    const Vector3d r = skin.p_F[i] - load.p_F;
    const double x = 1 + r.squaredNorm() / width_squared;
    const double kernel = kCompliance / (width_squared * x * std::sqrt(x));
    // Dragged skin becomes thicker ahead of the contact and thinner behind it.
    (*strain)[i] = skin.freedom[i] * kernel * (normal - shear.dot(r));
  }
}

bool Usable(const FingertipLoad& load) noexcept {
  return load.p_F.allFinite() && load.f_F.allFinite() && std::isfinite(load.radius) &&
         load.p_F.stableNorm() > 0;
}

}  // namespace

struct SimulatedFingertip::Skin {
  explicit Skin(std::uint32_t seed) : surface(simulation::MakeSkinSurface()), random(seed) {
    for (double& rest : rests) {
      rest = std::clamp(kElectrodeRest + kElectrodeSpread * normal(random), kMinRest, kMaxRest);
    }
    rest_pdc = kPdcRest + kPdcSpread * normal(random);
    rest_pac = kPacRest + kPacSpread * normal(random);
    for (std::size_t i = 0; i < SkinSurface::kCount; ++i) {
      bulging_area += surface.area[i] * surface.bulge[i];
    }
  }

  // Returns the bulge that conserves the fluid's volume between closed and bulging gaps.
  [[nodiscard]] double Bulge(double prompt, double slow) const noexcept {
    double lost = 0;
    for (std::size_t i = kElectrodeCount; i < SkinSurface::kCount; ++i) {
      lost += surface.area[i] * Closed(prompt * strain[i] + slow * crept[i]);
    }
    return lost / bulging_area;
  }
  void Advance(const FingertipLoad* load, double seconds) noexcept;
  FingerReading Read() noexcept;

  const SkinSurface surface;
  double bulging_area = 0;  // [m^2]
  std::array<double, kElectrodeCount> rests{};
  double rest_pdc = 0, rest_pac = 0;

  Field strain{}, crept{};  // strain and delayed strain of a standard linear solid at every point
  double pressure = 0;      // of the fluid [counts of pdc]
  double pdc = 0;           // static pressure, as the sensor measures it
  double trail = 0;         // lagging pressure, whose rate is pac
  double pac = 0;

  std::mt19937 random;
  std::normal_distribution<double> normal;
};

void SimulatedFingertip::Skin::Advance(const FingertipLoad* load, double seconds) noexcept {
  if (load != nullptr && Usable(*load)) {
    Press(surface, *load, &strain);
  } else {
    strain.fill(0);
  }
  const double creep = 1 - std::exp(-seconds / kCreepTime);
  for (std::size_t i = 0; i < SkinSurface::kCount; ++i) crept[i] += creep * (strain[i] - crept[i]);
  pressure = kPressure * Bulge(1 + kRelaxation, -kRelaxation);
  pdc += (1 - std::exp(-seconds / kPdcTime)) * (pressure - pdc);
  const double rise = (1 - std::exp(-seconds / kPacTime)) * (pressure - trail);
  trail += rise;
  pac = seconds > 0 ? -kPacGain * rise / seconds : 0;

  const double wander = std::sqrt(seconds);
  for (double& rest : rests) rest += kElectrodeDrift * wander * normal(random);
  rest_pdc += kPdcDrift * wander * normal(random);
}

FingerReading SimulatedFingertip::Skin::Read() noexcept {
  FingerReading reading;
  reading.present = true;
  const double bulge = Bulge(1, kCreep);
  for (std::size_t i = 0; i < kElectrodeCount; ++i) {
    const double closed = Closed(strain[i] + kCreep * crept[i]);
    const double gap = std::max(1 - closed + bulge * (surface.bulge[i] + kPath), 0.0);
    reading.channels[i] =
        Rounded(rests[i] + Divider(gap) - Divider(1) + kElectrodeNoise * normal(random));
  }
  reading.pac = Rounded(rest_pac + pac + kPacNoise * normal(random));
  reading.pdc = Rounded(rest_pdc + pdc + kPdcNoise * normal(random));
  return reading;
}

SimulatedFingertip::SimulatedFingertip(std::uint32_t seed) : skin_(std::make_unique<Skin>(seed)) {}

SimulatedFingertip::~SimulatedFingertip() = default;
SimulatedFingertip::SimulatedFingertip(SimulatedFingertip&&) noexcept = default;
SimulatedFingertip& SimulatedFingertip::operator=(SimulatedFingertip&&) noexcept = default;

FingerReading SimulatedFingertip::Sample(const FingertipLoad* load, double seconds) noexcept {
  skin_->Advance(load, seconds > 0 ? std::min(seconds, kMaxStep) : 0);
  return skin_->Read();
}

}  // namespace palpate
