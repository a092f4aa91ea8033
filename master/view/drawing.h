// Just enough SVG for a picture of a surface: coloured polygons, and lines and words whose classes
// a style sheet colours. Coordinates in pixels, y down.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace palpate {

class Drawing {
 public:
  enum class Anchor { kStart, kMiddle, kEnd };

  // `style`: CSS rules.
  Drawing(double width, double height, std::string_view title, std::string_view style);

  // `colour` as CSS has it; edged in the same colour, so that neighbours leave no gap.
  void Polygon(std::span<const Eigen::Vector2d> corners, std::string_view colour);
  // Closed, coloured by its class.
  void Shape(std::span<const Eigen::Vector2d> corners, std::string_view style_class);
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, std::string_view style_class);
  void Circle(const Eigen::Vector2d& centre, double radius, std::string_view style_class);
  // What is drawn until EndGroup takes the class as a whole: one opacity for all of it.
  void BeginGroup(std::string_view style_class);
  void EndGroup() { text_ += "</g>\n"; }
  void Text(const Eigen::Vector2d& at, std::string_view words, std::string_view style_class,
            Anchor anchor = Anchor::kStart);

  // The whole document; more may be drawn after it.
  [[nodiscard]] std::string Document() const { return text_ + "</svg>\n"; }

 private:
  void Corners(std::span<const Eigen::Vector2d> corners);
  void Attribute(std::string_view name, std::string_view value);
  void Attribute(std::string_view name, double value);

  std::string text_;
};

}  // namespace palpate
