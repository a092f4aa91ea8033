// A report that opens in any browser and is one file: images are inside.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "slave/study/shape/shape_score.h"

namespace palpate::study {

class HtmlPage {
 public:
  explicit HtmlPage(std::string_view title);

  // All text is escaped.
  void Heading(std::string_view words);
  void Paragraph(std::string_view words);
  // `align` left; numbers are aligned right.
  void Table(const std::vector<std::string>& head,
             const std::vector<std::vector<std::string>>& rows);
  struct Figure {
    std::string png;  // bytes
    std::string caption;
  };
  // Side by side, as many as fit.
  void Figures(const std::vector<Figure>& figures);
  // An SVG document as it is.
  void Drawing(std::string_view svg);

  [[nodiscard]] std::string Document() const { return body_ + "</body></html>\n"; }

 private:
  std::string body_;
};

// RFC 4648, with padding.
std::string Base64(std::string_view bytes);

// Numbers of an evaluation, for people and for programs. 0.9731: `97.3 %`; NaN: `unknown`.
std::string Percent(double share);
// 0.0123: `12.3 mm`.
std::string Millimetres(double length);
// Intersection over union, or that it is a support.
std::string LabelWords(const LabelScore& label);
// A table of distances.
std::vector<std::string> DistanceHead(std::string first);
std::vector<std::string> DistanceRow(std::string name, const DistanceSummary& distances);
// Unknown values are null.
nlohmann::ordered_json DistanceJson(const DistanceSummary& distances);
nlohmann::ordered_json ScoreJson(const ShapeScore& score, double leaf);

}  // namespace palpate::study
