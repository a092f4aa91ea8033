#include "master/motion/fixture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kMilli = 1e-3;
constexpr double kDegree = std::numbers::pi / 180;  // [rad]
constexpr double kWidest = 89;  // largest half angle of a cone, so that it is convex [deg]

std::vector<std::string> Split(std::string_view text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::optional<Vector3d> ThreeNumbers(const std::string& text) {
  const auto parts = Split(text, ',');
  if (parts.size() != 3) return std::nullopt;
  Vector3d numbers;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = ParseFinite(parts[i]);
    if (!number) return std::nullopt;
    numbers[static_cast<int>(i)] = *number;
  }
  return numbers;
}

// Returns `v`, shortened to at most `most`.
Vector3d Within(const Vector3d& v, double most) {
  const double size = v.norm();
  return size <= most ? v : Vector3d(most / size * v);
}

Vector3d NearestOfCone(const Vector3d& q, const Vector3d& axis, double half_angle) {
  const double height = q.dot(axis);
  const Vector3d across = q - height * axis;
  const double r = across.norm(), c = std::cos(half_angle), s = std::sin(half_angle);
  if (r * c <= height * s) return q;                // inside
  if (height * c <= -r * s) return {0, 0, 0};       // the apex is nearest
  const Vector3d side = c * axis + s / r * across;  // along the nearest line of the surface
  return q.dot(side) * side;
}

// Parts of the text of a fixture: kind, point, and remaining words.
struct Words {
  std::string kind;
  std::vector<std::string> rest;
};

bool ReadNumbers(const Words& words, Fixture* fixture) {
  const bool has_direction = fixture->kind != Fixture::Kind::kSphere;
  const std::size_t vectors = has_direction ? 2 : 1;
  const bool has_size = words.rest.size() == vectors + 1;
  if (!has_size && words.rest.size() != vectors) return false;
  const bool is_plane = fixture->kind == Fixture::Kind::kPlane;
  const bool may_lack_size = is_plane || fixture->kind == Fixture::Kind::kLine;
  if (has_size ? is_plane : !may_lack_size) return false;
  const auto point = ThreeNumbers(words.rest[0]);
  if (!point) return false;
  fixture->point = kMilli * *point;
  if (has_direction) {
    const auto direction = ThreeNumbers(words.rest[1]);
    if (!direction || !(direction->stableNorm() > 0)) return false;
    fixture->direction = direction->stableNormalized();
  }
  const auto size = has_size ? ParseFinite(words.rest.back()) : std::optional<double>(0);
  if (!size || *size < 0) return false;
  const bool is_cone = fixture->kind == Fixture::Kind::kCone;
  if (is_cone && !(*size > 0 && *size <= kWidest)) return false;
  fixture->size = *size * (is_cone ? kDegree : kMilli);
  return true;
}

}  // namespace

Fixture Fixture::Parse(std::string_view text) {
  static constexpr std::array<std::pair<std::string_view, Kind>, 4> kKinds{
      {{"plane", Kind::kPlane},
       {"line", Kind::kLine},
       {"sphere", Kind::kSphere},
       {"cone", Kind::kCone}}};
  Words words;
  words.rest = Split(text, ':');
  words.kind = words.rest.front();
  words.rest.erase(words.rest.begin());
  for (const auto& [name, kind] : kKinds) {
    Fixture fixture;
    fixture.kind = kind;
    if (words.kind == name && ReadNumbers(words, &fixture)) return fixture;
  }
  throw std::invalid_argument(
      "--fixture " + std::string(text) +
      ": expected plane:X,Y,Z:NX,NY,NZ, line:X,Y,Z:DX,DY,DZ[:RADIUS], sphere:X,Y,Z:RADIUS or "
      "cone:X,Y,Z:DX,DY,DZ:DEGREES (1 to 89 degrees), lengths in mm, frame S");
}

Fixture Fixture::ParseBox(std::string_view text) {
  const auto parts = Split(text, ':');
  if (parts.size() == 2) {
    const auto from = ThreeNumbers(parts[0]), to = ThreeNumbers(parts[1]);
    if (from && to) {
      return {Kind::kBox, kMilli * from->cwiseMin(*to), kMilli * from->cwiseMax(*to), 0};
    }
  }
  throw std::invalid_argument("--box " + std::string(text) +
                              ": expected two opposite corners in mm, frame S: X,Y,Z:X,Y,Z");
}

Vector3d Fixture::Nearest(const Vector3d& p_S) const noexcept {
  const Vector3d q = p_S - point;
  switch (kind) {
    case Kind::kPlane:
      return p_S - std::min(0.0, q.dot(direction)) * direction;
    case Kind::kLine: {
      const Vector3d along = q.dot(direction) * direction;
      return point + along + Within(q - along, size);
    }
    case Kind::kSphere:
      return point + Within(q, size);
    case Kind::kCone:
      return point + NearestOfCone(q, direction, size);
    case Kind::kBox:
      return p_S.cwiseMax(point).cwiseMin(direction);
  }
  return p_S;
}

void FixtureSpring::Begin(const Vector3d& p_S) noexcept {
  free_ = (fixture_.Nearest(p_S) - p_S).norm();
}

Vector3d FixtureSpring::Pull(const Vector3d& p_S) noexcept {
  const Vector3d way = fixture_.Nearest(p_S) - p_S;
  const double distance = way.norm();
  free_ = std::min(free_, distance);
  return distance > 0 ? Vector3d((1 - free_ / distance) * way) : Vector3d(0, 0, 0);
}

}  // namespace palpate
