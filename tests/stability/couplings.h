// Ways to couple a hand to a wall far away, as they stand beside each other in the literature, on a
// clock of 1 ms and a line of constant delay: what the product renders is compared with them.
#pragma once

#include <cstddef>
#include <deque>

#include "master/haptics/force_chain.h"
#include "master/haptics/renderer.h"

namespace palpate {

inline constexpr double kTick = 0.001;  // [s]

// Gives out what was put in `ticks` ago; zero before that.
class DelayLine {
 public:
  explicit DelayLine(std::size_t ticks) : line_(ticks + 1, 0.0) {}
  double Pass(double in) {
    line_.push_back(in);
    line_.pop_front();
    return line_.front();
  }
  // Sum of the squares of what is to come, and of what came last where `with_last`.
  [[nodiscard]] double Squares(bool with_last) const {
    double sum = 0;
    for (std::size_t i = with_last ? 0 : 1; i < line_.size(); ++i) sum += line_[i] * line_[i];
    return sum;
  }

 private:
  std::deque<double> line_;
};

// One dimension: x goes into the wall, the force f that the hand feels pushes it out. Once a tick.
class Coupling {
 public:
  Coupling(double stiffness, std::size_t delay_ticks)
      : K_(stiffness), up_(delay_ticks), down_(delay_ticks) {}
  virtual ~Coupling() = default;
  Coupling(const Coupling&) = delete;
  Coupling& operator=(const Coupling&) = delete;
  // The hand is at `x` [m], going at `v` [m/s]: the force on it until the next tick [N].
  virtual double Step(double x, double v) = 0;

 protected:
  [[nodiscard]] double WallAt(double x) const { return x > 0 ? K_ * x : 0; }  // [N]

  double K_;  // [N/m]
  DelayLine up_, down_;
};

// The tool goes where the hand was, the hand feels what the tool felt: nobody looks at the energy.
class Bare : public Coupling {
 public:
  using Coupling::Coupling;
  double Step(double x, double) override { return down_.Pass(WallAt(up_.Pass(x))); }
};

// The same with the product's control of the energy at the hand.
class Controlled : public Bare {
 public:
  using Bare::Bare;
  double Step(double x, double v) override;

 private:
  PassivityControl control_;
  double shown_ = 0;
};

// The wall's model stands at the hand: the product's local contact.
class Modelled : public Coupling {
 public:
  Modelled(double stiffness, std::size_t delay_ticks);
  double Step(double x, double v) override;

 private:
  LocalContact contact_;
  double t_ = 0;
};

// Wave variables (Niemeyer & Slotine 1991):
//
//   u = (b v + f) / sqrt(2 b),   w = (b v - f) / sqrt(2 b),   f v = (u^2 - w^2) / 2
//
// Up goes u, down comes w, and a line that delays keeps (u^2 + w^2) / 2 of each tick: it stores
// energy and makes none. At the hand f = b v - sqrt(2 b) w. The tool has a damper b, so that no
// wave comes back from free motion, and goes at the v that u = (b v + f) / sqrt(2 b) asks of it,
// f = b v + K (x + v T) being the wall's and the damper's at the tick's end.
class Waves : public Coupling {
 public:
  Waves(double stiffness, std::size_t delay_ticks, double impedance)
      : Coupling(stiffness, delay_ticks), b_(impedance) {}
  double Step(double x, double v) override;
  // What the hand put in and the wall did not take [J].
  [[nodiscard]] double kept() const { return kept_; }
  // What the waves on their way carry [J]; w came and acts in the next tick.
  [[nodiscard]] double on_the_line() const {
    return (up_.Squares(false) + down_.Squares(true)) / 2 * kTick;
  }
  [[nodiscard]] double tool() const { return x_tool_; }  // [m]

 private:
  double b_;  // [N s/m]
  double x_tool_ = 0, w_ = 0, kept_ = 0;
  bool begun_ = false;
};

}  // namespace palpate
