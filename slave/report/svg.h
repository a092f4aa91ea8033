// Writes simple SVG figures: shapes and texts with classes for a style sheet. Coordinates in
// pixels, y down.
#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include <Eigen/Core>

#include "shared/text/text.h"

namespace palpate {

class Svg {
 public:
  enum class Anchor { kStart, kMiddle, kEnd };

  // `style`: CSS rules.
  Svg(double width, double height, std::string_view title, std::string_view style);

  // `style_class`: one or more class names.
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style_class);
  void Polyline(std::span<const Eigen::Vector2d> points, std::string_view style_class);
  void Rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                 std::string_view style_class);
  void Circle(const Eigen::Vector2d& centre, double radius, std::string_view style_class,
              std::string_view tooltip = {});
  void Text(const Eigen::Vector2d& at, std::string_view words, std::string_view style_class,
            Anchor anchor = Anchor::kStart, double degrees = 0);
  // The complete document. More may be drawn afterwards.
  [[nodiscard]] std::string Document() const { return body_ + "</svg>\n"; }

 private:
  using Numbers = std::initializer_list<std::pair<std::string_view, double>>;

  void Draw(std::string_view element, std::string_view style_class, Numbers numbers,
            std::string_view tooltip = {});
  void Open(std::string_view element, std::string_view style_class);
  void Add(std::string_view name, std::string_view value);
  void Add(std::string_view name, double value);
  void AddPoints(std::span<const Eigen::Vector2d> points);
  void Close(std::string_view element, std::string_view tooltip = {});

  std::string body_;
};

}  // namespace palpate
