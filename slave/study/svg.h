// Just enough SVG for a figure: shapes and words with classes that a style sheet colours.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// `<`, `&`, quotes and control characters made harmless in element content and attributes.
std::string XmlEscaped(std::string_view text);

class Svg {
 public:
  enum class Anchor { kStart, kMiddle, kEnd };

  // `style`: CSS rules.
  Svg(double width, double height, std::string_view title, std::string_view style);

  // Coordinates in pixels, y down. `style_class`: one or more class names.
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style_class);
  void Polyline(const std::vector<Eigen::Vector2d>& points, std::string_view style_class);
  void Polygon(const std::vector<Eigen::Vector2d>& points, std::string_view style_class,
               std::string_view tooltip = {});
  void Rectangle(const Eigen::Vector2d& corner, const Eigen::Vector2d& size,
                 std::string_view style_class);
  void Circle(const Eigen::Vector2d& centre, double radius, std::string_view style_class,
              std::string_view tooltip = {});
  void Text(const Eigen::Vector2d& at, std::string_view words, std::string_view style_class,
            Anchor anchor = Anchor::kStart, double degrees = 0);

  // The whole document; more may be drawn after it.
  [[nodiscard]] std::string Document() const { return body_ + "</svg>\n"; }

 private:
  void Close(std::string_view element, std::string_view tooltip);

  std::string body_;
};

}  // namespace palpate
